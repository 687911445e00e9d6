# SPDX-License-Identifier: Apache-2.0
"""`evcot presets`: list the presets."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict

from evcot.filters.config import FilterConfig
from evcot.hardware.config import MotionConfig
from evcot.hardware.modules import MODULES
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES, Engine
from evcot.trackers.presets import PRESETS, presets_of

from ...tables import print_table

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """List the presets; 0."""
    if options.engine is not None and options.engine not in MODULES:
        _print_settings(ENGINES[options.engine], options.json)
        return 0
    presets = presets_of(options.engine) if options.engine else PRESETS
    if options.json:
        print(json.dumps({name: config.to_dict() for name, config in presets.items()}, indent=2))
        return 0
    print_table([("name", "hardware", "N_ev", "window px", "lifetime", "tick", "filters"), *map(_row, presets.items())])
    return 0


def _row(named: tuple[str, RunConfig]) -> tuple[str, ...]:
    name, config = named
    filters = ", ".join(which.name.lower() for which in config.filters.filters)
    filters += " by the noise" if config.filters.activity_noise_hz else ""
    hardware, tick_us = config.hardware, config.hardware.tick_us
    if isinstance(hardware, MotionConfig):
        registers = hardware.registers
        n_ev, window = f"{registers.nev_low} to {registers.nev_high}", "by its box"
        life = f"{registers.life_ticks * tick_us / 1000:g} to {registers.coast_ticks * tick_us / 1000:g} ms"
    else:
        slot = hardware.slots[0]
        n_ev, window = f"{slot.clust_nev} ({slot.nev_min} to {slot.nev_max})", f"{slot.init_radix} + {slot.radix_th}"
        life = f"{slot.max_ticks * tick_us / 1000:g} ms"
    return name, hardware.module, n_ev, window, life, f"{tick_us} us", filters


def _print_settings(engine: Engine, as_json: bool) -> None:
    """A software tracker's presets: each setting that is not the same in all of them."""
    presets = {name: asdict(settings) for name, settings in engine.presets.items()}
    filters = {name: asdict(engine.filters[name]) if name in engine.filters else {} for name in presets}
    if as_json:
        print(json.dumps({name: {"settings": presets[name], "filters": filters[name]} for name in presets}, indent=2))
        return
    default = asdict(FilterConfig())
    for name, chosen in filters.items():
        presets[name] |= {f"filters.{key}": value for key, value in chosen.items() if value != default[key]}
    keys = dict.fromkeys(key for settings in presets.values() for key in settings)
    rows = [(key, *(settings.get(key, "") for settings in presets.values())) for key in keys]
    print_table([("setting", *presets), *(row for row in rows if len(set(row[1:])) > 1 or len(presets) == 1)])

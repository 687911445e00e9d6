# SPDX-License-Identifier: Apache-2.0
"""`evcot presets`: list the presets."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict

from evcot.filters.config import FilterConfig
from evcot.trackers.engines import ENGINES, Engine
from evcot.trackers.presets import AUTO, AUTO_PAPER, FOLLOWING, PRESETS

from ...tables import print_table

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """List the presets; 0."""
    if options.engine not in (None, "cot"):
        _print_settings(ENGINES[options.engine], options.json)
        return 0
    if options.json:
        print(json.dumps({name: config.to_dict() for name, config in PRESETS.items()}, indent=2))
        return 0
    rows = [("name", "N_ev", "window px", "lifetime", "tick", "filters")]
    for name, config in {AUTO: FOLLOWING, **PRESETS}.items():
        filters = ", ".join(which.name.lower() for which in config.filters.filters)
        filters += " by the noise" if config.filters.activity_noise_hz else ""
        slot, motion = config.cot.slots[0], config.cot.motion
        if motion.enable:
            lives_ms = (motion.life_ticks * config.cot.tick_us / 1000, motion.coast_ticks * config.cot.tick_us / 1000)
            n_ev, life = f"{motion.nev_low} to {motion.nev_high}", f"{lives_ms[0]:g} to {lives_ms[1]:g} ms"
            rows.append((name, n_ev, "by its box", life, f"{config.cot.tick_us} us", filters))
            continue
        lifetime_ms = slot.max_ticks * config.cot.tick_us / 1000
        rows.append(
            (
                name,
                f"{slot.clust_nev} ({slot.nev_min} to {slot.nev_max})",
                f"{slot.init_radix} + {slot.radix_th}",
                f"{lifetime_ms:g} ms",
                f"{config.cot.tick_us} us",
                filters,
            )
        )
    rows.append((AUTO_PAPER, "by what the recording shows: docs/auto.md", "", "", "", ""))
    print_table(rows)
    return 0


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

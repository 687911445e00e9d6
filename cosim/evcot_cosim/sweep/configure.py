# SPDX-License-Identifier: Apache-2.0
"""The configuration of a task: a preset with tables on top, for an engine and a sensor."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from evcot.filters.config import FilterConfig
from evcot.hardware.modules import MODULES
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig, run_config_from, tracker_from
from evcot.trackers.presets import fit, run_config
from evcot.trackers.settings import engine_settings

from .fields import RTL

__all__ = ["configuration", "tables_of"]


def tables_of(tables: Mapping[str, Any], engine: str) -> dict[str, Any]:
    """Those tables that mean anything to an engine, of the hardware its module."""
    wanted = [engine, "filters"]
    if engine in MODULES:
        wanted = ["shape", "filters", *(["motion"] if engine == "cot_motion" else ["cot", "slot"])]
    return {name: tables[name] for name in wanted if name in tables}


def configuration(
    engine: str, sensor: Sensor, preset: str | None, tables: Mapping[str, Any], hardware: str = ""
) -> tuple[Any, FilterConfig]:
    """An engine's settings, of hardware and golden models a `RunConfig`, and the filters in front.

    Args:
        hardware: the module of `RTL`.

    Raises:
        ConfigError: no such preset or field, or a value outside its range.
    """
    own = tables_of(tables, hardware or engine)
    if engine == RTL:
        base = run_config(*sensor, preset, hardware=hardware)
    else:
        base, filters = engine_settings(engine, sensor, preset)
        if not isinstance(base, RunConfig):
            return tracker_from(own, engine, base, filters, Path())
        base = fit(base, *sensor)
    config: RunConfig = run_config_from(own, base, Path())
    return config, config.filters

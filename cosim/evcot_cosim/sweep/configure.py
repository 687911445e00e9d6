# SPDX-License-Identifier: Apache-2.0
"""The configuration of a task: a preset with tables on top, for an engine and a sensor."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from evcot.filters.config import FilterConfig
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig, run_config_from, tracker_from
from evcot.trackers.presets import run_config
from evcot.trackers.settings import engine_settings

from .fields import MODEL, RTL

__all__ = ["configuration", "tables_of"]

_HARDWARE = ("shape", "cot", "slot", "filters")


def tables_of(tables: Mapping[str, Any], engine: str) -> dict[str, Any]:
    """Those tables that mean anything to an engine."""
    wanted = _HARDWARE if engine in (RTL, MODEL) else (engine, "filters")
    return {name: tables[name] for name in wanted if name in tables}


def configuration(
    engine: str, sensor: Sensor, preset: str | None, tables: Mapping[str, Any], slots: int | None = None
) -> tuple[Any, FilterConfig]:
    """An engine's settings, of hardware and model a `RunConfig`, and the filters in front.

    Args:
        slots: number of tracker slots, unless the tables state it; None: the preset's.

    Raises:
        ConfigError: no such preset or field, or a value outside its range.
    """
    own = tables_of(tables, engine)
    if engine in (RTL, MODEL):
        config: RunConfig = run_config_from(own, run_config(*sensor, preset, slots), Path())
        return config, config.filters
    settings, filters = engine_settings(engine, sensor, preset)
    return tracker_from(own, engine, settings, filters, Path())

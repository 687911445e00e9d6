# SPDX-License-Identifier: Apache-2.0
"""An engine's settings: those of a preset, with a file's changes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import ConfigError, meant
from ..filters.config import FilterConfig
from ..recordings.formats.source import Sensor
from .config import RunConfig, load_toml, load_tracker
from .engines import ENGINES
from .presets import for_sensor

__all__ = ["engine_settings"]


def engine_settings(
    engine: str, sensor: Sensor, preset: str | None = None, config: Path | None = None, *, mark: str = ""
) -> tuple[Any, FilterConfig]:
    """The settings of an engine of `ENGINES`, and the filters in front of it.

    Args:
        sensor: (width, height) in pixels.
        preset: one of the engine's; None: its first, or of "cot" the one for the sensor.
        config: a TOML file that overrides the preset.
        mark: what messages have in front of an argument's name: `--` on the command line.

    Raises:
        ConfigError: no such engine or preset, or a file that cannot be used.
    """
    if engine not in ENGINES:
        raise ConfigError(f"{mark}engine {engine}: must be one of {', '.join(ENGINES)}{meant(engine, ENGINES)}")
    presets = ENGINES[engine].presets
    if preset not in (None, *presets):
        rule = f"must be one of {', '.join(presets)} with {mark}engine {engine}"
        raise ConfigError(f"{mark}preset {preset}: {rule}{meant(str(preset), presets)}")
    name = preset or (for_sensor(sensor[0]).name if engine == "cot" else next(iter(presets)))
    settings = presets[name]
    if isinstance(settings, RunConfig):
        settings = load_toml(config, settings) if config else settings
        return settings, settings.filters
    filters = ENGINES[engine].filters.get(name, FilterConfig())
    return load_tracker(config, engine, settings, filters) if config else (settings, filters)

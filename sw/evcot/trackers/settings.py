# SPDX-License-Identifier: Apache-2.0
"""An engine's settings: those of a preset, with a file's changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError, meant
from ..filters.config import FilterConfig
from ..hardware.config import MotionConfig
from ..hardware.modules import DEFAULT_MODULE, MODULES
from ..recordings.formats.source import Sensor
from .config import RunConfig, load_toml, load_tracker, with_settings
from .engines import ENGINES
from .presets import for_sensor

__all__ = ["changeable", "changed", "engine_settings"]


def engine_settings(
    engine: str, sensor: Sensor, preset: str | None = None, config: Path | None = None, *, mark: str = ""
) -> tuple[Any, FilterConfig]:
    """The settings of an engine of `ENGINES`, and the filters in front of it.

    Args:
        sensor: (width, height) in pixels.
        preset: one of the engine's; None: its first, of cot, cot_chain and cot_array the one for the sensor.
        config: a TOML file that overrides the preset.
        mark: what messages have in front of an argument's name: `--` on the command line.

    Raises:
        ConfigError: no such engine or preset, or a file that cannot be used.
    """
    if engine not in ENGINES:
        raise ConfigError(f"{mark}engine {engine}: must be one of {', '.join(ENGINES)}{meant(engine, ENGINES)}")
    presets = ENGINES[engine].presets
    if preset not in (None, *presets):
        known = f"must be one of {', '.join(presets)} with {mark}engine {engine}"
        raise ConfigError(f"{mark}preset {preset}: {known}{meant(str(preset), presets)}")
    by_sensor = engine in MODULES and engine != DEFAULT_MODULE
    name = preset or (for_sensor(sensor[0]).name if by_sensor else next(iter(presets)))
    settings = presets[name]
    if isinstance(settings, RunConfig):
        if config is not None:
            settings = load_toml(config, settings)
            module = settings.hardware.module
            if module != engine:
                raise ConfigError(f"{config}: is about {module}: must be used with {mark}engine {module}")
        return settings, settings.filters
    filters = ENGINES[engine].filters.get(name, FilterConfig())
    return load_tracker(config, engine, settings, filters) if config else (settings, filters)


def changeable(engine: str, settings: Any) -> dict[str, Any]:
    """The settings that `changed` can change: those of a software tracker, or the registers of cot_motion.

    Raises:
        ConfigError: another hardware tracker, whose slots have registers of their own.
    """
    if not isinstance(settings, RunConfig):
        return {field.name: getattr(settings, field.name) for field in fields(settings)}
    if not isinstance(settings.hardware, MotionConfig):
        rule = "its slots have registers of their own, which stand in a file"
        raise ConfigError(f"engine {engine} with preset {settings.name}: no single setting can be changed: {rule}")
    registers = settings.hardware.registers
    return {field.name: getattr(registers, field.name) for field in fields(registers)}


def changed(engine: str, settings: Any, changes: Mapping[str, Any]) -> Any:
    """An engine's settings with other values for some of `changeable`.

    Raises:
        ConfigError: no such setting, or a value outside its range.
    """
    if not changes:
        return settings
    known = changeable(engine, settings)
    for key in changes:
        if key not in known:
            rule = f"must be one of {', '.join(known)}{meant(key, known)}" if known else f"engine {engine} has none"
            raise ConfigError(f"{engine}.{key}: no such setting: {rule}")
    if isinstance(settings, RunConfig):
        hardware = settings.hardware
        assert isinstance(hardware, MotionConfig)
        return replace(settings, hardware=replace(hardware, registers=replace(hardware.registers, **changes)))
    return with_settings(engine, settings, changes)

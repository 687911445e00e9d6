# SPDX-License-Identifier: Apache-2.0
"""The unit of work: one engine with one configuration on one recording or scene; and the configuration from its fields."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from hashlib import blake2b
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError
from evcot.filters.config import FilterConfig
from evcot.hardware.modules import MODULES
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig, run_config_from, tracker_from
from evcot.trackers.presets import fit, run_config
from evcot.trackers.settings import engine_settings

from .fields import RTL

__all__ = ["DRAWN", "FUZZ", "Input", "Task", "canonical", "configuration", "tables_of"]


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


DRAWN = "shape.drawn"  # the setting of a task whose shape is random: its number
FUZZ = "fuzz"  # the engine of a task that runs hardware and model on random registers, traffic and stalls


@dataclass(frozen=True)
class Input:
    """Where a run's events come from, and its truth.

    Attributes:
        name: path of a recording, or name of a scene.
        content: digest of the recording's bytes; empty for a scene.
        scene_seed: seed of a scene; None for a recording.
        scene_settings: settings of the scene that differ from its defaults.
        from_us, to_us: the part of it, relative to its first event; to_us None for all.
        width, height: size of the sensor.
        skip_damaged: leave out damaged parts of the file.
        truth: path of the truth; empty for a scene, which has its own, and where there is none.
        truth_content, rule, rule_content: digest of the truth, rule by which it is read (empty: by its columns), digest of a
            rule's file.
        family: group to which it belongs.
    """

    name: str
    content: str = ""
    scene_seed: int | None = None
    scene_settings: Mapping[str, Any] = field(default_factory=dict)
    from_us: int = 0
    to_us: int | None = None
    width: int = 0
    height: int = 0
    skip_damaged: bool = False
    truth: str = ""
    truth_content: str = ""
    rule: str = ""
    rule_content: str = ""
    family: str = ""

    @property
    def is_scene(self) -> bool:
        """Whether it is simulated."""
        return self.scene_seed is not None

    @property
    def has_truth(self) -> bool:
        """Whether tracks can be scored."""
        return self.is_scene or bool(self.truth)


@dataclass(frozen=True)
class Task:
    """One run.

    Attributes:
        engine: a name of `ENGINES`, `fields.RTL`, or `FUZZ`.
        input: its events; None for `FUZZ`.
        preset: the configuration before `tables`; None: the engine's first, or the one for the sensor.
        tables: what differs from the preset, as in a file for `--config`.
        hardware: the module of `RTL` and `FUZZ`; empty otherwise.
        seed: of the stall patterns, of `FUZZ` of everything; None never stalls.
        events: of `FUZZ`, number of events.
        settings: the fields that the sweep has set, by name: the columns of the row.
        code: fingerprint of the program that is to run it, see `machine`.
        design: fingerprint of the hardware; empty without.
    """

    engine: str
    input: Input | None = None
    preset: str | None = None
    tables: Mapping[str, Any] = field(default_factory=dict)
    hardware: str = ""
    seed: int | None = None
    events: int = 0
    settings: Mapping[str, Any] = field(default_factory=dict)
    code: str = ""
    design: str = ""

    @cached_property
    def key(self) -> str:
        """Digest of all that the result depends on: 16 hexadecimal digits. Names of files do not count, their contents do."""
        values = self.to_dict()
        del values["settings"]  # they are in preset, tables and hardware
        own = values["input"]
        if own is not None:
            for name in ("truth", "family", *(("name",) if own["content"] else ())):
                del own[name]
            if own["rule_content"]:
                del own["rule"]
        return blake2b(canonical(values).encode(), digest_size=8).hexdigest()

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return values | {"input": None if self.input is None else {**vars(self.input)}}

    @classmethod
    def from_json(cls, text: str) -> Task:
        """The task of a stored row.

        Raises:
            ConfigError: the text is not one of a task.
        """
        try:
            values = json.loads(text)
            own = values["input"]
            task = cls(**{**values, "input": None if own is None else Input(**own)})
            if not isinstance(task.tables, dict):
                raise TypeError("tables")
            return task
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ConfigError(f"task = {text[:60]!r}: must be a task, as `evcot sweep` stores it") from error


def canonical(value: Any) -> str:
    """One text for equal values."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)

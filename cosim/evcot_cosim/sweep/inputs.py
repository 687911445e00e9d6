# SPDX-License-Identifier: Apache-2.0
"""The inputs of a sweep: recordings and scenes by name, their contents and truths, and their events in a worker."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.metrics import GroundTruth, Rule, load_rule, read_truth, rule_for
from evcot.metrics.rule import RULES
from evcot.metrics.truth import TRUTH_SUFFIXES, ground_truth_of
from evcot.recordings.files import open_recording
from evcot.recordings.formats.source import Sensor
from evcot.scenes import Scene
from evcot.scenes.registry import scene_settings, simulate_scene

from .machine import content_of
from .places import exists, files_in, local, stem_of
from .spec import Spec
from .task import Input, canonical

__all__ = ["Stream", "inputs_of", "opened", "sensor_of", "truth_of"]

_KEPT_EVENTS = 8_000_000  # of the recording that was read last: about 100 MB
_NO_RECORDINGS = (".csv", ".toml", ".json", ".html", ".md", ".png", ".parquet")


@dataclass(frozen=True)
class Stream:
    """Events of an input, in blocks; the time of the recording's first event; the sensor."""

    sensor: Sensor
    first_us: int
    blocks: Iterator[Events]


def inputs_of(spec: Spec) -> list[Input]:
    """Every recording and scene of a specification, with the digests of their contents.

    Raises:
        ConfigError: a path that is not there, or a folder without recordings.
        RecordingError: a file that cannot be read.
    """
    families = {member: family for family, members in spec.families.items() for member in members}
    rule_content = content_of(spec.rule) if spec.rule and spec.rule not in RULES and Path(spec.rule).is_file() else ""
    if spec.rule:
        load_rule(spec.rule)
    found = []
    for given in spec.recordings:
        for name in _files(given):
            truth = spec.truth.get(name, "") or _truth_beside(name)
            content = _content(name)
            truth_content = _content(truth) if truth else ""
            family = families.get(given) or families.get(name) or Path(name).stem
            for begin_us, end_us in spec.parts:
                found.append(
                    Input(
                        name,
                        content,
                        from_us=begin_us,
                        to_us=end_us,
                        skip_damaged=spec.skip_damaged,
                        truth=truth,
                        truth_content=truth_content,
                        rule=spec.rule,
                        rule_content=rule_content,
                        family=family,
                    )
                )
    unused = spec.truth.keys() - {each.name for each in found}
    if unused:
        raise ConfigError(f"truth: {sorted(unused)[0]}: must be one of the recordings")
    for scene in spec.scenes:
        for seed in spec.seeds:
            for begin_us, end_us in spec.parts:
                family = families.get(scene) or scene
                settings = dict(spec.scene_settings)
                found.append(
                    Input(scene, "", seed, settings, begin_us, end_us, rule=spec.rule, rule_content=rule_content, family=family)
                )
    return found


def _files(name: str) -> Sequence[str]:
    """The recordings in a folder, by name; a file itself."""
    try:
        inner = files_in(name)
    except OSError as error:
        raise ConfigError(f"recordings: {name}: is missing: must be a recording, or a folder of them") from error
    if inner is None:
        return [name]
    found = [each for each in inner if _looks_like_one(Path(each))]
    if not found:
        raise ConfigError(f"recordings: {name}: holds no recording: must hold one at least")
    return found


def _looks_like_one(path: Path) -> bool:
    return not path.name.startswith(".") and path.suffix.lower() not in _NO_RECORDINGS


def _truth_beside(name: str) -> str:
    return next((beside for suffix in TRUTH_SUFFIXES if exists(beside := stem_of(name) + suffix)), "")


def _content(name: str) -> str:
    try:
        return content_of(name)
    except OSError as error:
        raise ConfigError(f"{name}: cannot be read: {error.strerror or error}") from error


@lru_cache(maxsize=1 << 16)
def _file_sensor(name: str, _content: str, skip_damaged: bool) -> Sensor:
    with open_recording(local(name), damage="skip" if skip_damaged else "refuse") as file:
        return file.sensor


def sensor_of(source: Input) -> Sensor:
    """Width and height in pixels.

    Raises:
        RecordingError: a recording that cannot be read.
    """
    if source.is_scene:
        settings = scene_settings(source.name, source.scene_seed or 0, source.scene_settings)
        return settings.width, settings.height
    return _file_sensor(source.name, source.content, source.skip_damaged)


@lru_cache(maxsize=2)
def _scene(name: str, seed: int, settings: str) -> Scene:
    return simulate_scene(name, seed, json.loads(settings))


class _Kept:
    """The blocks of the recording that was read last, if it is small enough: tasks on one recording follow each other."""

    def __init__(self) -> None:
        self.of: tuple[str, str, bool] | None = None
        self.blocks: list[Events] = []
        self.sensor: Sensor = (1, 1)
        self.first_us = 0


_kept = _Kept()


@contextmanager
def opened(source: Input) -> Iterator[Stream]:
    """The events of an input, as long as the block lasts; memory is bounded, whatever its length, unless it is a scene.

    Raises:
        RecordingError: it cannot be read, or holds no events.
        ConfigError: it has changed since the sweep began.
    """
    if source.is_scene:
        recording = _scene(source.name, source.scene_seed or 0, canonical(source.scene_settings)).recording
        first_us = int(recording.events.t_us[0]) if len(recording.events) else 0
        part = recording.window(source.from_us, source.to_us)
        yield Stream((recording.width, recording.height), first_us, iter([part.events]))
        return
    try:
        if content_of(source.name) != source.content:
            raise ConfigError(f"{source.name}: has changed since the sweep began: must stay as it is")
        path = local(source.name)
    except OSError as error:
        raise ConfigError(f"{source.name}: cannot be read: {error.strerror or error}") from error
    key = (source.name, source.content, source.skip_damaged)
    if _kept.of == key:
        yield Stream(_kept.sensor, _kept.first_us, _part(_kept.blocks, _kept.first_us, source))
        return
    with open_recording(path, damage="skip" if source.skip_damaged else "refuse") as file:
        whole = (source.from_us, source.to_us) == (0, None)
        blocks = file.blocks(source.from_us, source.to_us, required=True)
        sensor, first_us = file.sensor, file.t0_us
        yield Stream(sensor, first_us, _keeping(key, sensor, first_us, blocks) if whole else blocks)


def _keeping(key: tuple[str, str, bool], sensor: Sensor, first_us: int, blocks: Iterator[Events]) -> Iterator[Events]:
    """The same blocks, remembered at their end if they are few."""
    _kept.of, _kept.blocks = None, []
    kept: list[Events] | None = []
    count = 0
    for block in blocks:
        count += len(block)
        if kept is not None:
            kept.append(block)
            kept = kept if count <= _KEPT_EVENTS else None
        yield block
    if kept is not None:
        _kept.of, _kept.blocks, _kept.sensor, _kept.first_us = key, kept, sensor, first_us


def _part(blocks: Sequence[Events], first_us: int, source: Input) -> Iterator[Events]:
    end_us = None if source.to_us is None else first_us + source.to_us
    for block in blocks:
        begin, end = (
            int(np.searchsorted(block.t_us, limit)) if limit is not None else len(block)
            for limit in (first_us + source.from_us, end_us)
        )
        if begin < end:
            yield block[begin:end]


@lru_cache(maxsize=2)
def _truth(name: str, content: str, rule: str, _rule_content: str, sensor: Sensor) -> tuple[GroundTruth, Rule]:
    path = local(name)
    chosen = load_rule(rule) if rule else rule_for(path)
    chosen = chosen.on(chosen.sensor or sensor)
    return read_truth(path, chosen), chosen


@lru_cache(maxsize=2)
def _scene_truth(name: str, seed: int, settings: str, rule: str, _rule_content: str) -> tuple[GroundTruth, Rule]:
    scene = _scene(name, seed, settings)
    chosen = load_rule(rule or "scene").on((scene.recording.width, scene.recording.height))
    return ground_truth_of(scene.truth, chosen), chosen


def truth_of(source: Input, sensor: Sensor, first_us: int) -> tuple[GroundTruth, Rule] | None:
    """The truth of an input's part, and the rule by which it is read; None where there is none.

    Raises:
        ConfigError, RecordingError: a truth that cannot be read, or has no instant within the part.
    """
    if not source.has_truth:
        return None
    if source.is_scene:
        settings = canonical(source.scene_settings)
        truth, rule = _scene_truth(source.name, source.scene_seed or 0, settings, source.rule, source.rule_content)
    else:
        truth, rule = _truth(source.truth, source.truth_content, source.rule, source.rule_content, sensor)
    if (source.from_us, source.to_us) == (0, None):
        return truth, rule
    end_us = np.iinfo(np.int64).max if source.to_us is None else first_us + source.to_us
    first, end = (int(i) for i in np.searchsorted(truth.instants_us, (first_us + source.from_us, end_us)))
    if first == end:
        where = f"from {source.from_us} to {source.to_us} us"
        raise ConfigError(f"{source.truth or source.name}: no instant {where}: must have one")
    chosen = (truth.objects["frame"] >= first) & (truth.objects["frame"] < end)
    objects = truth.objects[chosen].copy()
    objects["frame"] -= first
    return GroundTruth(truth.instants_us[first:end], objects, truth.ids), rule

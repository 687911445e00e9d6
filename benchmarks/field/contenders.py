# SPDX-License-Identifier: Apache-2.0
"""Who competes on the field: engines of `evcot` and the peers, each with its settings and more of them at random.

The oracle has tracks with true identity, whose boxes are the extents of the objects' events. What it misses is in the truth and
not in the events: sides that send none, objects that stand still.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.filters.config import FILTER_RANGES, FilterConfig
from evcot.hardware.config import CotConfig
from evcot.hardware.motion.contract import MOTION_RANGES
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import DEFAULT, ENGINES
from evcot.trackers.presets import MOTION, fit, for_sensor
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.tracking import Tracker
from field import peers
from field.member import Member

__all__ = ["Contender", "contenders", "more_settings", "oracle_log", "varied_default"]

_BY_THEMSELVES = (DEFAULT, "adaptive")  # follow size, speed and noise, with their first preset: there is nothing to choose
_ARRAY = "cot_array"
_LEFT_OUT = ("cot_chain", "cot")  # the same rules as those of the array, but trackers see less of the events
_SPREAD = 0.4  # standard deviation of a changed setting's logarithm
_CHANGED = 0.4  # share of the settings that are changed
_TRIES = 100

Sensor = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Contender:
    """A tracker.

    Attributes:
        name: of the tracker.
        settings: its presets, by name.
        start: a tracker that has seen nothing, of settings and a sensor.
        vary: other settings, near given ones or anywhere in sensible ranges; None: there is nothing to choose.
        masked: whether hot pixels, learned from the whole recording, are taken out before: for trackers that cannot do it.
        peer: whether it is somebody else's.
    """

    name: str
    settings: Mapping[str, Any]
    start: Callable[[Any, Sensor], Tracker]
    vary: Callable[[Any, np.random.Generator], Any] | None
    masked: bool = True
    peer: bool = False


def contenders(names: list[str] | None = None) -> list[Contender]:
    """Those that are installed; all, or those of the names."""
    found = [_engine(name) for name in ENGINES if name not in _LEFT_OUT]
    found += [peer for peer in _peers() if importlib.util.find_spec(peer.name.replace("-", "_"))]
    return [one for one in found if names is None or one.name in names]


def more_settings(contender: Contender, count: int, random: np.random.Generator) -> dict[str, Any]:
    """The contender's presets, and `count` more settings, each varied from a preset chosen at random."""
    settings = dict(contender.settings)
    if contender.vary is None:
        return settings
    bases = list(contender.settings.values())
    for number in range(count):
        settings[f"random {number + 1}"] = contender.vary(bases[random.integers(len(bases))], random)
    return settings


def varied_default(words: Sequence[str]) -> Contender:
    """The default tracker with settings that differ from its preset as each word says.

    Args:
        words: "NAME=VALUE,NAME=VALUE": registers, `n_slots`, settings of filters.

    Raises:
        ConfigError: no such name, or a value that is not allowed.
    """
    default = _engine(DEFAULT)
    return replace(default, settings={**default.settings, **{word: _changed_default(word) for word in words}})


def _changed_default(word: str) -> tuple[RunConfig, FilterConfig]:
    values = dict(pair.partition("=")[::2] for pair in word.split(","))
    run, filters = MOTION, MOTION.filters
    known = {**MOTION_RANGES, **FILTER_RANGES, "n_slots": (1, 32, "")}
    try:
        numbers = {key: (float if isinstance(known[key][1], float) else int)(value) for key, value in values.items()}
    except (KeyError, ValueError) as error:
        raise ConfigError(f"--vary {word}: {error}: must be a register, n_slots or a filter's setting, and a number") from error
    registers, of_filters = ({key: numbers[key] for key in numbers if key in own} for own in (MOTION_RANGES, FILTER_RANGES))
    hardware = replace(run.hardware, registers=replace(run.hardware.registers, **registers))
    run = replace(run, hardware=hardware)
    if "n_slots" in numbers:
        run = fit(run, 1 << hardware.shape.x_w, 1 << hardware.shape.y_w, int(numbers["n_slots"]))
    return run, filters.changed(of_filters)


def _engine(name: str) -> Contender:
    engine = ENGINES[name]
    by_itself = name in _BY_THEMSELVES

    def start(settings: Any, sensor: Sensor) -> Tracker:
        if isinstance(settings, str):  # the one for the sensor
            settings = for_sensor(sensor[0])
            return engine.start(settings, settings.filters, sensor)
        config, filters = settings
        return engine.start(config, filters, sensor)

    presets = list(engine.presets.items())[: 1 if by_itself else None]
    own: dict[str, Any] = {preset: (config, engine.filters.get(preset, FilterConfig())) for preset, config in presets}
    if name == _ARRAY:
        own = {"for the sensor": "for the sensor", **own}
    return Contender(name, own, start, None if by_itself else _varied_engine, masked=not by_itself)


def _varied_engine(settings: Any, random: np.random.Generator) -> Any:
    if isinstance(settings, str):
        settings = (for_sensor(346), FilterConfig())
    config, filters = settings
    if not isinstance(config, RunConfig):
        return _varied(config, random), filters
    assert isinstance(config.hardware, CotConfig)
    slot = config.hardware.slots[0]
    for _ in range(_TRIES):
        try:
            changed = {name: value for name, value in _changes(slot, random).items() if name != "mode"}
            slots = tuple(replace(one, **changed) for one in config.hardware.slots)
            return replace(config, hardware=replace(config.hardware, slots=slots)), filters
        except ConfigError:
            continue
    return settings


def _varied(config: Any, random: np.random.Generator) -> Any:
    """Some of the numbers larger or smaller; what is forbidden is drawn again."""
    for _ in range(_TRIES):
        try:
            return replace(config, **_changes(config, random))
        except ConfigError:
            continue
    return config


def _changes(config: Any, random: np.random.Generator) -> dict[str, Any]:
    changed: dict[str, Any] = {}
    for field in fields(config):
        value = getattr(config, field.name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not value or random.random() > _CHANGED:
            continue
        other = value * float(np.exp(random.normal(0, _SPREAD)))
        changed[field.name] = round(other) if isinstance(value, int) else other
    return changed


def _peers() -> Iterator[Contender]:
    yield Contender("eventcv", peers.EVENTCV, peers.EventcvTracker, peers.varied_eventcv, peer=True)
    yield Contender("dv-processing", peers.DV, peers.DvTracker, peers.varied_dv, peer=True)


_WITHIN_US = 20_000  # before an instant: like trackers, the oracle knows no later events
_MOST = 300  # events, the latest: those of a fast object lie along its way
_MARGIN_PX = 1.0  # around the truth's box
_LEAST = 8  # events: with fewer an object cannot be seen
_BEYOND = 0.02  # share of the events beyond each side: noise within the truth's box


def oracle_log(member: Member) -> TrackLog:
    """At each instant of the truth, a track for each object that counts."""
    events, truth = member.recording.events, member.truth
    objects = truth.objects[truth.objects["counted"]]
    instants_us = truth.instants_us[objects["frame"]]
    spans = np.searchsorted(events.t_us, [instants_us - _WITHIN_US, instants_us + 1]).T
    records = np.zeros(len(objects), TRACK)
    records["t_us"], records["track_id"], records["kind"], records["other_id"] = instants_us, objects["object"], Kind.MOVED, -1
    seen = np.zeros(len(objects), np.bool_)
    for number, (one, (begin, end)) in enumerate(zip(objects, spans, strict=True)):
        x, y = events.x[begin:end], events.y[begin:end]
        off = np.abs(x - one["x"]) - one["width"] / 2, np.abs(y - one["y"]) - one["height"] / 2
        latest = np.flatnonzero(np.maximum(*off) <= _MARGIN_PX)[-_MOST:]
        seen[number] = len(latest) >= _LEAST
        if seen[number]:
            _extents(records[number : number + 1], x[latest], y[latest])
    return TrackLog("oracle", records[seen], np.empty(0, np.int16))


def _extents(record: NDArray[np.void], x: NDArray[np.uint16], y: NDArray[np.uint16]) -> None:
    for axis, side, column in (("x", "width", x), ("y", "height", y)):
        low, high = np.quantile(column, [_BEYOND, 1 - _BEYOND])
        record[axis], record[side] = (low + high) / 2, high - low + 1
    record["radius"] = max(record["width"][0], record["height"][0]) / 2

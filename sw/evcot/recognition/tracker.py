# SPDX-License-Identifier: Apache-2.0
"""The golden model of the tracker with the classifier behind it, and the windows of its tracks for training."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..events import Events
from ..filters.config import FilterConfig
from ..hardware.classifier import CELLS, NONE, RecognitionRegisters
from ..hardware.config import CotConfig, MotionConfig
from ..hardware.golden import GoldenTracker
from ..hardware.model import Decisions
from ..recordings.formats.source import Sensor
from ..trackers.config import RunConfig
from ..trackers.presets import fit
from ..tracks.record import TRACK, VERDICT, last_until, no_verdicts
from ..tracks.tracking import TrackerOutput
from .model import Classifier, OwnedEvents, Windows
from .weights import Weights, class_indices

__all__ = ["ClassifyingTracker", "TrackClassifier", "TrackWindows", "WindowTracker", "joined", "start_classifying"]


class _Newest:
    """The newest record of each slot."""

    def __init__(self, n_slots: int) -> None:
        self._past = np.zeros(n_slots, TRACK)
        self._past["track_id"] = -1

    def at(self, event: NDArray[np.int64], slot: NDArray[np.int64], records: NDArray[np.void]) -> NDArray[np.void]:
        """The newest record of a slot at each event, (k,) of dtype `TRACK`; `records` are those of the run."""
        last = last_until(records["slot"], records["event_index"], slot, event)
        found = self._past[slot]
        found[last >= 0] = records[last[last >= 0]]
        return found

    def fed(self, records: NDArray[np.void]) -> None:
        """The run ends."""
        slots, last = np.unique(records["slot"][::-1], return_index=True)
        self._past[slots] = records[len(records) - 1 - last]


class TrackClassifier:
    """The classifier behind a tracker's decisions: the verdicts of its tracks, in the units of a track log.

    Args:
        config: of the tracker.

    Raises:
        ConfigError: another tracker than that of the weights.
    """

    def __init__(self, config: CotConfig | MotionConfig, weights: Weights) -> None:
        if config.module != weights.tracker:
            raise ConfigError(f"engine {config.module}: must be {weights.tracker}, the tracker of the weights")
        shape = config.shape
        self._classifier = Classifier(weights.registers, weights.network, shape.n_slots, shape.rel_w)
        self._size_speed = weights.size_speed
        self._class_ids = np.full(NONE + 1, -1, np.int64)
        self._class_ids[: len(weights.class_ids)] = weights.class_ids
        self._newest = _Newest(shape.n_slots)

    def feed(
        self, events: Events, first: int, decided: Decisions, visible: NDArray[np.bool_], records: NDArray[np.void]
    ) -> NDArray[np.void]:
        """The verdicts of a run of events, (k,) of dtype `VERDICT`.

        Args:
            first: number of the run's first event.
            decided, visible: what the tracker decided on the events.
            records: those of the run, (m,) of dtype `TRACK`.
        """
        raw = self._classifier.feed(OwnedEvents(*decided[1:], visible))
        verdicts = np.zeros(len(raw), VERDICT)
        event = raw["seq"].astype(np.int64)
        verdicts["event_index"], verdicts["t_us"] = event, events.t_us[event - first]
        for name in ("slot", "margin", "windows"):
            verdicts[name] = raw[name]
        states = self._newest.at(event, raw["slot"].astype(np.int64), records)
        verdicts["track_id"] = states["track_id"]
        index = class_indices(self._size_speed, raw, states) if len(self._size_speed) else raw["class"]
        verdicts["class_id"] = self._class_ids[index]
        self._newest.fed(records)
        return verdicts


class ClassifyingTracker(GoldenTracker):
    """The tracker with a classifier. See `tracking.Tracker`.

    Attributes:
        class_names: of the weights.

    Raises:
        ConfigError: another tracker than that of the weights.
    """

    def __init__(self, config: CotConfig | MotionConfig, weights: Weights) -> None:
        super().__init__(config)
        self._classifier = TrackClassifier(config, weights)
        self.class_names = weights.names
        self._verdicts: list[NDArray[np.void]] = []

    def feed(self, events: Events) -> TrackerOutput:
        """See `tracking.Tracker`."""
        first = self._seen
        records, decided = self.decide(events)
        verdicts = self._classifier.feed(events, first, decided, self._model.visible, records)
        if len(verdicts):
            self._verdicts.append(verdicts)
        return records, decided.owner

    def take_verdicts(self) -> NDArray[np.void]:
        """The verdicts since the last call, (k,) of dtype `VERDICT`; about 50 bytes per K owned events wait for it."""
        taken = np.concatenate([no_verdicts(), *self._verdicts])
        self._verdicts.clear()
        return taken


def start_classifying(
    engine: str, settings: Any, filters: FilterConfig, sensor: Sensor, weights: Weights
) -> ClassifyingTracker:
    """As `engines.Engine.start`, with a classifier.

    Raises:
        ConfigError: another tracker than that of the weights, or a value outside its range.
    """
    if not isinstance(settings, RunConfig) or engine != weights.tracker:
        raise ConfigError(f"engine {engine}: must be {weights.tracker}, the tracker of the weights")
    config = replace(fit(settings, *sensor), filters=filters).device_config(*sensor)
    return ClassifyingTracker(config, weights)


class TrackWindows(NamedTuple):
    """Windows of tracks, for training.

    Attributes:
        t_us: (n,) int64, when each closed.
        states: (n,) of dtype `TRACK`, the newest record of its track at that time.
        images: (n, CELLS^2) uint8.
    """

    t_us: NDArray[np.int64]
    states: NDArray[np.void]
    images: NDArray[np.uint8]


class WindowTracker(GoldenTracker):
    """The tracker with the classifier's front end: the windows that have a verdict."""

    def __init__(self, config: MotionConfig, registers: RecognitionRegisters) -> None:
        super().__init__(config)
        self._windows = Windows(registers, config.shape.n_slots, config.shape.rel_w)
        self._newest = _Newest(config.shape.n_slots)

    def windows(self, events: Events) -> TrackWindows:
        """Those that close in a run of events."""
        begin = self._seen
        records, decided = self.decide(events)
        parts = []
        for closed in self._windows.feed(OwnedEvents(*decided[1:], self._model.visible)):
            kept = closed.stage > 0
            event = closed.event[kept]
            states = self._newest.at(event + begin, closed.slot[kept], records)
            parts.append(TrackWindows(events.t_us[event], states, closed.images[kept]))
        self._newest.fed(records)
        return joined(parts)


def joined(parts: list[TrackWindows]) -> TrackWindows:
    """All windows, in order."""
    if not parts:
        return TrackWindows(np.zeros(0, np.int64), np.zeros(0, TRACK), np.zeros((0, CELLS**2), np.uint8))
    return TrackWindows(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))

# SPDX-License-Identifier: Apache-2.0
"""The golden model that belongs to a configuration, its records in the units of a TrackLog, and the model as a tracker."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..events import Events, Recording
from ..ticks import TickCounter
from ..tracks.log import TRACK, Kind, TrackLog
from ..tracks.tracking import TrackerOutput, log_of
from .config import CotConfig, HardwareConfig, MotionConfig
from .cot import CotModel
from .model import Decisions
from .motion.contract import SUB
from .motion.model import MotionModel

__all__ = ["GoldenTracker", "golden_model", "to_track_records", "track"]


def golden_model(config: CotConfig | MotionConfig) -> CotModel | MotionModel:
    """The golden model of a configuration, in its state after reset."""
    HardwareConfig.check_type(config)
    return MotionModel(config) if isinstance(config, MotionConfig) else CotModel(config)


def to_track_records(
    raw: NDArray[np.void], config: CotConfig | MotionConfig, t_us: NDArray[np.int64], first_seq: int, t0_us: int
) -> NDArray[np.void]:
    """Convert raw records to the units of a TrackLog: pixels, microseconds, event indices.

    Of the modules only cot_motion estimates extent and velocity. With the others width and height are the sides of the window,
    and vx, vy and angle are 0.

    Args:
        raw: (m,) of dtype `contract.RECORD` or `motion.contract.MOTION_RECORD`.
        config: the configuration that produced them.
        t_us: times of the events `first_seq`, `first_seq + 1`, …; must hold every event that caused a record.
        first_seq: sequence number of `t_us[0]`.
        t0_us: time of tick 0.
    """
    out = np.zeros(len(raw), TRACK)
    in_ticks = (raw["kind"] == Kind.LOST) | isinstance(config, MotionConfig)  # motion steps are between events
    seq = raw["seq"].astype(np.int64)
    cause = np.where(in_ticks, 0, seq - first_seq)
    out["t_us"] = np.where(in_ticks, t0_us + raw["time"].astype(np.int64) * config.tick_us, t_us[cause] if len(t_us) else 0)
    out["event_index"] = seq
    for name in ("kind", "track_id", "slot", "n_ev", "support"):
        out[name] = raw[name]
    visible = (_motion_fields if isinstance(config, MotionConfig) else _cot_fields)(raw, config, out)  # type: ignore[arg-type]
    out["confidence"] = out["support"] / (out["support"] + visible)
    out["other_id"] = np.where(raw["kind"] == Kind.MERGED, raw["other_id"].astype(np.int64), -1)
    return out


def _cot_fields(raw: NDArray[np.void], config: CotConfig, out: NDArray[np.void]) -> NDArray[np.float64]:
    """Fill in the window; returns the events that made each track visible."""
    out["x"], out["y"] = (raw[name] / (1 << config.shape.frac) for name in ("cm_x", "cm_y"))
    out["radius"] = raw["radius"]
    out["width"] = out["height"] = 2.0 * out["radius"] + 1.0
    return np.array([slot.clust_nev for slot in config.slots], np.float64).take(raw["slot"], mode="clip")


def _motion_fields(raw: NDArray[np.void], config: MotionConfig, out: NDArray[np.void]) -> NDArray[np.float64]:
    """Fill in box and velocity; returns the events that made each track visible."""
    registers = config.registers
    out["x"], out["y"] = (raw[name] / (1 << SUB) for name in ("cm_x", "cm_y"))
    whole = 1.0 + 1.0 / (1 << registers.side_share)  # sides are quantiles: some events lie beyond them
    for name in ("width", "height"):
        out[name] = whole * raw[name] / (1 << SUB) + 1.0
    out["radius"] = np.maximum(out["width"], out["height"]) / 2.0
    per_s = 1e6 / ((1 << SUB) * (1 << registers.step_log2) * config.tick_us)
    out["vx"], out["vy"] = raw["v_x"] * per_s, raw["v_y"] * per_s
    return np.full(len(raw), registers.birth_support, np.float64)


class GoldenTracker:
    """A golden model with times in microseconds, tick 0 at the first event. See `tracking.Tracker`.

    Args:
        config: the hardware's.
    """

    def __init__(self, config: CotConfig | MotionConfig) -> None:
        self._config = config
        self._model = golden_model(config)
        self._clock = TickCounter(config.tick_us)
        self._seen = 0

    def feed(self, events: Events) -> TrackerOutput:
        """See `tracking.Tracker`."""
        records, decided = self.decide(events)
        return records, decided.owner

    def decide(self, events: Events) -> tuple[NDArray[np.void], Decisions]:
        """As `feed`: the records, (m,) of dtype `TRACK`, and all that the model decided on each event."""
        ticked = self._clock.count(events)
        decided = self._model.feed(ticked)
        records = to_track_records(decided.records, self._config, events.t_us, self._seen, self._clock.t0_us)
        self._seen += len(events)
        return records, decided

    def finish(self) -> NDArray[np.void]:
        """Returns no records: time does not advance after the last event."""
        return np.empty(0, TRACK)

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: all events, since each event's records are returned with it."""
        return self._seen


def track(recording: Recording, config: CotConfig | MotionConfig) -> TrackLog:
    """Run the golden model over a recording; tick 0 is the time of the first event."""
    return log_of(config.module, GoldenTracker(config), [recording.events])

# SPDX-License-Identifier: Apache-2.0
"""The golden model of the hardware tracker: bit-exact, event-level, without clock cycles.

It computes with integers of the widths that the RTL has by `contract.Shape`, and returns the same raw records, owners and
recentred addresses. docs/algorithm.md specifies the rules; the arithmetic is equation (6) of the paper with
alpha = 2^-hist_avg.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..events import Events, Recording
from ..filters.base import EventFilter
from ..filters.chain import FilterChain
from ..ticks import TickCounter, TickedEvents
from ..tracks.log import DROPPED, TRACK, Kind, TrackLog
from ..tracks.tracking import TrackerOutput, log_of
from ._cot_kernel import FIELD_COUNT, GLOBAL_COUNT, LIMIT_COUNT, Global, Limit, feed, initialise, rewrite
from .config import CotConfig, SlotConfig
from .contract import RECORD, REGISTERS, Mode
from .motion.contract import MOTION_RECORD, SUB, MotionRegisters
from .motion.model import MotionModel

__all__ = ["Arrangement", "CotModel", "CotTracker", "Decisions", "to_track_records", "track"]

_ALL = np.empty(0, np.bool_)


class Arrangement(StrEnum):
    """How events are distributed to several trackers."""

    ARRAY = "array"  # every slot sees every event; active windows never overlap
    CHAIN = "chain"  # each tracker sees the events that the one before it passed on


class Decisions(NamedTuple):
    """The result of a run of events.

    Attributes:
        records: (m,) of dtype `contract.RECORD`, with motion `motion.contract.MOTION_RECORD`; in chronological order.
        owner: (n,) int16, the slot that took each event, -1 if none did, `tracks.log.DROPPED` if a
            filter dropped it.
        rel_x, rel_y: (n,) uint16, the event's address in its owner's window (x - cm_x + R), 0 without an owner.
    """

    records: NDArray[np.void]
    owner: NDArray[np.int16]
    rel_x: NDArray[np.uint16]
    rel_y: NDArray[np.uint16]


class CotModel:
    """The model as a stream: feed events in runs of any length; the result does not depend on how they are split into runs.

    About 30 to 60 ns per event with 8 slots; memory is proportional to the events fed at once.

    Args:
        config: shape and registers.
        arrangement: array (the default) or chain, which has no motion.

    Raises:
        ConfigError: a chain with motion.
    """

    def __init__(self, config: CotConfig, arrangement: Arrangement = Arrangement.ARRAY) -> None:
        CotConfig.check(config)
        shape = config.shape
        self.config = config
        self._regs = np.array([[getattr(slot, name) for slot in config.slots] for name in REGISTERS], np.int64)
        self._limits = np.zeros(LIMIT_COUNT, np.int64)
        self._limits[Limit.FRAC] = shape.frac
        self._limits[Limit.X_MAX] = (1 << shape.x_w) - 1
        self._limits[Limit.Y_MAX] = (1 << shape.y_w) - 1
        self._limits[Limit.TC_MAX] = (1 << shape.tc_w) - 1
        self._limits[Limit.SUPPORT_MAX] = (1 << shape.sup_w) - 1
        self._limits[Limit.ID_MASK] = (1 << shape.id_w) - 1
        self._limits[Limit.IS_CHAIN] = arrangement is Arrangement.CHAIN
        self._limits[Limit.REL_MASK] = (1 << shape.rel_w) - 1
        self._state = np.zeros((FIELD_COUNT, shape.n_slots), np.int64)
        self._globals = np.zeros(GLOBAL_COUNT, np.int64)
        self._filters = FilterChain(config.filters, config.filter_shape) if config.filtered else None
        initialise(self._state, self._regs, self._limits, self._globals)
        self._motion: MotionModel | None = None
        if config.motion.enable:
            if arrangement is Arrangement.CHAIN:
                raise ConfigError("motion.enable = 1: must be 0 for a chain; only an array has motion")
            self._motion = MotionModel(shape, config.motion, [slot.mode for slot in config.slots])

    def feed(self, events: TickedEvents, keep: NDArray[np.bool_] | None = None) -> Decisions:
        """Process a run of events.

        Args:
            events: ticks never decrease over the model's life, and addresses are below 2^x_w and 2^y_w.
            keep: (n,) bool, mask of the events that passed external filters; the others are counted but have no owner. None
                for all. Not allowed if the model has filters itself.
        """
        n = len(events)
        if self._filters is not None:
            if keep is not None:
                raise ConfigError("a model with filters decides itself which events stay")
            keep = self._filters.feed(events)
        keep = _ALL if keep is None else events.mask(keep)
        owner = np.empty(n, np.int16)
        rel_x = np.zeros(n, np.uint16)
        rel_y = np.zeros(n, np.uint16)
        if self._motion is not None:
            kept = np.arange(n) if keep is _ALL else np.flatnonzero(keep)
            owner[:] = DROPPED
            return Decisions(self._motion.feed(events, kept, owner, rel_x, rel_y), owner, rel_x, rel_y)
        per_event_max = 3 * self.config.shape.n_slots
        parts: list[NDArray[np.void]] = []
        done = 0
        while done < n:
            buffer = np.zeros(max(2 * per_event_max, (n - done) // 4), RECORD)
            done, count = feed(
                self._state, self._regs, self._limits, self._globals,
                events.ticks, events.x, events.y, keep, done, per_event_max, owner, rel_x, rel_y, buffer,
            )  # fmt: skip
            parts.append(buffer[:count])
        records = parts[0] if len(parts) == 1 else np.concatenate(parts) if parts else np.zeros(0, RECORD)
        return Decisions(records, owner, rel_x, rel_y)

    def write_registers(self, slot: int, registers: SlotConfig, *, restart: bool) -> NDArray[np.void]:
        """Change a slot's registers before the next event, as a commit does: docs/registers.md.

        Args:
            restart: `mode` is written, too, which ends the slot's current life; returns its record, (m,) RECORD.

        Raises:
            ConfigError: a register outside its limits.
        """
        registers.check(self.config.shape, f"slot[{slot}]")
        if self._motion is not None:
            if registers.mode == Mode.FIXED:
                raise ConfigError(f"slot[{slot}].mode = {int(registers.mode)}: must be 0 or 2 with motion.enable = 1")
            return self._motion.set_mode(slot, registers.mode) if restart else np.zeros(0, MOTION_RECORD)
        values = np.array([getattr(registers, name) for name in REGISTERS], np.int64)
        room = np.zeros(1, RECORD)
        return room[: rewrite(self._state, self._regs, self._limits, self._globals, slot, values, restart, room)]

    def write_motion(self, registers: MotionRegisters) -> None:
        """Change the registers of an array with motion before the next event, as commits do: docs/registers.md.

        Raises:
            ConfigError: the model is none with motion, or the registers turn it off.
        """
        if self._motion is None or not registers.enable:
            raise ConfigError(f"motion.enable = {registers.enable}: a model with motion has it on, another never")
        self._motion.write(registers)

    @property
    def time(self) -> int:
        """Ticks since reset."""
        return int(self._globals[Global.NOW]) if self._motion is None else self._motion.time


def to_track_records(
    raw: NDArray[np.void], config: CotConfig, t_us: NDArray[np.int64], first_seq: int, t0_us: int
) -> NDArray[np.void]:
    """Convert raw records to the units of a TrackLog: pixels, microseconds, event indices.

    Without motion the hardware estimates neither extent nor velocity: width and height are the sides of the window, and vx, vy
    and angle 0.

    Args:
        raw: (m,) of dtype `contract.RECORD` or `motion.contract.MOTION_RECORD`.
        config: the configuration that produced them.
        t_us: times of the events `first_seq`, `first_seq + 1`, …; must hold every event that caused a record.
        first_seq: sequence number of `t_us[0]`.
        t0_us: time of tick 0.
    """
    out = np.zeros(len(raw), TRACK)
    in_ticks = (raw["kind"] == Kind.LOST) | bool(config.motion.enable)  # motion steps are between events
    seq = raw["seq"].astype(np.int64)
    cause = np.where(in_ticks, 0, seq - first_seq)
    out["t_us"] = np.where(in_ticks, t0_us + raw["time"].astype(np.int64) * config.tick_us, t_us[cause] if len(t_us) else 0)
    out["event_index"] = seq
    for name in ("kind", "track_id", "slot", "n_ev", "support"):
        out[name] = raw[name]
    frac = SUB if config.motion.enable else config.shape.frac
    out["x"] = raw["cm_x"] / (1 << frac)
    out["y"] = raw["cm_y"] / (1 << frac)
    if config.motion.enable:
        whole = 1.0 + 1.0 / (1 << config.motion.side_share)  # sides are quantiles: some events lie beyond them
        for name in ("width", "height"):
            out[name] = whole * raw[name] / (1 << SUB) + 1.0
        out["radius"] = np.maximum(out["width"], out["height"]) / 2.0
        per_s = 1e6 / ((1 << SUB) * (1 << config.motion.step_log2) * config.tick_us)
        out["vx"], out["vy"] = raw["v_x"] * per_s, raw["v_y"] * per_s
        visible = np.full(len(raw), config.motion.birth_support, np.float64)
    else:
        out["radius"] = raw["radius"]
        out["width"] = out["height"] = 2.0 * out["radius"] + 1.0
        visible = np.array([slot.clust_nev for slot in config.slots], np.float64).take(raw["slot"], mode="clip")
    out["confidence"] = out["support"] / (out["support"] + visible)
    out["other_id"] = np.where(raw["kind"] == Kind.MERGED, raw["other_id"].astype(np.int64), -1)
    return out


class CotTracker:
    """The model with times in microseconds, tick 0 at the first event. See `tracking.Tracker`.

    Args:
        config, arrangement: see `CotModel`.
        before: a filter in front of the model, which has none itself.
    """

    def __init__(
        self, config: CotConfig, arrangement: Arrangement = Arrangement.ARRAY, before: EventFilter | None = None
    ) -> None:
        self._config = config
        self._before = before
        self._model = CotModel(config, arrangement)
        self._clock = TickCounter(config.tick_us)
        self._seen = 0

    def feed(self, events: Events) -> TrackerOutput:
        """See `tracking.Tracker`."""
        ticked = self._clock.count(events)
        decided = self._model.feed(ticked, self._before.feed(ticked) if self._before else None)
        records = to_track_records(decided.records, self._config, events.t_us, self._seen, self._clock.t0_us)
        self._seen += len(events)
        return records, decided.owner

    def finish(self) -> NDArray[np.void]:
        """Returns no records: time does not advance after the last event."""
        return np.empty(0, TRACK)

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: all events, since each event's records are returned with it."""
        return self._seen


def track(recording: Recording, config: CotConfig, arrangement: Arrangement = Arrangement.ARRAY) -> TrackLog:
    """Run the golden model over a recording; tick 0 is the time of the first event."""
    return log_of("cot-model", CotTracker(config, arrangement), [recording.events])

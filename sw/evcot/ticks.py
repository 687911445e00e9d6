# SPDX-License-Identifier: Apache-2.0
"""Time in the hardware: ticks since the first event of a run, and events with times in ticks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import RecordingError
from .events import Events

__all__ = ["TickCounter", "TickedEvents", "tick_times"]

_COLUMNS = {name: np.dtype(kind) for name, kind in (("ticks", "i8"), ("x", "u2"), ("y", "u2"), ("p", "u1"))}


def tick_times(t_us: NDArray[np.int64], t0_us: int, tick_us: int) -> NDArray[np.int64]:
    """Number of ticks elapsed since `t0_us` at each event: floor((t - t0) / tick_us), (n,) int64."""
    since = t_us - t0_us
    return since if tick_us == 1 else since // tick_us


@dataclass(frozen=True, eq=False)
class TickedEvents:
    """Events with times in ticks, the input of trackers and filters in hardware and of their models.

    The columns are contiguous, read-only and of these types, whatever they were made from, so Numba compiles a loop over them
    only once. A part, `events[begin:end]`, shares memory.

    Attributes:
        ticks: (n,) int64, ticks since reset at each event, never decreasing.
        x, y: (n,) uint16 pixel addresses.
        p: (n,) uint8 polarities, 0 or 1.

    Raises:
        RecordingError: columns of different length, or a value that its type cannot hold.
    """

    ticks: NDArray[np.int64]
    x: NDArray[np.uint16]
    y: NDArray[np.uint16]
    p: NDArray[np.uint8]

    def __post_init__(self) -> None:
        for name, kind in _COLUMNS.items():
            object.__setattr__(self, name, _column(name, kind, getattr(self, name)))
        if not len(self.ticks) == len(self.x) == len(self.y) == len(self.p):
            raise RecordingError(
                f"ticks, x, y, p hold {len(self.ticks)}, {len(self.x)}, {len(self.y)}, {len(self.p)} values: "
                "all must be the same"
            )

    @classmethod
    def of(cls, events: Events, tick_us: int = 1, t0_us: int | None = None) -> TickedEvents:
        """Events in ticks of `tick_us`; tick 0 is at `t0_us`, or else at the first of them."""
        if t0_us is None:
            t0_us = int(events.t_us[0]) if len(events) else 0
        return cls(tick_times(events.t_us, t0_us, tick_us), events.x, events.y, events.p)

    def __len__(self) -> int:
        return len(self.ticks)

    def __getitem__(self, which: slice | NDArray[np.bool_]) -> TickedEvents:
        """A run of the events, or those whose entry in a mask, (n,) bool, is true."""
        return TickedEvents(self.ticks[which], self.x[which], self.y[which], self.p[which])

    def mask(self, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """`keep` as a contiguous mask of these events, (n,) bool.

        Raises:
            RecordingError: it has another length.
        """
        if len(keep) != len(self):
            raise RecordingError(f"keep holds {len(keep)} values: must be one for each of {len(self)} events")
        return np.ascontiguousarray(keep, np.bool_)


def _column(name: str, kind: np.dtype[Any], given: NDArray[Any]) -> NDArray[Any]:
    """The same values as a contiguous, read-only column of its own type."""
    if given.dtype == kind and given.flags.c_contiguous:
        column = given.view()
    else:
        with np.errstate(invalid="ignore"):
            column = np.ascontiguousarray(given, kind)
        if not np.array_equal(column, given):
            i = int(np.argmax(column != given))
            raise RecordingError(f"event {i}: {name} = {given[i]}: must be a value of {kind}")
    column.flags.writeable = False
    return column


class TickCounter:
    """Counts the times of a recording that comes in runs: tick 0 is the time of the first event of all.

    Attributes:
        tick_us: length of a tick.
        t0_us: when tick 0 was; 0 as long as there was no event.
    """

    def __init__(self, tick_us: int) -> None:
        self.tick_us = tick_us
        self.t0_us = 0
        self._began = False

    def count(self, events: Events) -> TickedEvents:
        """The next run of events in ticks."""
        if len(events) and not self._began:
            self._began, self.t0_us = True, int(events.t_us[0])
        return TickedEvents.of(events, self.tick_us, self.t0_us)

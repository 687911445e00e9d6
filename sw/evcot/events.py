# SPDX-License-Identifier: Apache-2.0
"""Events and recordings: structures of arrays, validated once, immutable by convention."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .dataframes import Columns, Tabular
from .errors import RecordingError
from .page import EVENTS_MAX, HEIGHT_PX, Page
from .structured import EVENT_CD, array_of, columns_of

__all__ = ["Events", "Fault", "Recording", "check_sensor", "find_fault"]

_NEVER = np.iinfo(np.int64).min


@dataclass(frozen=True, eq=False)
class Events(Tabular):
    """Events in time order, one array per field; one row per event in a data frame.

    Attributes:
        t_us: (n,) int64, microseconds, never decreasing.
        x: (n,) uint16, pixels from the left.
        y: (n,) uint16, pixels from the top.
        p: (n,) uint8, 1 where the pixel became brighter, 0 where darker.
    """

    t_us: NDArray[np.int64]
    x: NDArray[np.uint16]
    y: NDArray[np.uint16]
    p: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.t_us)

    def __getitem__(self, window: slice) -> Events:
        return Events(self.t_us[window], self.x[window], self.y[window], self.p[window])

    def where(self, keep: NDArray[np.bool_]) -> Events:
        """A copy of the events whose entry in `keep`, (n,) bool, is true."""
        return Events(self.t_us[keep], self.x[keep], self.y[keep], self.p[keep])

    @classmethod
    def joined(cls, blocks: Iterable[Events]) -> Events:
        """Concatenate blocks of events."""
        parts = [cls.empty(), *blocks]
        if len(parts) == 2:
            return parts[1]
        return cls(*(np.concatenate([getattr(part, field) for part in parts]) for field in ("t_us", "x", "y", "p")))

    @classmethod
    def allocated(cls, count: int) -> Events:
        """Uninitialised arrays for `count` events."""
        return cls(np.empty(count, np.int64), np.empty(count, np.uint16), np.empty(count, np.uint16), np.empty(count, np.uint8))

    def __repr__(self) -> str:
        if not len(self.t_us):
            return "<Events: none>"
        return f"<Events: {len(self.t_us):,}, from {int(self.t_us[0]):,} to {int(self.t_us[-1]):,} us>"

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """A structured array as `to_array` makes it, for `numpy.asarray`; always a copy.

        Raises:
            ValueError: `copy` is False.
        """
        if copy is False:
            raise ValueError("copy = False: must be True or None: the columns of events do not lie side by side")
        return self.to_array() if dtype is None else self.to_array(dtype)

    @classmethod
    def empty(cls) -> Events:
        """No events."""
        return cls.allocated(0)

    @classmethod
    def from_array(cls, array: NDArray[np.void]) -> Events:
        """Events of a structured array with the fields `x`, `y`, `p` and `t`, as OpenEB and tonic hold them.

        Nothing is copied where a field's low bytes are the column's type, which those of OpenEB (x, y uint16, p int16, t int64)
        and of tonic (x, y int16, t int64, p bool) are: the columns are views of the array, and change with it. Such columns
        have gaps; kernels want them without (`packed`), and a `Recording` takes care of that by one copy.

        Example:
            recording = Recording(Events.from_array(array), width=1280, height=720)

        Args:
            array: (n,) in time order; `t` in whole microseconds, `p` 0 or 1 or bool, `x` and `y` in pixels. Other fields are
                ignored.

        Raises:
            RecordingError: a field is missing or of no whole numbers, a value lies outside (x, y: 0 to 65535; p: 0 or 1), or
                time runs back; the message names event, field, value and rule.
        """
        return cls(*columns_of(array))

    def to_array(self, dtype: DTypeLike = EVENT_CD) -> NDArray[np.void]:
        """A copy as one structured array, whose fields lie side by side while the columns do not.

        Args:
            dtype: with the fields `x`, `y`, `p` and `t` in any order, of whole numbers (`p` also bool); by default OpenEB's.

        Raises:
            RecordingError: a field is missing, unknown or of no whole numbers, or cannot hold a value.
        """
        return array_of((self.t_us, self.x, self.y, self.p), np.dtype(dtype))

    def _columns(self) -> Columns:
        return {"t_us": self.t_us, "x": self.x, "y": self.y, "p": self.p}

    def packed(self) -> Events:
        """The same events in columns without gaps: itself where it has none, else a copy."""
        columns = self._columns().values()
        if all(column.flags.c_contiguous and column.flags.aligned for column in columns):
            return self
        return Events(*(np.require(column, requirements=["C", "A"]) for column in columns))

    def read_only(self) -> Events:
        """Views of the columns that cannot be written. Numba compiles a loop for each kind of array; so all get this one."""
        seen = self[:]
        for column in (seen.t_us, seen.x, seen.y, seen.p):
            column.flags.writeable = False
        return seen

    def kept(self) -> Events:
        """A copy, for a block that is kept: a reader's may be part of larger arrays, which would stay in memory with it."""
        return Events(self.t_us.copy(), self.x.copy(), self.y.copy(), self.p.copy())


MOST_PIXELS = 1 << 24  # 4096x4096: 20 times what event cameras have, and at most 1.5 GB in any tracker, filter or picture


@dataclass(frozen=True)
class Fault:
    """The first invalid event of a recording: its index, and the error message."""

    index: int
    what: str

    def describe(self, first_index: int = 0) -> str:
        """One-line message, for events that begin at index `first_index` of a recording."""
        return f"event {first_index + self.index}: {self.what}"


def find_fault(events: Events, width: int, height: int, after_us: int = _NEVER) -> Fault | None:
    """The first event that is earlier than the previous one (or than `after_us`, for the first), lies outside the sensor, or
    has a polarity other than 0 and 1; None if there is none. About 0.2 ns per event."""
    from ._sound_kernel import first_fault, is_sound  # Numba takes longer to load than all that only names events

    seen = events.read_only()
    t_us, x, y, p = seen.t_us, seen.x, seen.y, seen.p
    if is_sound(t_us, x, y, p, after_us, width, height):
        return None
    i = int(first_fault(t_us, x, y, p, after_us, width, height))
    before = int(t_us[i - 1]) if i else after_us
    if t_us[i] < before:
        return Fault(i, f"t = {t_us[i]} us follows t = {before} us: time must not run back")
    for axis, values, size in (("x", x, width), ("y", y, height)):
        if values[i] >= size:
            return Fault(i, f"{axis} = {values[i]}: must be below the sensor's {size}")
    return Fault(i, f"p = {p[i]}: must be 0 or 1")


def check_sensor(name: str, width: int, height: int) -> None:
    """Raise RecordingError for a sensor without pixels, or larger than an event's address."""
    if not 1 <= width <= 65536 or not 1 <= height <= 65536:
        raise RecordingError(f"{name}: sensor {width}x{height}: each side must be from 1 to 65536 pixels")


def check_pixels(width: int, height: int) -> None:
    """Raise RecordingError for a sensor that is too large for work with memory for every pixel: more than `MOST_PIXELS`."""
    if width * height > MOST_PIXELS:
        rule = f"must be at most {MOST_PIXELS:,} for this; --sensor WxH states a smaller sensor, where events lie within it"
        raise RecordingError(f"sensor {width}x{height}: {width * height:,} pixels: {rule}")


@dataclass(frozen=True, eq=False)
class Recording:
    """Events and the sensor that they come from.

    Attributes:
        events: the events, in time order; `packed`.
        width, height: sensor size in pixels.
        name: its origin, for messages and output folders.

    Raises:
        RecordingError: arrays of different length, time running backwards, or an event outside the sensor; the message
            names the event's index, the value and the rule.
    """

    events: Events
    width: int
    height: int
    name: str = "recording"

    def __repr__(self) -> str:
        n, seconds = len(self.events.t_us), self.duration_us / 1e6
        return f"<Recording {self.name}: {n:,} events in {seconds:.6g} s, {self.width}x{self.height} pixels>"

    def __post_init__(self) -> None:
        check_sensor(self.name, self.width, self.height)
        events = self.events
        if not isinstance(events, Events):
            raise RecordingError(f"{self.name}: events are of type {type(events).__name__}: must be Events")
        if not len(events.t_us) == len(events.x) == len(events.y) == len(events.p):
            raise RecordingError(
                f"{self.name}: t, x, y, p hold {len(events.t_us)}, {len(events.x)}, {len(events.y)}, {len(events.p)} values: "
                "all must be the same"
            )
        events = events.packed()
        object.__setattr__(self, "events", events)
        fault = find_fault(events, self.width, self.height)
        if fault is not None:
            raise RecordingError(f"{self.name}: {fault.describe()}")

    def show(self, *logs: object, events_max: int = EVENTS_MAX, height_px: int = HEIGHT_PX) -> Page:
        """The page of `evcot report` for a notebook: the events, with the tracks of logs if they are given.

        Example:
            recording.show(evcot.track(recording))

        Args:
            logs: each a `TrackLog` of this recording.
            events_max: most events in the page, which are spread evenly over the recording.
            height_px: height of the frame in the notebook.

        Raises:
            ConfigError: no log or one with more events than the recording has, or a value outside its range.
        """
        page: Page = resolve_name("evcot_cosim.notebook:recording_page")(self, logs, events_max, height_px)
        return page

    def _repr_html_(self) -> str:
        """The recording in a notebook: the page that `show` makes."""
        return self.show()._repr_html_()

    def window(self, from_us: int = 0, to_us: int | None = None) -> Recording:
        """The events with from_us <= t - t_us[0] < to_us as a new recording; to_us None for the end.

        Raises:
            RecordingError: there are none.
        """
        since = self.events.t_us - self.events.t_us[:1]
        first = int(np.searchsorted(since, from_us))
        end = len(since) if to_us is None else int(np.searchsorted(since, to_us))
        if first >= end:
            last = "its end" if to_us is None else f"{to_us} us"
            raise RecordingError(f"{self.name}: holds no events from {from_us} us to {last}")
        return Recording(self.events[first:end], self.width, self.height, self.name)

    @property
    def duration_us(self) -> int:
        """Time from the first to the last event."""
        t_us = self.events.t_us
        return int(t_us[-1] - t_us[0]) if len(t_us) else 0

# SPDX-License-Identifier: Apache-2.0
"""Statistics of a recording in one pass: event count, rates, share of polarities, distribution over the pixels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..events import MOST_PIXELS, Events
from .files import RecordingFile

__all__ = ["PEAK_WINDOW_US", "BusyPixel", "Description", "PixelFigures", "describe"]

PEAK_WINDOW_US = 10_000
_BUSIEST = 5
# Bursts: so many events, on average, have one time, and times are so far apart. They come from frames or grouped times.
_BURST_EVENTS, _BURST_US = 8, 1_000

# Histogram of intervals with 8 bins per power of two: a median taken from it is accurate to 7 %, and exact up to 15 us.
_INTERVAL_BINS = 64 * 8
_BELOW_BINS_BITS = 52 - 3
_BEFORE_ONE = 1023 * 8 - 1
_NEVER = np.iinfo(np.int64).min

# Entries of the running state.
_WINDOW, _WINDOW_EVENTS, _PEAK_EVENTS, _ON = range(4)


@dataclass(frozen=True)
class BusyPixel:
    """A pixel and its share of all events."""

    x: int
    y: int
    share: float


@dataclass(frozen=True)
class PixelFigures:
    """Distribution of the events over the pixels.

    Attributes:
        silent: share of the sensor's pixels that have no events.
        median_interval_us: median time between two successive events of one pixel, to within 7 %; None where no pixel has
            two events.
        busiest: at most five, the busiest first: one with far more events than the next is likely a hot pixel.
    """

    silent: float
    median_interval_us: int | None
    busiest: tuple[BusyPixel, ...]


@dataclass(frozen=True)
class Description:
    """The result of `describe`; rates in events/s, shares from 0 to 1.

    Attributes:
        assumes_sensor: whether the sensor size is assumed, as the smallest that holds all events.
        first_us: time of the first event described, as the file has it.
        duration_us: from the first event to the last.
        mean_rate: None where all events have the same time.
        peak_rate: of the busiest of the consecutive windows of `PEAK_WINDOW_US` from the first event on; None for a recording
            shorter than one window.
        burst_us: mean time between bursts, where events come in bursts of one time, as from frames; else None.
        pixels: None for a sensor of more than `MOST_PIXELS`.
        left_out: reason -> number of events that were left out.
        remarks: faults for which no event was left out.
        details: other metadata of the file.
    """

    format: str
    width: int
    height: int
    assumes_sensor: bool
    events: int
    first_us: int
    duration_us: int
    mean_rate: float | None
    peak_rate: float | None
    on_share: float
    burst_us: float | None
    pixels: PixelFigures | None
    left_out: Mapping[str, int]
    remarks: tuple[str, ...]
    details: Mapping[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as for JSON."""
        return asdict(self) | {"left_out": dict(self.left_out), "details": dict(self.details)}


@njit(cache=True, nogil=True)
def _count_in_time(t_us, p, first_us, state):  # type: ignore[no-untyped-def]
    """Count the events of one polarity and the events per window; keep the largest window count."""
    window, events, peak, on = state
    for i in range(len(t_us)):
        at = (t_us[i] - first_us) // PEAK_WINDOW_US
        if at != window:
            peak = max(peak, events)
            window, events = at, 0
        events += 1
        on += p[i]
    state[_WINDOW], state[_WINDOW_EVENTS], state[_PEAK_EVENTS], state[_ON] = window, events, max(peak, events), on


@njit(cache=True, nogil=True, inline="always")
def _bin_of(interval):  # type: ignore[no-untyped-def]
    """The bin of an interval >= 0: exponent and upper three mantissa bits of its floating-point form, contiguous integers."""
    return max((np.float64(interval).view(np.int64) >> _BELOW_BINS_BITS) - _BEFORE_ONE, 0)


def _middle_of(index: int) -> int:
    """The centre of a bin, in microseconds."""
    octave, eighth = divmod(index - 1, 8)
    return ((8 + eighth) << octave >> 3) + (1 << octave >> 4) if index else 0


@njit(cache=True, nogil=True)
def _count_by_pixel(t_us, x, y, width, counts, last_us, intervals):  # type: ignore[no-untyped-def]
    for i in range(len(t_us)):
        pixel = np.int64(y[i]) * width + np.int64(x[i])
        counts[pixel] += 1
        if last_us[pixel] != _NEVER:
            intervals[_bin_of(max(t_us[i] - last_us[pixel], np.int64(0)))] += 1
        last_us[pixel] = t_us[i]


class _PixelCounts:
    """Running event counts and interval histogram of all pixels."""

    def __init__(self, width: int, height: int) -> None:
        self._width = width
        self._counts = np.zeros(width * height, np.int64)
        self._last_us = np.full(width * height, _NEVER)
        self._intervals = np.zeros(_INTERVAL_BINS, np.int64)

    def add(self, events: Events) -> None:
        _count_by_pixel(events.t_us, events.x, events.y, self._width, self._counts, self._last_us, self._intervals)

    def figures(self, events: int) -> PixelFigures:
        busiest = np.argpartition(self._counts, -min(_BUSIEST, self._counts.size))[-_BUSIEST:]
        busiest = busiest[np.lexsort((busiest, -self._counts[busiest]))]
        return PixelFigures(
            silent=float((self._counts == 0).mean()),
            median_interval_us=_median(self._intervals),
            busiest=tuple(
                BusyPixel(int(i % self._width), int(i // self._width), float(self._counts[i] / events))
                for i in busiest
                if self._counts[i]
            ),
        )


def _median(intervals: NDArray[np.int64]) -> int | None:
    below = np.cumsum(intervals)
    return _middle_of(int(np.searchsorted(below, (below[-1] + 1) // 2))) if below[-1] else None


def describe(
    file: RecordingFile,
    from_us: int = 0,
    to_us: int | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Description:
    """Describe the events with from_us <= t - t0_us < to_us; memory depends on the sensor, not on the recording's length.

    Args:
        progress: called with the number of events done and their last time after the file's first event, in us.

    Raises:
        RecordingError: as `RecordingFile.blocks`, or there is no event in the window.
    """
    width, height = file.sensor
    pixels = _PixelCounts(width, height) if width * height <= MOST_PIXELS else None
    state = np.zeros(4, np.int64)
    first_us = last_us = events = steps = 0
    for block in file.blocks(from_us, to_us, required=True):
        first_us = first_us if events else int(block.t_us[0])
        steps += int(np.count_nonzero(np.diff(block.t_us, prepend=last_us if events else first_us)))
        last_us = int(block.t_us[-1])
        events += len(block)
        _count_in_time(block.t_us, block.p, first_us, state)
        if pixels is not None:
            pixels.add(block)
        if progress is not None:
            progress(events, last_us - file.t0_us)
    duration_us = last_us - first_us
    in_bursts = steps > 0 and events >= _BURST_EVENTS * (steps + 1) and duration_us >= _BURST_US * steps
    return Description(
        format=file.format,
        width=width,
        height=height,
        assumes_sensor=file.assumes_sensor,
        events=events,
        first_us=first_us,
        duration_us=duration_us,
        mean_rate=events / duration_us * 1e6 if duration_us else None,
        peak_rate=float(state[_PEAK_EVENTS]) / PEAK_WINDOW_US * 1e6 if duration_us >= PEAK_WINDOW_US else None,
        on_share=float(state[_ON]) / events,
        burst_us=duration_us / steps if in_bursts else None,
        pixels=pixels.figures(events) if pixels is not None else None,
        left_out=dict(file.left_out),
        remarks=tuple(file.remarks),
        details=dict(file.details),
    )

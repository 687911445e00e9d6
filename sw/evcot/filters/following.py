# SPDX-License-Identifier: Apache-2.0
"""A chain that follows the stream: pixels that never rest are masked, and the activity filter's neighbours follow the noise.

In software only: the registers of the hardware's filters hold until they are written. docs/filters.md describes it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .activity import ActivityFilter
from .base import EventFilter
from .chain import FilterChain
from .contract import Filter, FilterShape
from .mask import MaskFilter
from .noise import WINDOW_US, NoiseRate, close, note, support_against
from .registers import FilterRegisters
from .restless import epoch_of, restless, rests

__all__ = ["FollowingChain"]

_UNKNOWN = 9  # neighbours, of eight: nothing passes


class FollowingChain(FilterChain):
    """A chain whose activity filter needs as many neighbours as leave at most `passing_hz` of the noise, window by window.

    Before the noise is known, for `WINDOW_US`, no event passes. About 22 ns per event with refractory and activity filter.

    Args:
        registers, shape: those of a chain with an activity filter; `activity_support` does not count.
        passing_hz: events of noise that may pass, per pixel and second.
        tick_us: length of a tick.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape, passing_hz: float, tick_us: int) -> None:
        super().__init__(registers, shape)
        within_us = float(registers.activity_ticks * tick_us)
        self._mask = _RestingMask(MaskFilter(registers, shape), shape, tick_us, within_us, passing_hz)
        activity = _ActivityByNoise(ActivityFilter(registers, shape), self._mask)
        self._use({**self._filters, Filter.MASK: self._mask, Filter.ACTIVITY: activity})

    @property
    def noise_hz(self) -> float | None:
        """Events per pixel and second of the background; None before the end of the first window."""
        return self._mask.rate.hz

    @property
    def support(self) -> int | None:
        """Neighbours that an event needs now; None before the noise is known."""
        return None if self.noise_hz is None else self._mask.support

    @property
    def restless(self) -> NDArray[np.bool_]:
        """The pixels that are masked now because they never rest, (height, width)."""
        return self._mask.restless


class _RestingMask(EventFilter):
    """The hot pixel mask, and besides: an event passes if its pixel rests from time to time. The noise of these is measured.

    Attributes:
        rate: of the noise.
        support: neighbours that it asks for after the last run.
        ends, supports: (k,) of the last run: the first number of neighbours holds up to the first end, and so on.
    """

    def __init__(self, fixed: MaskFilter, shape: FilterShape, tick_us: int, within_us: float, passing_hz: float) -> None:
        self._fixed = fixed
        self._noted = np.zeros((shape.height, shape.width), np.int32)
        self._tick_us, self._within_us, self._passing_hz = tick_us, within_us, passing_hz
        self._last_us = 0
        self.rate = NoiseRate(shape.width, shape.height)
        self.support = _UNKNOWN
        self.ends, self.supports = np.empty(0, np.int64), np.empty(0, np.int64)

    @property
    def restless(self) -> NDArray[np.bool_]:
        return restless(self._noted, self._last_us, 0)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        window = self._last_us // WINDOW_US
        last_us = int(events.ticks[-1]) * self._tick_us if len(events) else self._last_us
        most = min(last_us // WINDOW_US - window, len(events)) + 1
        self.ends, self.supports = np.empty(most, np.int64), np.empty(most, np.int64)
        self.supports[0] = self.support
        rate = self.rate.pixels, self.rate.state
        rule = self._tick_us, self._within_us, self._passing_hz
        runs = _narrow(
            self._fixed.quiet,
            self._noted,
            *rate,
            window,
            *rule,
            events.ticks,
            events.x,
            events.y,
            keep,
            self.ends,
            self.supports,
        )
        self.ends, self.supports = self.ends[:runs], self.supports[:runs]
        self.support = int(self.supports[-1])
        self._last_us = last_us


class _ActivityByNoise(EventFilter):
    """The activity filter, with the numbers of neighbours that a mask has found for the same run."""

    def __init__(self, fixed: ActivityFilter, noise: _RestingMask) -> None:
        self._fixed, self._noise = fixed, noise

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        self._fixed.narrow_by(self._noise.ends, self._noise.supports, events, keep)


@njit(cache=True, nogil=True)
def _narrow(  # type: ignore[no-untyped-def]
    quiet, noted, pixels, state, window, tick_us, within_us, passing_hz, ticks, x, y, keep, ends, supports
):
    """Mask events, and fill in which numbers of neighbours hold for which of them; returns how many there are."""
    height, width = quiet.shape
    ends_us = (window + 1) * WINDOW_US
    k = 0
    for i in range(len(keep)):
        t_us = ticks[i] * tick_us
        if t_us >= ends_us:
            windows = (t_us - ends_us) // WINDOW_US + 1
            noise_hz = close(pixels, state, windows)
            ends_us += windows * WINDOW_US
            ends[k] = i
            k += 1
            supports[k] = support_against(noise_hz, within_us, passing_hz)
        if keep[i]:
            keep[i] = x[i] < width and y[i] < height and quiet[y[i], x[i]] and rests(noted, x[i], y[i], epoch_of(t_us, 0))
            if keep[i]:
                note(pixels, x[i], y[i])
    ends[k] = len(keep)
    return k + 1

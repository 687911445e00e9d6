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
from .noise import WINDOW_US, NoiseRate, support_against
from .registers import FilterRegisters
from .restless import epoch_of, restless, rests

__all__ = ["FollowingChain"]

_UNKNOWN = 9  # neighbours, of eight: nothing passes


class FollowingChain(FilterChain):
    """A chain whose activity filter needs as many neighbours as leave at most `passing_hz` of the noise, window by window.

    Before the noise is known, for `WINDOW_US`, no event passes. About 25 ns per event with refractory and activity filter.

    Args:
        registers, shape: those of a chain with an activity filter; `activity_support` does not count.
        passing_hz: events of noise that may pass, per pixel and second.
        tick_us: length of a tick.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape, passing_hz: float, tick_us: int) -> None:
        super().__init__(registers, shape)
        activity = self._filters[Filter.ACTIVITY]
        assert isinstance(activity, ActivityFilter)
        self._activity = activity
        self._activity.support = _UNKNOWN
        self._mask = _RestingMask(self._filters.get(Filter.MASK) or MaskFilter(registers, shape), shape, tick_us)
        self._use({**self._filters, Filter.MASK: self._mask})
        self._passing_hz = passing_hz
        self._within_us = float(registers.activity_ticks * tick_us)
        self._tick_us = tick_us
        self._window = 0

    @property
    def noise_hz(self) -> float | None:
        """Events per pixel and second of the background; None before the end of the first window."""
        return self._mask.rate.hz

    @property
    def support(self) -> int | None:
        """Neighbours that an event needs now; None before the noise is known."""
        return None if self.noise_hz is None else self._activity.support

    @property
    def restless(self) -> NDArray[np.bool_]:
        """The pixels that are masked now because they never rest, (height, width)."""
        return self._mask.restless

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        begin = 0
        while begin < len(events):
            window = int(events.ticks[begin]) * self._tick_us // WINDOW_US
            if window > self._window:
                self._mask.rate.close(window - self._window)
                self._window = window
                self._activity.support = support_against(self._mask.rate.hz or 0.0, self._within_us, self._passing_hz)
            end = int(np.searchsorted(events.ticks, -(-(window + 1) * WINDOW_US // self._tick_us)))
            super().narrow(events[begin:end], keep[begin:end])
            begin = end


class _RestingMask(EventFilter):
    """The hot pixel mask, and besides: an event passes if its pixel rests from time to time. The rate of these is measured."""

    def __init__(self, fixed: EventFilter, shape: FilterShape, tick_us: int) -> None:
        self._fixed = fixed
        self._noted = np.zeros((shape.height, shape.width), np.int32)
        self._tick_us = tick_us
        self._last_us = 0
        self.rate = NoiseRate(shape.width, shape.height)

    @property
    def restless(self) -> NDArray[np.bool_]:
        return restless(self._noted, self._last_us, 0)

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        self._fixed.narrow(events, keep)
        _rest(self._noted, self._tick_us, events.ticks, events.x, events.y, keep)
        self.rate.add(events.x, events.y, keep)
        self._last_us = int(events.ticks[-1]) * self._tick_us


@njit(cache=True, nogil=True)
def _rest(noted, tick_us, ticks, x, y, keep):  # type: ignore[no-untyped-def]
    for i in range(len(keep)):
        if keep[i]:
            keep[i] = rests(noted, x[i], y[i], epoch_of(ticks[i] * tick_us, 0))

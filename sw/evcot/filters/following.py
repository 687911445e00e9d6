# SPDX-License-Identifier: Apache-2.0
"""A chain that follows the stream: pixels that never rest are masked, and the activity filter's neighbours follow the noise.

In software only: the registers of the hardware's filters hold until they are written. docs/filters.md describes it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .activity import supporters
from .base import NEVER, EventFilter, per_pixel
from .chain import FilterChain, Total
from .contract import Filter, FilterShape
from .mask import MaskFilter
from .noise import WINDOW_US, NoiseRate, close, note, support_against
from .registers import FilterRegisters
from .restless import epoch_of, restless, rests

__all__ = ["FollowingChain"]

_UNKNOWN = 9  # neighbours, of eight: nothing passes


class FollowingChain(EventFilter):
    """A chain whose activity filter needs as many neighbours as leave at most `passing_hz` of the noise, window by window.

    Before the noise is known, for `WINDOW_US`, no event passes. Mask, refractory and activity filter are one loop, about 12 ns
    per event; the others of the chain stand before and behind it.

    Args:
        registers, shape: those of a chain with an activity filter and without cells; `activity_support` does not count.
        passing_hz: events of noise that may pass, per pixel and second.
        tick_us: length of a tick.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape, passing_hz: float, tick_us: int) -> None:
        registers.check(shape)
        self._before = FilterChain(_only(registers, (Filter.REGION, Filter.POLARITY)), shape)
        self._after = FilterChain(_only(registers, (Filter.RECENT, Filter.DECAY, Filter.ROWCOL)), shape)
        self._quiet = MaskFilter(registers, shape).quiet
        self._masked = not self._quiet.all()
        self._noted = np.zeros((shape.height, shape.width), np.int32)
        self._last = per_pixel(shape, NEVER, border=1)
        self._rate = NoiseRate(shape.width, shape.height)
        self._refractory = registers.enables(Filter.REFRACTORY)
        self._silence = registers.refractory_ticks if self._refractory else 0
        self._within = registers.activity_ticks
        self._passing_hz, self._tick_us = passing_hz, tick_us
        self._support, self._last_us = _UNKNOWN, 0
        self._counts = np.zeros(4, np.int64)

    @property
    def noise_hz(self) -> float | None:
        """Events per pixel and second of the background; None before the end of the first window."""
        return self._rate.hz

    @property
    def support(self) -> int | None:
        """Neighbours that an event needs now; None before the noise is known."""
        return None if self.noise_hz is None else self._support

    @property
    def restless(self) -> NDArray[np.bool_]:
        """The pixels that are masked now because they never rest, (height, width)."""
        return restless(self._noted, self._last_us, 0)

    @property
    def totals(self) -> dict[Filter, Total]:
        """Event counts of each enabled filter so far, in the order of the chain."""
        seen, rested, sent, supported = self._counts.tolist()
        own = {
            Filter.MASK: Total(seen, seen - rested),
            Filter.REFRACTORY: Total(rested, rested - sent),
            Filter.ACTIVITY: Total(sent, sent - supported),
        }
        if not self._refractory:
            del own[Filter.REFRACTORY]
        return {**self._before.totals, **own, **self._after.totals}

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        self._before.narrow(events, keep)
        memories = self._quiet, self._masked, self._noted, self._last, self._rate.pixels, self._rate.state
        rule = self._tick_us, self._silence, self._within, self._passing_hz, self._support
        columns = events.ticks, events.x, events.y, keep
        self._support = _narrow(*memories, *rule, self._last_us // WINDOW_US, *columns, self._counts)
        if len(events):
            self._last_us = int(events.ticks[-1]) * self._tick_us
        self._after.narrow(events, keep)


def _only(registers: FilterRegisters, filters: Iterable[Filter]) -> FilterRegisters:
    """The same registers with no other filters enabled."""
    return replace(registers, enable=registers.enable & sum(1 << which for which in filters))


@njit(cache=True, nogil=True)
def _narrow(  # type: ignore[no-untyped-def]
    quiet, masked, noted, last, pixels, state, tick_us, silence, within, passing_hz, support, window,
    ticks, xs, ys, keep, counts,
):  # fmt: skip
    """Mask, refractory and activity filter of a run that begins in that window; returns the neighbours at its end.

    One memory of `last` ticks serves two of them: the activity filter sees what the refractory filter passes.
    """
    height, width = np.uint64(quiet.shape[0]), np.uint64(quiet.shape[1])
    one = np.uint64(1)
    ends_us = (window + 1) * WINDOW_US
    seen = rested = sent = supported = 0
    x: Any
    y: Any
    for i in range(len(keep)):
        tick = ticks[i]
        t_us = tick * tick_us
        if t_us >= ends_us:
            windows = (t_us - ends_us) // WINDOW_US + 1
            noise_hz = close(pixels, state, windows)
            ends_us += windows * WINDOW_US
            support = support_against(noise_hz, float(within * tick_us), passing_hz)
        if not keep[i]:
            continue
        seen += 1
        keep[i] = False
        x, y = np.uint64(xs[i]), np.uint64(ys[i])  # as indices that need no check for negative ones
        if x >= width or y >= height or (masked and not quiet[y, x]) or not rests(noted, x, y, epoch_of(t_us, 0)):
            continue
        rested += 1
        note(pixels, x, y)
        if tick - last[y + one, x + one] < silence:
            continue
        sent += 1
        keep[i] = supporters(last, tick - within, tick, x, y) >= support
        supported += keep[i]
    counts += np.array([seen, rested, sent, supported])
    return support

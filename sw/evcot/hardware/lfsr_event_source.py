# SPDX-License-Identifier: Apache-2.0
"""Pseudo-random events from an LFSR: cycle-exact model of `lfsr_event_source.v`, described in that file's header."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..errors import ConfigError
from ..events import Events
from .lfsr import WIDTH_MAX, Lfsr, next_state, tap_mask

__all__ = ["LfsrEventSource"]


@dataclass(frozen=True)
class LfsrEventSource:
    """Source of events uniform over the window x_min..x_min + x_span, y_min..y_min + y_span (both ends included), in pixels.

    Attributes:
        x_min, y_min: first pixel of the window.
        x_span, y_span: last pixel of the window minus its first.
        gap: LFSR steps between two candidates, minus one. Below x_w + y_w successive events are correlated.
        seed: initial state of the LFSR.
        x_w, y_w, gap_w, lfsr_w: widths of the hardware, in bits.

    Raises:
        ConfigError: a width, the seed or the window is outside what the hardware supports.
    """

    x_min: int
    x_span: int
    y_min: int
    y_span: int
    gap: int = 0
    seed: int = 0
    x_w: int = 9
    y_w: int = 9
    gap_w: int = 16
    lfsr_w: int = 32

    def __post_init__(self) -> None:
        for name in ("x_w", "y_w", "gap_w"):
            if getattr(self, name) < 1:
                raise ConfigError(f"lfsr_event_source.{name} = {getattr(self, name)}: must be at least 1")
        narrowest = self.x_w + self.y_w + 1
        if not narrowest <= self.lfsr_w <= WIDTH_MAX:
            raise ConfigError(
                f"lfsr_event_source.lfsr_w = {self.lfsr_w}: must be from x_w + y_w + 1 = {narrowest} to {WIDTH_MAX}"
            )
        Lfsr(self.lfsr_w, self.seed)  # refuses a wrong seed
        if not 0 <= self.gap < 1 << self.gap_w:
            raise ConfigError(f"lfsr_event_source.gap = {self.gap}: must be from 0 to {(1 << self.gap_w) - 1}")
        for axis, low, span, bits in (("x", self.x_min, self.x_span, self.x_w), ("y", self.y_min, self.y_span, self.y_w)):
            if low < 0 or span < 0 or low + span >= 1 << bits:
                raise ConfigError(
                    f"lfsr_event_source.{axis}_min, {axis}_span = {low}, {span}: must not be negative, "
                    f"and their sum must be below {1 << bits}"
                )

    def events(self, count: int) -> Events:
        """The first `count` events after reset or load; t_us is the number of LFSR steps before the event.

        Raises:
            ConfigError: the LFSR produces no event in a whole period.
        """
        events = Events.allocated(count)
        lfsr = np.array([self.seed, tap_mask(self.lfsr_w), (1 << self.lfsr_w) - 1], np.uint64)
        window = np.array([self.x_min, self.x_span, self.y_min, self.y_span], np.uint64)
        found = _fill(lfsr, window, self.x_w, self.y_w, self.gap + 1, events.t_us, events.x, events.y, events.p)
        if found < count:
            raise ConfigError(f"lfsr_event_source.gap = {self.gap}: no event in a whole period of the {self.lfsr_w}-bit LFSR")
        return events


@njit(cache=True, nogil=True)
def _fill(
    lfsr: NDArray[np.uint64],
    window: NDArray[np.uint64],
    x_w: int,
    y_w: int,
    stride: int,
    step: NDArray[np.int64],
    x: NDArray[np.uint16],
    y: NDArray[np.uint16],
    p: NDArray[np.uint8],
) -> int:
    """Fill the event arrays and return the number of events; `lfsr` is (state, taps, mask of its bits)."""
    state, taps, keep = lfsr
    x_min, x_span, y_min, y_span = window
    x_mask, y_mask = np.uint64(0), np.uint64(0)
    while x_mask < x_span:
        x_mask = (x_mask << np.uint64(1)) | np.uint64(1)
    while y_mask < y_span:
        y_mask = (y_mask << np.uint64(1)) | np.uint64(1)

    found, steps, rejected = 0, 0, np.uint64(0)
    while found < step.size and rejected < keep:
        for _ in range(stride - 1):
            state = next_state(state, taps, keep)
        steps += stride - 1
        x_offset = state & x_mask
        y_offset = (state >> np.uint64(x_w)) & y_mask
        if x_offset <= x_span and y_offset <= y_span:
            step[found], x[found], y[found] = steps, x_min + x_offset, y_min + y_offset
            p[found] = (state >> np.uint64(x_w + y_w)) & np.uint64(1)
            found += 1
            rejected = np.uint64(0)
        else:
            rejected += np.uint64(1)
        state = next_state(state, taps, keep)
        steps += 1
    return found

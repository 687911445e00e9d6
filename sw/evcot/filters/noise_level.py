# SPDX-License-Identifier: Apache-2.0
"""The noise of a stream, measured in integers while the stream goes on, and the neighbours that an event then needs.

docs/filters.md, "Support that follows the noise", is the contract; `noise_support.v` is the hardware.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .._numba_private import njit, step
from .contract import CELL_LOG2, LEVEL_FRAC, LEVEL_MAX, NOISE_SHORTER, NOISE_SUPPORTS, FilterShape
from .registers import FilterRegisters

__all__ = ["ENDS", "NUMBER", "SUPPORT", "UNKNOWN_SUPPORT", "NoiseLevel", "end_window", "note"]

UNKNOWN_SUPPORT = 9  # neighbours, of eight: nothing passes before the noise is known

# A cell's word: the place of an event, whether another pixel had one, too, and the number of the window.
_PLACE_BITS = 2 * CELL_LOG2
_SEVERAL = 1 << _PLACE_BITS
_NUMBER_AT = _PLACE_BITS + 1
_NUMBERS = 1 << 11
_SHIFT, _INNER = np.uint64(CELL_LOG2), np.uint64((1 << CELL_LOG2) - 1)
_SMOOTHED = 4  # log2 of the windows over which the means reach

# State: the first tick after the open window, log2 of how much shorter than the longest it is, its number; its cells with an
# event, and those with one pixel; windows so far, the means of cells with one pixel and of empty ones; the level; the support.
ENDS, _SHORTER, NUMBER, _TOUCHED, _ALONE, _WINDOWS, _MEAN_ALONE, _MEAN_EMPTY, LEVEL, SUPPORT = range(10)


class NoiseLevel:
    """The noise of a stream, and the support that follows it. About 2 ns per event.

    Compiled functions note events with `note`, and call `end_window` at the first event from `state[ENDS]` on.

    Attributes:
        words: (rows, columns) int64, a word for each cell of 8 x 8 pixels that lies wholly on the sensor.
        state: int64, see above.
        rule: int64: log2 of the ticks in the longest window, and the thresholds of the support.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        columns, rows = (max(pixels >> CELL_LOG2, 1) for pixels in (shape.width, shape.height))
        self.words = np.zeros((rows, columns), np.int64)
        self.state = np.zeros(SUPPORT + 1, np.int64)
        self.state[NUMBER], self.state[SUPPORT], self.state[ENDS] = 1, UNKNOWN_SUPPORT, 1 << registers.noise_log2
        least = [getattr(registers, f"noise_{support}") for support in NOISE_SUPPORTS]
        self.rule = np.array([registers.noise_log2, *least], np.int64)

    @property
    def level(self) -> int | None:
        """Events per cell and longest window, in 1/256; None before the end of the first window."""
        return int(self.state[LEVEL]) if self.state[_WINDOWS] else None

    @property
    def support(self) -> int:
        """Neighbours that an event needs now."""
        return int(self.state[SUPPORT])


@step
def note(words: Any, state: Any, number: int, x: Any, y: Any) -> None:
    """Note an event on the sensor, in the open window, whose number is given; x and y are unsigned."""
    row, column = y >> _SHIFT, x >> _SHIFT
    if row < np.uint64(words.shape[0]) and column < np.uint64(words.shape[1]):
        place = (y & _INNER) << _SHIFT | (x & _INNER)
        word = words[row, column]
        if word >> _NUMBER_AT != number:
            words[row, column] = number << _NUMBER_AT | np.int64(place)
            state[_TOUCHED] += 1
            state[_ALONE] += 1
        elif not word & _SEVERAL and word & (_SEVERAL - 1) != np.int64(place):
            words[row, column] = word | _SEVERAL
            state[_ALONE] -= 1


@njit(cache=True, nogil=True)
def end_window(words: Any, state: Any, rule: Any, tick: int) -> None:
    """Measure the open window, if it had an event, and open that of a tick."""
    if state[_TOUCHED]:
        cells, most = words.size, min(NOISE_SHORTER, rule[0])
        empty, shorter, windows = cells - state[_TOUCHED], state[_SHORTER], state[_WINDOWS]
        dense = 4 * empty < cells
        if not dense or shorter == most:
            state[_MEAN_ALONE] += ((state[_ALONE] << (shorter + LEVEL_FRAC)) - state[_MEAN_ALONE]) >> windows
            state[_MEAN_EMPTY] += ((empty << LEVEL_FRAC) - state[_MEAN_EMPTY]) >> windows
            state[_WINDOWS] = min(windows + 1, _SMOOTHED)
            level = LEVEL_MAX
            if state[_MEAN_EMPTY] > 0:
                level = min((state[_MEAN_ALONE] << LEVEL_FRAC) // state[_MEAN_EMPTY], LEVEL_MAX)
            state[LEVEL], state[SUPPORT] = level, 1
            for least in rule[1:]:
                state[SUPPORT] += level >= least
        if dense:
            state[_SHORTER] = min(shorter + 1, most)
        elif 4 * state[_TOUCHED] < cells:
            state[_SHORTER] = max(shorter - 1, 0)
        state[_TOUCHED] = state[_ALONE] = 0
        state[NUMBER] = (state[NUMBER] + 1) & (_NUMBERS - 1)
    log2 = rule[0] - state[_SHORTER]
    state[ENDS] = ((tick >> log2) + 1) << log2

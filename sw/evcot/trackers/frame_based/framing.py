# SPDX-License-Identifier: Apache-2.0
"""Events cut into frames: every so many microseconds from the first event on, or packets of so many events."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["Framing"]

_NONE_US = np.iinfo(np.int64).max


class Framing:
    """Where frames end in a stream that comes in runs.

    Args:
        length_us: a frame holds less than so much time.
        events: and at most so many events; None for a fixed grid in time, whose cells count from the first event and of which
            the silent ones are no frames. A packet counts its time from its own first event.
    """

    def __init__(self, length_us: int, events: int | None = None) -> None:
        self._length_us = length_us
        self._events = events
        self._held = 0  # events in the open frame
        self._until_us = _NONE_US  # its end, exclusive

    def cut(self, t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        """Take the next (n,) events and say before which of them, or after the last, frames end: (f,) from 0 to n, ascending.

        An end at 0 closes a frame of earlier events alone.
        """
        if not len(t_us):
            return np.empty(0, np.int64)
        if self._until_us == _NONE_US:
            self._until_us = int(t_us[0]) + self._length_us
        most = _NONE_US if self._events is None else self._events
        ends = np.empty(len(t_us) + 1, np.int64)
        n, self._held, self._until_us = _cut(t_us, self._length_us, most, self._held, self._until_us, ends)
        return ends[:n]


@njit(cache=True, nogil=True)
def _cut(ts, length_us, most, held, until_us, ends):  # type: ignore[no-untyped-def]
    grid = most == _NONE_US
    n = 0
    for e in range(len(ts)):
        if ts[e] >= until_us or held == 0:
            if held > 0:
                ends[n] = e
                n += 1
            if not grid:
                until_us = ts[e] + length_us
            elif ts[e] >= until_us:
                until_us += ((ts[e] - until_us) // length_us + 1) * length_us
            held = 0
        held += 1
        if held == most:
            ends[n] = e + 1
            n += 1
            held = 0
    return n, held, until_us

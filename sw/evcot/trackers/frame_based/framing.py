# SPDX-License-Identifier: Apache-2.0
"""Split a stream of events into frames: of fixed length in microseconds, or packets with a maximum number of events."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["Framing"]

_NONE_US = np.iinfo(np.int64).max


class Framing:
    """Finds the ends of frames in a stream that is fed in runs.

    Args:
        length_us: length of a frame, exclusive.
        events: maximum number of events in a packet, whose time counts from its own first event. None for a fixed time grid
            from the first event of the stream on, in which empty cells are not frames.
    """

    def __init__(self, length_us: int, events: int | None = None) -> None:
        self._length_us = length_us
        self._events = events
        self._held = 0  # events in the open frame
        self._until_us = _NONE_US  # its end, exclusive

    def cut(self, t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        """Process the next (n,) event times; returns the event indices at which frames end: (f,) from 0 to n, ascending.

        An end at 0 closes a frame with events of earlier runs only.
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

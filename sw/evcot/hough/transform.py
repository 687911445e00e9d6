# SPDX-License-Identifier: Apache-2.0
"""Golden model of `hough_lines`: leaky integrate-and-fire cells on (angle, rho), bit-exact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from .contract import COSINES, STAMP_W, THRESHOLD, HoughConfig

__all__ = ["SPIKE", "HoughTransform"]

SPIKE = np.dtype([("event", "<i8"), ("angle", "u1"), ("rho", "<u2")])
"""A spike: number of its event since the start, index of its angle, index of its cell along rho."""

_MASK = (1 << STAMP_W) - 1


class HoughTransform:
    """The line transform of a stream of events: feed events in blocks of any length.

    About 40 ns per event with 16 angles (`benchmarks/lines.py`).
    """

    def __init__(self, config: HoughConfig) -> None:
        self.config = config
        self._from_x, self._from_y = _shares(config)
        self._cells = np.zeros((config.angles, 1 << config.rho_w), np.uint16)
        self._rows = np.zeros(config.angles, np.int32)
        self._potentials = np.zeros(config.angles, np.int32)
        self._counts = np.zeros(2, np.int64)  # events on the sensor, all events

    @property
    def events(self) -> int:
        """Number of events since the start."""
        return int(self._counts[1])

    def feed(self, x: NDArray[np.uint16], y: NDArray[np.uint16]) -> NDArray[np.void]:
        """The spikes of a block of events, at most one per event.

        Args:
            x, y: (n,) pixels of the events. An event outside the sensor is ignored.

        Returns:
            (m,) of dtype `SPIKE`, in the order of the events.
        """
        config = self.config
        spikes = np.empty(len(x), SPIKE)
        tables = self._from_x, self._from_y, self._cells, self._rows, self._potentials, self._counts
        columns = spikes["event"], spikes["angle"], spikes["rho"]
        return spikes[: _transform(x, y, *tables, config.leak_log2, *columns)].copy()


def _shares(config: HoughConfig) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Shares of x and y in the index along rho, 1/8 px: (width, angles) and (height, angles)."""
    half = config.angles // 2
    table = np.array(COSINES[:: 16 // half], np.int32)
    k = np.arange(config.angles)
    u, v = (2 * np.arange(size, dtype=np.int32)[:, None] - (size - 1) for size in (config.width, config.height))
    parts_x = (u * table[np.where(k <= half, k, config.angles - k)]) >> 6
    parts_y = (v * table[abs(half - k)]) >> 6
    middle = 8 << (config.rho_w - 1)
    return np.where(k <= half, parts_x, -parts_x).astype(np.int32) + np.int32(middle), parts_y.astype(np.int32)


@njit(cache=True, nogil=True)
def _transform(x, y, from_x, from_y, cells, rows, potentials, counts, leak_log2, event, angle, rho):  # type: ignore[no-untyped-def]
    """Rules H1 to H4 for a run of events; `event`, `angle` and `rho` are filled in. Returns the number of spikes."""
    angles = len(rows)
    width, height = len(from_x), len(from_y)
    n, first = counts
    count = 0
    for i in range(len(x)):
        if x[i] >= width or y[i] >= height:
            continue
        period = np.int32((n >> leak_log2) & _MASK)
        n += 1
        part_x, part_y = from_x[x[i]], from_y[y[i]]
        for k in range(angles):
            rows[k] = (part_x[k] + part_y[k]) >> 3
        fires = False
        for k in range(angles):
            word = np.int32(cells[k, rows[k]])  # the potential left, and the period in which it was
            potentials[k] = max((word >> STAMP_W) - ((period - word) & _MASK), 0)
            fires |= potentials[k] == THRESHOLD - 1
        if fires:
            winner = 0
            while potentials[winner] < THRESHOLD - 1:
                winner += 1
            event[count], angle[count], rho[count] = first + i, winner, rows[winner]
            count += 1
            for k in range(angles):
                cells[k, rows[k]] = period
        else:
            for k in range(angles):
                cells[k, rows[k]] = (potentials[k] + 1) << STAMP_W | period
    counts[0], counts[1] = n, first + len(x)
    return count

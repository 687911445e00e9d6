# SPDX-License-Identifier: Apache-2.0
"""A set of track ids. Ids are counted up from 0, so a bit each is enough; those of other logs, which may be any, take more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["IdSet"]

_DENSE = 1 << 27  # ids below it are bits


class IdSet:
    """An empty set of int64."""

    def __init__(self) -> None:
        self._bits = np.zeros(0, np.uint8)
        self._others: set[int] = set()

    def add(self, ids: NDArray[np.int64]) -> None:
        """Add ids, some of which may be there."""
        dense = (ids >= 0) & (ids < _DENSE)
        self._others.update(ids[~dense].tolist())
        ids = ids[dense]
        lacking = int(ids.max(initial=-1)) // 8 + 1 - len(self._bits)
        if lacking > 0:
            self._bits = np.concatenate((self._bits, np.zeros(max(lacking, len(self._bits)), np.uint8)))
        np.bitwise_or.at(self._bits, ids >> 3, np.left_shift(1, ids & 7).astype(np.uint8))

    @property
    def nbytes(self) -> int:
        """Bytes of the bits."""
        return self._bits.nbytes

    def __contains__(self, track_id: int) -> bool:
        if 0 <= track_id < _DENSE:
            return track_id >> 3 < len(self._bits) and bool(self._bits[track_id >> 3] >> (track_id & 7) & 1)
        return track_id in self._others

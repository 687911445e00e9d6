# SPDX-License-Identifier: Apache-2.0
"""Statistics of durations: exact for the most recent ones, by a histogram of constant size for all."""

from __future__ import annotations

import threading
from collections import deque

import numpy as np
from numpy.typing import NDArray

__all__ = ["Latency"]

_RECENT = 2_000
_LEAST_S, _MOST_S = 1e-6, 1e3
_BINS_PER_DECADE = 200  # 1.2 % wide
_BINS = int(_BINS_PER_DECADE * np.log10(_MOST_S / _LEAST_S))


class Latency:
    """Thread-safe statistics of durations."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._recent: deque[float] = deque(maxlen=_RECENT)
        self._counts = np.zeros(_BINS + 1, np.int64)

    def add(self, durations_s: NDArray[np.float64]) -> None:
        """Add (k,) durations in seconds."""
        place = np.log10(np.clip(durations_s, _LEAST_S, _MOST_S) / _LEAST_S) * _BINS_PER_DECADE
        with self._lock:
            self._recent.extend(durations_s.tolist())
            np.add.at(self._counts, place.astype(np.int64), 1)

    def recent_ms(self, share: float) -> float | None:
        """Quantile of the most recent durations in ms; None before the first."""
        with self._lock:
            recent = list(self._recent)
        return float(np.quantile(recent, share)) * 1e3 if recent else None

    def overall_ms(self, share: float) -> float | None:
        """Quantile of all durations so far in ms, to 1.2 %; None before the first."""
        with self._lock:
            upto = np.cumsum(self._counts)
        if not upto[-1]:
            return None
        return float(_LEAST_S * 10 ** ((np.searchsorted(upto, share * upto[-1]) + 0.5) / _BINS_PER_DECADE)) * 1e3

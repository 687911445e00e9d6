# SPDX-License-Identifier: Apache-2.0
"""Spontaneous events of pixels, independent of how time is divided into steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit

__all__ = ["OWN", "Spontaneous"]

OWN = np.dtype([("t_us", "f8"), ("x", "i8"), ("y", "i8"), ("p", "i8")])

_CHUNK = 4096


class Spontaneous:
    """Background activity and leak, which are Poisson processes over the sensor, and hot pixels, which fire periodically.

    Attributes:
        hot: (hot_pixels, 2) int64, x and y.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        noise_hz: float,
        leak_hz: float,
        hot_pixels: int,
        hot_hz: float,
        random: np.random.Generator,
    ) -> None:
        height, width = self._shape = shape
        places = random.choice(width * height, hot_pixels, replace=False).astype(np.int64)
        self.hot = np.stack((places % width, places // width), axis=1)
        self._hot_p = random.integers(0, 2, hot_pixels)
        self._period_us = 1e6 / hot_hz
        self._phase_us = random.uniform(0, self._period_us, hot_pixels)
        self._rate_hz = (noise_hz + leak_hz) * width * height
        self._leak_share = leak_hz / (noise_hz + leak_hz) if self._rate_hz else 0.0
        self._random = random
        self._ahead = np.empty(0, OWN)
        self._last_us = 0.0

    def between(self, times_us: NDArray[np.int64]) -> tuple[NDArray[np.void], NDArray[np.int64]]:
        """The events in (a, b] of each interval from a time to the next, of dtype `OWN`, by time, relative to a; and the end of
        each interval in them. Each call must continue where the previous one ended."""
        own: tuple[NDArray[np.void], NDArray[np.int64]] = _with_beats(
            self._background(int(times_us[-1])), self.hot, self._hot_p, self._phase_us, self._period_us, times_us
        )
        return own

    def _background(self, to_us: int) -> NDArray[np.void]:
        """Background events up to `to_us`, drawn ahead in chunks; later ones are kept."""
        chunks = [self._ahead]
        while self._rate_hz and self._last_us <= to_us:
            chunks.append(self._chunk())
            self._last_us = float(chunks[-1]["t_us"][-1])
        drawn = np.concatenate(chunks) if len(chunks) > 1 else self._ahead
        due = int(np.searchsorted(drawn["t_us"], to_us, side="right"))
        self._ahead = drawn[due:]
        return drawn[:due]

    def _chunk(self) -> NDArray[np.void]:
        height, width = self._shape
        chunk = np.empty(_CHUNK, OWN)
        chunk["t_us"] = self._last_us + np.cumsum(self._random.exponential(1e6 / self._rate_hz, _CHUNK))
        chunk["x"] = self._random.integers(0, width, _CHUNK)
        chunk["y"] = self._random.integers(0, height, _CHUNK)
        leak = self._random.random(_CHUNK) < self._leak_share
        chunk["p"] = np.where(leak, 1, self._random.integers(0, 2, _CHUNK))
        return chunk


@njit(cache=True, nogil=True, error_model="numpy")
def _with_beats(background, hot, polarity, phase_us, period_us, times_us):  # type: ignore[no-untyped-def]
    """Background events together with those of hot pixels, as `between` returns them; of equal times, those of hot pixels come
    last."""
    beats = np.empty((len(hot), len(times_us)), np.int64)  # of each hot pixel, the first after each time
    for i in range(len(hot)):
        for k in range(len(times_us)):
            beats[i, k] = max(int(np.floor((times_us[k] - phase_us[i]) / period_us)) + 1, 0)
    own = np.empty(len(background) + (beats[:, -1] - beats[:, 0]).sum(), background.dtype)
    ends = np.empty(len(times_us) - 1, np.int64)
    n, taken = 0, 0
    for k in range(len(ends)):
        begin, from_us, to_us = n, times_us[k], times_us[k + 1]
        while taken < len(background) and background[taken].t_us <= to_us:
            own[n] = background[taken]
            n, taken = n + 1, taken + 1
        for i in range(len(hot)):
            for beat in range(beats[i, k], beats[i, k + 1]):
                own[n].t_us = min(max(phase_us[i] + beat * period_us, from_us), to_us)
                own[n].x, own[n].y, own[n].p = hot[i, 0], hot[i, 1], polarity[i]
                n += 1
        if len(hot):
            own[begin:n] = own[begin:n][np.argsort(own[begin:n]["t_us"], kind="mergesort")]
        for i in range(begin, n):
            own[i].t_us -= from_us
        ends[k] = n
    return own, ends

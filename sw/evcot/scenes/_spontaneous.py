# SPDX-License-Identifier: Apache-2.0
"""Spontaneous events of pixels, independent of how time is divided into steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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

    def between(self, from_us: int, to_us: int) -> NDArray[np.void]:
        """The events in (from_us, to_us], of dtype `OWN`, by time, relative to `from_us`; each call must continue where the
        previous one ended."""
        own = self._background(to_us)
        if len(self.hot):
            own = np.concatenate((own, self._beats(from_us, to_us)))
            own = own[np.argsort(own["t_us"], kind="stable")]
        own["t_us"] -= from_us
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

    def _beats(self, from_us: int, to_us: int) -> NDArray[np.void]:
        first, past = (
            np.maximum(np.floor((t_us - self._phase_us) / self._period_us).astype(np.int64) + 1, 0) for t_us in (from_us, to_us)
        )
        counts = past - first
        pixel = np.repeat(np.arange(len(counts)), counts)
        beat = np.arange(len(pixel)) - np.repeat(np.cumsum(counts) - past, counts)
        beats = np.empty(len(pixel), OWN)
        beats["t_us"] = np.clip(self._phase_us[pixel] + beat * self._period_us, from_us, to_us)
        beats["x"], beats["y"], beats["p"] = self.hot[pixel, 0], self.hot[pixel, 1], self._hot_p[pixel]
        return beats

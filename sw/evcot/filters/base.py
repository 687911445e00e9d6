# SPDX-License-Identifier: Apache-2.0
"""The interface of a filter: it keeps state, and decides for each event whether it passes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["NEVER", "EventFilter", "per_pixel"]

# The time stamp of a pixel without an event: older than any relevant age, but no difference with it overflows.
NEVER = -(1 << 61)

# Larger than any existing sensor; a larger value is a mistake, and its memory would take gigabytes.
_PIXELS_MAX = 1 << 25


def per_pixel(shape: FilterShape, value: int | bool, border: int = 0) -> NDArray[Any]:
    """A memory with one `value` per pixel, of shape (height + 2 border, width + 2 border), int64 or bool.

    Raises:
        ConfigError: the sensor has more than 2^25 pixels.
    """
    if shape.width * shape.height > _PIXELS_MAX:
        raise ConfigError(f"sensor {shape.width}x{shape.height}: filters remember at most {_PIXELS_MAX} pixels")
    return np.full((shape.height + 2 * border, shape.width + 2 * border), value)


class EventFilter(ABC):
    """A streaming filter: feed events in runs of any length; the result does not depend on how they are split into runs.

    Time stamps do not wrap around: ticks may reach 2^62.

    Args:
        registers, shape: those of a filter chain in hardware; a filter reads its own registers, regardless of `enable`.
    """

    @abstractmethod
    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None: ...

    @abstractmethod
    def narrow(
        self,
        ticks: NDArray[np.int64],
        x: NDArray[np.uint16],
        y: NDArray[np.uint16],
        p: NDArray[np.uint8],
        keep: NDArray[np.bool_],
    ) -> None:
        """Filter a run of events in place: clear `keep`, (n,) bool, for each event that is dropped.

        An event whose entry is already false is ignored. The other arguments are those of `feed`.
        """

    def feed(
        self, ticks: NDArray[np.int64], x: NDArray[np.uint16], y: NDArray[np.uint16], p: NDArray[np.uint8]
    ) -> NDArray[np.bool_]:
        """The events of a run that pass, as a mask of (n,) bool.

        Args:
            ticks: (n,) int64, ticks since reset at each event, never decreasing over the filter's life.
            x, y: (n,) uint16 pixel addresses.
            p: (n,) uint8 polarities, 0 or 1.
        """
        keep = np.ones(len(ticks), np.bool_)
        self.narrow(ticks, x, y, p, keep)
        return keep

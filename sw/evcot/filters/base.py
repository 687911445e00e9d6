# SPDX-License-Identifier: Apache-2.0
"""What every filter is: a memory, and a rule that decides of each event whether it stays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from .contract import FilterShape
from .registers import FilterRegisters

__all__ = ["NEVER", "EventFilter", "per_pixel"]

# The stamp of a pixel without an event: older than any age that counts, and near enough that no difference overflows.
NEVER = -(1 << 61)

# Larger than any sensor that is made; beyond it the sensor is a mistake, and its memory would take gigabytes.
_PIXELS_MAX = 1 << 25


def per_pixel(shape: FilterShape, value: int | bool, border: int = 0) -> NDArray[Any]:
    """A memory of one `value` per pixel, (height + 2 border, width + 2 border), int64 or bool.

    Raises:
        ConfigError: the sensor has more than 2^25 pixels.
    """
    if shape.width * shape.height > _PIXELS_MAX:
        raise ConfigError(f"sensor {shape.width}x{shape.height}: filters remember at most {_PIXELS_MAX} pixels")
    return np.full((shape.height + 2 * border, shape.width + 2 * border), value)


class EventFilter(ABC):
    """One filter as a stream: feed events in runs of any length, the result does not depend on where they are cut.

    Stamps have no end: ticks may reach 2^62.

    Args:
        registers, shape: as a chain in hardware has them; a filter reads its own registers, whatever `enable` says.
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
        """Decide a run of events in place: clear `keep`, (n,) bool, where an event does not stay.

        An event whose entry is already false does not reach the filter. The other arguments are those of `feed`.
        """

    def feed(
        self, ticks: NDArray[np.int64], x: NDArray[np.uint16], y: NDArray[np.uint16], p: NDArray[np.uint8]
    ) -> NDArray[np.bool_]:
        """Which events of a run stay, (n,) bool.

        Args:
            ticks: (n,) int64, ticks since reset at each event, never decreasing over the filter's life.
            x, y: (n,) uint16 pixel addresses.
            p: (n,) uint8 polarities, 0 or 1.
        """
        keep = np.ones(len(ticks), np.bool_)
        self.narrow(ticks, x, y, p, keep)
        return keep

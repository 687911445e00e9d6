# SPDX-License-Identifier: Apache-2.0
"""What every filter is: a memory, and a rule that decides of each event whether it stays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..ticks import TickedEvents
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
    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        """Decide a run of events in place: clear `keep`, (n,) bool, where an event does not stay.

        An event whose entry is already false does not reach the filter.
        """

    def feed(self, events: TickedEvents) -> NDArray[np.bool_]:
        """Which events of a run stay, (n,) bool; ticks never decrease over the filter's life."""
        keep = np.ones(len(events), np.bool_)
        self.narrow(events, keep)
        return keep

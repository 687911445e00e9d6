# SPDX-License-Identifier: Apache-2.0
"""The interface of a filter: it keeps state, and decides for each event whether it passes."""

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
    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        """Filter a run of events in place: clear `keep`, (n,) bool, for each event that is dropped.

        An event whose entry is already false is ignored.
        """

    def feed(self, events: TickedEvents) -> NDArray[np.bool_]:
        """The events of a run that pass, as a mask of (n,) bool; ticks never decrease over the filter's life."""
        keep = np.ones(len(events), np.bool_)
        self.narrow(events, keep)
        return keep

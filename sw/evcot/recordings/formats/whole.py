# SPDX-License-Identifier: Apache-2.0
"""A source for files that are read at once: they are bounded by memory."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from ...events import Events
from .source import BLOCK_EVENTS, Sensor

__all__ = ["WholeFile"]


class WholeFile:
    """All events of a file that states no sensor, handed out in blocks. See `source.Source`."""

    def __init__(self, events: Events, details: Mapping[str, str]) -> None:
        self._events = events
        self.sensor: Sensor | None = None
        self.details = details
        self.left_out: Counter[str] = Counter()

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        for begin in range(0, len(self._events), BLOCK_EVENTS):
            yield self._events[begin : begin + BLOCK_EVENTS]

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

    def close(self) -> None:
        """Nothing is open."""

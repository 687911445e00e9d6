# SPDX-License-Identifier: Apache-2.0
"""A source for files whose library reads them at once: they are bounded by memory."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path

from ..events import Events
from .columns import Decoded, Sensor
from .source import BLOCK_EVENTS, Source

__all__ = ["WholeFile", "opens_whole"]


class WholeFile:
    """Reads the file when it is opened and hands it out in blocks.

    Args:
        decoded: what the file holds; a sensor of None is not stated.
    """

    def __init__(self, decoded: Decoded, details: Mapping[str, str] | None = None) -> None:
        self._decoded = decoded
        self.details: Mapping[str, str] = details or {}
        self.left_out: Counter[str] = Counter()

    @cached_property
    def sensor(self) -> Sensor | None:
        """(width, height) in pixels, None where the file states none."""
        return self._decoded.sensor

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """See `source.Source`."""
        events = self._decoded.events
        for begin in range(0, len(events), BLOCK_EVENTS):
            yield events[begin : begin + BLOCK_EVENTS]

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `source.Source`."""
        return width, height

    def close(self) -> None:
        """Nothing is open."""


def opens_whole(read: Callable[[Path], Decoded]) -> Callable[[Path], Source]:
    """A reader of a whole file as `Format.open` wants it."""
    return lambda path: WholeFile(read(path))

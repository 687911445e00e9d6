# SPDX-License-Identifier: Apache-2.0
"""Filter a recording in memory, or a stream of blocks of events."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from ..events import Events, Recording
from ..ticks import TickCounter
from .chain import FilterChain, Total
from .config import FilterConfig
from .contract import Filter

__all__ = ["Filtered", "apply", "filtered"]


class Filtered(Iterator[Events]):
    """Iterator over the events that pass, block by block; `totals` are updated with each block."""

    def __init__(self, blocks: Iterable[Events], chain: FilterChain, tick_us: int) -> None:
        self._blocks = iter(blocks)
        self._chain = chain
        self._clock = TickCounter(tick_us)

    def __next__(self) -> Events:
        block = next(self._blocks)
        return block.where(self.keep(block))

    def keep(self, block: Events) -> NDArray[np.bool_]:
        """The mask of the events of the next block that pass, (n,) bool; tick 0 is the time of the very first event."""
        return self._chain.feed(self._clock.count(block))

    @property
    def totals(self) -> dict[Filter, Total]:
        """Event counts of each enabled filter so far, in the order of the chain."""
        return self._chain.totals


def filtered(blocks: Iterable[Events], config: FilterConfig, sensor: tuple[int, int], tick_us: int = 1) -> Filtered:
    """Filter a stream of blocks of events; memory does not grow with its length.

    Args:
        blocks: events in time order.
        sensor: (width, height) in pixels.
        tick_us: length of a tick.

    Raises:
        ConfigError: a time that cannot be represented in ticks, or a hot pixel outside the sensor.
    """
    return Filtered(blocks, FilterChain(config.registers(tick_us), config.shape(*sensor)), tick_us)


def apply(recording: Recording, config: FilterConfig, tick_us: int = 1) -> tuple[Recording, NDArray[np.bool_]]:
    """A recording of the events that pass, with the same name, and their mask, (n,) bool; raises as `filtered` does."""
    keep = filtered((), config, (recording.width, recording.height), tick_us).keep(recording.events)
    return Recording(recording.events.where(keep), recording.width, recording.height, recording.name), keep

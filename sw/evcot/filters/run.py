# SPDX-License-Identifier: Apache-2.0
"""Filters over a recording in memory, or over blocks of one that is not."""

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
    """The events of some blocks that stay, block by block; `totals` grow with them."""

    def __init__(self, blocks: Iterable[Events], chain: FilterChain, tick_us: int) -> None:
        self._blocks = iter(blocks)
        self._chain = chain
        self._clock = TickCounter(tick_us)

    def __next__(self) -> Events:
        block = next(self._blocks)
        return block.where(self.keep(block))

    def keep(self, block: Events) -> NDArray[np.bool_]:
        """Which events of the next block stay, (n,) bool; tick 0 is the time of the first event of all."""
        return self._chain.feed(self._clock.count(block))

    @property
    def totals(self) -> dict[Filter, Total]:
        """What each enabled filter has done so far, in their order."""
        return self._chain.totals


def filtered(blocks: Iterable[Events], config: FilterConfig, sensor: tuple[int, int], tick_us: int = 1) -> Filtered:
    """Filter a recording that comes in blocks; memory does not grow with its length.

    Args:
        blocks: events in time order.
        sensor: (width, height) in pixels.
        tick_us: length of a tick.

    Raises:
        ConfigError: a time that ticks cannot count, or a hot pixel outside the sensor.
    """
    return Filtered(blocks, FilterChain(config.registers(tick_us), config.shape(*sensor)), tick_us)


def apply(recording: Recording, config: FilterConfig, tick_us: int = 1) -> tuple[Recording, NDArray[np.bool_]]:
    """A recording of the events that stay, under the same name, and which they are, (n,) bool; errors as of `filtered`."""
    keep = filtered((), config, (recording.width, recording.height), tick_us).keep(recording.events)
    return Recording(recording.events.where(keep), recording.width, recording.height, recording.name), keep

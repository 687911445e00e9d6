# SPDX-License-Identifier: Apache-2.0
"""A chain of filters, in the order of the hardware."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .activity import ActivityFilter
from .base import EventFilter
from .cells import CellsFilter
from .contract import Filter, FilterShape
from .decay import DecayFilter
from .noise_level import NoiseLevel
from .recent import RecentFilter
from .refractory import RefractoryFilter
from .registers import FilterRegisters
from .rowcol import RowColumnFilter
from .stateless import MaskFilter, PolarityFilter, RegionFilter

__all__ = ["FILTERS", "FilterChain", "Total"]

FILTERS: dict[Filter, type[EventFilter]] = {
    Filter.REGION: RegionFilter,
    Filter.POLARITY: PolarityFilter,
    Filter.MASK: MaskFilter,
    Filter.REFRACTORY: RefractoryFilter,
    Filter.ACTIVITY: ActivityFilter,
    Filter.RECENT: RecentFilter,
    Filter.DECAY: DecayFilter,
    Filter.ROWCOL: RowColumnFilter,
}


class Total(NamedTuple):
    """Number of events that reached a filter, and number of those that it dropped."""

    seen: int
    dropped: int


class FilterChain(EventFilter):
    """The enabled filters in the contract's order; each sees only the events that passed those before it.

    Attributes:
        totals: event counts of each enabled filter so far, in the order of the chain.

    Raises:
        ConfigError: a register outside its limits.
    """

    def __init__(self, registers: FilterRegisters, shape: FilterShape) -> None:
        registers.check(shape)
        enabled = [which for which in Filter if registers.enables(which)]
        self._cells: CellsFilter | None = None
        self._stages: list[tuple[list[Filter], EventFilter]] = []
        with_cells = (Filter.REFRACTORY, Filter.ACTIVITY) if shape.cell_px else ()
        joined = [which for which in enabled if which in with_cells]
        for which in enabled:
            if which not in joined:
                self._stages.append(([which], FILTERS[which](registers, shape)))
            elif which == joined[0]:
                self._cells = CellsFilter(registers, shape)
                self._stages.append((joined, self._cells))
        self.totals = dict.fromkeys(enabled, Total(0, 0))

    @property
    def noise(self) -> NoiseLevel | None:
        """What the support of the activity filter follows; None if it follows nothing."""
        return self._cells.noise if self._cells else None

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        left = int(np.count_nonzero(keep))
        for filters, stage in self._stages:
            stage.narrow(events, keep)
            seen, left = left, int(np.count_nonzero(keep))
            if isinstance(stage, CellsFilter):
                self._count_cells(stage, filters)
                continue
            before = self.totals[filters[0]]
            self.totals[filters[0]] = Total(before.seen + seen, before.dropped + seen - left)

    def _count_cells(self, stage: CellsFilter, filters: list[Filter]) -> None:
        seen, rested, sent = stage.counts.tolist()
        if Filter.REFRACTORY in filters:
            self.totals[Filter.REFRACTORY] = Total(seen, seen - rested)
        if Filter.ACTIVITY in filters:
            reached = rested if Filter.REFRACTORY in filters else seen
            self.totals[Filter.ACTIVITY] = Total(reached, reached - sent)

# SPDX-License-Identifier: Apache-2.0
"""A chain of filters, in the order of the hardware."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..ticks import TickedEvents
from .activity import ActivityFilter
from .base import EventFilter
from .contract import Filter, FilterShape
from .decay import DecayFilter
from .mask import MaskFilter
from .polarity import PolarityFilter
from .recent import RecentFilter
from .refractory import RefractoryFilter
from .region import RegionFilter
from .registers import FilterRegisters
from .rowcol import RowColumnFilter

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
        self._filters = {which: FILTERS[which](registers, shape) for which in Filter if registers.enables(which)}
        self.totals = dict.fromkeys(self._filters, Total(0, 0))

    def narrow(self, events: TickedEvents, keep: NDArray[np.bool_]) -> None:
        left = int(np.count_nonzero(keep))
        for which, stage in self._filters.items():
            stage.narrow(events, keep)
            seen, left = left, int(np.count_nonzero(keep))
            before = self.totals[which]
            self.totals[which] = Total(before.seen + seen, before.dropped + seen - left)

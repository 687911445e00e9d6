# SPDX-License-Identifier: Apache-2.0
"""What the golden models of both contracts share: the filters in front, and the form of their decisions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..filters.chain import FilterChain
from ..ticks import TickedEvents
from ..tracks.log import DROPPED
from .config import HardwareConfig

__all__ = ["Decisions", "GoldenModel"]


class Decisions(NamedTuple):
    """The result of a run of events.

    Attributes:
        records: (m,) of dtype `contract.RECORD`, of cot_motion `motion.contract.MOTION_RECORD`; in chronological order.
        owner: (n,) int16, the slot that took each event, -1 if none did, `tracks.log.DROPPED` if a
            filter dropped it.
        rel_x, rel_y: (n,) uint16, the event's address in its owner's window (x - cm_x + R), of cot_motion half pixels from the
            middle of its owner's box, modulo 2^shape.rel_w; 0 without an owner.
    """

    records: NDArray[np.void]
    owner: NDArray[np.int16]
    rel_x: NDArray[np.uint16]
    rel_y: NDArray[np.uint16]


class GoldenModel(ABC):
    """A golden model as a stream: feed events in runs of any length; the result does not depend on how they are split.

    Memory is proportional to the events fed at once.

    Attributes:
        visible: (n,) bool, of cot_motion: whether a visible slot owns each event of the run that was fed last (rule O6).
    """

    def __init__(self, config: HardwareConfig) -> None:
        self._filters = FilterChain(config.filters, config.filter_shape) if config.filtered else None
        self.visible = np.zeros(0, np.bool_)

    def feed(self, events: TickedEvents, keep: NDArray[np.bool_] | None = None) -> Decisions:
        """Process a run of events.

        Args:
            events: ticks never decrease over the model's life, and addresses are below 2^x_w and 2^y_w.
            keep: (n,) bool, mask of the events that passed external filters; the others are counted but have no owner. None
                for all. Not allowed if the model has filters itself.
        """
        if self._filters is not None:
            if keep is not None:
                raise ConfigError("a model with filters decides itself which events stay")
            keep = self._filters.feed(events)
        n = len(events)
        owner = np.full(n, DROPPED, np.int16)
        rel_x, rel_y = np.zeros(n, np.uint16), np.zeros(n, np.uint16)
        self.visible = np.zeros(n, np.bool_)
        records = self._decide(events, None if keep is None else events.mask(keep), owner, rel_x, rel_y, self.visible)
        return Decisions(records, owner, rel_x, rel_y)

    @abstractmethod
    def _decide(
        self,
        events: TickedEvents,
        keep: NDArray[np.bool_] | None,
        owner: NDArray[np.int16],
        rel_x: NDArray[np.uint16],
        rel_y: NDArray[np.uint16],
        visible: NDArray[np.bool_],
    ) -> NDArray[np.void]:
        """Fill in what is decided on each event, and return the records. `owner` holds `DROPPED`, the other arrays zeros."""

    @property
    @abstractmethod
    def time(self) -> int:
        """Ticks since reset, at the last event."""

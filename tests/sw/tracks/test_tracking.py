# SPDX-License-Identifier: Apache-2.0
"""A log is the concatenation of a tracker's output, run by run, and at the end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.tracks.log import TRACK
from evcot.tracks.tracking import TrackerOutput, log_of


class Parrot:
    """A tracker with one record per run, and one at the end; the owner of an event is its column."""

    def __init__(self) -> None:
        self.seen = 0

    def _record(self) -> NDArray[np.void]:
        told = np.zeros(1, TRACK)
        told["event_index"] = self.seen
        return told

    def feed(self, events: Events) -> TrackerOutput:
        self.seen += len(events)
        return self._record(), events.x.astype(np.int16)

    def finish(self) -> NDArray[np.void]:
        return self._record()


def make_events(count: int) -> Events:
    return Events(np.arange(count), *(np.arange(count, dtype=np.uint16),) * 2, np.zeros(count, np.uint8))


def test_records_and_owners_are_joined_in_order() -> None:
    events = make_events(10)
    log = log_of("parrot", Parrot(), [events[:4], events[4:9], events[9:]])
    assert log.engine == "parrot"
    assert log.records["event_index"].tolist() == [4, 9, 10, 10]
    assert log.owner.tolist() == list(range(10))


def test_without_blocks_there_is_only_the_end() -> None:
    log = log_of("parrot", Parrot(), [])
    assert (log.records["event_index"].tolist(), len(log.owner)) == ([0], 0)

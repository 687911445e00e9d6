# SPDX-License-Identifier: Apache-2.0
"""Check that a log belongs to a recording: by the fingerprint of the events, if the log has one, and by its extent.

The extent matches if there are as many owners as events, and no record before, after or beyond them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..digest import EventsDigest
from ..errors import TrackLogError
from ..events import Events
from .reading import RecordRuns

__all__ = ["Extent", "check_belongs"]


@dataclass(frozen=True)
class Extent:
    """What a log must match: number of events, first and last time, and the fingerprint (`digest.digest`)."""

    events: int
    first_us: int
    last_us: int
    digest: str

    @classmethod
    def of(cls, blocks: Iterable[Events]) -> Extent:
        """The extent of blocks of events; times are 0 without events."""
        count, first_us, last_us, summary = 0, 0, 0, EventsDigest()
        for block in blocks:
            if len(block):
                first_us = first_us if count else int(block.t_us[0])
                last_us = int(block.t_us[-1])
                count += len(block)
                summary.add(block)
        return cls(count, first_us, last_us, summary.hex())


def check_belongs(log: RecordRuns, to: Extent) -> None:
    """Raise TrackLogError for a log of other events than these."""
    owners = log.count_owners()
    if owners != to.events:
        raise TrackLogError(f"owner has {owners} entries: must be one for each of the recording's {to.events} events")
    if log.recording and log.recording != to.digest:
        raise TrackLogError(f"recording = {log.recording!r}: must be the digest of the recording's events, {to.digest!r}")
    first = 0
    for records in log.record_runs():
        for name, low, high in (("event_index", 0, to.events), ("t_us", to.first_us, to.last_us)):
            good = (records[name] >= low) & (records[name] <= high)
            if not good.all():
                row = int(np.argmin(good))
                rule = f"must be from {low} to {high}, as the recording's events are"
                raise TrackLogError(f"record {first + row}: {name} = {records[name][row]}: {rule}")
        first += len(records)

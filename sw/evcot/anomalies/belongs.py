# SPDX-License-Identifier: Apache-2.0
"""Whether a log can be of a recording: as many owners as events, and no record before, after or beyond them."""

from __future__ import annotations

import numpy as np

from ..errors import TrackLogError
from ..tracks.log import TrackLog

__all__ = ["check_belongs"]

_AFTER_US = 1_000_000  # in which packets and lives may end


def check_belongs(log: TrackLog, events: int, first_us: int, last_us: int) -> None:
    """Raise TrackLogError for a log that does not belong to a recording of so many events, between these times."""
    if len(log.owner) != events:
        raise TrackLogError(f"owner has {len(log.owner)} entries: must be one for each of the recording's {events} events")
    records = log.records
    rules = (
        ("event_index", (records["event_index"] >= 0) & (records["event_index"] <= events), f"must be from 0 to {events}"),
        (
            "t_us",
            (records["t_us"] >= first_us) & (records["t_us"] <= last_us + _AFTER_US),
            f"must be in the recording's time, {first_us} to {last_us}, or a second after",
        ),
    )
    for name, good, rule in rules:
        if not good.all():
            row = int(np.argmin(good))
            raise TrackLogError(f"record {row}: {name} = {records[name][row]}: {rule}")

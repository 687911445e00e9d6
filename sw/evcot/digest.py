# SPDX-License-Identifier: Apache-2.0
"""A fingerprint of events, by which runs and track logs identify the events from which they were made."""

from __future__ import annotations

from hashlib import blake2b

import numpy as np

from .events import Events

__all__ = ["EventsDigest", "digest"]


class EventsDigest:
    """The fingerprint of a stream of events, independent of its division into blocks. About 1 ns per byte."""

    def __init__(self) -> None:
        self._columns = [blake2b(digest_size=8) for _ in range(4)]

    def add(self, events: Events) -> None:
        """Append a block."""
        for column, values in zip(self._columns, (events.t_us, events.x, events.y, events.p), strict=True):
            column.update(np.ascontiguousarray(values).data)

    def hex(self) -> str:
        """The fingerprint of all events so far: 16 hexadecimal digits."""
        return blake2b(b"".join(column.digest() for column in self._columns), digest_size=8).hexdigest()


def digest(events: Events) -> str:
    """The fingerprint of events."""
    summary = EventsDigest()
    summary.add(events)
    return summary.hex()

# SPDX-License-Identifier: Apache-2.0
"""The output of a tracker: records of its tracks, and owners of the events."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

__all__ = ["DROPPED", "TRACK", "Kind"]

DROPPED = -2  # owner of an event that a filter dropped; -1 is an event that no tracker took


class Kind(IntEnum):
    """Kinds of records in a TrackLog."""

    BORN = 0
    MOVED = 1
    MERGED = 2
    LOST = 3


TRACK = np.dtype(
    [
        ("t_us", "<i8"),
        ("event_index", "<i8"),
        ("kind", "u1"),
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("radius", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("angle", "<f8"),
        ("vx", "<f8"),
        ("vy", "<f8"),
        ("confidence", "<f8"),
        ("n_ev", "<i4"),
        ("support", "<i8"),
        ("other_id", "<i8"),
    ]
)

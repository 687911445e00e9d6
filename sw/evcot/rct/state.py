# SPDX-License-Identifier: Apache-2.0
"""What the compiled tracker remembers between two events: plain arrays of these records."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..tracklog import TRACK

__all__ = ["CELLS", "CLUSTER", "CURSOR", "NEVER_US", "RECORDS_PER_PACKET", "Rules", "State", "Table", "new_state", "summary"]

Table = NDArray[Any]

NEVER_US = 1 << 62
# A cluster is born, and ends or moves, in one packet, and may be lost in the silence after it; then the next packet's births.
RECORDS_PER_PACKET = 4
CELLS = 64  # to a side of the lookup

# One per slot. What every event touches stands first, in one line of the cache.
CLUSTER = np.dtype(
    [
        ("x", "<f8"),  # centre, pixels
        ("y", "<f8"),
        ("last_us", "<i8"),  # its last event
        ("packet_events", "<i8"),  # events in the open packet
        ("check_at", "<i8"),  # at so many of these it is looked at: visible by now? far from where it was registered?
        ("order", "<i8"),  # how many were seeded before it
        ("before", "<i8"),  # events before the open packet, its own and those of the clusters that it absorbed
        ("track_id", "<i8"),  # -1 until it is visible
        ("velocity_x", "<f8"),  # pixels per second
        ("velocity_y", "<f8"),
        ("from_x", "<f8"),  # where and when velocity was last measured
        ("from_y", "<f8"),
        ("from_us", "<i8"),  # NEVER_US before the end of its first packet
        ("due_index", "<i8"),  # first event at or after the end of its life, as of
        ("due_us", "<i8"),  # the `last_us` for which that was found
        ("cells_x", "<f8"),  # where it is registered in the lookup
        ("cells_y", "<f8"),
    ]
)

CURSOR = np.dtype(
    [
        ("live", "<i8"),  # clusters
        ("seeded", "<i8"),  # clusters so far
        ("births", "<i8"),  # clusters that became visible so far: the next track id
        ("index", "<i8"),  # events so far
        ("last_us", "<i8"),  # the last event
        ("packet_end_us", "<i8"),  # exclusive; -NEVER_US before the first event
        ("next_due_us", "<i8"),  # no life whose end is not yet noted ends before it
        ("records", "<i8"),  # in the buffer
        ("closed", "<i8"),  # of which in packets that are closed
    ]
)

# What the outside sees of a cluster.
SUMMARY = np.dtype(
    [
        ("x", "<f8"),
        ("y", "<f8"),
        ("velocity_x", "<f8"),
        ("velocity_y", "<f8"),
        ("events", "<i8"),
        ("last_us", "<i8"),
        ("track_id", "<i8"),
        ("slot", "<i8"),
    ]
)


class Rules(NamedTuple):
    """`config.RctConfig` as the kernel takes it."""

    radius_px: float
    alpha: float
    velocity_alpha: float
    visible_events: int
    lifetime_us: int
    packet_us: int


class State(NamedTuple):
    """All that a tracker carries along.

    Attributes:
        cursor: (1,) of `CURSOR`.
        clusters: (max_clusters,) of `CLUSTER`, by slot.
        live: (max_clusters,) int64: the slots in use, seeded first first.
        cells: (CELLS * CELLS, words) uint64: the sets of `lookup`.
        out: the records that were not yet taken, of dtype `TRACK`.
    """

    cursor: Table
    clusters: Table
    live: Table
    cells: Table
    out: Table


def new_cells(max_clusters: int) -> NDArray[np.uint64]:
    """Empty sets: (cells, words)."""
    return np.zeros((CELLS * CELLS, -(-max_clusters // 64)), np.uint64)


def new_state(max_clusters: int) -> State:
    """Before the first event."""
    cursor = np.zeros(1, CURSOR)
    cursor["packet_end_us"] = cursor["last_us"] = -NEVER_US
    cursor["next_due_us"] = -NEVER_US
    clusters = np.zeros(max_clusters, CLUSTER)
    clusters["order"] = -1
    out = np.zeros(2 * RECORDS_PER_PACKET * max_clusters + 4096, TRACK)
    return State(cursor, clusters, np.zeros(max_clusters, np.int64), new_cells(max_clusters), out)


def summary(clusters: NDArray[np.void], slots: NDArray[np.int64]) -> NDArray[np.void]:
    """What `RctTracker.clusters` shows of them."""
    shown = np.zeros(len(clusters), SUMMARY)
    for name in set(SUMMARY.names or ()) & set(CLUSTER.names or ()):
        shown[name] = clusters[name]
    shown["events"] = clusters["before"] + clusters["packet_events"]
    shown["slot"] = slots
    return shown

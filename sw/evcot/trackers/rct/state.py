# SPDX-License-Identifier: Apache-2.0
"""The state of the compiled tracker: settings and everything kept between two events, as plain structured arrays."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...tracks.log import TRACK
from .config import RCT_CHOICES, RctConfig

__all__ = [
    "CELLS",
    "NEVER_US",
    "PLACE",
    "RECORDS_PER_PACKET",
    "SUMMARY",
    "EventOptions",
    "EventRules",
    "State",
    "Table",
    "choice",
    "event_options",
    "event_rules",
    "new_state",
    "summary",
]

Table = NDArray[Any]

NEVER_US = 1 << 62
# In one packet a cluster is born, and ends or moves; it may be lost in the silence after; then the next packet's births.
RECORDS_PER_PACKET = 4
CELLS = 64  # to a side of the lookup
_LINE = 64  # bytes
_WORD = 64  # bits

# The settings by name, with choices as numbers; and values derived from them.
RULES = np.dtype(
    [(f.name, "<f8" if isinstance(f.default, float) else "<i8") for f in fields(RctConfig)]
    + [
        ("full", "<i8"),  # any option beyond the paper's tracker
        ("perspective", "<i8"),
        ("width", "<f8"),  # of the sensor, 0 where unknown
        ("height", "<f8"),
    ]
)


class EventRules(NamedTuple):
    """The rules needed for every event, by value: no store can alias them, so that the loop need not reload them."""

    full: int
    radius_px: float
    alpha: float


class EventOptions(NamedTuple):
    """The options needed for every event, likewise."""

    alpha: float
    assign: int
    surround: float
    birth_spread_px: float
    box_quantile: float


# A cluster's fields. Those used for every event come first, eight per cache line.
_CLUSTER_FIELDS = (
    ("x", "<f8"),  # centre, pixels
    ("y", "<f8"),
    ("last_us", "<i8"),  # its last event
    ("packet_events", "<i8"),  # events in the open packet
    ("check_at", "<i8"),  # value of `packet_events` at the next `life.check`
    ("slot", "<i8"),  # public slot number
    ("extent_x", "<f8"),  # half the sides of the object, as seen from the centre
    ("extent_y", "<f8"),
    # Options: half the sides of the window.
    ("half_width", "<f8"),
    ("half_height", "<f8"),
    ("room", "<f8"),  # how far it may move before it is registered anew
    ("mix", "<f8"),  # mixing factor of the deviations, larger for young clusters
    ("track_id", "<i8"),  # -1 until it is visible
    # Options: running means of the distances of its events from the centre.
    ("deviation_x", "<f8"),
    ("deviation_y", "<f8"),
    ("before", "<i8"),  # events before the open packet, its own and those of the clusters that it absorbed
    ("left", "<f8"),  # the box
    ("right", "<f8"),
    ("top", "<f8"),
    ("bottom", "<f8"),
    ("step_x", "<f8"),  # of the sides of box and extent
    ("step_y", "<f8"),
    ("cells_x", "<f8"),  # where it is registered in the lookup
    ("cells_y", "<f8"),
    # Once per packet.
    ("velocity_x", "<f8"),  # pixels per second
    ("velocity_y", "<f8"),
    ("from_x", "<f8"),  # where and when velocity was last measured
    ("from_y", "<f8"),
    ("from_us", "<i8"),  # NEVER_US before the end of its first packet
    ("places", "<i8"),  # number of positions in the path so far
    ("measured", "<i8"),  # number of these since it last jumped
    ("mass", "<f8"),  # at the end of the last packet
    ("due_index", "<i8"),  # first event at or after the end of its life, for
    ("due_us", "<i8"),  # the `last_us` for which it was determined
    ("cells_reach_x", "<f8"),  # extent of its registration in the lookup
    ("cells_reach_y", "<f8"),
)

# Padded to whole cache lines.
CLUSTER = np.dtype(
    {
        "names": [name for name, _ in _CLUSTER_FIELDS],
        "formats": [form for _, form in _CLUSTER_FIELDS],
        "itemsize": -(-8 * len(_CLUSTER_FIELDS) // _LINE) * _LINE,
    }
)

# A position on a path.
PLACE = np.dtype([("t_us", "<i8"), ("x", "<f8"), ("y", "<f8")])

CURSOR = np.dtype(
    [
        ("live", "<i8"),  # clusters
        ("seated", "<i8"),  # seats of the lookup that were assigned
        ("births", "<i8"),  # clusters that became visible so far: the next track id
        ("index", "<i8"),  # events so far
        ("last_us", "<i8"),  # the last event
        ("packet_end_us", "<i8"),  # exclusive; -NEVER_US before the first event
        ("next_due_us", "<i8"),  # lower bound of the ends of life not yet noted
        ("records", "<i8"),  # in the buffer
        ("closed", "<i8"),  # of which in closed packets
    ]
)

# The public fields of a cluster.
SUMMARY = np.dtype(
    [
        ("x", "<f8"),
        ("y", "<f8"),
        ("velocity_x", "<f8"),
        ("velocity_y", "<f8"),
        ("half_width", "<f8"),
        ("half_height", "<f8"),
        ("events", "<i8"),
        ("last_us", "<i8"),
        ("track_id", "<i8"),
        ("slot", "<i8"),
    ]
)


class State(NamedTuple):
    """The complete state of a tracker.

    Attributes:
        rules: (1,) of `RULES`.
        cursor: (1,) of `CURSOR`.
        clusters: (max_clusters,) of `CLUSTER`, by slot.
        live: (max_clusters,) int64: the slots in use, in order of seeding.
        taken: (max_clusters,) int64: 1 where a slot is in use.
        cells: (words, CELLS * CELLS) uint64: the sets of `lookup`, by windows.
        around: the same by surrounds; empty without surrounds.
        paths: (max_clusters, path_points) of `PLACE`, rings by slot.
        out: the records that were not yet returned, of dtype `TRACK`.
    """

    rules: Table
    cursor: Table
    clusters: Table
    live: Table
    taken: Table
    cells: Table
    around: Table
    paths: Table
    out: Table


def choice(field: str, name: str) -> int:
    """The integer code of a choice in the rules."""
    return RCT_CHOICES[field].index(name)


def event_rules(state: State) -> EventRules:
    """The rules for the loop over events."""
    return EventRules(*(state.rules[name][0].item() for name in EventRules._fields))


def event_options(state: State) -> EventOptions | None:
    """The options for the loop over events; None for the paper's tracker."""
    if not state.rules["full"][0]:
        return None
    return EventOptions(*(state.rules[name][0].item() for name in EventOptions._fields))


def new_state(config: RctConfig, width: int, height: int) -> State:
    """The state before the first event."""
    n = config.max_clusters
    words = -(-(n + n // 4) // _WORD)
    cursor = np.zeros(1, CURSOR)
    cursor["packet_end_us"] = cursor["last_us"] = cursor["next_due_us"] = -NEVER_US
    clusters = _on_lines(_WORD * words, CLUSTER)
    return State(
        _rules(config, width, height),
        cursor,
        clusters,
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros((words, CELLS * CELLS), np.uint64),
        np.zeros((words if config.surround > 1.0 else 0, CELLS * CELLS), np.uint64),
        np.zeros((n, max(1, config.path_points)), PLACE),
        np.zeros(2 * RECORDS_PER_PACKET * n + 4096, TRACK),
    )


def _on_lines(n: int, dtype: np.dtype[Any]) -> Table:
    """n zeros, aligned to a cache line."""
    raw = np.zeros(n * dtype.itemsize + _LINE, np.uint8)
    begin = -raw.ctypes.data % _LINE
    return raw[begin : begin + n * dtype.itemsize].view(dtype)


def _rules(config: RctConfig, width: int, height: int) -> Table:
    rules = np.zeros(1, RULES)
    for f in fields(config):
        value = getattr(config, f.name)
        rules[f.name] = choice(f.name, value) if f.name in RCT_CHOICES else value
    rules["full"], rules["perspective"] = config.full, config.perspective
    rules["width"], rules["height"] = width, height
    return rules


def summary(clusters: NDArray[np.void]) -> NDArray[np.void]:
    """The public fields of clusters, as in `RctTracker.clusters`: (k,) of dtype `SUMMARY`."""
    shown = np.zeros(len(clusters), SUMMARY)
    for name in set(SUMMARY.names or ()) & set(CLUSTER.names or ()):
        shown[name] = clusters[name]
    shown["events"] = clusters["before"] + clusters["packet_events"]
    return shown

# SPDX-License-Identifier: Apache-2.0
"""Data shared by the compiled parts: settings, objects, cells, and the state of the stream."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiled import UNSET_US
from .config import AdaptiveConfig

__all__ = [
    "BINS",
    "CELL_BITS",
    "INSIDE",
    "LEVELS",
    "NEAR",
    "NOBODY",
    "OBJECT",
    "PARTS",
    "RUN",
    "UNSET_US",
    "Rules",
    "World",
    "make_rules",
    "make_world",
]

Table = NDArray[Any]

CELL_BITS = 3  # a cell has 8 x 8 pixels: as many as a word has bits
BINS = 48  # of a look along an axis, at most; a row of them fits into a word
PARTS = 24  # that a look tells apart, at most
LEVELS = 6  # windows in which births are looked for, each twice as long as the one before
NOBODY = -1  # in `World.near`, beside slots
INSIDE = 4  # of `away`, beside edges: lost on the sensor
NEAR = 4  # objects that a cell can have near it

OBJECT = np.dtype(
    [
        ("alive", "?"),
        ("track_id", "<i8"),  # -1 until the object is visible
        ("name", "<i8"),  # its track id until it was lost, if it was found again; or -1
        ("born_us", "<i8"),
        ("first_x", "<f8"),  # where it was seen to start, until it is visible
        ("first_y", "<f8"),
        ("path", "<f8"),  # way since then
        ("still", "<f8"),  # half sides that it would have travelled at its speed, since it last moved for sure
        ("packets", "<i8"),
        ("edge", "<i8"),  # edge of the sensor at which it was born: 0 left, 1 right, 2 top, 3 bottom; or -1
        ("travel", "<f8"),  # half sides travelled
        ("inside", "<i8"),  # slot of an object whose box holds most of this one's, or whose box this one's holds
        ("within", "<f8"),  # travel since it is, half sides
        ("meets", "?"),  # whether its box touches another object's
        ("speed", "<f8"),  # px/s, the greatest of the recent past: the object's unit of velocity
        ("unseen_us", "<i8"),  # time since the last look
        ("missed", "<f8"),  # half sides travelled without support
        ("lost_us", "<i8"),  # time since the last support
        ("away", "<i8"),  # edge over which it has left the sensor, as for `edge`; INSIDE if it was lost on it; or -1
        ("support", "<i8"),  # events so far
        ("packet_events", "<i8"),
        ("mass", "<f8"),  # pixels that the last look showed
        ("usual", "<f8"),  # pixels per pixel travelled, a mean over its life
        ("contrast", "<f8"),  # pixels in its box, per area, by those around it
        ("apart", "<i8"),  # looks in a row that showed two objects
        ("gate", "<f8"),  # width of the gate around the box
        ("x", "<f8"),  # the box used to assign the open packet's events: centre and half sides
        ("y", "<f8"),
        ("half_x", "<f8"),
        ("half_y", "<f8"),
    ]
)

RUN = np.dtype(
    [
        ("index", "<i8"),  # events so far
        ("settled", "<i8"),  # events before the open packet
        ("last_us", "<i8"),  # the last event
        ("packet", "<i8"),  # number of the open packet
        ("packet_us", "<i8"),  # its length
        ("packet_end_us", "<i8"),  # exclusive; UNSET_US before the first event
        ("birth_end_us", "<i8"),
        ("birth_tick", "<i8"),
        ("first_us", "<i8"),  # the first event
        ("births", "<i8"),  # the next track id
        ("noise", "<f8"),  # events per pixel and second of the background; negative until known
        ("live", "<i8"),  # living objects
        ("records", "<i8"),  # in the buffer
    ]
)


class Rules(NamedTuple):
    """`config.AdaptiveConfig` in the form used by the kernel, and the sensor."""

    width: int
    height: int
    memory: float
    fill: float
    blur: float
    pause: float
    quantile: float
    precision: float
    gate: float
    dense: float
    agility: float
    growth_agility: float
    meeting_agility: float
    birth_pixels: int
    birth_speed: float
    visible_travel: float
    coast: float
    full: float
    elongation: float
    gap: float
    merge_velocity: float
    step: float


class World(NamedTuple):
    """The complete state of a tracker.

    n objects by slot; c cells of 8 x 8 pixels by row; axis 0 is x, 1 is y.
    """

    run: Table  # (1,) of dtype RUN
    objects: Table  # (n,) of dtype OBJECT
    slots: Table  # (n,) the slots of the living objects, `run.live` of them
    state: Table  # (n, 2, 4): centre, velocity, half side, growth of the half side; px and px/s
    cov: Table  # (n, 2, 4, 4)
    meeting: Table  # (n,) the slots of objects that meet the one that is looked at
    bins: Table  # (BINS, BINS) pixels in each bin of a look, by row
    around: Table  # (BINS, BINS) sums of 3 x 3 bins around those that are not empty
    filled: Table  # (BINS,) uint64: the bins of each row that are not empty, a bit each
    taken: Table  # (BINS,) uint64: those that belong to a part
    label: Table  # (BINS, BINS) the part of each of these, from 1 on
    free: Table  # (BINS,) uint64: the bins of each row that belong to no part yet, a bit each
    part: Table  # (BINS,) uint64: those of the part that is searched
    fresh: Table  # (BINS,) uint64: those of them whose surroundings are not searched yet
    line: Table  # (2, BINS) sums of columns and of rows
    parts: Table  # (PARTS, 3, 2) first and last bin of each part, along x and y; its pixels, and those in the box
    groups: Table  # (PARTS, 3, 2) middle and half side of groups of parts, along x and y, in bins; pixels
    group_of: Table  # (PARTS,) the group of each part
    whole: Table  # (2, 2) each: work space
    rest: Table
    bounds: Table
    group_box: Table  # (4,)
    seen: Table  # (height, width) int64: the time of each pixel's last event that counts
    noted: Table  # (height, width) int32: see `restless.rests`
    near: Table  # (rows, columns, NEAR): the slots of the objects near each cell, then NOBODY
    pixels: Table  # (LEVELS, rows, columns) uint64: pixels of each cell with events outside objects
    bits: Table  # (8, 8) uint64: the bit of each pixel of a cell
    queue: Table  # (cells,) the cells of a group
    group: Table  # (cells,) uint64: their pixels
    counts: Table  # (65,) cells by number of pixels


def make_rules(config: AdaptiveConfig, width: int, height: int) -> Rules:
    """The rules for a sensor."""
    values: dict[str, Any] = {name: getattr(config, name) for name in Rules._fields[2:]}
    for name, kind in Rules.__annotations__.items():
        if kind == "float":
            values[name] = float(values[name])
    return Rules(width, height, **values)


def make_world(n_objects: int, width: int, height: int) -> World:
    """The state before the first event."""
    rows, columns = (height + 7) >> CELL_BITS, (width + 7) >> CELL_BITS
    run = np.zeros(1, RUN)
    run["packet_end_us"] = run["last_us"] = UNSET_US
    run["noise"] = -1.0
    run["packet"] = 1
    return World(
        run,
        np.zeros(n_objects, OBJECT),
        np.zeros(n_objects, np.int64),
        np.zeros((n_objects, 2, 4)),
        np.zeros((n_objects, 2, 4, 4)),
        np.zeros(n_objects, np.int64),
        np.zeros((BINS, BINS)),
        np.zeros((BINS, BINS)),
        np.zeros(BINS, np.uint64),
        np.zeros(BINS, np.uint64),
        np.zeros((BINS, BINS), np.int64),
        np.zeros(BINS, np.uint64),
        np.zeros(BINS, np.uint64),
        np.zeros(BINS, np.uint64),
        np.zeros((2, BINS)),
        np.zeros((PARTS, 3, 2)),
        np.zeros((PARTS, 3, 2)),
        np.zeros(PARTS, np.int64),
        np.zeros((2, 2)),
        np.zeros((2, 2)),
        np.zeros((2, 2)),
        np.zeros(4),
        np.full((height, width), UNSET_US, np.int64),
        np.zeros((height, width), np.int32),
        np.full((rows, columns, NEAR), NOBODY, np.int16),
        np.zeros((LEVELS, rows, columns), np.uint64),
        np.uint64(1) << np.arange(64, dtype=np.uint64).reshape(8, 8),
        np.zeros(rows * columns, np.int64),
        np.zeros(rows * columns, np.uint64),
        np.zeros(65, np.int64),
    )

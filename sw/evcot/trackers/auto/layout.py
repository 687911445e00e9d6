# SPDX-License-Identifier: Apache-2.0
"""Data shared by the compiled parts: settings, objects, cells, and the state of the stream."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiled import UNSET_US
from .config import AutoConfig

__all__ = [
    "BINS",
    "CELL_BITS",
    "LEVELS",
    "NEAR",
    "NOBODY",
    "OBJECT",
    "PROFILE",
    "REACH",
    "RUN",
    "UNSET_US",
    "Rules",
    "World",
    "make_rules",
    "make_world",
]

Table = NDArray[Any]

CELL_BITS = 3  # a cell has 8 x 8 pixels: as many as a word has bits
PROFILE = 8  # parts of a box along each side, in which the density of its events is kept
BINS, REACH = 40, 2.5  # of an object's picture along an axis: bins over -REACH to REACH units
LEVELS = 6  # windows in which births are looked for, each twice as long as the one before
NOBODY = -1  # in `World.near`, beside slots
NEAR = 4  # objects that a cell can have near it

OBJECT = np.dtype(
    [
        ("alive", "?"),
        ("track_id", "<i8"),  # -1 until the object is visible
        ("born_us", "<i8"),
        ("first_x", "<f8"),  # where it was seen to start, until it is visible
        ("first_y", "<f8"),
        ("path", "<f8"),  # way since then
        ("still", "<f8"),  # half sides that it would have travelled at its speed, since it last moved for sure
        ("packets", "<i8"),
        ("enters", "<i8"),  # edge of the sensor over which it enters: 0 left, 1 right, 2 top, 3 bottom; -1 once inside
        ("edge", "<i8"),  # the edge at which it was born, or -1
        ("travel", "<f8"),  # half sides travelled
        ("inside", "<i8"),  # slot of an object whose box holds most of this one's, or whose box this one's holds
        ("within", "<f8"),  # travel since it is, half sides
        ("meets", "?"),  # whether its box touches another object's
        ("speed", "<f8"),  # px/s, the greatest of the recent past: the object's unit of velocity
        ("silent_us", "<i8"),  # time without support
        ("support", "<i8"),  # events so far
        ("packet_events", "<i8"),
        ("rate", "<f8"),  # pixels per second, a mean over the recent past
        ("usual", "<f8"),  # pixels per pixel travelled, a mean over its life
        ("weight", "<f8"),  # weight of the open packet's pixels, shared ones counted by share
        ("x", "<f8"),  # the box used to assign the open packet's events: centre and half sides
        ("y", "<f8"),
        ("half_x", "<f8"),
        ("half_y", "<f8"),
        ("unit_x", "<f8"),  # of its picture, px
        ("unit_y", "<f8"),
        ("drawn", "<f8"),  # half sides travelled since its picture was begun
        ("area", "<f8"),  # pixels that its picture fills
        ("unfitted", "<f8"),  # since the box was held against it
        ("gain", "<f8"),  # weight of a pixel drawn now
        ("floor", "<f8"),  # noise in a bin of the picture
        ("contrast", "<f8"),  # pixels of its picture in the box, per area, by those around it
        ("gate", "<f8"),  # width of the gate around the box
        ("left", "<f8"),  # the box and the gate
        ("right", "<f8"),
        ("top", "<f8"),
        ("bottom", "<f8"),
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
        ("filled", "<i8"),  # bins of the picture looked at last
        ("records", "<i8"),  # in the buffer
    ]
)


class Rules(NamedTuple):
    """`config.AutoConfig` in the form used by the kernel, and the sensor."""

    width: int
    height: int
    quantile: float
    gate: float
    events_per_sample: float
    agility: float
    growth_agility: float
    meeting_agility: float
    birth_pixels: int
    birth_speed: float
    visible_travel: float
    coast: float
    memory: float
    dense: float
    tolerance: float
    full: float
    gap: float
    elongation: float
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
    beyond: Table  # (n, 2, 2): weight of the open packet's events beyond the low and the high side
    abreast: Table  # (n, 2): weight of the events between the other axis's sides
    moments: Table  # (n, 2, 2): sums over these of the offset from the centre, and of its absolute value; px
    usual: Table  # (n, 2, 3): fading sums, of weights and of both moments in half sides
    profile: Table  # (n, PROFILE * PROFILE): events in each part of the box, fading
    total: Table  # (n,) of all parts
    picture: Table  # (n, BINS, BINS) float32: weight of the pixels in the object's frame, by row
    done: Table  # (BINS, BINS) bool, bin_queue: (BINS * BINS,) of a search in a picture
    bin_queue: Table
    line: Table  # (BINS,) float32, parts: (16, 3, 2), whole, rest and bounds: (2, 2), group_box: (4,): work space
    parts: Table
    whole: Table
    rest: Table
    bounds: Table
    group_box: Table
    seen: Table  # (height, width, 2) int32: the packet of each pixel's last event; and see `restless.rests`
    near: Table  # (rows, columns, NEAR): the slots of the objects near each cell, then NOBODY
    pixels: Table  # (LEVELS, rows, columns) uint64: pixels of each cell with unassigned events
    bits: Table  # (8, 8) uint64: the bit of each pixel of a cell
    queue: Table  # (cells,) the cells of a group
    group: Table  # (cells,) uint64: their pixels
    counts: Table  # (65,) cells by number of pixels


def make_rules(config: AutoConfig, width: int, height: int) -> Rules:
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
        np.zeros((n_objects, 2, 2)),
        np.zeros((n_objects, 2)),
        np.zeros((n_objects, 2, 2)),
        np.zeros((n_objects, 2, 3)),
        np.zeros((n_objects, PROFILE * PROFILE)),
        np.zeros(n_objects),
        np.zeros((n_objects, BINS, BINS), np.float32),
        np.zeros((BINS, BINS), np.bool_),
        np.zeros(BINS * BINS, np.int64),
        np.zeros(BINS, np.float32),
        np.zeros((16, 3, 2)),
        np.zeros((2, 2)),
        np.zeros((2, 2)),
        np.zeros((2, 2)),
        np.zeros(4),
        np.zeros((height, width, 2), np.int32),
        np.full((rows, columns, NEAR), NOBODY, np.int16),
        np.zeros((LEVELS, rows, columns), np.uint64),
        np.uint64(1) << np.arange(64, dtype=np.uint64).reshape(8, 8),
        np.zeros(rows * columns, np.int64),
        np.zeros(rows * columns, np.uint64),
        np.zeros(65, np.int64),
    )

# SPDX-License-Identifier: Apache-2.0
"""Data shared by the compiled parts: settings, objects, cells, and the state of the stream."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiled import UNSET_US
from .config import KalmanConfig

__all__ = ["CELL_BITS", "MANY", "NOBODY", "OBJECT", "PROFILE", "RUN", "UNSET_US", "Rules", "World", "make_rules", "make_world"]

Table = NDArray[Any]

CELL_BITS = 3  # a cell has 8 x 8 pixels: as many as a word has bits
PROFILE = 8  # parts of a box along each side, in which the density of its events is kept
NOBODY, MANY = -1, -2  # in `World.near`, beside the slot of the only object near a cell

OBJECT = np.dtype(
    [
        ("alive", "?"),
        ("track_id", "<i8"),
        ("born_us", "<i8"),
        ("enters", "<i8"),  # edge of the sensor over which it enters: 0 left, 1 right, 2 top, 3 bottom; -1 once inside
        ("edge", "<i8"),  # the edge at which it was born, or -1
        ("alone_us", "<i8"),  # total time without touching another object
        ("meets", "?"),  # whether its box touches another object's
        ("supported_us", "<i8"),  # end of the last packet in which it had the expected events
        ("support", "<i8"),  # events so far
        ("packet_events", "<i8"),
        ("rate", "<f8"),  # events per packet, a mean over the recent past
        ("weight", "<f8"),  # weight of the open packet's events, shared events counted by share
        ("x", "<f8"),  # the box used to assign the open packet's events: centre and half sides
        ("y", "<f8"),
        ("half_x", "<f8"),
        ("half_y", "<f8"),
        ("parts_x", "<f8"),  # parts of the profile in a pixel, along x and y
        ("parts_y", "<f8"),
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
        ("last_us", "<i8"),  # the last event
        ("packet_end_us", "<i8"),  # exclusive; UNSET_US before the first event
        ("birth_end_us", "<i8"),
        ("births", "<i8"),  # the next track id
        ("clutter", "<f8"),  # unassigned events per pixel and packet
        ("live", "<i8"),
        ("listed", "<i8"),  # in `World.slots`
        ("records", "<i8"),  # in the buffer
    ]
)


class Rules(NamedTuple):
    """`config.KalmanConfig` in the form used by the kernel, and the sensor."""

    width: int
    height: int
    packet_us: int
    refractory_us: int
    quantile: float
    afterglow: float
    gate_px: float
    gate_share: float
    events_per_sample: float
    velocity_walk: float
    growth_walk: float
    meeting_walk: float
    speed: float
    birth_us: int
    birth_pixels: int
    coast_us: int
    merge_gap: float
    merge_velocity: float
    walls: bool


class World(NamedTuple):
    """The complete state of a tracker.

    n objects by slot; c cells of 8 x 8 pixels by row; axis 0 is x, 1 is y.
    """

    run: Table  # (1,) of dtype RUN
    objects: Table  # (n,) of dtype OBJECT
    slots: Table  # (n,) the slots of the living objects when the packet was opened, ascending; `run.listed` of them
    state: Table  # (n, 2, 4): centre, velocity, half side, growth of the half side; px and px/s
    cov: Table  # (n, 2, 4, 4)
    beyond: Table  # (n, 2, 2): weight of the open packet's events beyond the low and the high side
    abreast: Table  # (n, 2): weight of the events between the other axis's sides
    profile: Table  # (n, PROFILE * PROFILE): events in each part of the box, fading
    total: Table  # (n,) of all parts
    accepted_us: Table  # (height, width): time of each pixel's last accepted event
    near: Table  # (rows, columns): the object near each cell, or NOBODY or MANY
    sets: Table  # (rows, columns, words) uint64: the slots of all objects near each cell, a bit each
    density: Table  # (n,) work space: expected events of each object at an event's pixel
    pixels: Table  # (rows, columns) uint64: pixels of each cell with unassigned events
    bits: Table  # (8, 8) uint64: the bit of each pixel of a cell
    sums: Table  # (2, PROFILE), sides: (2, 2, 2), group_box: (4,): work space
    sides: Table
    group_box: Table
    queue: Table  # (cells,) the cells of a group
    group: Table  # (cells,) uint64: their pixels


def make_rules(config: KalmanConfig, width: int, height: int) -> Rules:
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
    return World(
        run,
        np.zeros(n_objects, OBJECT),
        np.zeros(n_objects, np.int64),
        np.zeros((n_objects, 2, 4)),
        np.zeros((n_objects, 2, 4, 4)),
        np.zeros((n_objects, 2, 2)),
        np.zeros((n_objects, 2)),
        np.zeros((n_objects, PROFILE * PROFILE)),
        np.zeros(n_objects),
        np.full((height, width), UNSET_US),
        np.full((rows, columns), NOBODY, np.int16),
        np.zeros((rows, columns, (n_objects + 63) >> 6), np.uint64),
        np.zeros(n_objects),
        np.zeros((rows, columns), np.uint64),
        np.uint64(1) << np.arange(64, dtype=np.uint64).reshape(8, 8),
        np.zeros((2, PROFILE)),
        np.zeros((2, 2, 2)),
        np.zeros(4),
        np.zeros(rows * columns, np.int64),
        np.zeros(rows * columns, np.uint64),
    )

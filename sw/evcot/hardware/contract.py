# SPDX-License-Identifier: Apache-2.0
"""The contract of RTL, model and host: the single definition of what they must agree on.

It defines widths and their ranges, the registers of a slot, state codes, record kinds and the layout of a raw record.
`hw/verilog/common/evcot_defs.vh` and the C++ side of the simulation driver are generated from this file
(`python -m evcot.hardware.generate`); a test fails when a generated file is stale.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum
from types import MappingProxyType

import numpy as np

from ..errors import ConfigError
from ..ranges import check_integer

__all__ = [
    "HIST_AVG_STILL",
    "ORDERED",
    "RECORD",
    "RECORD_MEANINGS",
    "REGISTERS",
    "SHAPE_RANGES",
    "SLOTS_MAX",
    "Mode",
    "Register",
    "Shape",
    "State",
]

SLOTS_MAX = 64

HIST_AVG_STILL = 10
"""From this `hist_avg` on, which the bus refuses, neither average nor centre moves."""


class Mode(IntEnum):
    """Start mode of a tracker slot: register `mode`."""

    OFF = 0
    FIXED = 1
    SEEDED = 2


class State(IntEnum):
    """States of the tracker FSM in `cot.v`, as a waveform shows them."""

    INIT_CELL = 0
    IDLE = 1
    EV_DISCRI = 2
    EV_PASS_TH = 3
    EV_NO_PROC = 4
    EV_PROC = 5


# Hardware shape: field -> (lowest, highest, meaning). The RTL checks the same ranges at elaboration.
SHAPE_RANGES: dict[str, tuple[int, int, str]] = {
    "n_slots": (1, SLOTS_MAX, "tracker slots"),
    "x_w": (1, 16, "bits of an x address"),
    "y_w": (1, 16, "bits of a y address"),
    "frac": (0, 8, "fractional bits of a centre and of an average; 0 truncates like the published shifts"),
    "tick_w": (1, 32, "bits of the tick input"),
    "radix_w": (1, 12, "bits of a radius register"),
    "nev_w": (1, 16, "bits of N_ev"),
    "tc_w": (1, 32, "bits of a timer"),
    "sup_w": (1, 32, "bits of a support count, saturating"),
    "id_w": (1, 32, "bits of a track id"),
    "seq_w": (8, 48, "bits of an event's sequence number"),
    "time_w": (8, 48, "bits of the tick count"),
}


@dataclass(frozen=True)
class Shape:
    """Elaboration parameters of the hardware; the golden model computes with exactly these widths.

    Raises:
        ConfigError: a field lies outside `SHAPE_RANGES`, or time_w is less than tc_w + nev_w or than tick_w.
    """

    n_slots: int = 8
    x_w: int = 9
    y_w: int = 9
    frac: int = 4
    tick_w: int = 20
    radix_w: int = 8
    nev_w: int = 10
    tc_w: int = 24
    sup_w: int = 16
    id_w: int = 32
    seq_w: int = 48
    time_w: int = 48

    def __post_init__(self) -> None:
        for field in fields(self):
            low, high, meaning = SHAPE_RANGES[field.name]
            check_integer(f"shape.{field.name}", getattr(self, field.name), low, high, meaning)
        if self.time_w < self.tc_w + self.nev_w:
            raise ConfigError(
                f"shape.time_w = {self.time_w}: must be at least tc_w + nev_w = {self.tc_w + self.nev_w}, "
                "or the length of a window would wrap"
            )
        if self.time_w < self.tick_w:
            raise ConfigError(f"shape.time_w = {self.time_w}: must be at least tick_w = {self.tick_w}")

    @property
    def slot_w(self) -> int:
        """Bits of a slot number: ceil(log2(n_slots)), at least 1."""
        return max(1, (self.n_slots - 1).bit_length())

    @property
    def r_w(self) -> int:
        """Bits of a window radius R = g + radix_th."""
        return self.radix_w + 1

    @property
    def rel_w(self) -> int:
        """Bits of a recentred address, 0..2R; with motion signed half pixels."""
        return self.radix_w + 2

    @property
    def reach_log2(self) -> int:
        """With motion a box is not moved farther than 2^reach_log2 px out of the address space of as many pixels a side."""
        return max(self.x_w, self.y_w, 9)


@dataclass(frozen=True)
class Register:
    """One software-written register of a tracker slot.

    Attributes:
        address: word address on the register port.
        width: name of the `Shape` field that gives its width, or a number of bits.
        low: smallest legal value.
        high: largest legal value, or None for all ones.
        paper: the symbol in the published parameter table, if any.
        meaning: a one-line description.
    """

    address: int
    width: str | int
    low: int
    high: int | None
    paper: str
    meaning: str

    def bits(self, shape: Shape) -> int:
        """Width in bits for one hardware shape."""
        return self.width if isinstance(self.width, int) else int(getattr(shape, self.width))

    def limits(self, shape: Shape) -> tuple[int, int]:
        """Smallest and largest legal value for one hardware shape."""
        return self.low, (1 << self.bits(shape)) - 1 if self.high is None else self.high


# Software writes `mode` last: writing it sends the slot through INIT_CELL.
REGISTERS: dict[str, Register] = {
    "mode": Register(0, 2, 0, 2, "", "0 off, 1 fixed start, 2 seeded start; a write restarts the slot"),
    "init_cm_x": Register(1, "x_w", 0, None, "InitCMx", "x of the initial centre"),
    "init_cm_y": Register(2, "y_w", 0, None, "InitCMy", "y of the initial centre"),
    "init_radix": Register(3, "radix_w", 0, None, "InitRadix", "initial inner radius g"),
    "radix_th": Register(4, "radix_w", 0, None, "RadixTH", "width of the ring: R = g + radix_th"),
    "radix_step": Register(5, "radix_w", 0, None, "RadixStep", "step by which g grows or shrinks at a centre update"),
    "radix_min": Register(6, "radix_w", 0, None, "RadixMin", "smallest g"),
    "radix_max": Register(7, "radix_w", 0, None, "RadixMax", "largest g"),
    "hist_avg": Register(8, 4, 0, 8, "HistAvg", "k in alpha = 2^-k, for the average and for the centre"),
    "max_ticks": Register(9, "tc_w", 1, None, "Max, RSTimer", "ticks without an event after which an active cluster ends"),
    "clust_nev": Register(10, "nev_w", 1, None, "ClustNev", "N_ev at the start of a life"),
    "nev_min": Register(11, "nev_w", 1, None, "", "smallest N_ev"),
    "nev_max": Register(12, "nev_w", 1, None, "", "largest N_ev"),
    "nev_th": Register(13, "tc_w", 0, None, "TH", "ticks by which a window must differ from the previous one to change N_ev"),
    "detect_ticks": Register(14, "tc_w", 1, None, "", "ticks within which a candidate must collect clust_nev events"),
}

ORDERED = (("radix_min", "init_radix", "radix_max"), ("nev_min", "clust_nev", "nev_max"))
"""Registers of one slot that must not decrease from left to right; the hardware does not compare them with each other."""


# A record as output by the hardware: centres in fixed point with `Shape.frac` fractional bits.
RECORD = np.dtype(
    [
        ("seq", "<u8"),
        ("time", "<u8"),
        ("track_id", "<u4"),
        ("other_id", "<u4"),
        ("cm_x", "<u4"),
        ("cm_y", "<u4"),
        ("support", "<u4"),
        ("radius", "<u2"),
        ("n_ev", "<u2"),
        ("slot", "u1"),
        ("kind", "u1"),
        ("_pad", "<u2"),
        ("_pad2", "<u4"),
    ]
)

RECORD_MEANINGS: MappingProxyType[str, str] = MappingProxyType(
    {
        "seq": "number of the event that caused it; of a LOST record, of the next event",
        "time": "ticks since reset",
        "track_id": "the track",
        "other_id": "of a MERGED record, the track that survives; else 0",
        "cm_x": "column of the centre, in pixels with `shape0.frac` fractional bits",
        "cm_y": "row of it, likewise",
        "support": "events that the track has collected; saturates",
        "radius": "R = g + `radix_th`, in pixels",
        "n_ev": "N_ev, the events until the next centre update",
        "slot": "the slot of the track",
        "kind": "see below",
    }
)
"""Field of `RECORD` -> its meaning."""

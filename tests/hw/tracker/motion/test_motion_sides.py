# SPDX-License-Identifier: Apache-2.0
"""motion_sides.v: both axes of a slot, whatever commands come one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import PX

SIDE_W, X_W, Y_W, REACH = 25, 9, 7, 9
AXES = (("x", 0, X_W), ("y", 1, Y_W))


def signed(value: int, bits: int = SIDE_W) -> int:
    return (value + (1 << bits - 1)) % (1 << bits) - (1 << bits - 1)


@dataclass
class Axis:
    lo: int
    hi: int
    ref_lo: int
    ref_hi: int
    v: int

    @property
    def side(self) -> int:
        return max(self.hi - self.lo, 0)


def command(axis: Axis, name: str, io: Any, number: int, place: int, v_next: int) -> None:
    """What a command does to one axis."""
    marks = int(io.marks) >> 2 * number
    cut, mine = int(io.cut_px) * PX, int(io.on_y) == number
    if name == "seed":
        axis.lo, axis.hi, axis.v = (place - int(io.seed_px)) * PX, (place + int(io.seed_px)) * PX, 0
    elif name == "shrink":
        part = axis.side >> int(io.side_shrink)
        axis.lo, axis.hi = axis.lo + part * (not marks & 1), axis.hi - part * (not marks & 2)
    elif name == "cut_high" and mine:
        axis.hi = axis.lo + cut
    elif name == "cut_low" and mine:
        axis.lo += cut
    elif name == "order" and mine:
        axis.hi = max(axis.lo, axis.hi)
    elif name == "unite":
        axis.lo, axis.hi = axis.lo - max(axis.ref_lo, 0), axis.hi - min(axis.ref_hi, 0)
    elif name in ("move", "move slowly"):
        way = axis.v if name == "move" else axis.v >> int(io.coast_slow)
        sides = axis.lo + way, axis.hi + way
        if all(-(1 << REACH) * PX <= side < (2 << REACH) * PX for side in sides):
            axis.lo, axis.hi = sides
    elif name == "shorten" and axis.hi - axis.lo > int(io.side_max) * PX:
        middle, half = (axis.lo + axis.hi) >> 1, int(io.side_max) * PX // 2
        axis.lo, axis.hi = middle - half, middle + half
    elif name == "reflect":
        axis.ref_lo, axis.ref_hi = axis.lo - axis.ref_lo, axis.hi - axis.ref_hi
    elif name == "settle":
        axis.ref_lo, axis.ref_hi = axis.lo, axis.hi
    elif name == "turn":
        axis.v = v_next
    if name in ("rub", "move slowly") and int(io.friction):
        axis.v -= axis.v >> int(io.friction)


COMMANDS = (
    "seed", "shrink", "cut_high", "cut_low", "order", "unite", "move", "shorten", "reflect", "settle", "turn", "rub",
    "move slowly",
)  # fmt: skip


def packed(values: list[int], bits: int = SIDE_W) -> int:
    word = 0
    for value in values:
        word = word << bits | value % (1 << bits)
    return word


def show(io: Any, axis: Axis) -> None:
    """What is loaded of an axis."""
    io.r_sides, io.r_refs = packed([axis.lo, axis.hi]), packed([axis.ref_lo, axis.ref_hi])


def test_random_commands() -> None:
    sim, rng = load("motion_sides", {"X_W": X_W, "Y_W": Y_W, "SIDE_W": SIDE_W}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    seen = dict.fromkeys(COMMANDS, 0)
    axes: list[Axis] = []
    for _slot in range(150):
        highs = {"side_shrink": 9, "side_max": 300, "friction": 16, "coast_slow": 4, "seed_px": 256, "marks": 16}
        for name, high in highs.items():
            setattr(io, name, int(rng.integers(name == "side_max", high)))
        places = [int(rng.integers(1 << bits)) for _, _, bits in AXES]
        io.x, io.y = places
        before_load, axes = axes, []
        for _axis in AXES:
            lo = int(rng.integers(-600, 1_000)) * PX + int(rng.integers(PX))
            hi = lo + int(rng.integers(-2 * PX, 400 * PX >> int(rng.integers(8))))
            ref = [int(rng.integers(-(1 << 22), 1 << 22)) for _ in range(2)]
            axes.append(Axis(lo, hi, *ref, int(rng.integers(-32_767, 32_768))))
        for _ in range(int(rng.integers(2))):  # it may come at any time
            sim.clock.tick()
        show(io, axes[0])
        io.m_v = packed([axis.v for axis in reversed(axes)], 16)
        io.load, io.load_refs = 1, int(not before_load or rng.random() < 0.5)
        if not int(io.load_refs):
            for axis, was in zip(axes, before_load, strict=True):
                axis.ref_lo, axis.ref_hi = was.ref_lo, was.ref_hi
        sim.clock.tick()
        io.load = io.load_refs = 0
        assert int(io.lane) == 1
        show(io, axes[1])
        sim.clock.tick()
        io.r_sides = io.r_refs = 0
        name = ""
        for _command in range(12):
            for _clock in range(7):
                sim.clock.tick()
            assert int(io.lane) == 1
            before = [(axis.lo, axis.hi, axis.ref_lo, axis.ref_hi, axis.v) for axis in axes]
            name = "order" if name == "cut_low" else str(rng.choice(COMMANDS))
            if name != "order":
                io.cut_px, io.on_y = int(rng.integers(100)), int(rng.integers(2))
            v_next = [int(v) for v in rng.integers(-32_767, 32_768, 2)]
            for axis, (_, number, _) in zip(axes, AXES, strict=True):
                command(axis, name, io, number, places[number], v_next[number])
            seen[name] += before != [(axis.lo, axis.hi, axis.ref_lo, axis.ref_hi, axis.v) for axis in axes]
            ports = ("move", "rub") if name == "move slowly" else (name,)
            for port in ports:
                setattr(io, port, 1)
            io.v_next = v_next[0] % (1 << 16)
            sim.clock.tick()
            for port in ports:
                setattr(io, port, 0)
            io.v_next = v_next[1] % (1 << 16)
            for _clock in range(8):
                sim.clock.tick()
            assert int(io.o_sides) == packed([side for axis in axes for side in (axis.lo, axis.hi)]), name
            for _clock in range(2):
                axis = axes[int(io.f_y)]
                assert int(io.f_sides) == packed([axis.lo, axis.hi]), name
                assert int(io.f_refs) == packed([axis.ref_lo, axis.ref_hi]), name
                sim.clock.tick()
            assert int(io.o_v) == packed([axis.v for axis in reversed(axes)], 16), name
            for axis, (suffix, _, _) in zip(axes, AXES, strict=True):
                assert int(getattr(io, f"side_{suffix}")) == axis.side
                assert int(getattr(io, f"speed_{suffix}")) == abs(axis.v)
                assert signed(int(getattr(io, f"sum_{suffix}")), SIDE_W + 1) == axis.lo + axis.hi
                assert int(getattr(io, f"crossed_{suffix}")) == (axis.hi < axis.lo)
    assert min(seen.values()) > 20

# SPDX-License-Identifier: Apache-2.0
"""motion_match.v: whose an event is, among random boxes and windows."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.testing import lint

PX_W = 13

Bounds = tuple[int, int, int, int]


def packed(bounds: Bounds) -> int:
    word = 0
    for bound in bounds:
        word = word << PX_W | bound % (1 << PX_W)
    return word


def holds(bounds: Bounds, x: int, y: int) -> bool:
    return bounds[0] <= x <= bounds[1] and bounds[2] <= y <= bounds[3]


def owner(states: list[str], boxes: list[Bounds], windows: list[Bounds], x: int, y: int) -> tuple[int, bool, bool]:
    """The slot, or -1; whether the event is shared; whether a candidate begins."""
    slots = range(len(states))
    for kind, bounds in (("visible", boxes), ("visible", windows), ("candidate", windows)):
        found = [i for i in slots if states[i] == kind and holds(bounds[i], x, y)]
        if found:
            return found[0], kind == "visible" and len(found) > 1, False
    for kind in ("free", "left"):
        found = [i for i in slots if states[i] == kind]
        if found:
            return found[0], False, True
    return -1, False, True


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (5, 3), (64, 6)])
def test_random_events(n: int, slot_w: int) -> None:
    sim = load("motion_match", {"N": n, "PX_W": PX_W, "SLOT_W": slot_w})
    io, rng = sim.io, np.random.default_rng(n)
    boxes: list[Bounds] = [(0, 0, 0, 0)] * n
    windows = list(boxes)
    seen = set()
    for round_ in range(5_000 if n < 5 else 1_200):
        slot = round_ if round_ < n else int(rng.integers(n))
        x0, y0, ring = int(rng.integers(-6, 36)), int(rng.integers(-6, 20)), int(rng.integers(4))
        x1, y1 = x0 + int(rng.integers(30)), y0 + int(rng.integers(16))
        boxes[slot], windows[slot] = (x0, x1, y0, y1), (x0 - ring, x1 + ring, y0 - ring, y1 + ring)
        io.place, io.place_slot, io.box, io.window = 1, slot, packed(boxes[slot]), packed(windows[slot])
        sim.clock.tick()
        io.place = 0
        if round_ < n:
            continue
        share = rng.dirichlet([1, 1, 1, 1, 1]) if rng.random() < 0.9 else [0, 0, 0, 0, 1]
        states = [str(state) for state in rng.choice(["visible", "candidate", "free", "left", "off"], n, p=share)]
        ports = {"visible": ("visible",), "candidate": ("candidate",), "fresh": ("free",), "empty": ("free", "left")}
        for port, kinds in ports.items():
            setattr(io, port, sum(1 << i for i in range(n) if states[i] in kinds))
        x, y = int(rng.integers(32)), int(rng.integers(16))
        io.is_op = int(rng.random() < 0.1)
        io.op_slot = int(rng.integers(n))
        io.asked = 1
        io.lo_x = io.hi_x = x
        io.lo_y = io.hi_y = y
        for _clock in range(3):
            sim.clock.tick()
        expected, shared, begins = owner(states, boxes, windows, x, y)
        assert (bool(io.owned), bool(io.begins), bool(io.shared)) == (expected >= 0, begins, shared)
        if int(io.is_op):
            assert int(io.owner) == int(io.op_slot)
        elif expected >= 0:
            assert int(io.owner) == expected
        seen.add((expected >= 0, begins, shared))
    assert len(seen) == (3 if n == 1 else 4)


def test_intervals() -> None:
    """Whose box and window share a pixel with an interval, on each axis."""
    sim, rng = load("motion_match", {"N": 5, "PX_W": PX_W, "SLOT_W": 3}), np.random.default_rng(6)
    io = sim.io
    for round_ in range(600):
        slot = round_ % 5
        low = [int(side) for side in rng.integers(-60, 60, 2)]
        high = [side + int(rng.integers(40)) for side in low]
        io.place, io.place_slot = 1, slot
        io.box = packed((low[0], high[0], low[1], high[1]))
        io.window = packed((low[0] - 3, high[0] + 3, low[1] - 2, high[1] + 2))
        sim.clock.tick()
        io.place = 0
        io.asked = 1
        begins = [int(side) for side in rng.integers(-80, 80, 2)]
        ends = [side + int(rng.integers(30)) for side in begins]
        io.lo_x, io.lo_y = (side % (1 << PX_W) for side in begins)
        io.hi_x, io.hi_y = (side % (1 << PX_W) for side in ends)
        sim.clock.tick()
        for on_y, axis in enumerate("xy"):
            for name, ring in (("box", 0), ("window", 3 - on_y)):
                shares = begins[on_y] <= high[on_y] + ring and low[on_y] - ring <= ends[on_y]
                assert int(getattr(io, f"{name}_{axis}")) >> slot & 1 == shares


def test_lint() -> None:
    assert lint("motion_match") == (0, "")
    assert lint("motion_match", N=1, SLOT_W=1) == (0, "")

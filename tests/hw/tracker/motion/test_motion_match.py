# SPDX-License-Identifier: Apache-2.0
"""motion_match.v: whose an event is, among random boxes and windows."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.rtl.build import load
from support.testing import lint

PX_W = 13

Bounds = tuple[int, int, int, int]


def place(sim: PyVerilator, slot: int, box: Bounds, window: Bounds) -> None:
    """Bounds of a slot, one after the other."""
    io = sim.io
    for number, (lo_hi, bounds) in enumerate(((0, box), (1, box), (0, window), (1, window))):
        io.place, io.place_slot = 1 << number, slot
        io.bound_x, io.bound_y = (bounds[2 * axis + lo_hi] % (1 << PX_W) for axis in (0, 1))
        sim.clock.tick()
    io.place = 0


def holds(bounds: Bounds, x: int, y: int) -> bool:
    return bounds[0] <= x <= bounds[1] and bounds[2] <= y <= bounds[3]


def owner(states: list[str], boxes: list[Bounds], windows: list[Bounds], x: int, y: int) -> tuple[int, bool, bool]:
    """The slot, or -1; whether the event is shared; whether a candidate begins."""
    slots = range(len(states))
    for kind, bounds in (("visible", boxes), ("visible", windows), ("candidate", windows)):
        found = [i for i in slots if states[i] == kind and holds(bounds[i], x, y)]
        if found:
            return found[0], kind == "visible" and len(found) > 1, False
    free = [i for i in slots if states[i] == "free"]
    return (free[0], False, True) if free else (-1, False, True)


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (5, 3), (64, 6)])
def test_random_events(n: int, slot_w: int) -> None:
    sim = load("motion_match", {"N": n, "PX_W": PX_W, "SLOT_W": slot_w})
    io, rng = sim.io, np.random.default_rng(n)
    boxes: list[Bounds] = [(0, 0, 0, 0)] * n
    windows = list(boxes)
    seen = set()
    for round_ in range(1_200):
        slot = round_ if round_ < n else int(rng.integers(n))
        x0, y0, ring = int(rng.integers(-6, 36)), int(rng.integers(-6, 20)), int(rng.integers(4))
        x1, y1 = x0 + int(rng.integers(30)), y0 + int(rng.integers(16))
        boxes[slot], windows[slot] = (x0, x1, y0, y1), (x0 - ring, x1 + ring, y0 - ring, y1 + ring)
        io.hold = 0
        place(sim, slot, boxes[slot], windows[slot])
        if round_ < n:
            continue
        share = rng.dirichlet([1, 1, 1, 1]) if rng.random() < 0.9 else [0, 0, 0, 1]
        states = [str(state) for state in rng.choice(["visible", "candidate", "free", "off"], n, p=share)]
        for port, state in (("visible", "visible"), ("candidate", "candidate"), ("may_begin", "free")):
            setattr(io, port, sum(1 << i for i in range(n) if states[i] == state))
        x, y = int(rng.integers(32)), int(rng.integers(16))
        io.lo_x, io.hi_x, io.lo_y, io.hi_y = x, x, y, y
        for _clock in range(3):
            io.hold = 1
            for _held in range(int(rng.integers(2))):
                sim.clock.tick()
            io.hold = 0
            sim.clock.tick()
            x0, y0 = int(rng.integers(-30, 50)), int(rng.integers(-30, 50))  # what follows
            asked = (x0, x0 + int(rng.integers(20)), y0, y0 + int(rng.integers(20)))
            io.lo_x, io.hi_x, io.lo_y, io.hi_y = (bound % (1 << PX_W) for bound in asked)
        expected, shared, begins = owner(states, boxes, windows, x, y)
        assert (bool(io.owned), bool(io.begins), bool(io.shared)) == (expected >= 0, begins, shared)
        if expected >= 0:
            assert int(io.owner) == expected
        seen.add((expected >= 0, begins, shared))
        sim.clock.tick()  # intervals share pixels with bounds on each axis apart
        for name, bounds, axis in (
            ("box_x", boxes, 0),
            ("box_y", boxes, 2),
            ("window_x", windows, 0),
            ("window_y", windows, 2),
        ):
            shares = [its[axis] <= asked[axis + 1] and asked[axis] <= its[axis + 1] for its in bounds]
            assert int(getattr(io, name)) == sum(1 << i for i in range(n) if shares[i])
    assert len(seen) == (3 if n == 1 else 4)


def test_lint() -> None:
    assert lint("motion_match") == (0, "")
    assert lint("motion_match", N=1, SLOT_W=1) == (0, "")

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
    free = [i for i in slots if states[i] == "free"]
    return (free[0], False, True) if free else (-1, False, True)


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (5, 3), (64, 6)])
def test_random_events(n: int, slot_w: int) -> None:
    sim = load("motion_match", {"N": n, "X_W": 5, "Y_W": 4, "PX_W": PX_W, "SLOT_W": slot_w})
    io, rng = sim.io, np.random.default_rng(n)
    boxes: list[Bounds] = [(0, 0, 0, 0)] * n
    windows = list(boxes)
    seen = set()
    for round_ in range(1_200):
        slot = round_ if round_ < n else int(rng.integers(n))
        x0, y0, ring = int(rng.integers(-6, 36)), int(rng.integers(-6, 20)), int(rng.integers(4))
        x1, y1 = x0 + int(rng.integers(30)), y0 + int(rng.integers(16))
        boxes[slot], windows[slot] = (x0, x1, y0, y1), (x0 - ring, x1 + ring, y0 - ring, y1 + ring)
        io.place, io.place_slot, io.box, io.window = 1, slot, packed(boxes[slot]), packed(windows[slot])
        io.asked = 0
        sim.clock.tick()
        io.place = 0
        if round_ < n:
            continue
        share = rng.dirichlet([1, 1, 1, 1]) if rng.random() < 0.9 else [0, 0, 0, 1]
        states = [str(state) for state in rng.choice(["visible", "candidate", "free", "off"], n, p=share)]
        for port, state in (("visible", "visible"), ("candidate", "candidate"), ("may_begin", "free")):
            setattr(io, port, sum(1 << i for i in range(n) if states[i] == state))
        x, y = int(rng.integers(32)), int(rng.integers(16))
        io.x, io.y, io.asked = x, y, 1
        sim.clock.tick()
        io.x, io.asked = (x + 9) % 32, 0
        sim.clock.tick()
        expected, shared, begins = owner(states, boxes, windows, x, y)
        assert (bool(io.owned), bool(io.begins), bool(io.shared)) == (expected >= 0, begins, shared)
        if expected >= 0:
            assert int(io.owner) == expected
        seen.add((expected >= 0, begins, shared))
    assert len(seen) == (3 if n == 1 else 4)


def test_lint() -> None:
    assert lint("motion_match") == (0, "")
    assert lint("motion_match", N=1, SLOT_W=1) == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""motion_match.v: whose an event is, among random boxes and windows."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import load

PX_W, X_W, Y_W = 13, 5, 4

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


class Match:
    """The module, and the box and the window of each slot that are in effect."""

    def __init__(self, n: int, slot_w: int) -> None:
        widths = {"N": n, "X_W": X_W, "Y_W": Y_W, "PX_W": PX_W, "SLOT_W": slot_w}
        self.sim = load("motion_match", widths)
        self.io = self.sim.io
        self.boxes: list[Bounds] = [(0, -1, 0, -1)] * n
        self.windows = list(self.boxes)
        self.io.rst = self.io.asked = 1
        self.sim.clock.tick()
        self.io.rst = 0
        while not int(self.io.ready):
            self.sim.clock.tick()

    def update(self, slot: int, box: Bounds, window: Bounds) -> None:
        io = self.io
        io.update_slot = slot
        self.sim.clock.tick()
        io.update, io.box = 1, packed(box)
        for clock in range(200):
            self.sim.clock.tick()
            io.update = io.update_slot = 0
            if clock == 1:
                io.window = packed(window)
            if not int(io.busy):
                break
        assert not int(io.busy)
        self.sim.clock.tick()  # in which the last word is written

    def place(self, slot: int, box: Bounds, window: Bounds) -> None:
        self.io.place, self.io.place_slot = 1, slot
        self.sim.clock.tick()
        self.io.place = 0
        self.boxes[slot], self.windows[slot] = box, window


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (5, 3), (64, 6)])
def test_random_events(n: int, slot_w: int) -> None:
    match, rng = Match(n, slot_w), np.random.default_rng(n)
    sim, io = match.sim, match.io
    seen = set()
    for round_ in range(2_000 if n < 5 else 1_200):
        slot = round_ if round_ < n else int(rng.integers(n))
        x0, y0, ring = int(rng.integers(-6, 36)), int(rng.integers(-6, 20)), int(rng.integers(4))
        x1, y1 = x0 + int(rng.integers(30)), y0 + int(rng.integers(16))
        box, window = (x0, x1, y0, y1), (x0 - ring, x1 + ring, y0 - ring, y1 + ring)
        match.update(slot, box, window)
        if round_ < n or rng.random() < 0.8:  # else only the next update takes effect
            match.place(slot, box, window)
        if round_ < n:
            continue
        share = rng.dirichlet([1, 1, 1, 1, 1]) if rng.random() < 0.9 else [0, 0, 0, 0, 1]
        states = [str(state) for state in rng.choice(["visible", "candidate", "free", "left", "off"], n, p=share)]
        ports = {"visible": ("visible",), "candidate": ("candidate",), "fresh": ("free",), "empty": ("free", "left")}
        for port, kinds in ports.items():
            setattr(io, port, sum(1 << i for i in range(n) if states[i] in kinds))
        x, y = int(rng.integers(1 << X_W)), int(rng.integers(1 << Y_W))
        io.is_op = int(rng.random() < 0.1)
        io.op_slot = int(rng.integers(n))
        io.x, io.y = x, y
        for _clock in range(4):
            sim.clock.tick()
            io.x = io.y = 0
        expected, shared, begins = owner(states, match.boxes, match.windows, x, y)
        assert (bool(io.owned), bool(io.begins), bool(io.shared)) == (expected >= 0, begins, shared)
        if int(io.is_op):
            assert int(io.owner) == int(io.op_slot)
        elif expected >= 0:
            assert int(io.owner) == expected
        seen.add((expected >= 0, begins, shared))
    assert len(seen) == (3 if n == 1 else 4)


def test_box_and_window_take_effect_with_the_event_of_the_clock_before_place() -> None:
    match = Match(2, 1)
    io, sim = match.io, match.sim
    io.visible, old, new = 1, (2, 4, 2, 4), (20, 24, 8, 9)
    match.update(0, old, old)
    match.place(0, old, old)
    match.update(0, new, new)
    for _clock in range(2):
        sim.clock.tick()
    # Events in successive clocks, at both boxes in turn; `place` is given in the clock of the fifth one.
    places, found = [(3, 3), (22, 9)] * 5, []
    for clock in range(len(places) + 4):
        io.x, io.y = places[min(clock, len(places) - 1)]
        io.place, io.place_slot = int(clock == 4), 0
        sim.clock.tick()
        found.append(bool(io.owned))
    assert found[3 : 3 + len(places)] == [i % 2 == (i >= 3) for i in range(len(places))]


def test_an_event_at_the_word_that_is_written_next_collides() -> None:
    match = Match(2, 1)
    io, sim = match.io, match.sim
    for ports in ("x", "y"), ("next_x", "next_y"):
        for at, (low, high) in zip(ports, ((8, 11), (4, 6)), strict=True):
            match.update(1, (0, 1, 0, 1), (0, 1, 0, 1))
            io.x = io.next_x = 31
            io.y = io.next_y = 15
            io[at] = high
            io.update_slot = 1
            sim.clock.tick()
            io.update, io.box, io.window = 1, packed((8, 11, 4, 6)), packed((8, 11, 4, 6))
            found = 0
            for _clock in range(40):
                sim.clock.tick()
                io.update = 0
                found += int(io.collides)
            assert found == 2  # once for the box, once for the window
            io[at] = low - 1
            sim.eval()
            assert not int(io.collides)

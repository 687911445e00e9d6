# SPDX-License-Identifier: Apache-2.0
"""array_match.v: whose an event is, and which windows overlap, while windows come, move and go."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load

N, SIDE = 6, 32  # slots; addresses on an axis
Window = tuple[int, int, int, int]  # lo_x, hi_x, lo_y, hi_y


@dataclass(frozen=True)
class Slot:
    """What the hardware is to know of a slot."""

    window: Window = (0, 0, 0, 0)
    candidate: bool = False
    active: bool = False
    free: bool = False


def meet(one: Window, other: Window) -> bool:
    """Whether two windows share a pixel."""
    columns = set(range(one[0], one[1] + 1)) & set(range(other[0], other[1] + 1))
    rows = set(range(one[2], one[3] + 1)) & set(range(other[2], other[3] + 1))
    return bool(columns and rows)


def lowest(slots: list[int]) -> int | None:
    return min(slots, default=None)


def started(far: int) -> PyVerilator:
    sim = load("array_match", {"N": N, "FAR": far, "X_W": 5, "Y_W": 5, "SLOT_W": 3})
    sim.io.m_valid = sim.io.w_places = sim.io.w_changes = 0
    reset(sim)
    return sim


def random_window(rng: np.random.Generator) -> Window:
    x, y = rng.integers(0, SIDE, 2)
    width, height = rng.integers(0, 12, 2)
    return int(x), int(min(x + width, SIDE - 1)), int(y), int(min(y + height, SIDE - 1))


def bounds(window: Window) -> Window:
    """As the ports take them: the lower ones as complements."""
    return SIDE - 1 - window[0], window[1], SIDE - 1 - window[2], window[3]


def put(sim: PyVerilator, number: int, slot: Slot, places: bool, changes: bool) -> None:
    io = sim.io
    io.w_places, io.w_changes, io.w_slot = places, changes, number
    io.w_lo_x_not, io.w_hi_x, io.w_lo_y_not, io.w_hi_y = bounds(slot.window)
    io.w_free, io.w_window, io.w_active = slot.free, slot.candidate or slot.active, slot.active


@pytest.mark.parametrize("far", [0, 1])
def test_random_probes_while_windows_change(far: int) -> None:
    sim = started(far)
    rng, io = np.random.default_rng(8), sim.io
    coming = deque[tuple[tuple[bool, bool, bool], int | None]]()  # whose the probes under way are
    slots, seen = [Slot()] * N, dict.fromkeys(("active", "candidate", "free", "nobody", "overlap", "alone"), 0)
    for clock in range(2_500):
        # A window anywhere, but no two active ones share a pixel.
        number = int(rng.integers(N))
        state = int(rng.integers(5))
        new = Slot(random_window(rng), candidate=state == 0, active=state in (1, 2), free=state == 3)
        moves = bool(rng.random() < 0.3)  # keeps its state
        if moves:
            new = replace(slots[number], window=new.window)
        clash = new.active and any(i != number and s.active and meet(s.window, new.window) for i, s in enumerate(slots))
        writes = not clash and rng.random() < 0.25
        put(sim, number, new, places=writes, changes=writes and not moves)

        check, names, valid = rng.random() < 0.3, rng.random() < 0.2, rng.random() < 0.9
        x, y = (int(at) for at in rng.integers(0, SIDE, 2))
        probe = random_window(rng) if check else (x, x, y, y)
        myself, named = int(rng.integers(N)), int(rng.integers(N))
        io.m_valid, io.m_check, io.m_self, io.names, io.slot = valid, check, myself, names, named
        io.m_lo_x_not, io.m_hi_x, io.m_lo_y_not, io.m_hi_y = bounds(probe)

        hits = [i for i, slot in enumerate(slots) if valid and meet(slot.window, probe)]
        owner = None if check else lowest([i for i in hits if slots[i].active])
        other = lowest([i for i in hits if (slots[i].active and i != myself if check else slots[i].candidate)])
        free = lowest([i for i, slot in enumerate(slots) if slot.free])
        spare = named if names else free
        sim.clock.tick()
        if writes:
            slots[number] = new

        first = next((slot for slot in (owner, other, spare) if slot is not None), None)
        coming.append(((owner is not None, other is not None, free is not None), first))
        if len(coming) > far:
            held, whose = coming.popleft()
            assert (io.d_active, io.d_other, io.d_free) == held, clock
            if whose is not None:
                assert io.d_slot == whose, clock
        assert io.e_other == (other is not None), clock
        if other is not None:
            assert io.e_lowest == other, clock
        assert io.active == sum(slot.active << i for i, slot in enumerate(slots)), clock
        if valid and check:
            seen["alone" if other is None else "overlap"] += 1
        elif valid:
            holder = "active" if owner is not None else "candidate" if other is not None else "free"
            seen["nobody" if first is None else holder] += 1
    print(seen)
    assert min(seen.values()) > 30


@pytest.mark.parametrize("far", [0, 1])
def test_reset_leaves_no_window(far: int) -> None:
    sim = started(far)
    put(sim, 2, Slot((0, SIDE - 1, 0, SIDE - 1), active=True), places=True, changes=True)
    sim.clock.tick()
    put(sim, 3, Slot(free=True), places=False, changes=True)
    sim.clock.tick()
    io = sim.io
    io.w_places = io.w_changes = 0
    io.m_valid = 1
    for _ in range(1 + far):
        sim.clock.tick()
    assert (io.d_active, io.d_slot, io.d_free) == (1, 2, 1)
    reset(sim)
    for _ in range(1 + far):
        sim.clock.tick()
    assert (io.d_active, io.d_other, io.d_free, io.active) == (0, 0, 0, 0)

# SPDX-License-Identifier: Apache-2.0
"""motion_waiting.v: slots are worked on, and put in force, in the order in which they came, before the 64th event behind."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.testing import lint

AFTER, SLOTS = 64, 4


def test_random_events() -> None:
    """Events come and complete corrections; an event whose turn it is waits for what must be in force before it."""
    sim, rng = load("motion_waiting", {"SLOT_W": 2}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    issued, came, busy = 0, 0, 0
    jobs: list[tuple[int, int, int]] = []  # slot, whether it seeds, number of the event
    puts: list[tuple[int, int, int]] = []
    put_at, waited, done, had_puts, new = -9, 0, 0, False, 0  # new: a slot that came in the clock before
    for clock in range(20_000):
        io.following = (issued + 1) % 256
        io.issued, io.issues, io.job_done, io.put_done, io.s_valid = issued % 256, 0, 0, 0, 0
        waits = [number for _, _, number in jobs + puts]
        late = any(number + AFTER < issued for number in waits)
        assert not late
        assert int(io.job_valid) == bool(jobs[: len(jobs) - new])
        assert int(io.put_valid) == had_puts
        had_puts = bool(puts)
        if int(io.job_valid):
            slot, seeds, number = jobs[0]
            assert (int(io.job_slot), int(io.job_seed)) == (slot, seeds)
            busy += 1
            assert busy < 3 or int(io.job_seq) == number
            if busy > 40:
                io.job_done, busy = 1, 0
                puts.append(jobs.pop(0))
        elif int(io.put_valid) and int(io.reached) and clock > put_at + 6:
            assert (int(io.put_slot), int(io.put_seed)) == puts[0][:2]
            assert puts[0][2] + AFTER == issued
            io.put_done, put_at = 1, clock
            done += 1
            puts.pop(0)
        busy_slots = {slot for slot, _, _ in jobs + puts}
        blocked = int(io.reached) or clock <= put_at + 1
        waited += int(io.reached)
        if not blocked and rng.random() < 0.8:
            io.issues = 1
            issued += 1
        free, new = [slot for slot in range(SLOTS) if slot not in busy_slots], 0
        if came < issued - 6 and free:  # a correction is seen some clocks behind its event
            if rng.random() < 0.03:
                io.s_valid, io.s_slot, io.s_seed, io.s_seq = 1, free[0], int(rng.integers(2)), came
                jobs.append((free[0], int(io.s_seed), came))
                new = 1
            came += 1
        sim.clock.tick()
    assert done > 100
    assert waited > 100


def test_lint() -> None:
    assert lint("motion_waiting") == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""motion_queue.v: tokens in order, with their times, issued again from the oldest one on."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.testing import lint


def test_random_tokens_issued_again() -> None:
    sim, rng = load("motion_queue", {"X_W": 5, "Y_W": 4, "TICK_W": 3, "TIME_W": 20}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    kept: list[tuple[int, int, int, int, int, int]] = []  # accepted, not done: time, event, skip, x, y, p
    indices: list[int] = []  # of those that were issued
    now = done = full = repeats = 0
    for _clock in range(20_000):
        busy = (_clock // 200) % 3
        io.s_valid = int(rng.random() < (0.9, 0.5, 0.1)[busy])
        token = [int(rng.integers(limit)) for limit in (8, 2, 2, 32, 16, 2)]
        io.s_tick, io.s_event, io.s_skip, io.s_x, io.s_y, io.s_p = token
        io.m_ready = int(rng.random() < (0.3, 0.7, 0.9)[busy])
        again = rng.random() < 0.03
        leaves = bool(indices) and rng.random() < 0.4 and not again
        io.done, io.again = int(leaves), int(again)
        if again:
            io.m_ready = 0
        if indices:
            which = int(rng.integers(len(indices)))
            io.index = indices[which]
            found = (io.event_time, io.is_event, io.is_skip, io.x, io.y, io.p)
            assert tuple(int(value) for value in found) == kept[which]
        accepts = int(io.s_valid) and int(io.s_ready)
        issues = int(io.m_valid) and int(io.m_ready)
        if int(io.m_valid):
            assert (int(io.m_x), int(io.m_y)) == kept[len(indices)][3:5]
        full += int(io.s_valid) and not int(io.s_ready)
        index = int(io.m_index)
        sim.clock.tick()
        if issues and not again:
            indices.append(index)
        if accepts:
            now = (now + token[0]) % (1 << 20)
            kept.append((now, token[1], token[2], token[3], token[4], token[5]))
        if leaves:
            kept.pop(0)
            indices.pop(0)
            done += 1
        if again:
            repeats += len(indices)
            indices.clear()
        assert not int(io.empty) or not kept
        assert len(kept) <= 16
    assert done > 3_000
    assert full > 1_000
    assert repeats > 100


def test_lint() -> None:
    assert lint("motion_queue") == (0, "")

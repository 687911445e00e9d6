# SPDX-License-Identifier: Apache-2.0
"""motion_birth.v: what a candidate needs to become visible."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import PX

SIDE_W = 25


def test_random_candidates() -> None:
    sim, rng = load("motion_birth", {"SIDE_W": SIDE_W, "SUP_W": 12, "TIME_W": 40}), np.random.default_rng(1)
    io, seen = sim.io, {True: 0, False: 0}
    lacks = {"support": 0, "size": 0, "time": 0, "way": 0, "young": 0}
    for _ in range(800):
        sides = [int(side) >> int(rng.integers(6)) for side in rng.integers(64 * PX, size=2)]
        sums, starts = [], []
        for _axis in range(2):
            sums.append(int(rng.integers(-(1 << 24), 1 << 24)))
            starts.append(sums[-1] + (int(rng.integers(-64 * PX, 64 * PX)) >> int(rng.integers(4))))
        support, age, young = int(rng.integers(1 << 12)), int(rng.integers(1 << 25)), int(rng.random() < 0.1)
        io.birth_support, io.birth_px = int(rng.integers(1, 2_000)), int(rng.integers(256)) >> 5
        io.birth_ticks, io.birth_travel = int(rng.integers(1 << 23)), int(rng.integers(9))
        io.side_x, io.side_y = sides
        io.shorter = min(sides) >> 12
        io.support, io.age, io.young = support, age, young
        wrong = {
            "support": support < int(io.birth_support),
            "size": min(sides) >> 12 < int(io.birth_px),
            "time": age < int(io.birth_ticks),
            "way": max(abs(end - begin) for end, begin in zip(sums, starts, strict=True))
            < (sum(sides) >> int(io.birth_travel) + 1) + 2 * PX,
            "young": bool(young),
        }
        for clock in range(9 + int(io.birth_travel)):
            io.measure = clock == 1
            io.sum = sums[clock % 2] % (1 << SIDE_W + 1)
            io.start = starts[clock % 2] % (1 << SIDE_W + 1)
            sim.clock.tick()
        assert int(io.appears) == (not any(wrong.values()))
        seen[bool(int(io.appears))] += 1
        if sum(wrong.values()) == 1:
            lacks[next(name for name, is_wrong in wrong.items() if is_wrong)] += 1
    assert min(seen.values()) > 100
    assert min(lacks.values()) > 5

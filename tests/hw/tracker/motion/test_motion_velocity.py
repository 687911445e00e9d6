# SPDX-License-Identifier: Apache-2.0
"""motion_velocity.v: the correction of a velocity, whatever the time and the offsets."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import Axis, divided

OFF_W = 26


def signed(value: int, bits: int) -> int:
    return value - (value >> (bits - 1) << bits)


def test_random_corrections() -> None:
    """Both axes go through one after the other; each has its own offsets, velocity and corrections in one direction."""
    sim, rng = load("motion_velocity", {"OFF_W": OFF_W}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    limited = 0
    runs: set[tuple[int, int]] = set()
    for round_ in range(2_000):
        ticks = max(1, int(rng.integers(1 << 24)) >> int(rng.integers(25)))
        slower, gain, step_log2 = int(rng.integers(2)), int(rng.integers(1, 14)), int(rng.integers(21))
        room = int(rng.integers(gain + 1))
        if round_ < 4:  # the ends
            room = 0
            ticks, gain, step_log2 = ((1, 1, 20), (2**24 - 1, 13, 0), (1, 1, 20), (2**24 - 1, 1, 20))[round_]
        most = int(rng.integers(32_768)) >> int(rng.integers(16))
        exponent = ticks.bit_length() - 1
        leading, inverse = exponent, round(1024 / (8.5 + (ticks * 8 >> exponent) - 8))
        io.slower, io.gain, io.room, io.step_log2, io.speed_max = slower, gain, room, step_log2, most
        offsets, velocities, before, expected, found, expected_runs = [], [], [], [], [], []
        for _axis in range(2):
            offs = [int(off) >> int(rng.integers(26)) for off in rng.integers(-(1 << 24), 1 << 24, 2)]
            if rng.random() < 0.3:
                offs = [offs[0], int(rng.choice([offs[0], -offs[0], 0]))]
            if round_ < 4:
                offs = [-(1 << 24), -(1 << 24)] if round_ < 2 else [1, 0] if round_ < 3 else [-1, 0]
            v = int(rng.integers(-most, most + 1))
            run, way = int(rng.integers(-7, 8)), Axis(0, 0, off=offs).common(bool(slower))
            axis = Axis(0, 0, ways=[run] * abs(run))
            axis.go(way)
            agree = min(len(axis.ways), 7)
            before.append(run)
            expected_runs.append(agree if way > 0 else -agree)
            runs.add((run, expected_runs[-1]))
            change = divided(way, step_log2 - 1 - (gain - min(max(agree - 2, 0), room)), ticks)
            offsets.append(offs)
            velocities.append(v)
            expected.append(max(-most, min(most, v + change)))
        for clock in range(16):
            # The leading bit may still be looked for when it begins.
            io.leading, io.inverse = (leading, inverse) if clock >= 2 else (int(rng.integers(24)), int(rng.integers(128)))
            io.run_x, io.run_y = (run % 16 for run in before) if clock in (2, 3) else (5, 5)
            io.start = clock == 0
            io.low, io.high = (off % (1 << OFF_W) for off in offsets[clock]) if clock < 2 else (0, 0)
            io.v = velocities[clock - 10] % (1 << 16) if clock in (10, 11) else 0
            assert int(io.ran) == (clock == 3)
            if clock in (3, 4):
                assert signed(int(io.run_next), 4) == expected_runs[clock - 3]
            if clock >= 14:
                assert int(io.turn) == (clock == 14)
                found.append(signed(int(io.v_next), 16))
            sim.clock.tick()
        assert found == expected
        limited += sum(abs(v) == most for v in expected)
    assert 200 < limited < 3_800
    assert len(runs) > 40  # of 45: after each of 15 runs one goes up, down, or nowhere

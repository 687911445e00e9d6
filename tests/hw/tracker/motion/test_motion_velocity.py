# SPDX-License-Identifier: Apache-2.0
"""motion_velocity.v: the correction of a velocity, whatever the time and the offsets."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import Axis, divided
from support.testing import lint

OFF_W = 30


def signed(value: int, bits: int) -> int:
    return value - (value >> (bits - 1) << bits)


def test_random_corrections() -> None:
    sim, rng = load("motion_velocity", {"OFF_W": OFF_W}), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    limited = clocks_most = 0
    for round_ in range(1_200):
        ticks = max(1, int(rng.integers(1 << 24)) >> int(rng.integers(25)))
        offs = [int(off) >> int(rng.integers(30)) for off in rng.integers(-(1 << 28), 1 << 28, 4)]
        if rng.random() < 0.3:
            offs = [offs[0], offs[0] if rng.random() < 0.5 else -offs[0], offs[2], 0]
        slower, gain, step_log2 = int(rng.integers(2)), int(rng.integers(1, 14)), int(rng.integers(21))
        if round_ < 4:  # the ends
            ticks, gain, step_log2 = ((1, 1, 20), (2**24 - 1, 13, 0), (1, 1, 20), (2**24 - 1, 1, 20))[round_]
            offs = [-(1 << 28), -(1 << 28), (1 << 28) - 1, (1 << 28) - 1] if round_ < 2 else [1, 0, -1, 0]
        most = int(rng.integers(32_768)) >> int(rng.integers(16))
        velocities = [int(rng.integers(-most, most + 1)) for _ in range(2)]
        io.ticks, io.slower, io.gain, io.step_log2, io.speed_max = ticks, slower, gain, step_log2, most
        io.off_lo_x, io.off_hi_x, io.off_lo_y, io.off_hi_y = (off % (1 << OFF_W) for off in offs)
        io.v_x, io.v_y = (v % (1 << 16) for v in velocities)
        io.start = 1
        sim.clock.tick()
        io.start, clocks = 0, 1
        while not int(io.done):
            sim.clock.tick()
            clocks += 1
        found = [signed(int(io.v_x_next), 16), signed(int(io.v_y_next), 16)]
        expected = []
        for v, pair in zip(velocities, (offs[:2], offs[2:]), strict=True):
            change = divided(Axis(0, 0, off=pair).common(bool(slower)), step_log2 - 1 - gain, ticks)
            expected.append(max(-most, min(most, v + change)))
        assert found == expected
        limited += abs(expected[0]) == most
        clocks_most = max(clocks_most, clocks)
    assert 100 < limited < 1_100
    assert clocks_most <= 56


def test_lint() -> None:
    assert lint("motion_velocity") == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""motion_inverse.v: leading bit and inverse of every kind of number."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import load


def test_numbers_of_every_length() -> None:
    sim, rng = load("motion_inverse"), np.random.default_rng(1)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    numbers = [*range(1, 70), *((1 << k) - 1 for k in range(7, 25)), *(1 << k for k in range(7, 24))]
    numbers += [int(rng.integers(1, 1 << 24)) >> int(rng.integers(17)) or 1 for _ in range(400)]
    took: dict[bool, set[int]] = {False: set(), True: set()}
    for number, beyond in [(number, False) for number in numbers] + [(number, True) for number in numbers]:
        io.number, io.start = number, 1
        assert int(io.goes_on)
        sim.clock.tick()
        io.start, io.number, io.beyond, clocks = 0, 0, int(beyond), 1
        number = (1 << 24) - 1 if beyond else number
        while int(io.goes_on):
            sim.clock.tick()
            io.beyond = 0
            clocks += 1
        for _ in range(4):
            sim.clock.tick()
            io.beyond = 0
        exponent = number.bit_length() - 1
        assert int(io.leading) == exponent
        assert int(io.inverse) == round(1024 / (8.5 + (number * 8 >> exponent) - 8))
        took[beyond].add(clocks)
    assert took == {False: set(range(1, 8)), True: {1, 2}}

# SPDX-License-Identifier: Apache-2.0
"""noise_mean.v: the mean goes a part of the way to each value, rounded down."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load


@pytest.mark.parametrize("w", [4, 26])
def test_a_mean_goes_a_part_of_the_way_to_each_value(w: int) -> None:
    sim, rng = load("noise_mean", {"W": w}), np.random.default_rng(61)
    io, mean = sim.io, 0
    reset(sim)
    for value, halvings in zip(rng.integers(1 << w - 1, size=300).tolist(), rng.integers(5, size=300).tolist(), strict=True):
        for bit in range(w):
            io.subtracts, io.value = 1, value >> bit & 1
            sim.clock.tick()
        io.subtracts, io.value = 0, int(rng.integers(2))
        for name, clocks in (("halves", halvings), ("", 1), ("adds", w)):
            for _ in range(clocks):
                if name:
                    io[name] = 1
                sim.clock.tick()
            if name:
                io[name] = 0
        mean += (value - mean) >> halvings
        assert int(io.mean) == mean
        sim.clock.tick()
    reset(sim)
    assert int(io.mean) == 0

# SPDX-License-Identifier: Apache-2.0
"""array_shift.v: an arithmetic right shift with the bit below it, but for its last place."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint


@pytest.mark.parametrize(("w", "copy"), [(14, 0), (5, 1), (25, 1), (2, 0)])
def test_every_k(w: int, copy: int) -> None:
    sim = load("array_shift", {"W": w, "COPY": copy})
    io, rng = sim.io, np.random.default_rng(w)
    ones = (1 << w) - 1
    reset(sim)
    for k in rng.permutation(9).tolist():
        io.k, io.load = k, 1
        sim.clock.tick()
        io.k, io.load = 8 - k, 0  # nobody looks
        sim.clock.tick()
        assert io.odd == k % 2
        extremes = [(value, 0, 0) for value in (1 << w - 1, (1 << w - 1) - 1, 0, ones)]
        for a, b, c in [*rng.integers(0, 1 << w, (40, 3)).tolist(), *extremes]:
            io.a_not, io.b_not, io.c = a ^ ones, b ^ ones, c
            value = a | b | c
            signed = value - (value >> w - 1 << w)
            assert io.evenly == ((signed << 1) >> k - k % 2) % (2 << w), (k, signed)


@pytest.mark.parametrize(("w", "copy"), [(2, 0), (14, 1), (25, 0)])
def test_lints_clean(w: int, copy: int) -> None:
    assert lint("array_shift", W=w, COPY=copy) == (0, "")

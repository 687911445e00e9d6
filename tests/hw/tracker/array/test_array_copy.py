# SPDX-License-Identifier: Apache-2.0
"""array_copy.v: a register, kept apart from others of the same value."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.testing import lint


def test_a_value_comes_a_clock_later() -> None:
    sim = load("array_copy", {"W": 6})
    for value in np.random.default_rng(1).integers(0, 64, 20).tolist():
        before = sim.io.m
        sim.io.s = value
        assert sim.io.m == before
        sim.clock.tick()
        assert sim.io.m == value


@pytest.mark.parametrize("width", [1, 6])
def test_lints_clean(width: int) -> None:
    assert lint("array_copy", W=width) == (0, "")

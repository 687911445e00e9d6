# SPDX-License-Identifier: Apache-2.0
"""clock_us.v: microseconds since reset, which wrap, and stand still while the clock frequency is not configured."""

from __future__ import annotations

import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint


@pytest.mark.parametrize("w", [1, 40])
def test_lints_clean(w: int) -> None:
    assert lint("clock_us", PRESCALE_W=w, T_W=w) == (0, "")


@pytest.mark.parametrize("parameter", ["T_W", "PRESCALE_W"])
def test_refuses_zero(parameter: str) -> None:
    code, log = lint("clock_us", **{parameter: 0})
    assert code != 0
    assert "W_must_be_at_least_1" in log


def test_microseconds() -> None:
    sim = load("clock_us", {"T_W": 5, "PRESCALE_W": 3})
    for clocks_per_us in (3, 1, 7):
        sim.io.clocks_per_us = clocks_per_us
        reset(sim)
        for clock in range(40 * clocks_per_us):
            assert sim.io.t_us == clock // clocks_per_us % 32
            sim.clock.tick()
    assert sim.io.t_us == 40 % 32
    sim.io.clocks_per_us = 0
    for _ in range(20):
        sim.clock.tick()
        assert sim.io.t_us == 40 % 32

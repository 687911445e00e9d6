# SPDX-License-Identifier: Apache-2.0
"""prescaler.v: a pulse every period, also where the period changes."""

from __future__ import annotations

import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint


def pulses(sim: PyVerilator, clocks: int) -> list[int]:
    """The clocks, counted from now, at which there is a pulse."""
    seen = []
    for clock in range(clocks):
        if sim.io.pulse:
            seen.append(clock)
        sim.clock.tick()
    return seen


@pytest.mark.parametrize("w", [1, 16, 40])
def test_lints_clean(w: int) -> None:
    assert lint("prescaler", W=w) == (0, "")


def test_refuses_zero() -> None:
    code, log = lint("prescaler", W=0)
    assert code != 0
    assert "W_must_be_at_least_1" in log


@pytest.mark.parametrize("period", [1, 2, 7, 15])
def test_a_pulse_every_period(period: int) -> None:
    sim = load("prescaler", {"W": 4})
    sim.io.period = period
    reset(sim)
    assert pulses(sim, 100) == list(range(period - 1, 100, period))
    reset(sim)
    assert pulses(sim, 100) == list(range(period - 1, 100, period))


def test_a_new_period_counts_from_the_last_pulse() -> None:
    sim = load("prescaler", {"W": 4})
    sim.io.period = 12
    reset(sim)
    assert pulses(sim, 9) == []
    sim.io.period = 10
    assert pulses(sim, 8) == [1]
    sim.io.period = 3
    assert pulses(sim, 7) == [1, 4]
    sim.io.period = 0
    assert pulses(sim, 40) == [0]
    sim.io.period = 5
    assert pulses(sim, 10) == [4, 9]

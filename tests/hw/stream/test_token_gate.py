# SPDX-License-Identifier: Apache-2.0
"""The gate: closes between two tokens, never withdraws one, opens when register writes have taken effect."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load


@pytest.fixture
def sim() -> PyVerilator:
    sim = load("token_gate", {"SEQ_W": 48})
    reset(sim)
    sim.io.idle = 1
    sim.clock.tick()
    return sim


def clocks_until_open(sim: PyVerilator, most: int = 20) -> int:
    for clock in range(most):
        if sim.io.open:
            return clock
        sim.clock.tick()
    return most


def test_is_closed_after_reset_and_opens_when_enabled(sim: PyVerilator) -> None:
    assert clocks_until_open(sim) == 20
    sim.io.enable = 1
    assert clocks_until_open(sim) == 1
    sim.io.enable = 0
    sim.clock.tick()
    assert sim.io.open == 0


def test_opens_after_reset_only_when_all_behind_it_has_been_idle_once() -> None:
    sim = load("token_gate")
    reset(sim)
    sim.io.enable = 1
    assert (clocks_until_open(sim), sim.io.cleared) == (20, 0)
    sim.io.idle = 1
    assert clocks_until_open(sim) == 2
    sim.io.idle = 0
    sim.clock.tick()
    assert (sim.io.open, sim.io.cleared) == (1, 1)
    reset(sim)
    assert (sim.io.open, sim.io.cleared) == (0, 0)


def test_a_closed_gate_lets_nothing_through_either_way(sim: PyVerilator) -> None:
    sim.io.s_valid = sim.io.m_ready = 1
    assert (sim.io.m_valid, sim.io.s_ready) == (0, 0)
    sim.io.enable = 1
    sim.clock.tick()
    assert (sim.io.m_valid, sim.io.s_ready) == (1, 1)


def test_a_token_on_offer_is_not_taken_back(sim: PyVerilator) -> None:
    sim.io.enable = sim.io.s_valid = 1
    sim.clock.tick()
    sim.io.busy = 1
    for _ in range(5):
        sim.clock.tick()
        assert (sim.io.m_valid, sim.io.apply) == (1, 0)
    sim.io.m_ready = 1
    sim.clock.tick()
    assert (sim.io.m_valid, sim.io.open, sim.io.apply) == (0, 0, 1)


def test_registers_may_be_written_when_closed_and_idle(sim: PyVerilator) -> None:
    sim.io.enable = sim.io.busy = 1
    sim.io.idle = 0
    for _ in range(3):
        sim.clock.tick()
        assert sim.io.apply == 0
    sim.io.idle = 1
    assert sim.io.apply == 1


def test_opens_when_the_consequences_of_a_write_are_over(sim: PyVerilator) -> None:
    sim.io.enable = sim.io.busy = 1
    sim.clock.tick()
    sim.io.busy = 0
    assert clocks_until_open(sim) == 4
    sim.io.busy = 1
    sim.clock.tick()
    sim.io.busy = sim.io.idle = 0  # a life ends, say
    assert clocks_until_open(sim) == 20
    sim.io.idle = 1
    assert clocks_until_open(sim) == 2


def test_numbers_the_events_that_went_through(sim: PyVerilator) -> None:
    rng = np.random.default_rng(2)
    sim.io.enable = 1
    through = 0
    for _ in range(400):
        sim.io.s_valid, sim.io.s_counts, sim.io.m_ready = (int(bit) for bit in rng.integers(0, 2, 3))
        sim.io.busy = int(rng.random() < 0.1)
        assert sim.io.seq == through
        through += int(sim.io.m_valid and sim.io.m_ready and sim.io.s_counts)
        sim.clock.tick()
    assert through > 20

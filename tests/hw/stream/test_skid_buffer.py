# SPDX-License-Identifier: Apache-2.0
"""skid_buffer.v: everything registered, full throughput, nothing lost, repeated or reordered."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, always, lint, run_streams


@pytest.fixture
def sim() -> PyVerilator:
    sim = load("skid_buffer", {"W": 8})
    reset(sim)
    return sim


@pytest.mark.parametrize("w", [1, 8, 200])
def test_lints_clean(w: int) -> None:
    assert lint("skid_buffer", W=w) == (0, "")


def test_refuses_a_word_without_bits() -> None:
    code, log = lint("skid_buffer", W=0)
    assert code != 0
    assert "W_must_be_at_least_1" in log


def test_reset_empties_it(sim: PyVerilator) -> None:
    sim.clock.tick()
    sim.io.s_valid, sim.io.s_data = 1, 7
    sim.clock.tick()
    sim.clock.tick()
    assert (sim.io.m_valid, sim.io.s_ready) == (1, 0)  # one word on offer, one aside
    sim.io.s_valid = 0
    reset(sim, clocks=1)
    assert (sim.io.m_valid, sim.io.s_ready) == (0, 0)
    sim.clock.tick()
    assert (sim.io.m_valid, sim.io.s_ready) == (0, 1)


def test_no_input_reaches_an_output_before_the_clock(sim: PyVerilator) -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        before = (int(sim.io.s_ready), int(sim.io.m_valid), int(sim.io.m_data))
        sim.io.s_valid, sim.io.m_ready, sim.io.s_data = (int(v) for v in rng.integers((2, 2, 256)))
        assert (sim.io.s_ready, sim.io.m_valid, sim.io.m_data) == before
        sim.clock.tick()


def test_a_word_every_clock_one_clock_later(sim: PyVerilator) -> None:
    """s_ready rises one clock after reset, so word k enters at clock k + 1 and leaves at clock k + 2."""
    words = [(k,) for k in range(50)]
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Source(sim, "s", ["data"], words, always())], [sink])
    assert sink.words == words
    assert sink.clocks == list(range(2, 52))


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("idle", PATTERNS)
def test_traffic_arrives_as_sent(sim: PyVerilator, idle: str, stall: str) -> None:
    rng = np.random.default_rng(2)
    words = [(int(word),) for word in rng.integers(256, size=300)]
    source = Source(sim, "s", ["data"], words, PATTERNS[idle](rng))
    sink = Sink(sim, "m", ["data"], PATTERNS[stall](rng))
    run_streams(sim, [source], [sink])
    assert sink.words == words

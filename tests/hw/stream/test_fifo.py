# SPDX-License-Identifier: Apache-2.0
"""fifo.v at a depth of one and at one that is no power of two, for either kind of memory."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, always, lint, run_streams

DEPTHS = [1, 5]


@pytest.fixture(params=DEPTHS)
def depth(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture(params=[0, 1])
def block(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture
def sim(depth: int, block: int) -> PyVerilator:
    sim = load("fifo", {"W": 8, "DEPTH": depth, "BLOCK": block})
    reset(sim)
    return sim


@pytest.mark.parametrize(("w", "depth"), [(1, 1), (8, 2), (8, 5), (70, 16)])
def test_lints_clean(w: int, depth: int, block: int) -> None:
    assert lint("fifo", W=w, DEPTH=depth, BLOCK=block) == (0, "")


@pytest.mark.parametrize("parameter", ["W", "DEPTH"])
def test_refuses_zero(parameter: str) -> None:
    code, log = lint("fifo", **{parameter: 0})
    assert code != 0
    assert f"{parameter}_must_be_at_least_1" in log


def test_refuses_what_is_neither_kind_of_memory() -> None:
    code, log = lint("fifo", BLOCK=2)
    assert code != 0
    assert "BLOCK_must_be_0_or_1" in log


@pytest.mark.parametrize("block", [0], indirect=True)
def test_fills_up_to_its_depth_then_empties_in_order(sim: PyVerilator, depth: int) -> None:
    assert (sim.io.m_valid, sim.io.s_ready, sim.io.level) == (0, 1, 0)
    sim.io.s_valid = 1
    for k in range(depth):
        sim.io.s_data = 10 + k
        assert sim.io.s_ready == 1
        sim.clock.tick()
        assert (sim.io.m_valid, sim.io.m_data, sim.io.level) == (1, 10, k + 1)  # the first word has fallen through
    sim.io.s_data = 99
    assert sim.io.s_ready == 0
    sim.clock.tick()
    assert sim.io.level == depth
    sim.io.s_valid, sim.io.m_ready = 0, 1
    for k in range(depth):
        assert (sim.io.m_valid, sim.io.m_data, sim.io.level) == (1, 10 + k, depth - k)
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.level) == (0, 0)


@pytest.mark.parametrize("block", [1], indirect=True)
def test_with_block_ram_one_more_than_its_depth_is_on_offer(sim: PyVerilator, depth: int) -> None:
    sim.io.s_valid = 1
    for k in range(depth + 20):
        sim.io.s_data = k
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.m_data, sim.io.level, sim.io.s_ready) == (1, 0, depth, 0)
    reset(sim)
    assert (sim.io.m_valid, sim.io.s_ready, sim.io.level) == (0, 1, 0)


def test_reset_empties_it(sim: PyVerilator, block: int) -> None:
    latency = 4 if block else 1
    sim.io.s_valid, sim.io.s_data = 1, 7
    for _ in range(latency):
        sim.clock.tick()
    assert sim.io.m_valid == 1
    reset(sim)
    assert (sim.io.m_valid, sim.io.s_ready, sim.io.level) == (0, 1, 0)
    sim.io.s_data = 42
    for _ in range(latency):
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.m_data) == (1, 42)
    assert block or sim.io.level == 1


def test_throughput(sim: PyVerilator, depth: int, block: int) -> None:
    """A word every clock, one clock later, with block RAM four; one in so many clocks when only one word fits."""
    latency = 4 if block else 1
    words = [(k,) for k in range(40)]
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Source(sim, "s", ["data"], words, always())], [sink])
    assert sink.words == words
    apart = 1 if depth > 1 else 4 if block else 2
    assert sink.clocks == [latency + k * apart for k in range(40)]


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("idle", PATTERNS)
def test_traffic_arrives_as_sent(sim: PyVerilator, depth: int, block: int, idle: str, stall: str) -> None:
    rng = np.random.default_rng(3)
    words = [(int(word),) for word in rng.integers(256, size=300)]
    source = Source(sim, "s", ["data"], words, PATTERNS[idle](rng))
    sink = Sink(sim, "m", ["data"], PATTERNS[stall](rng))

    def check_level(_clock: int) -> None:
        inside = source.taken - len(sink.words)
        held = inside - sim.io.m_valid if block else inside  # what block RAM has on offer is out of it
        assert (sim.io.level, sim.io.s_ready) == (held, held < depth)
        assert block or sim.io.m_valid == (held > 0)

    run_streams(sim, [source], [sink], on_clock=check_level)
    assert sink.words == words
    assert (sim.io.level, sim.io.m_valid) == (0, 0)

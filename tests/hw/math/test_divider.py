# SPDX-License-Identifier: Apache-2.0
"""divider.v: quotient and remainder, division by zero, timing."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, Word, always, lint, run_streams

NUM_W, DEN_W = 12, 5
OPERANDS = ["num", "den"]
RESULTS = ["quot", "rem"]


def divided(num: int, den: int, num_w: int = NUM_W, den_w: int = DEN_W) -> Word:
    return divmod(num, den) if den else ((1 << num_w) - 1, num & ((1 << den_w) - 1))


@pytest.fixture
def sim() -> PyVerilator:
    sim = load("divider", {"NUM_W": NUM_W, "DEN_W": DEN_W})
    reset(sim)
    return sim


@pytest.mark.parametrize(("num_w", "den_w"), [(1, 1), (12, 5), (3, 12), (40, 16)])
def test_lints_clean(num_w: int, den_w: int) -> None:
    assert lint("divider", NUM_W=num_w, DEN_W=den_w) == (0, "")


@pytest.mark.parametrize("parameter", ["NUM_W", "DEN_W"])
def test_refuses_zero(parameter: str) -> None:
    code, log = lint("divider", **{parameter: 0})
    assert code != 0
    assert f"{parameter}_must_be_at_least_1" in log


def test_a_division_takes_a_clock_per_quotient_bit_and_two(sim: PyVerilator) -> None:
    operands = [(1000, 7), (4095, 1), (6, 31), (0, 5), (2047, 0)]
    sink = Sink(sim, "m", RESULTS, always())
    run_streams(sim, [Source(sim, "s", OPERANDS, operands, always())], [sink])
    assert sink.words == [(142, 6), (4095, 0), (0, 6), (0, 0), (4095, 31)]
    assert sink.clocks == [NUM_W + 1 + k * (NUM_W + 2) for k in range(5)]


def test_reset_drops_a_division_under_way(sim: PyVerilator) -> None:
    sim.io.s_valid, sim.io.s_num, sim.io.s_den = 1, 100, 3
    sim.clock.tick()
    sim.io.s_valid = 0
    assert sim.io.s_ready == 0
    reset(sim)
    assert sim.io.s_ready == 1
    for _ in range(2 * NUM_W):
        sim.clock.tick()
        assert sim.io.m_valid == 0


def test_one_bit_numerators_exhaustively() -> None:
    sim = load("divider", {"NUM_W": 1, "DEN_W": 2})
    reset(sim)
    operands = list(product(range(2), range(4)))
    sink = Sink(sim, "m", RESULTS, always())
    run_streams(sim, [Source(sim, "s", OPERANDS, operands, always())], [sink])
    assert sink.words == [divided(num, den, 1, 2) for num, den in operands]


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("idle", PATTERNS)
def test_traffic_matches_integer_division(sim: PyVerilator, idle: str, stall: str) -> None:
    rng = np.random.default_rng(4)
    operands = [(int(num), int(den)) for num, den in rng.integers((1 << NUM_W, 1 << DEN_W), size=(150, 2))]
    sink = Sink(sim, "m", RESULTS, PATTERNS[stall](rng))
    run_streams(sim, [Source(sim, "s", OPERANDS, operands, PATTERNS[idle](rng))], [sink])
    assert sink.words == [divided(num, den) for num, den in operands]

# SPDX-License-Identifier: Apache-2.0
"""weighted_mean.v: the mean of two values with a weight each, two clocks for each bit."""

from __future__ import annotations

from fractions import Fraction
from math import floor

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.rtl.build import load
from support.testing import lint

W, WEIGHT_W = 7, 4


@pytest.fixture(params=[1, 0], ids=["to nearest", "down"])
def sim(request: pytest.FixtureRequest) -> PyVerilator:
    sim = load("weighted_mean", {"W": W, "WEIGHT_W": WEIGHT_W, "ROUND": request.param})
    sim.half = Fraction(request.param, 2)
    return sim


def mean(sim: PyVerilator, a: int, weight_a: int, b: int, weight_b: int) -> tuple[int, int]:
    """The mean that the hardware makes, and its clocks from `start` to `done`."""
    io = sim.io
    io.a, io.b, io.weight_b, io.weight = a, b, weight_b, weight_a + weight_b
    io.start = 1
    sim.clock.tick()
    io.start = 0
    assert io.done == 0
    for clock in range(1, 100):
        sim.clock.tick()
        if io.done:
            return int(io.mean), clock
    raise AssertionError("never done")


@pytest.mark.parametrize(("w", "weight_w"), [(1, 1), (13, 16), (24, 32)])
def test_lints_clean(w: int, weight_w: int) -> None:
    assert lint("weighted_mean", W=w, WEIGHT_W=weight_w) == (0, "")


def test_random_operands(sim: PyVerilator) -> None:
    rng = np.random.default_rng(31)
    for a, weight_a, b, weight_b in rng.integers(0, [1 << W, 1 << WEIGHT_W] * 2, (150, 4)).tolist():
        if weight_a + weight_b:
            exact = Fraction(a * weight_a + b * weight_b, weight_a + weight_b)
            assert mean(sim, a, weight_a, b, weight_b) == (floor(exact + sim.half), 2 * W + 3)


def test_the_ends_of_the_ranges(sim: PyVerilator) -> None:
    highest, heaviest = (1 << W) - 1, (1 << WEIGHT_W) - 1
    for a, weight_a, b, weight_b in ((0, heaviest, highest, heaviest), (highest, heaviest, 0, 0), (highest, 0, highest, 1)):
        exact = Fraction(a * weight_a + b * weight_b, weight_a + weight_b)
        assert mean(sim, a, weight_a, b, weight_b)[0] == floor(exact + sim.half)


def test_a_result_stays_until_the_next_start(sim: PyVerilator) -> None:
    assert mean(sim, 10, 1, 20, 1)[0] == 15
    for _ in range(20):
        sim.clock.tick()
        assert (sim.io.done, sim.io.mean) == (1, 15)


@pytest.mark.parametrize(
    ("parameter", "value", "rule"),
    [("W", 0, "W_must_be_at_least_1"), ("WEIGHT_W", 0, "WEIGHT_W_must_be_at_least_1"), ("ROUND", 2, "ROUND_must_be_0_or_1")],
)
def test_refuses(parameter: str, value: int, rule: str) -> None:
    code, log = lint("weighted_mean", **{parameter: value})
    assert code != 0
    assert rule in log

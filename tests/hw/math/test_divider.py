# SPDX-License-Identifier: Apache-2.0
"""Division, weighted means and approaches."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import floor

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware._cot_kernel import _approach
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, Word, always, evaluate, run_streams

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


W, WEIGHT_W = 7, 4


@pytest.fixture(params=[1, 0], ids=["to nearest", "down"])
def weighted_mean_sim(request: pytest.FixtureRequest) -> PyVerilator:
    weighted_mean_sim = load("weighted_mean", {"W": W, "WEIGHT_W": WEIGHT_W, "ROUND": request.param})
    weighted_mean_sim.half = Fraction(request.param, 2)
    return weighted_mean_sim


def mean(weighted_mean_sim: PyVerilator, a: int, weight_a: int, b: int, weight_b: int) -> tuple[int, int]:
    """The mean that the hardware makes, and its clocks from `start` to `done`."""
    io = weighted_mean_sim.io
    io.a, io.b, io.weight_b, io.weight = a, b, weight_b, weight_a + weight_b
    io.start = 1
    weighted_mean_sim.clock.tick()
    io.start = 0
    assert io.done == 0
    for clock in range(1, 100):
        weighted_mean_sim.clock.tick()
        if io.done:
            return int(io.mean), clock
    raise AssertionError("never done")


def test_random_operands(weighted_mean_sim: PyVerilator) -> None:
    rng = np.random.default_rng(31)
    for a, weight_a, b, weight_b in rng.integers(0, [1 << W, 1 << WEIGHT_W] * 2, (150, 4)).tolist():
        if weight_a + weight_b:
            exact = Fraction(a * weight_a + b * weight_b, weight_a + weight_b)
            assert mean(weighted_mean_sim, a, weight_a, b, weight_b) == (floor(exact + weighted_mean_sim.half), 2 * W + 3)


def test_the_ends_of_the_ranges(weighted_mean_sim: PyVerilator) -> None:
    highest, heaviest = (1 << W) - 1, (1 << WEIGHT_W) - 1
    for a, weight_a, b, weight_b in ((0, heaviest, highest, heaviest), (highest, heaviest, 0, 0), (highest, 0, highest, 1)):
        exact = Fraction(a * weight_a + b * weight_b, weight_a + weight_b)
        assert mean(weighted_mean_sim, a, weight_a, b, weight_b)[0] == floor(exact + weighted_mean_sim.half)


def test_a_result_stays_until_the_next_start(weighted_mean_sim: PyVerilator) -> None:
    assert mean(weighted_mean_sim, 10, 1, 20, 1)[0] == 15
    for _ in range(20):
        weighted_mean_sim.clock.tick()
        assert (weighted_mean_sim.io.done, weighted_mean_sim.io.mean) == (1, 15)


SHIFTS = np.arange(9)


def steps(value: np.ndarray, target: np.ndarray, k: np.ndarray, frac: int) -> np.ndarray:
    return np.array([_approach(*row, frac) for row in zip(value.tolist(), target.tolist(), k.tolist(), strict=True)])


@pytest.mark.parametrize(("w", "frac"), [(1, 0), (6, 0), (6, 4)])
def test_is_the_models_step_for_every_value_target_and_shift(w: int, frac: int) -> None:
    every = np.arange(1 << w)
    value, target, k = (axis.ravel() for axis in np.meshgrid(every, every, SHIFTS))
    result = evaluate("approach", {"W": w, "FRAC": frac}, {"value": value, "target": target, "k": k}, ["result"])["result"]
    np.testing.assert_array_equal(result, steps(value, target, k, frac))
    assert ((np.minimum(value, target) <= result) & (result <= np.maximum(value, target))).all()


@pytest.mark.parametrize(("w", "frac"), [(24, 8)])
def test_is_the_models_step_for_random_wide_values(w: int, frac: int) -> None:
    rng = np.random.default_rng(w)
    value, target, k = rng.integers(0, 1 << w, 20_000), rng.integers(0, 1 << w, 20_000), rng.integers(0, 9, 20_000)
    result = evaluate("approach", {"W": w, "FRAC": frac}, {"value": value, "target": target, "k": k}, ["result"])["result"]
    np.testing.assert_array_equal(result, steps(value, target, k, frac))


@pytest.mark.parametrize(
    ("frac", "value", "target", "k", "result"),
    [
        (0, 10, 13, 1, 11),  # floor(3/2) = 1
        (0, 10, 7, 1, 8),  # floor(-3/2) = -2: the shift is not symmetric
        (0, 10, 13, 2, 10),  # short of a target that lies above
        (4, 10, 13, 1, 12),  # 1.5 rounds up
        (4, 10, 7, 1, 9),  # -1.5 rounds up as well
        (4, 10, 11, 2, 10),  # a quarter rounds to nothing
        (4, 10, 12, 2, 11),  # a half rounds up
        (4, 10, 63, 0, 63),  # k = 0 goes all the way
    ],
)
def test_rounds_with_fractional_bits_and_floors_without(frac: int, value: int, target: int, k: int, result: int) -> None:
    found = evaluate("approach", {"W": 6, "FRAC": frac}, {"value": value, "target": target, "k": k}, ["result"])
    assert found["result"].tolist() == [result]

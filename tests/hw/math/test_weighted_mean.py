# SPDX-License-Identifier: Apache-2.0
"""weighted_mean.v: the centre of two clusters that merge, weighted by what each has seen."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, Word, always, lint, run_streams

W, WEIGHT_W = 7, 4
OPERANDS = ["a", "weight_a", "b", "weight_b"]


def mean(a: int, weight_a: int, b: int, weight_b: int, rounds: bool) -> int:
    both = weight_a + weight_b
    return (a * weight_a + b * weight_b + (both // 2 if rounds else 0)) // both


@pytest.fixture(params=[1, 0], ids=["to nearest", "down"])
def sim(request: pytest.FixtureRequest) -> PyVerilator:
    sim = load("weighted_mean", {"W": W, "WEIGHT_W": WEIGHT_W, "ROUND": request.param})
    sim.rounds = bool(request.param)
    reset(sim)
    return sim


def means(sim: PyVerilator, operands: list[Word]) -> Sink:
    sink = Sink(sim, "m", ["mean"], always())
    run_streams(sim, [Source(sim, "s", OPERANDS, operands, always())], [sink])
    return sink


@pytest.mark.parametrize(("w", "weight_w"), [(1, 1), (15, 16), (24, 32)])
def test_lints_clean(w: int, weight_w: int) -> None:
    assert lint("weighted_mean", W=w, WEIGHT_W=weight_w) == (0, "")


@pytest.mark.parametrize(
    ("parameter", "value", "rule"),
    [("W", 0, "W_must_be_at_least_1"), ("WEIGHT_W", 0, "WEIGHT_W_must_be_at_least_1"), ("ROUND", 2, "ROUND_must_be_0_or_1")],
)
def test_refuses(parameter: str, value: int, rule: str) -> None:
    code, log = lint("weighted_mean", **{parameter: value})
    assert code != 0
    assert rule in log


def test_a_heavy_and_a_light_one(sim: PyVerilator) -> None:
    """Nine parts of 100 and one of 0 are 90; halves go up when rounding; equal values stay, at any weight."""
    sink = means(sim, [(100, 9, 0, 1), (10, 1, 11, 1), (10, 2, 11, 1), (127, 15, 127, 15), (5, 0, 77, 3)])
    assert sink.words == [(90,), (11 if sim.rounds else 10,), (10,), (127,), (77,)]
    assert sink.clocks[0] == W + WEIGHT_W + 2
    assert set(np.diff(sink.clocks)) == {W + WEIGHT_W + 3}


@pytest.mark.parametrize(("source", "sink"), list(product(PATTERNS, repeat=2)))
def test_random_operands_under_stalls(sim: PyVerilator, source: str, sink: str) -> None:
    rng = np.random.default_rng([20, list(PATTERNS).index(source), list(PATTERNS).index(sink)])
    highs = [1 << W, 1 << WEIGHT_W, 1 << W, 1 << WEIGHT_W]
    operands = [tuple(int(v) for v in rng.integers([0, 1, 0, 0], highs)) for _ in range(15)]
    results = Sink(sim, "m", ["mean"], PATTERNS[sink](rng))
    run_streams(sim, [Source(sim, "s", OPERANDS, operands, PATTERNS[source](rng))], [results])
    assert results.words == [(mean(*operand, sim.rounds),) for operand in operands]

# SPDX-License-Identifier: Apache-2.0
"""The decaying weight in integers, compared with exp over every age, rate and fraction of a unit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from evcot.filters.contract import FilterShape
from evcot.filters.decay import DecayFilter, weights
from evcot.filters.registers import FilterRegisters
from support.ticked import ticked

BOUND = 0.03


def test_the_table_is_the_pages_formula() -> None:
    for epsilon in range(256):
        table = weights(epsilon)
        assert len(table) == 289
        for age, weight in enumerate(table.tolist()):
            exact = round(256 * 2 ** (-(age % 32) / 32)) >> (age // 32)
            assert weight == (exact if exact > epsilon else 0)
    assert weights(0)[-1] == 0  # nothing is left, so every greater age may read the last entry
    assert weights(0)[-2] == 0
    assert weights(0)[287 - 31] == 1


def test_a_weight_is_within_the_bound_of_exp_at_every_age_in_units() -> None:
    """Over all ages, and over the whole unit by which two stamps rounded down may be off on either side."""
    table = weights(0) / 256
    age = np.arange(len(table))
    for off in np.linspace(-1, 1, 2001)[1:-1]:
        exact = np.exp2(-np.maximum(age + off, 0) / 32)
        assert np.abs(table - exact).max() < BOUND


@pytest.mark.parametrize("rate", [1 << 24, (1 << 24) - 1, 12_345_678, 1 << 20, 774_411, 99_991, 1 << 12, 37, 1])
def test_a_weight_is_within_the_bound_of_exp_at_every_age_in_ticks(rate: int) -> None:
    """tau is what the rate says: a half-life of 2^29 / rate ticks. Events begin anywhere within a unit."""
    tau = 2**29 / rate / math.log(2)
    horizon = int(12 * tau)
    ages = np.arange(horizon + 1) if horizon < 5_000 else np.linspace(0, horizon, 5_000).astype(np.int64)
    table = weights(0) / 256
    worst = 0.0
    for start in np.linspace(0, 2**24 / rate * 3, 97).astype(np.int64):
        units = ((start + ages) * rate >> 24) - (start * rate >> 24)
        got = table[np.minimum(units, len(table) - 1)]
        worst = max(worst, float(np.abs(got - np.exp(-ages / tau)).max()))
    assert worst < BOUND
    assert worst > 0.001  # integers are not exact: a bound that nothing comes near would test nothing


@pytest.mark.parametrize("rate", [1 << 24, 12_345_678, 1 << 20, 99_991, 1])
@pytest.mark.parametrize("start", [0, 1_000_003, 1 << 61])
def test_the_filter_counts_the_same_units(rate: int, start: int) -> None:
    """One neighbour, and a support that its weight just reaches: the event passes until the last tick of the unit given by
    the table, and no longer."""
    table = weights(0)
    for support in (256, 200, 128, 100, 5, 1):
        last_unit = (start * rate >> 24) + int(np.flatnonzero(table >= support)[-1])
        last_tick = ((last_unit + 1 << 24) - 1) // rate
        for now, stays in ((last_tick, True), (last_tick + 1, False)):
            decay = DecayFilter(FilterRegisters(decay_rate=rate, decay_support=support), FilterShape(2, 1))
            keep = decay.feed(ticked([start, now], [0, 1], 0))
            assert keep.tolist() == [False, stays]


@pytest.mark.parametrize("support", [2048, 2047, 1793])
def test_eight_fresh_neighbours_reach_the_greatest_support(support: int) -> None:
    ring = [(x, y) for x in range(3) for y in range(3) if (x, y) != (1, 1)]
    x, y = (np.array(column, np.uint16) for column in zip(*ring, (1, 1), strict=True))
    for fresh in (8, 7):
        decay = DecayFilter(FilterRegisters(decay_rate=1 << 24, decay_support=support), FilterShape(3, 3))
        keep = decay.feed(ticked(0, x[8 - fresh :], y[8 - fresh :]))
        assert keep[-1] == (256 * fresh >= support)

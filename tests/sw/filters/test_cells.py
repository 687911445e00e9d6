# SPDX-License-Identifier: Apache-2.0
"""Memories of cells follow docs/filters.md: compared with a dict of each cell's last event; and the choice of their unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.filters.chain import FILTERS, FilterChain
from evcot.filters.config import FilterConfig
from evcot.filters.contract import CELL_STAMP_W, Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.ticks import TickedEvents
from support.refusals import refused
from support.tokens import ticked

SIDES = list(CELL_STAMP_W)
SENSORS = [(1, 1), (1, 7), (6, 5), (40, 30), (41, 31)]
BOTH = 1 << Filter.REFRACTORY | 1 << Filter.ACTIVITY


def traffic(random: np.random.Generator, width: int, height: int, count: int = 3000) -> TickedEvents:
    """Random events: many at one tick, some after a long silence, a few off the sensor."""
    gaps = random.choice([0, 0, 1, 2, 5, 50], count)
    gaps[random.integers(0, count, 3)] = 1 << 33
    x, y = random.integers(0, width, count), random.integers(0, height, count)
    outside = random.random(count) < 0.05
    x[outside] += width
    return ticked(np.cumsum(gaps), x, y, random.integers(0, 2, count))


def registers(random: np.random.Generator) -> FilterRegisters:
    return FilterRegisters(
        refractory_ticks=int(random.integers(32, 100)),
        activity_ticks=int(random.integers(0, 100)),
        activity_support=int(random.integers(1, 4)),
        decay_rate=int(random.integers(1 << 20, 1 << 24)),
        decay_epsilon=int(random.integers(0, 100)),
        decay_support=int(random.integers(1, 600)),
        stamp_shift=int(random.integers(3, 6)),
    )


def by_the_rule(which: Filter, regs: FilterRegisters, shape: FilterShape, events: TickedEvents) -> list[bool]:
    side, shift = shape.cell_px, regs.stamp_shift
    last: dict[tuple[int, int], tuple[int, int, int]] = {}  # cell -> unit, x, y
    kept = []
    for tick, x, y in zip(events.ticks.tolist(), events.x.tolist(), events.y.tolist(), strict=True):
        if x >= shape.width or y >= shape.height:
            kept.append(False)
            continue
        column, row = x // side, y // side
        unit = tick * regs.decay_rate // (side**2 << 24) if which == Filter.DECAY else tick >> shift
        around = [last.get((column + dx, row + dy)) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        ages = [unit - event[0] for event in around if event and event[1:] != (x, y)]
        if which == Filter.REFRACTORY:
            own = last.get((column, row))
            stays = not (own and own[1:] == (x, y) and unit - own[0] < regs.refractory_ticks >> shift)
        elif which == Filter.ACTIVITY:
            stays = sum(age <= regs.activity_ticks >> shift for age in ages) >= regs.activity_support
        else:
            fine = [age * side**2 for age in ages]
            weights = [round(256 * 2 ** (-(age % 32) / 32)) >> age // 32 for age in fine if age < 1000]
            stays = sum(weight for weight in weights if weight > regs.decay_epsilon) >= regs.decay_support
        if stays or which != Filter.REFRACTORY:
            last[column, row] = unit, x, y
        kept.append(stays)
    return kept


@pytest.mark.parametrize("size", SENSORS)
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("which", [Filter.REFRACTORY, Filter.ACTIVITY, Filter.DECAY], ids=lambda which: which.name)
def test_a_filter_with_cells_keeps_its_rule(which: Filter, side: int, size: tuple[int, int]) -> None:
    dropped = kept = 0
    for seed in range(4):
        random = np.random.default_rng([seed, side])
        shape, regs, events = FilterShape(*size, cell_px=side), registers(random), traffic(random, *size)
        wanted = by_the_rule(which, regs, shape, events)
        regs = replace(regs, enable=1 << which)
        whole = FilterChain(regs, shape)
        assert whole.feed(events).tolist() == wanted, f"seed {seed}"
        one = FilterChain(regs, shape)
        parts = [one.feed(events[a:b]) for a, b in ((0, 700), (700, 701), (701, 3000))]
        assert np.concatenate(parts).tolist() == wanted
        dropped, kept = dropped + wanted.count(False), kept + wanted.count(True)
    assert dropped
    assert kept or size == (1, 1)


@pytest.mark.parametrize("which", [Filter.REFRACTORY, Filter.ACTIVITY, Filter.DECAY], ids=lambda which: which.name)
def test_a_cell_of_one_pixel_and_a_unit_of_a_tick_is_the_exact_filter(which: Filter) -> None:
    for seed in range(4):
        random = np.random.default_rng(seed)
        regs, events = replace(registers(random), stamp_shift=0), traffic(random, 20, 15)
        exact = FILTERS[which](regs, FilterShape(20, 15)).feed(events)
        assert 0 < np.count_nonzero(exact) < len(exact)
        cells = FilterChain(replace(regs, enable=1 << which), FilterShape(20, 15, cell_px=1))
        np.testing.assert_array_equal(cells.feed(events), exact)


class TestShape:
    def test_a_word_has_9_bits(self) -> None:
        assert all(stamp_w + 2 * (side.bit_length() - 1) == 9 for side, stamp_w in CELL_STAMP_W.items())
        assert [FilterShape(cell_px=side).units_max for side in SIDES] == [384, 96, 24]

    @pytest.mark.parametrize("side", [3, 5, -1])
    def test_other_sides_are_refused(self, side: int) -> None:
        for make in (FilterShape, FilterConfig):
            with pytest.raises(ConfigError, match="cell_px = "):
                make(cell_px=side)


class TestUnits:
    @pytest.mark.parametrize("side", SIDES)
    def test_the_unit_is_the_finest_whose_stamps_reach_the_times(self, side: int) -> None:
        most = FilterShape(cell_px=side).units_max
        for us, shift in ((most - 1, 0), (most, 1), (2 * most - 1, 1), (2 * most, 2)):
            config = FilterConfig(activity_us=us, cell_px=side)
            assert config.registers(1).stamp_shift == shift
            FilterChain(config.registers(1), config.shape(40, 30))
        assert FilterConfig(refractory_us=most, cell_px=side).registers(1).stamp_shift == 0
        assert FilterConfig(activity_us=524_287, cell_px=side).registers(1).stamp_shift <= 15
        assert FilterConfig(activity_us=524_287).registers(1).stamp_shift == 0

    def test_a_refractory_time_below_a_unit_is_refused(self) -> None:
        config = FilterConfig(refractory_us=300, activity_us=10_000, cell_px=4)
        with refused(
            ConfigError,
            "filters.refractory_us = 300: must be at least 512, one unit of stamps of 5 bits that reach activity_us = 10000; "
            "or a smaller cell_px",
        ):
            config.registers(1)
        assert replace(config, refractory_us=512).registers(1).stamp_shift == 9
        assert replace(config, cell_px=2).registers(1).stamp_shift == 7

    @pytest.mark.parametrize(
        ("register", "value", "limits"),
        [("refractory_ticks", 3, "4 to 387"), ("refractory_ticks", 388, "4 to 387"), ("activity_ticks", 384, "0 to 383")],
    )
    def test_registers_that_stamps_cannot_tell_are_refused_where_they_are_used(
        self, register: str, value: int, limits: str
    ) -> None:
        regs, shape = replace(FilterRegisters(refractory_ticks=4, stamp_shift=2), **{register: value}), FilterShape(cell_px=2)
        FilterChain(regs, shape)
        told = f"filters.{register} = {value}: must be from {limits}, with stamps of 7 bits in units of 4 ticks"
        with refused(ConfigError, told):
            FilterChain(replace(regs, enable=BOTH), shape)

# SPDX-License-Identifier: Apache-2.0
"""Support that follows the noise: the level by windows, and the neighbours that it asks for."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.filters.chain import FilterChain
from evcot.filters.config import FilterConfig, thresholds
from evcot.filters.contract import Filter, FilterShape
from evcot.filters.decay import DecayFilter, weights
from evcot.filters.noise_level import UNKNOWN_SUPPORT, NoiseLevel
from evcot.filters.registers import FilterRegisters
from evcot.ticks import TickedEvents
from support.tokens import ticked

SENSOR = 128, 96
FOLLOW = FilterConfig(activity_us=40_000, activity_noise_hz=0.03, cell_px=1)
LEVEL_HZ = 64 * 256 * (1 << 14) * 1e-6  # level of 1 Hz per pixel
SEED = 4711


def chain(config: FilterConfig = FOLLOW, sensor: tuple[int, int] = SENSOR) -> FilterChain:
    return FilterChain(config.registers(1), config.shape(*sensor))


def level_of(filters: FilterChain) -> NoiseLevel:
    assert filters.noise is not None
    return filters.noise


def noise(noise_hz: float, lasts_us: int, begin_us: int = 0) -> TickedEvents:
    random = np.random.default_rng(SEED)
    count = random.poisson(noise_hz * 1e-6 * lasts_us * SENSOR[0] * SENSOR[1])
    ticks = begin_us + np.sort(random.integers(lasts_us, size=count))
    return ticked(ticks, random.integers(SENSOR[0], size=count), random.integers(SENSOR[1], size=count))


def joined(*parts: TickedEvents) -> TickedEvents:
    columns = [np.concatenate([getattr(part, name) for part in parts]) for name in ("ticks", "x", "y", "p")]
    order = np.argsort(columns[0], kind="stable")
    return TickedEvents(*(column[order] for column in columns))


def by_the_rule(events: TickedEvents, registers: FilterRegisters, width: int, height: int) -> list[tuple[int, int]]:
    """docs/filters.md, "Support that follows the noise", event by event, with a dict: level and support of each event."""
    columns, rows = max(width // 8, 1), max(height // 8, 1)
    most = min(6, registers.noise_log2)
    least = [getattr(registers, f"noise_{n}") for n in range(2, 7)]
    shorter = window = windows = alone_mean = empty_mean = level = 0
    number, support = 1, UNKNOWN_SUPPORT
    last: dict[tuple[int, int], int] = defaultdict(int)  # cell -> number of the window of its last event, modulo 2048
    pixels: dict[tuple[int, int], set[tuple[int, int]]] = {(x, y): {(0, 0)} for x in range(columns) for y in range(rows)}
    open_cells: set[tuple[int, int]] = set()
    found = []
    for tick, x, y in zip(events.ticks.tolist(), events.x.tolist(), events.y.tolist(), strict=True):
        if tick >> (registers.noise_log2 - shorter) != window:
            if open_cells:
                empty = columns * rows - len(open_cells)
                alone = sum(len(pixels[cell]) == 1 for cell in open_cells)
                dense, sparse = 4 * empty < columns * rows, 4 * len(open_cells) < columns * rows
                if not dense or shorter == most:
                    alone_mean += (alone * 2**shorter * 256 - alone_mean) // 2**windows
                    empty_mean += (empty * 256 - empty_mean) // 2**windows
                    windows = min(windows + 1, 4)
                    level = min(256 * alone_mean // empty_mean, 65535) if empty_mean else 65535
                    support = 1 + sum(level >= one for one in least)
                shorter = min(shorter + 1, most) if dense else max(shorter - 1, 0) if sparse else shorter
                number = (number + 1) % 2048
                open_cells = set()
            window = tick >> (registers.noise_log2 - shorter)
        cell = x // 8, y // 8
        if cell in pixels:
            if last[cell] != number:
                open_cells.add(cell)
                last[cell], pixels[cell] = number, set()
            pixels[cell].add((x % 8, y % 8))
        found.append((level, support))
    return found


@pytest.mark.parametrize("noise_hz", [0.03, 0.3, 3.0, 20.0, 100.0])
def test_the_level_of_noise_alone(noise_hz: float) -> None:
    filters = chain()
    filters.feed(noise(noise_hz, 1_000_000))
    assert level_of(filters).level == pytest.approx(noise_hz * LEVEL_HZ, rel=0.15)


@pytest.mark.parametrize("noise_hz", [0.1, 1.0, 5.0])
def test_objects_on_a_tenth_of_the_sensor_change_it_little(noise_hz: float) -> None:
    random = np.random.default_rng(SEED)
    objects = ticked(np.sort(random.integers(1_000_000, size=200_000)), *random.integers(35, size=(2, 200_000)))
    filters = chain()
    filters.feed(joined(noise(noise_hz, 1_000_000), objects))
    assert level_of(filters).level == pytest.approx(noise_hz * LEVEL_HZ, rel=0.2)


def test_nothing_passes_before_the_first_window_ends() -> None:
    filters = chain()
    events = noise(1.0, 16_384)
    assert not filters.feed(events).any()
    assert (level_of(filters).level, level_of(filters).support) == (None, UNKNOWN_SUPPORT)
    filters.feed(ticked(16_384, 5, 5))
    assert level_of(filters).level == pytest.approx(LEVEL_HZ, rel=0.3)


def test_a_silence_is_not_measured() -> None:
    filters = chain()
    filters.feed(noise(3.0, 1_000_000))
    before = level_of(filters).level
    filters.feed(ticked(np.array([50_000_000, 50_000_001]), 5, 5))
    assert level_of(filters).level == pytest.approx(before, rel=0.12)


@pytest.mark.parametrize("noise_hz", [0.1, 1.0, 3.0])
def test_no_more_noise_passes_than_asked_for(noise_hz: float) -> None:
    lasts_us = 5_000_000
    keep = chain().feed(noise(noise_hz, lasts_us))
    passing_hz = np.count_nonzero(keep) / (1e-6 * lasts_us * SENSOR[0] * SENSOR[1])
    assert passing_hz <= 1.3 * FOLLOW.activity_noise_hz


def test_support_follows_a_noise_that_changes() -> None:
    filters = chain()
    supports = []
    for begin_s, noise_hz in enumerate((0.005, 3.0, 0.005)):
        filters.feed(noise(noise_hz, 1_000_000, begin_s * 1_000_000))
        supports.append(level_of(filters).support)
    assert supports == [1, 5, 1]


def test_with_a_noise_that_holds_it_is_the_chain_with_that_support() -> None:
    filters, events = chain(), noise(1.3, 2_000_000)
    keep = filters.feed(events)
    late = events.ticks >= 500_000
    held = replace(FOLLOW, activity_noise_hz=0.0, activity_support=level_of(filters).support)
    wanted = chain(held).feed(events)
    assert np.array_equal(keep[late], wanted[late])
    assert wanted[late].any()


@pytest.mark.parametrize("sensor", [(128, 96), (29, 22), (5, 3), (8, 8)])
def test_the_rule_as_it_stands_gives_the_same(sensor: tuple[int, int]) -> None:
    for run, noise_log2 in enumerate((0, 3, 9, 14, 20)):
        rng = np.random.default_rng([SEED, run])
        least = np.sort(rng.integers(1, 2_000, 5)).tolist()
        registers = FilterRegisters(
            enable=1 << Filter.ACTIVITY, activity_support=0, noise_log2=noise_log2,
            **{f"noise_{n}": one for n, one in zip(range(2, 7), least, strict=True)},
        )  # fmt: skip
        pace = 2.0 ** rng.integers(-3, 4) * 2**noise_log2 / 300
        ticks = np.cumsum(rng.poisson(pace, 20_000) + (rng.random(20_000) < 1e-3) * rng.integers(1 << 16, size=20_000))
        events = ticked(ticks, *(rng.integers(size, size=20_000) for size in sensor))
        wanted = by_the_rule(events, registers, *sensor)
        filters = FilterChain(registers, FOLLOW.shape(*sensor))
        for begin in range(0, 20_000, 40):
            filters.feed(events[begin : begin + 40])
            found = level_of(filters)
            assert (found.level or 0, found.support) == wanted[min(begin + 40, 20_000) - 1]


def test_the_number_of_a_window_wraps() -> None:
    """A cell without an event for 2,048 windows looks as if it had one in the open window: the contract says so."""
    registers = FilterRegisters(enable=1 << Filter.ACTIVITY, activity_support=0, noise_log2=4)
    events = joined(ticked(0, 0, 0), ticked(16 * np.arange(4_100), 20, 20))
    filters = FilterChain(registers, FOLLOW.shape(32, 32))
    filters.feed(events)
    level = level_of(filters)
    assert (level.level or 0, level.support) == by_the_rule(events, registers, 32, 32)[-1]


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_it_does_not_depend_on_how_events_are_split_into_runs(size: int) -> None:
    events = noise(1.0, 400_000)[: 4_000 if size > 1 else 400]
    runs = chain()
    parts: list[NDArray[np.bool_]] = [runs.feed(events[begin : begin + size]) for begin in range(0, len(events), size)]
    assert np.array_equal(np.concatenate(parts), chain().feed(events))


@pytest.mark.parametrize("tick_us", [10, 1_000])
def test_in_longer_ticks_windows_last_as_long(tick_us: int) -> None:
    events = noise(1.0, 1_000_000)
    coarse = TickedEvents(events.ticks // tick_us, events.x, events.y, events.p)
    filters = FilterChain(FOLLOW.registers(tick_us), FOLLOW.shape(*SENSOR))
    filters.feed(coarse)
    registers = FOLLOW.registers(tick_us)
    window_us = tick_us << registers.noise_log2
    assert 8_192 < window_us <= 16_384
    assert level_of(filters).level == pytest.approx(LEVEL_HZ * window_us / 16_384, rel=0.15)


def test_thresholds_are_the_least_noise_of_which_too_much_would_pass() -> None:
    within_us, passing_hz, window_us = 40_000.0, 0.03, 16_384.0
    for neighbours, level in zip(range(2, 7), thresholds(within_us, passing_hz, window_us), strict=True):
        for noise_hz, passes in ((0.99 * level / LEVEL_HZ, False), (1.01 * level / LEVEL_HZ, True)):
            mean = 8e-6 * noise_hz * within_us
            fewer = sum(math.exp(-mean) * mean**k / math.factorial(k) for k in range(neighbours - 1))
            assert (noise_hz * (1 - fewer) > passing_hz) == passes, neighbours
    assert thresholds(1.0, passing_hz, window_us)[-1] == 65_535, "never reached"


def test_without_cells_it_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"filters\.activity_noise_hz = 0\.03: must be 0 without memories of cells"):
        replace(FOLLOW, cell_px=0)
    registers = FilterRegisters(enable=1 << Filter.ACTIVITY, activity_support=0)
    with pytest.raises(ConfigError, match=r"filters\.activity_support = 0: must be 1 to 8 with cell_px = 0"):
        registers.check(FilterConfig().shape(*SENSOR))


BOUND = 0.03


def test_the_table_is_the_pages_formula() -> None:
    age = np.arange(289)
    exact = np.round(256 * 2 ** (-(age % 32) / 32)).astype(np.int64) >> age // 32
    for epsilon in range(256):
        np.testing.assert_array_equal(weights(epsilon), np.where(exact > epsilon, exact, 0))
    assert weights(0)[[-1, -2, 287 - 31]].tolist() == [0, 0, 1]  # nothing is left: every greater age may read the last entry


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
    x, y = np.array([*((x, y) for x in range(3) for y in range(3) if (x, y) != (1, 1)), (1, 1)], np.uint16).T
    for fresh in (8, 7):
        decay = DecayFilter(FilterRegisters(decay_rate=1 << 24, decay_support=support), FilterShape(3, 3))
        assert decay.feed(ticked(0, x[8 - fresh :], y[8 - fresh :]))[-1] == (256 * fresh >= support)

# SPDX-License-Identifier: Apache-2.0
"""filter_decay.v: stories, random traffic against model and rule, stamps that wrap, clocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.contract import FilterShape
from evcot.filters.decay import DecayFilter, weights
from evcot.filters.registers import FilterRegisters
from evcot_cosim.devices.base import Stalls
from support.filter_trials import (
    FilterDevice,
    FilterTraffic,
    check_reset_amid_events,
    compare_with_reference,
    filter_traffic,
    parameters,
    run_story,
)
from support.tokens import ticked

TOP = "filter_decay"


ONE_A_TICK = 1 << 24  # decay_rate of one unit per tick: a half-life of 32 ticks


def device_of(width: int, height: int, tick_w: int, cell_px: int = 0) -> FilterDevice:
    ports = {"enable": 1, "decay_rate": ONE_A_TICK, "decay_epsilon": 0, "decay_support": 1}
    return FilterDevice(TOP, parameters(width, height, tick_w=tick_w, CELL_PX=cell_px), ports)


def golden(device: FilterDevice, traffic: FilterTraffic) -> NDArray[np.bool_]:
    """What the model keeps, with the registers that the hardware has."""
    io, given = device.sim.io, device.model.parameters
    rate, epsilon, support = int(io.decay_rate), int(io.decay_epsilon), int(io.decay_support)
    registers = FilterRegisters(decay_rate=rate, decay_epsilon=epsilon, decay_support=support)
    keep = traffic.keep.copy()
    model = DecayFilter(registers, FilterShape(given["WIDTH"], given["HEIGHT"], cell_px=given["CELL_PX"]))
    model.narrow(traffic, keep)
    return keep


def by_the_rule(traffic: FilterTraffic, width: int, height: int, rate: int, epsilon: int, support: int) -> NDArray[np.bool_]:
    """docs/filters.md, event by event: each compared with all before it."""
    x, y = traffic.x.astype(int), traffic.y.astype(int)
    unit = traffic.ticks * rate >> 24
    reached = traffic.keep & (x < width) & (y < height)
    keep = np.zeros(len(x), np.bool_)
    for i in np.flatnonzero(reached):
        beside = np.flatnonzero(reached[:i] & (np.maximum(abs(x[:i] - x[i]), abs(y[:i] - y[i])) == 1))[::-1]
        _, newest = np.unique(x[beside] * height + y[beside], return_index=True)
        ages = [int(age) for age in unit[i] - unit[beside[newest]]]
        each = [round(256 * 2 ** (-(age % 32) / 32)) >> age // 32 for age in ages]
        keep[i] = sum(weight for weight in each if weight > epsilon) >= support
    return keep


@pytest.fixture(scope="module")
def small() -> FilterDevice:
    return device_of(9, 6, 8)


AROUND = [(3, 2), (4, 2), (5, 2), (3, 3), (5, 3), (3, 4), (4, 4), (5, 4)]


class TestStories:
    def test_every_weight_at_every_age_to_the_last_digit(self, small: FilterDevice) -> None:
        """One neighbour fires `age` units before: the event stays at a support of its weight, and not of one more."""
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0)
        ages = np.arange(300)
        ticks = np.cumsum(np.stack([np.full(300, 1000), ages], axis=1).ravel())
        x = np.tile(np.array([4, 5], np.uint16), 300)
        for support in (*range(1, 12), *range(12, 258, 5), 256, 257):
            small.set(decay_support=support)
            small.reset()
            result = small.stream(ticked(ticks, x, x // 2))
            assert not result[0::2].any()
            whole = [round(256 * 2 ** (-(age % 32) / 32)) >> age // 32 for age in range(300)]
            assert result[1::2].tolist() == [weight >= support for weight in whole], support

    @pytest.mark.parametrize("epsilon", [0, 1, 15, 127, 254, 255])
    def test_a_weight_counts_when_it_is_greater_than_epsilon(self, small: FilterDevice, epsilon: int) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=epsilon, decay_support=1)
        for age in range(0, 290, 3):
            assert run_story(small, [(7, 4, 3), (7 + age, 5, 3)]) == [False, bool(weights(0)[min(age, 288)] > epsilon)]

    def test_the_weights_of_all_neighbours_add_up(self, small: FilterDevice) -> None:
        ages = [0, 5, 31, 32, 40, 64, 100, 200]
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0)
        for n in range(9):
            total = int(sum(weights(0)[age] for age in ages[:n]))
            events = sorted((300 - age, *pixel) for age, pixel in zip(ages[:n], AROUND, strict=False))
            for support in (total, total + 1):
                small.set(decay_support=max(1, support))
                assert run_story(small, [*events, (300, 4, 3)])[-1] == (max(1, support) <= total)

    def test_eight_fresh_neighbours_weigh_2048(self, small: FilterDevice) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=255, decay_support=2048)
        assert run_story(small, [*[(0, *pixel) for pixel in AROUND], (0, 4, 3)]) == [False] * 8 + [True]
        assert run_story(small, [*[(0, *pixel) for pixel in AROUND[:7]], (0, 4, 3)]) == [False] * 8

    def test_the_last_event_of_a_neighbour_counts_and_its_own_pixel_does_not(self, small: FilterDevice) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0, decay_support=256)
        assert run_story(small, [(0, 4, 3), (40, 4, 3), (40, 5, 3), (40, 5, 3)]) == [False, False, True, True]
        assert run_story(small, [(0, 4, 3), (0, 4, 3)]) == [False, False]

    def test_nothing_comes_round_the_border(self, small: FilterDevice) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0, decay_support=1)
        pixels = [(x, y) for x in range(9) for y in range(6)]
        for x, y in [(0, 0), (8, 0), (0, 5), (8, 5), (0, 3), (8, 3), (4, 0), (4, 5)]:
            far = [(0, *other) for other in pixels if max(abs(other[0] - x), abs(other[1] - y)) > 1]
            assert not run_story(small, [*far, (0, x, y)])[-1]

    def test_fractions_of_a_unit_add_up(self, small: FilterDevice) -> None:
        """A unit every three ticks: what is left over of one tick counts in the next."""
        small.set(decay_rate=ONE_A_TICK // 3 + 1, decay_epsilon=0, decay_support=256)
        assert [run_story(small, [(start, 4, 3), (start + wait, 5, 3)])[1] for start in (3, 4, 5) for wait in (0, 1, 2, 3)] == [
            True, True, True, False,
            True, True, False, False,
            True, False, False, False,
        ]  # fmt: skip

    def test_an_event_beyond_the_sensor_neither_stays_nor_supports(self, small: FilterDevice) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0, decay_support=1)
        assert run_story(small, [(0, 8, 5), (0, 9, 5), (0, 8, 6), (0, 9, 6), (0, 8, 4)]) == [False, False, False, False, True]
        assert run_story(small, [(0, 9, 3), (0, 8, 3), (0, 3, 6), (0, 3, 5), (0, 0, 4)]) == [False] * 5

    def test_disabled_it_hands_everything_on_and_remembers_nothing_but_time_passes(self, small: FilterDevice) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0, decay_support=129)
        assert run_story(small, [(0, 3, 3)]) == [False]
        story = [  # tick, x, y, enable -> stays
            (4, 4, 3, 0, True),
            (5, 15, 7, 0, True),  # beyond the sensor
            (6, 5, 3, 1, False),
            (31, 2, 3, 1, True),  # the first event has 131 left
            (32, 2, 2, 0, True),
            (64, 1, 3, 1, False),
        ]
        for tick, x, y, enable, stays in story:
            small.set(enable=enable)
            result = small.stream(ticked(tick, x, y))
            assert result.tolist() == [stays], tick

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        small.set(decay_rate=ONE_A_TICK, decay_epsilon=0, decay_support=1)
        small.reset()
        assert small.stream(ticked(0, [3, 4, 5], 1, 1), np.array([True, False, True])).tolist() == [False] * 3

    def test_reset_forgets(self, small: FilterDevice) -> None:
        small.set(decay_rate=1, decay_epsilon=0, decay_support=1)
        everywhere = [(0, x, y) for x in range(9) for y in range(6)]
        assert any(run_story(small, everywhere))
        for _, x, y in everywhere:
            assert run_story(small, [(0, x, y)]) == [False]


@pytest.mark.parametrize("cell_px", [0, 2])
def test_reset_amid_events_leaves_nothing(cell_px: int) -> None:
    check_reset_amid_events(device_of(9, 6, 8, cell_px))


# (width, height, tick_w) -> runs, events in each
SHAPES = {
    (1, 1, 32): (5, 5_000),
    (3, 5, 1): (5, 10_000),
    (3, 5, 20): (10, 10_000),
    (64, 48, 8): (10, 20_000),
    (346, 260, 20): (6, 40_000),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_random_traffic_is_exact_under_stalls(shape: tuple[int, int, int]) -> None:
    width, height, _ = shape
    runs, n = SHAPES[shape]
    device = device_of(*shape)
    stayed = []
    for run in range(runs):
        rng = np.random.default_rng([2026, run])
        rate = ONE_A_TICK if run == 0 else int(2 ** rng.uniform(12, 24))  # half-lives of 32 ticks to 131,072
        epsilon, support = int(rng.choice([0, 3, 10, 200])), int(rng.choice([1, 100, 200, 500, 1200]))
        device.set(decay_rate=rate, decay_epsilon=epsilon, decay_support=support)
        device.reset()
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        unit = ONE_A_TICK / rate
        gap = int(unit * (2048 if shape[2] > 1 else 600))
        waits = float(rng.choice([0, 0.1 * unit, min(unit, 20)]))
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=waits, longest_gap=gap, gaps=20 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: golden(device, batch), parts=1 + run % 3))
    print(f"{shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert width * height == 1 or 0.05 < np.mean(stayed) < 0.95


# (width, height, tick_w, cell_px) -> runs, events in each
CELLS = {
    (11, 9, 1, 2): (5, 10_000),
    (23, 17, 8, 4): (6, 10_000),
    (64, 48, 20, 2): (5, 20_000),
    (64, 48, 8, 1): (5, 20_000),
}


@pytest.mark.parametrize("shape", CELLS)
def test_random_traffic_is_exact_with_cells(shape: tuple[int, int, int, int]) -> None:
    width, height, tick_w, _ = shape
    runs, n = CELLS[shape]
    device = device_of(*shape)
    stayed = []
    for run in range(runs):
        rng = np.random.default_rng([2031, run])
        rate = ONE_A_TICK if run == 0 else int(2 ** rng.uniform(14, 24))
        device.set(decay_rate=rate, decay_epsilon=int(rng.choice([0, 3, 10])), decay_support=int(rng.choice([1, 200, 500])))
        device.reset()
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        unit = ONE_A_TICK / rate
        gap = int(unit * (2048 if tick_w > 1 else 600))
        waits = float(rng.choice([0, 0.1 * unit, min(unit, 20)]))
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=waits, longest_gap=gap, gaps=20 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: golden(device, batch), parts=1 + run % 3))
    print(f"{shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert 0.05 < np.mean(stayed) < 0.97


def test_the_rule_as_it_stands_gives_the_same(small: FilterDevice) -> None:
    for run, (rate, epsilon, support) in enumerate([(ONE_A_TICK, 0, 300), (9_999_999, 20, 500), (1_234_567, 100, 1000)]):
        small.set(decay_rate=rate, decay_epsilon=epsilon, decay_support=support)
        small.reset()
        traffic = filter_traffic(np.random.default_rng(run), 1_500, 9, 6, longest_gap=1200, gaps=0.05, beyond=1)
        wanted = by_the_rule(traffic, 9, 6, rate, epsilon, support)
        assert 0.05 < compare_with_reference(small, traffic, lambda _, wanted=wanted: wanted) < 0.95  # type: ignore[misc]


def test_silences_longer_than_stamps_can_tell(small: FilterDevice) -> None:
    """Two neighbours fire up to five turns of the 9-bit stamp apart; something is left of the first 256 units alone."""
    small.set(decay_rate=ONE_A_TICK, decay_epsilon=0, decay_support=1)
    small.reset()
    units = np.arange(2600)
    ticks = np.cumsum(np.stack([np.full(len(units), 1001), units], axis=1).ravel())
    x = np.tile(np.array([4, 5], np.uint16), len(units))
    result = small.stream(ticked(ticks, x, x // 2))
    assert not result[0::2].any()
    assert result[1::2].tolist() == (units <= 256).tolist()


class TestClocks:
    """What the header claims."""

    def test_an_event_takes_1_clock_and_comes_out_after_13(self) -> None:
        device = device_of(346, 260, 20)
        device.set(decay_rate=ONE_A_TICK // 400)
        traffic = filter_traffic(np.random.default_rng(1), 200_000, 346, 260, ticks_per_event=0.01)
        _, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {13}

    @pytest.mark.parametrize("side", [1, 4])
    def test_with_cells_after_16(self, side: int) -> None:
        device = device_of(64, 48, 20, side)
        device.set(decay_rate=ONE_A_TICK // 400)
        traffic = filter_traffic(np.random.default_rng(1), 20_000, 64, 48, ticks_per_event=0.01)
        _, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {16}
        assert device.settled_after == 16 // side * (12 // side) + 8

    def test_reset_takes_a_clock_for_each_square_of_16_pixels(self) -> None:
        for width, height, tick_w in SHAPES:
            assert device_of(width, height, tick_w).settled_after == -(-width // 4) * -(-height // 4) + 6

    def test_where_one_clock_in_four_is_taken_the_walk_holds_no_event_up(self) -> None:
        device = device_of(64, 48, 8)
        device.set(decay_rate=ONE_A_TICK // 16, decay_support=200)
        device.stall(Stalls(source=np.array([1, 0, 0, 0], np.uint8)))
        # 0.4 ticks an event: a segment of 64 units, or 1,024 ticks, has 7,680 free clocks for a walk of 192 rows.
        traffic = filter_traffic(np.random.default_rng(1), 20_000, 64, 48, ticks_per_event=0.4)
        keep, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {4}
        assert np.array_equal(keep, golden(device, traffic))

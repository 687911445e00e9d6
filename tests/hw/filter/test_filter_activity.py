# SPDX-License-Identifier: Apache-2.0
"""filter_activity.v: stories, random traffic against model and rule, stamps that wrap, clocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.activity import ActivityFilter
from evcot.filters.contract import FilterShape
from evcot.filters.registers import FilterRegisters
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.filter_device import FilterDevice
from support.filter_trials import FilterTraffic, compare_with_reference, filter_traffic, parameters, run_story
from support.tokens import ticked

TOP = "filter_activity"


def device_of(width: int, height: int, stamp_w: int, tick_w: int, ticks: int = 10, support: int = 1) -> FilterDevice:
    ports = {"enable": 1, "activity_ticks": ticks, "activity_support": support}
    return FilterDevice(TOP, parameters(width, height, tick_w=tick_w, STAMP_W=stamp_w), ports)


def golden(device: FilterDevice, traffic: FilterTraffic) -> NDArray[np.bool_]:
    """What the model keeps, with the registers that the hardware has."""
    io, given = device.sim.io, device.model.parameters
    registers = FilterRegisters(activity_ticks=int(io.activity_ticks), activity_support=int(io.activity_support))
    keep = traffic.keep.copy()
    model = ActivityFilter(registers, FilterShape(given["WIDTH"], given["HEIGHT"], given["STAMP_W"]))
    model.narrow(traffic, keep)
    return keep


def by_the_rule(traffic: FilterTraffic, width: int, height: int, ticks: int, support: int) -> NDArray[np.bool_]:
    """docs/filters.md, event by event: each compared with all before it."""
    x, y = traffic.x.astype(int), traffic.y.astype(int)
    reached = traffic.keep & (x < width) & (y < height)
    keep = np.zeros(len(x), np.bool_)
    for i in np.flatnonzero(reached):
        beside = np.maximum(abs(x[:i] - x[i]), abs(y[:i] - y[i])) == 1
        supporters = reached[:i] & beside & (traffic.ticks[i] - traffic.ticks[:i] <= ticks)
        keep[i] = len(np.unique(x[:i][supporters] * height + y[:i][supporters])) >= support
    return keep


@pytest.fixture(scope="module")
def small() -> FilterDevice:
    return device_of(9, 6, 6, 8)


class TestStories:
    @pytest.mark.parametrize("dx", [-1, 0, 1])
    @pytest.mark.parametrize("dy", [-1, 0, 1])
    def test_each_neighbour_supports_and_the_pixel_itself_does_not(self, small: FilterDevice, dx: int, dy: int) -> None:
        small.set(activity_ticks=10, activity_support=1)
        for x in range(1, 8):
            for y in range(1, 5):
                assert run_story(small, [(0, x + dx, y + dy), (3, x, y)]) == [False, (dx, dy) != (0, 0)]

    def test_no_pixel_further_away_supports(self, small: FilterDevice) -> None:
        small.set(activity_ticks=10, activity_support=1)
        x, y = 4, 3
        ring = [(x + dx, y + dy) for dx in range(-2, 3) for dy in range(-2, 3) if max(abs(dx), abs(dy)) == 2]
        for other in ring:
            assert run_story(small, [(0, *other), (0, x, y)]) == [False, False]

    def test_nothing_comes_round_the_border(self, small: FilterDevice) -> None:
        small.set(activity_ticks=10, activity_support=1)
        pixels = [(x, y) for x in range(9) for y in range(6)]
        for x, y in [(0, 0), (8, 0), (0, 5), (8, 5), (0, 3), (8, 3), (4, 0), (4, 5)]:
            far = [(0, *other) for other in pixels if max(abs(other[0] - x), abs(other[1] - y)) > 1]
            assert not run_story(small, [*far, (0, x, y)])[-1]

    def test_as_many_neighbours_as_asked_for(self, small: FilterDevice) -> None:
        around = [(3, 2), (4, 2), (5, 2), (3, 3), (5, 3), (3, 4), (4, 4), (5, 4)]
        for support in range(1, 9):
            small.set(activity_ticks=10, activity_support=support)
            for n in range(9):
                events = [(5 * i // 8, *pixel) for i, pixel in enumerate(around[:n])]
                twice = [(9, *around[0])] * (n > 0)  # an event again is no second neighbour
                assert run_story(small, [*events, *twice, (10, 4, 3)])[-1] == (n >= support)

    @pytest.mark.parametrize("ticks", [0, 1, 7, 31])
    def test_up_to_the_oldest_age_and_not_beyond(self, small: FilterDevice, ticks: int) -> None:
        small.set(activity_ticks=ticks, activity_support=1)
        assert run_story(small, [(5, 4, 3), (5 + ticks, 5, 3)]) == [False, True]
        assert run_story(small, [(5, 4, 3), (5 + ticks + 1, 5, 3)]) == [False, False]

    def test_an_event_that_does_not_stay_is_remembered(self, small: FilterDevice) -> None:
        small.set(activity_ticks=10, activity_support=1)
        assert run_story(small, [(0, 2, 2), (20, 3, 2), (29, 4, 2), (31, 3, 2)]) == [False, False, True, True]

    def test_an_event_beyond_the_sensor_neither_stays_nor_supports(self, small: FilterDevice) -> None:
        small.set(activity_ticks=10, activity_support=1)
        assert run_story(small, [(0, 8, 5), (0, 9, 5), (0, 8, 6), (0, 9, 6), (0, 8, 4)]) == [False, False, False, False, True]
        assert run_story(small, [(0, 9, 3), (0, 8, 3), (0, 3, 6), (0, 3, 5), (0, 0, 4)]) == [False] * 5

    def test_disabled_it_hands_everything_on_and_remembers_nothing_but_time_passes(self, small: FilterDevice) -> None:
        small.set(activity_ticks=10, activity_support=1)
        assert run_story(small, [(0, 3, 3)]) == [False]
        story = [  # tick, x, y, enable -> stays
            (4, 4, 3, 0, True),
            (5, 15, 7, 0, True),  # beyond the sensor
            (6, 5, 3, 1, False),
            (10, 2, 3, 1, True),  # 10 ticks after the first event
            (11, 2, 2, 0, True),
            (21, 1, 3, 1, False),
        ]
        for tick, x, y, enable, stays in story:
            small.set(enable=enable)
            result = small.stream(ticked(tick, x, y))
            assert result.tolist() == [stays], tick

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        small.set(activity_ticks=10, activity_support=1)
        small.reset()
        assert small.stream(ticked(0, [3, 4, 5], 1, 1), np.array([True, False, True])).tolist() == [False] * 3

    def test_reset_forgets(self, small: FilterDevice) -> None:
        small.set(activity_ticks=31, activity_support=1)
        everywhere = [(0, x, y) for x in range(9) for y in range(6)]
        assert any(run_story(small, everywhere))
        for _, x, y in everywhere:
            assert run_story(small, [(0, x, y)]) == [False]


# (width, height, stamp_w, tick_w) -> runs, events in each
SHAPES = {
    (1, 1, 24, 20): (5, 5_000),
    (3, 5, 4, 1): (5, 10_000),
    (3, 5, 4, 8): (10, 10_000),
    (64, 48, 12, 8): (10, 20_000),
    (346, 260, 20, 20): (6, 40_000),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_random_traffic_is_exact_under_stalls(shape: tuple[int, int, int, int]) -> None:
    width, height, stamp_w, _ = shape
    runs, n = SHAPES[shape]
    device = device_of(*shape)
    stayed = []
    for run in range(runs):
        rng = np.random.default_rng([2026, run])
        oldest = (1 << (stamp_w - 1)) - 1
        ticks = oldest if run % 3 == 0 else int(2 ** rng.uniform(0, stamp_w - 1)) - 1
        device.set(activity_ticks=ticks, activity_support=int(rng.choice([1, 1, 2, 3, 8])))
        device.reset()
        device.stalls = Stalls.random(rng) if run % 2 else Stalls()
        rate, gap = float(rng.choice([0, 0.1, 1, 5])), (1 << stamp_w + 2)
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=rate, longest_gap=gap, gaps=50 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: golden(device, batch), parts=1 + run % 3))
    print(f"{shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert width * height == 1 or 0.05 < np.mean(stayed) < 0.95


def test_the_rule_as_it_stands_gives_the_same() -> None:
    device = device_of(9, 6, 6, 8)
    for run, (ticks, support) in enumerate([(0, 1), (5, 2), (31, 3), (31, 1)]):
        device.set(activity_ticks=ticks, activity_support=support)
        device.reset()
        traffic = filter_traffic(np.random.default_rng(run), 2_000, 9, 6, longest_gap=300, gaps=0.05, beyond=1)
        kept = compare_with_reference(device, traffic, lambda batch, t=ticks, s=support: by_the_rule(batch, 9, 6, t, s))  # type: ignore[misc]
        assert 0.05 < kept < 0.95


@pytest.mark.parametrize("tick_w", [1, 8])
def test_every_age_at_every_phase_of_the_stamps(tick_w: int) -> None:
    """Two neighbours fire, any time apart, up to five turns of a 4-bit stamp; then long enough silence for the next two."""
    device = device_of(3, 5, 4, tick_w, ticks=7)
    ages, phases = (axis.ravel() for axis in np.meshgrid(np.arange(81), np.arange(16)))
    ticks = np.cumsum(np.stack([90 + (phases - np.roll(phases, 1)) % 16, ages], axis=1).ravel())
    x = np.tile(np.array([1, 2], np.uint16), len(ages))
    result = device.stream(ticked(ticks, x, x))
    assert not result[0::2].any()
    assert result[1::2].tolist() == (ages <= 7).tolist()


class TestClocks:
    """What the header claims."""

    def test_an_event_takes_1_clock_and_comes_out_after_8(self) -> None:
        traffic = filter_traffic(np.random.default_rng(1), 200_000, 346, 260, ticks_per_event=0.01)
        _, times = device_of(346, 260, 20, 20).stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {8}

    def test_reset_takes_a_clock_for_each_square_of_16_pixels(self) -> None:
        for width, height, *widths in SHAPES:
            assert device_of(width, height, *widths).settled_after == -(-width // 4) * -(-height // 4) + 6

    def test_where_one_clock_in_four_is_taken_the_walk_holds_no_event_up(self) -> None:
        n = 20_000
        device = device_of(64, 48, 12, 8)
        device.stalls = Stalls(source=np.array([1, 0, 0, 0], np.uint8))
        # 0.4 ticks an event: a segment of 1,024 ticks has 7,680 free clocks for a walk of 192 rows.
        traffic = filter_traffic(np.random.default_rng(1), n, 64, 48, ticks_per_event=0.4)
        keep, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {4}
        assert np.array_equal(keep, golden(device, traffic))

    def test_a_stream_without_a_free_clock_waits_for_one_walk_in_each_segment(self) -> None:
        n, device = 50_000, device_of(64, 48, 12, 8)
        traffic = filter_traffic(np.random.default_rng(1), n, 64, 48, ticks_per_event=0.5, skips=0)
        _, times = device.stream_timed(traffic, traffic.keep)
        segments = traffic.ticks[-1] // 1024
        assert segments == 24
        assert 0 < times.accepted[-1] - (n - 1) <= segments * (192 + 6)

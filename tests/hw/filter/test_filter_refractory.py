# SPDX-License-Identifier: Apache-2.0
"""filter_refractory.v: stories, random traffic against model and rule, stamps that wrap, clocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.contract import FilterShape
from evcot.filters.refractory import RefractoryFilter
from evcot.filters.registers import FilterRegisters
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.filter_device import FilterDevice
from support.filter_trials import FilterTraffic, compare_with_reference, filter_traffic, parameters, run_story
from support.tokens import ticked

TOP = "filter_refractory"


def device_of(width: int, height: int, stamp_w: int, tick_w: int, ticks: int = 10) -> FilterDevice:
    ports = {"enable": 1, "refractory_ticks": ticks}
    return FilterDevice(TOP, parameters(width, height, tick_w=tick_w, STAMP_W=stamp_w), ports)


def golden(device: FilterDevice, traffic: FilterTraffic) -> NDArray[np.bool_]:
    """What the model keeps, with the register that the hardware has."""
    given = device.model.parameters
    registers = FilterRegisters(refractory_ticks=int(device.sim.io.refractory_ticks))
    keep = traffic.keep.copy()
    model = RefractoryFilter(registers, FilterShape(given["WIDTH"], given["HEIGHT"], given["STAMP_W"]))
    model.narrow(traffic, keep)
    return keep


def by_the_rule(traffic: FilterTraffic, width: int, height: int, ticks: int) -> NDArray[np.bool_]:
    """docs/filters.md, event by event: each compared with all that stayed before it."""
    keep = np.zeros(len(traffic.x), np.bool_)
    for i in np.flatnonzero(traffic.keep & (traffic.x < width) & (traffic.y < height)):
        here = keep[:i] & (traffic.x[:i] == traffic.x[i]) & (traffic.y[:i] == traffic.y[i])
        keep[i] = not (here & (traffic.ticks[i] - traffic.ticks[:i] < ticks)).any()
    return keep


@pytest.fixture(scope="module")
def small() -> FilterDevice:
    return device_of(9, 6, 6, 8)


class TestStories:
    def test_a_pixel_is_silent_after_an_event_that_stayed(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=10)
        assert run_story(small, [(0, 4, 3), (5, 4, 3), (9, 4, 3), (10, 4, 3), (12, 4, 3), (19, 4, 3), (20, 4, 3)]) == [
            True, False, False, True, False, False, True,
        ]  # fmt: skip

    def test_an_event_that_does_not_stay_does_not_prolong_the_silence(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=10)
        assert run_story(small, [(0, 4, 3), *[(9, 4, 3)] * 5, (10, 4, 3)]) == [True, *[False] * 5, True]

    def test_other_pixels_are_not_silenced(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=31)
        everywhere = [(0, x, y) for x in range(9) for y in range(6)]
        assert run_story(small, everywhere + everywhere) == [True] * 54 + [False] * 54

    @pytest.mark.parametrize("ticks", [1, 2, 17, 31])
    def test_for_as_many_ticks_as_the_register_says(self, small: FilterDevice, ticks: int) -> None:
        small.set(refractory_ticks=ticks)
        assert run_story(small, [(5, 4, 3), (5 + ticks - 1, 4, 3)]) == [True, False]
        assert run_story(small, [(5, 4, 3), (5 + ticks, 4, 3)]) == [True, True]

    @pytest.mark.parametrize("between", range(8))
    def test_an_event_soon_after_another_knows_what_became_of_that(self, small: FilterDevice, between: int) -> None:
        small.set(refractory_ticks=4)
        others = [(0, x, 5) for x in range(between)]
        assert run_story(small, [(0, 4, 3), *others, (0, 4, 3)]) == [True] * (between + 1) + [False]
        later = [(4, x, 5) for x in range(between)]
        assert run_story(small, [(0, 4, 3), (3, 4, 3), *later, (4, 4, 3), (4, 4, 3)]) == [True, False] + [True] * between + [
            True,
            False,
        ]

    def test_an_event_beyond_the_sensor_does_not_stay(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=10)
        assert run_story(small, [(0, 9, 2), (0, 8, 6), (0, 15, 7), (0, 0, 3), (0, 8, 5)]) == [False, False, False, True, True]

    def test_disabled_it_hands_everything_on_and_remembers_nothing_but_time_passes(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=10)
        assert run_story(small, [(0, 3, 3)]) == [True]
        story = [  # tick, x, y, enable -> stays
            (4, 3, 3, 0, True),
            (5, 15, 7, 0, True),  # beyond the sensor
            (9, 3, 3, 1, False),
            (10, 3, 3, 1, True),
            (11, 4, 3, 0, True),
            (12, 4, 3, 1, True),
        ]
        for tick, x, y, enable, stays in story:
            small.set(enable=enable)
            result = small.stream(ticked(tick, x, y))
            assert result.tolist() == [stays], tick

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=10)
        small.reset()
        result = small.stream(ticked(0, [3, 3, 3], 1, 1), np.array([False, True, True]))
        assert result.tolist() == [False, True, False]

    def test_reset_forgets(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=31)
        for x in range(9):
            assert run_story(small, [(0, x, 4)]) == [True]
            assert run_story(small, [(0, x, 4)]) == [True]


# (width, height, stamp_w, tick_w) -> runs, events in each
SHAPES = {
    (1, 1, 24, 20): (10, 10_000),
    (3, 5, 4, 1): (5, 10_000),
    (3, 5, 4, 8): (10, 10_000),
    (64, 48, 12, 8): (10, 20_000),
    (346, 260, 20, 20): (5, 40_000),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_random_traffic_is_exact_under_stalls(shape: tuple[int, int, int, int]) -> None:
    width, height, stamp_w, _ = shape
    runs, n = SHAPES[shape]
    device = device_of(*shape)
    stayed = []
    for run in range(runs):
        rng = np.random.default_rng([2026, run])
        longest = (1 << (stamp_w - 1)) - 1
        device.set(refractory_ticks=longest if run % 3 == 0 else max(1, int(2 ** rng.uniform(0, stamp_w - 1)) - 1))
        device.reset()
        device.stalls = Stalls.random(rng) if run % 2 else Stalls()
        rate, gap = float(rng.choice([0, 0.1, 1, 5])), (1 << stamp_w + 2)
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=rate, longest_gap=gap, gaps=20 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: golden(device, batch), parts=1 + run % 3))
    print(f"{shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert 0.05 < np.mean(stayed) < 0.95


def test_the_rule_as_it_stands_gives_the_same() -> None:
    device = device_of(9, 6, 6, 8)
    for run, ticks in enumerate([1, 5, 31, 31]):
        device.set(refractory_ticks=ticks)
        device.reset()
        traffic = filter_traffic(np.random.default_rng(run), 2_000, 9, 6, longest_gap=300, gaps=0.05, beyond=1)
        kept = compare_with_reference(device, traffic, lambda batch, t=ticks: by_the_rule(batch, 9, 6, t))  # type: ignore[misc]
        assert 0.05 < kept < 0.95


@pytest.mark.parametrize("tick_w", [1, 8])
def test_every_age_at_every_phase_of_the_stamps(tick_w: int) -> None:
    """A pixel fires twice, any time apart, up to five turns of a 4-bit stamp; then long enough silence for the next two."""
    device = device_of(3, 5, 4, tick_w, ticks=7)
    ages, phases = (axis.ravel() for axis in np.meshgrid(np.arange(81), np.arange(16)))
    ticks = np.cumsum(np.stack([90 + (phases - np.roll(phases, 1)) % 16, ages], axis=1).ravel())
    x = np.ones(2 * len(ages), np.uint16)
    result = device.stream(ticked(ticks, x, x))
    assert result[0::2].all()
    assert result[1::2].tolist() == (ages >= 7).tolist()


class TestClocks:
    """What the header claims."""

    def test_an_event_takes_1_clock_and_comes_out_after_7(self) -> None:
        traffic = filter_traffic(np.random.default_rng(1), 200_000, 346, 260, ticks_per_event=0.01)
        _, times = device_of(346, 260, 20, 20).stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {7}

    def test_reset_takes_a_clock_for_each_pixel(self) -> None:
        for shape in SHAPES:
            assert device_of(*shape).settled_after == shape[0] * shape[1] + 6

    def test_where_one_clock_in_four_is_taken_the_walk_holds_no_event_up(self) -> None:
        device = device_of(64, 48, 12, 8)
        device.stalls = Stalls(source=np.array([1, 0, 0, 0], np.uint8))
        # 0.4 ticks an event: a segment of 1,024 ticks has 7,680 free clocks for a walk of 3,072 pixels.
        traffic = filter_traffic(np.random.default_rng(1), 20_000, 64, 48, ticks_per_event=0.4)
        keep, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {4}
        assert np.array_equal(keep, golden(device, traffic))

    def test_a_stream_without_a_free_clock_waits_for_one_walk_in_each_segment(self) -> None:
        n, device = 50_000, device_of(64, 48, 12, 8)
        traffic = filter_traffic(np.random.default_rng(1), n, 64, 48, ticks_per_event=0.5, skips=0)
        _, times = device.stream_timed(traffic, traffic.keep)
        segments = traffic.ticks[-1] // 1024
        assert segments == 24
        assert 0 < times.accepted[-1] - (n - 1) <= segments * (64 * 48 + 6)

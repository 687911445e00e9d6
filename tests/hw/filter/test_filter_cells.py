# SPDX-License-Identifier: Apache-2.0
"""filter_cells.v: refractory and activity over one memory of cells decide what their models decide one after the other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.chain import FilterChain
from evcot.filters.contract import CELL_STAMP_W, Filter, FilterShape
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

TOP = "filter_cells"
SIDES = list(CELL_STAMP_W)
PORTS = ("refractory_ticks", "activity_ticks", "stamp_shift")


def device_of(width: int, height: int, cell_px: int, tick_w: int = 8, stamp_w: int = 12) -> FilterDevice:
    given = parameters(width, height, tick_w=tick_w, STAMP_W=stamp_w, CELL_PX=cell_px)
    return FilterDevice(TOP, given, {"enable_refractory": 1, "enable_activity": 1, "refractory_ticks": 1})


def choose(device: FilterDevice, *, refractory: int = 0, activity: int | None = None, support: int = 1, shift: int = 0) -> None:
    """Enable refractory and activity with these times in ticks, or not (0; None)."""
    device.set(
        enable_refractory=int(refractory > 0), refractory_ticks=max(1, refractory), enable_activity=int(activity is not None),
        activity_ticks=activity or 0, s_support=support, stamp_shift=shift, changes=1,
    )  # fmt: skip
    device.sim.clock.tick()
    device.set(changes=0)


def golden(device: FilterDevice, traffic: FilterTraffic, cell_px: int | None = None) -> NDArray[np.bool_]:
    """What the models keep, with the registers that the hardware has."""
    io, given = device.sim.io, device.model.parameters
    enable = int(io.enable_refractory) << Filter.REFRACTORY | int(io.enable_activity) << Filter.ACTIVITY
    chosen = {name: int(io[name]) for name in PORTS}
    registers = FilterRegisters(enable=enable, activity_support=int(io.s_support) or 1, **chosen)
    side = given["CELL_PX"] if cell_px is None else cell_px
    keep = traffic.keep.copy()
    FilterChain(registers, FilterShape(given["WIDTH"], given["HEIGHT"], given["STAMP_W"], cell_px=side)).narrow(traffic, keep)
    return keep


def by_the_rule(traffic: FilterTraffic, device: FilterDevice) -> NDArray[np.bool_]:
    """docs/filters.md, "One memory of cells", event by event, with a dict."""
    io, given = device.sim.io, device.model.parameters
    side, width, height = (given[name] for name in ("CELL_PX", "WIDTH", "HEIGHT"))
    silence, window = (int(io[name]) >> int(io.stamp_shift) for name in ("refractory_ticks", "activity_ticks"))
    last: dict[tuple[int, int], tuple[int, int, int]] = {}  # cell -> unit, x, y
    keep = np.zeros(len(traffic), np.bool_)
    for i, (tick, x, y) in enumerate(zip(traffic.ticks.tolist(), traffic.x.tolist(), traffic.y.tolist(), strict=True)):
        if not (traffic.keep[i] and x < width and y < height):
            continue
        unit, cell = tick >> int(io.stamp_shift), (x // side, y // side)
        if io.enable_refractory and cell in last and last[cell][1:] == (x, y) and unit - last[cell][0] < silence:
            continue
        around = [last.get((cell[0] + dx, cell[1] + dy)) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        supporters = sum(event is not None and unit - event[0] <= window and event[1:] != (x, y) for event in around)
        keep[i] = not io.enable_activity or supporters >= int(io.s_support)
        last[cell] = unit, x, y
    return keep


@pytest.fixture(scope="module", params=SIDES, ids=lambda side: f"cells of {side}")
def small(request: pytest.FixtureRequest) -> FilterDevice:
    """A sensor of 9 x 6 cells, the last ones cut off."""
    side = request.param
    return device_of(9 * side - side // 2, 6 * side - side // 2, side)


def side_of(device: FilterDevice) -> int:
    return int(device.model.parameters["CELL_PX"])


class TestStories:
    def test_each_cell_around_supports_and_none_further_away(self, small: FilterDevice) -> None:
        choose(small, activity=10)
        side = side_of(small)
        for dx in range(-2, 3):
            for dy in range(-2, 3):
                story = [(0, (4 + dx) * side, (3 + dy) * side), (3, 4 * side, 3 * side)]
                assert run_story(small, story) == [False, max(abs(dx), abs(dy)) == 1]

    def test_of_its_own_cell_another_pixel_supports_and_itself_does_not(self, small: FilterDevice) -> None:
        choose(small, activity=10)
        side = side_of(small)
        for dx in range(side):
            for dy in range(side):
                assert run_story(small, [(0, 4 * side + dx, 3 * side + dy), (3, 4 * side, 3 * side)])[1] == ((dx, dy) != (0, 0))

    def test_nothing_comes_round_the_border(self, small: FilterDevice) -> None:
        choose(small, activity=10)
        side = side_of(small)
        for x, y in [(0, 0), (8, 0), (0, 5), (8, 5), (0, 3), (8, 3), (4, 0), (4, 5)]:
            far = [(0, a * side, b * side) for a in range(9) for b in range(6) if max(abs(a - x), abs(b - y)) > 1]
            assert not run_story(small, [*far, (0, x * side, y * side)])[-1]

    def test_as_many_cells_as_asked_for(self, small: FilterDevice) -> None:
        side = side_of(small)
        around = [(3, 2), (4, 2), (5, 2), (3, 3), (5, 3), (3, 4), (4, 4), (5, 4)]
        for support in (1, 2, 5, 8):
            choose(small, activity=10, support=support)
            for n in range(9):
                events = [(0, a * side, b * side) for a, b in around[:n]]
                assert run_story(small, [*events, (10, 4 * side, 3 * side)])[-1] == (n >= support)

    def test_a_pixel_is_silent_until_its_time_or_until_another_of_its_cell_fires(self, small: FilterDevice) -> None:
        choose(small, refractory=10)
        side = side_of(small)
        x, y = 4 * side, 3 * side
        assert run_story(small, [(0, x, y), (9, x, y), (10, x, y), (19, x, y), (20, x, y)]) == [True, False, True, False, True]
        if side > 1:
            assert run_story(small, [(0, x, y), (5, x + 1, y), (6, x, y), (7, x, y)]) == [True, True, True, False]

    def test_what_refractory_drops_does_not_support(self, small: FilterDevice) -> None:
        choose(small, refractory=20, activity=10)
        side = side_of(small)
        x, y = 4 * side, 3 * side
        assert run_story(small, [(0, x, y), (8, x, y), (12, x + side, y)]) == [False, False, False]
        assert run_story(small, [(0, x, y), (20, x, y), (25, x + side, y)]) == [False, False, True]

    @pytest.mark.parametrize("between", range(8))
    def test_an_event_soon_after_another_knows_what_became_of_that(self, small: FilterDevice, between: int) -> None:
        side = side_of(small)
        x, y = 4 * side, 3 * side
        others = [(0, 0, 5 * side)] * between
        choose(small, refractory=4)
        assert run_story(small, [(0, x, y), *others, (0, x, y)])[-1] is False
        assert run_story(small, [(0, x, y), *others, (4, x, y), (4, x, y)])[-2:] == [True, False]
        choose(small, refractory=20, activity=3)
        assert run_story(small, [(0, x, y), *others, (0, x + side, y)])[-1] is True
        assert run_story(small, [(0, x, y), (5, x, y), *[(5, a, b) for _, a, b in others], (5, x + side, y)])[-1] is False

    @pytest.mark.parametrize("shift", [0, 1, 5, 15])
    def test_times_are_in_units_counted_from_reset(self, small: FilterDevice, shift: int) -> None:
        choose(small, activity=min(3 << shift, 2047), shift=shift)
        window, side = min(3 << shift, 2047) >> shift, side_of(small)
        for start in (0, 1, (1 << shift) - 1):
            for age in (window << shift, (window << shift) + (1 << shift), (window << shift) + (1 << shift) - 1):
                units = (start + age >> shift) - (start >> shift)
                story = [(start, 4 * side, 3 * side), (start + age, 5 * side, 3 * side)]
                assert run_story(small, story) == [False, units <= window]

    def test_a_time_beyond_the_stamps_is_the_longest_that_they_hold(self, small: FilterDevice) -> None:
        side = side_of(small)
        most = FilterShape(cell_px=side).units_max
        choose(small, activity=2047)
        for age in (most - 1, most):
            assert run_story(small, [(0, 4 * side, 3 * side), (age, 5 * side, 3 * side)])[1] == (age < most)
        choose(small, refractory=2047)
        for age in (most - 1, most):
            assert run_story(small, [(0, 4 * side, 3 * side), (age, 4 * side, 3 * side)])[1] == (age >= most)

    def test_an_event_beyond_the_sensor_neither_stays_nor_supports(self, small: FilterDevice) -> None:
        """Though the last cell reaches further."""
        choose(small, activity=10)
        width, height = (int(small.model.parameters[name]) for name in ("WIDTH", "HEIGHT"))
        story = [(0, width, height - 1), (0, width - 1, height), (0, width, height), (0, width - 1, height - 1)]
        assert run_story(small, story) == [False] * 4
        choose(small, refractory=10)
        assert run_story(small, story) == [False, False, False, True]

    def test_disabled_it_hands_everything_on_and_remembers_nothing_but_time_passes(self, small: FilterDevice) -> None:
        side = side_of(small)
        choose(small, activity=10)
        assert run_story(small, [(0, 3 * side, 3 * side)]) == [False]
        for tick, x, on, stays in [(4, 4, False, True), (6, 5, True, False), (10, 2, True, True), (21, 1, True, False)]:
            choose(small, activity=10 if on else None)
            assert small.stream(ticked(tick, x * side, 3 * side)).tolist() == [stays], tick

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        choose(small, refractory=5, activity=10)
        small.reset()
        x = np.array([3, 4, 5]) * side_of(small)
        assert small.stream(ticked(0, x, 1, 1), np.array([True, False, True])).tolist() == [False] * 3

    def test_reset_forgets(self, small: FilterDevice) -> None:
        choose(small, activity=20)
        side = side_of(small)
        everywhere = [(0, x * side, y * side) for x in range(9) for y in range(6)]
        assert any(run_story(small, everywhere))
        for _, x, y in everywhere:
            assert run_story(small, [(0, x, y)]) == [False]


# (width, height, cell_px, tick_w) -> runs, events in each
SHAPES = {
    (1, 1, 1, 8): (2, 3_000),
    (3, 5, 1, 1): (5, 10_000),
    (11, 9, 2, 1): (5, 10_000),
    (23, 17, 4, 8): (8, 10_000),
    (64, 48, 2, 8): (5, 20_000),
    (64, 48, 1, 20): (5, 20_000),
    (346, 260, 4, 20): (5, 40_000),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_random_traffic_is_exact_under_stalls(shape: tuple[int, int, int, int]) -> None:
    width, height, side, tick_w = shape
    runs, n = SHAPES[shape]
    device, most = device_of(width, height, side, tick_w, 20), FilterShape(cell_px=side).units_max
    stayed = []
    for run in range(runs):
        rng = np.random.default_rng([2029, run])
        shift = int(rng.choice([0, 0, 1, 3, 6]))
        units = [int(2 ** rng.uniform(0, np.log2(most))) for _ in range(2)]
        choose(
            device, refractory=0 if run % 4 == 1 else (most if run % 3 == 0 else units[0]) << shift,
            activity=None if run % 4 == 2 else (most - 1 if run % 3 == 1 else units[1]) << shift,
            support=int(rng.choice([1, 1, 2, 3, 8])), shift=shift,
        )  # fmt: skip
        device.reset()
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        rate, gap = float(rng.choice([0, 0.1, 1, 5])), 6 * most << shift
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=rate, longest_gap=gap, gaps=50 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: golden(device, batch), parts=1 + run % 3))
    print(f"{shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert width * height == 1 or 0.02 < np.mean(stayed) < 0.98


@pytest.mark.parametrize("cell_px", SIDES)
def test_reset_amid_events_leaves_nothing(cell_px: int) -> None:
    check_reset_amid_events(device_of(9, 6, cell_px))


def test_the_rule_as_it_stands_gives_the_same(small: FilterDevice) -> None:
    width, height = (int(small.model.parameters[name]) for name in ("WIDTH", "HEIGHT"))
    for run, (refractory, activity, support, shift) in enumerate(
        [(0, 5, 2, 0), (9, 20, 1, 1), (16, None, 1, 2), (4, 90, 3, 2)]
    ):
        choose(small, refractory=refractory, activity=activity, support=support, shift=shift)
        small.reset()
        traffic = filter_traffic(np.random.default_rng(run), 2_000, width, height, longest_gap=300, gaps=0.05, beyond=1)
        kept = compare_with_reference(small, traffic, lambda batch: by_the_rule(batch, small))
        assert 0.02 < kept < 0.98


def test_with_cells_of_one_pixel_and_units_of_a_tick_it_is_the_two_exact_filters() -> None:
    device = device_of(64, 48, 1)
    for run in range(4):
        rng = np.random.default_rng([2030, run])
        choose(device, refractory=int(rng.integers(1, 384)), activity=int(rng.integers(1, 384)), support=1 + run % 2)
        device.reset()
        traffic = filter_traffic(rng, 20_000, 64, 48, ticks_per_event=0.5, longest_gap=4000, beyond=1)
        compare_with_reference(device, traffic, lambda batch: golden(device, batch, cell_px=0))


@pytest.mark.parametrize("side", SIDES)
def test_every_age_at_every_phase_of_the_stamps(side: int) -> None:
    """Two neighbours fire, any time apart, up to three turns of a stamp; then long enough silence for the next two."""
    device, most, turn = device_of(3 * side, 5 * side, side), FilterShape(cell_px=side).units_max, 1 << CELL_STAMP_W[side]
    choose(device, activity=most - 1)
    steps = np.unique([*range(0, 3 * turn, max(1, turn // 40)), *range(most - 3, most + 3), *range(turn - 2, turn + 3)])
    ages, phases = (axis.ravel() for axis in np.meshgrid(steps, np.arange(0, turn, max(1, turn // 32))))
    ticks = np.cumsum(np.stack([5 * turn + (phases - np.roll(phases, 1)) % turn, ages], axis=1).ravel())
    x = np.tile(np.array([side, 2 * side], np.uint16), len(ages))
    result = device.stream(ticked(ticks, x, x))
    assert not result[0::2].any()
    assert result[1::2].tolist() == (ages < most).tolist()


class TestClocks:
    """What the header claims."""

    @pytest.mark.parametrize("side", SIDES)
    def test_an_event_takes_1_clock_and_comes_out_after_14(self, side: int) -> None:
        device = device_of(346, 260, side, 20, 20)
        choose(device, refractory=1000, activity=3000, shift=10)
        traffic = filter_traffic(np.random.default_rng(1), 100_000, 346, 260, ticks_per_event=0.01)
        _, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {14}

    @pytest.mark.parametrize("side", SIDES)
    def test_reset_takes_a_clock_for_each_square_of_16_cells(self, side: int) -> None:
        device = device_of(346, 260, side, 20, 20)
        assert device.settled_after == -(-346 // (4 * side)) * -(-260 // (4 * side)) + 8

    def test_a_stream_without_a_free_clock_waits_for_one_walk_in_each_segment(self) -> None:
        n, device = 50_000, device_of(64, 48, 2, 8)
        choose(device, activity=80 << 4, shift=4)
        traffic = filter_traffic(np.random.default_rng(1), n, 64, 48, ticks_per_event=0.5, skips=0)
        _, times = device.stream_timed(traffic, traffic.keep)
        segments = traffic.ticks[-1] >> 4 + 4  # of 16 units
        assert segments == 97
        assert 0 < times.accepted[-1] - (n - 1) <= segments * (8 * 6 + 9)

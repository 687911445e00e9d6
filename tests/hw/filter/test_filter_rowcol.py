# SPDX-License-Identifier: Apache-2.0
"""filter_rowcol.v: stories, random traffic against model and rule, stamps that wrap, clocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.contract import FILTER_SHAPE_RANGES, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.filters.rowcol import RowColumnFilter
from evcot.hardware.contract import SHAPE_RANGES
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.filter_device import FilterDevice
from support.filter_trials import FilterTraffic, compare_with_reference, filter_traffic, parameters, run_story
from support.testing import lint
from support.tokens import ticked

TOP = "filter_rowcol"


def device_of(
    width: int, height: int, stamp_w: int, tick_w: int, ticks: int = 10, radius: int = 1, support: int = 1
) -> FilterDevice:
    ports = {"enable": 1, "rowcol_ticks": ticks, "rowcol_radius": radius, "rowcol_support": support}
    return FilterDevice(TOP, parameters(width, height, tick_w=tick_w, STAMP_W=stamp_w), ports)


def golden(device: FilterDevice, traffic: FilterTraffic) -> NDArray[np.bool_]:
    """What the model keeps, with the registers that the hardware has."""
    io, given = device.sim.io, device.model.parameters
    names = ("rowcol_ticks", "rowcol_radius", "rowcol_support")
    registers = FilterRegisters(**{name: int(io[name]) for name in names})
    keep = traffic.keep.copy()
    RowColumnFilter(registers, FilterShape(given["WIDTH"], given["HEIGHT"], given["STAMP_W"])).narrow(traffic, keep)
    return keep


def by_the_rule(traffic: FilterTraffic, width: int, height: int, ticks: int, radius: int, support: int) -> NDArray[np.bool_]:
    """docs/filters.md, event by event: the last event of each column and row is searched for among all before it."""
    x, y = traffic.x.astype(int), traffic.y.astype(int)
    reached = traffic.keep & (x < width) & (y < height)
    keep = np.zeros(len(x), np.bool_)
    for i in np.flatnonzero(reached):
        supporters = 0
        for line, along in ((x, y), (y, x)):
            for place in (line[i] - 1, line[i], line[i] + 1):
                there = np.flatnonzero(reached[:i] & (line[:i] == place))
                if len(there):
                    last = there[-1]
                    young = traffic.ticks[i] - traffic.ticks[last] <= ticks
                    elsewhere = (x[last], y[last]) != (x[i], y[i])
                    supporters += bool(young and elsewhere and abs(along[last] - along[i]) <= radius)
        keep[i] = supporters >= support
    return keep


@pytest.fixture(scope="module")
def small() -> FilterDevice:
    return device_of(9, 6, 6, 8)


class TestStories:
    @pytest.mark.parametrize("dx", range(-2, 3))
    @pytest.mark.parametrize("dy", range(-2, 3))
    def test_each_neighbour_supports_and_no_pixel_further_away(self, small: FilterDevice, dx: int, dy: int) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=1)
        for x in range(2, 7):
            for y in range(2, 4):
                supports = max(abs(dx), abs(dy)) == 1
                assert run_story(small, [(0, x + dx, y + dy), (3, x, y)]) == [False, supports]

    def test_the_radius_reaches_along_a_column_and_a_row_and_not_across(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=3, rowcol_support=1)
        for dx in range(-4, 5):
            for dy in range(-2, 4):
                supports = (dx, dy) != (0, 0) and ((abs(dx) <= 1 and abs(dy) <= 3) or (abs(dy) <= 1 and abs(dx) <= 3))
                assert run_story(small, [(0, 4 + dx, 2 + dy), (3, 4, 2)]) == [False, supports]

    def test_an_event_beside_supports_as_column_and_as_row(self, small: FilterDevice) -> None:
        for support, stays in ((2, True), (3, False)):
            small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=support)
            assert run_story(small, [(0, 3, 3), (1, 4, 3)]) == [False, stays]

    def test_as_many_rows_and_columns_as_asked_for(self, small: FilterDevice) -> None:
        corners = [(3, 2), (4, 2), (5, 3), (4, 4), (3, 3)]  # columns 3, 4, 5 and rows 2, 3, 4, the last of each near (4, 3)
        for support, stays in ((6, True), (7, False)):
            small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=support)
            assert run_story(small, [*[(0, *pixel) for pixel in corners], (5, 4, 3)])[-1] == stays

    def test_only_the_last_event_of_a_column_and_of_a_row_counts(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=1)
        assert run_story(small, [(0, 3, 3), (1, 4, 3)]) == [False, True]
        assert run_story(small, [(0, 3, 3), (0, 3, 0), (1, 4, 3)]) == [False, False, True]  # row 3 still holds it
        assert run_story(small, [(0, 3, 3), (0, 3, 0), (0, 8, 3), (1, 4, 3)]) == [False] * 4

    def test_the_pixel_itself_does_not_support_and_hides_what_was_before(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=1)
        assert run_story(small, [(0, 4, 3)] * 5) == [False] * 5

    @pytest.mark.parametrize("ticks", [0, 1, 7, 31])
    def test_up_to_the_oldest_age_and_not_beyond(self, small: FilterDevice, ticks: int) -> None:
        small.set(rowcol_ticks=ticks, rowcol_radius=1, rowcol_support=1)
        assert run_story(small, [(5, 4, 3), (5 + ticks, 5, 3)]) == [False, True]
        assert run_story(small, [(5, 4, 3), (5 + ticks + 1, 5, 3)]) == [False, False]

    @pytest.mark.parametrize("between", range(8))
    def test_an_event_soon_after_another_knows_it(self, small: FilterDevice, between: int) -> None:
        """However many slots are between them: in each, what was read is corrected by what is written meanwhile."""
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=2)
        others = [(0, 8, 0)] * between
        assert run_story(small, [(0, 3, 4), *others, (0, 4, 4)])[-1]
        assert run_story(small, [(0, 4, 3), *others, (0, 4, 4)])[-1]
        assert not run_story(small, [(0, 4, 3), *others, (0, 4, 0), (0, 4, 4)])[-1]

    def test_an_event_beyond_the_sensor_neither_stays_nor_supports(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=1)
        assert run_story(small, [(0, 9, 5), (0, 8, 6), (0, 9, 6), (0, 8, 5)]) == [False] * 4
        assert run_story(small, [(0, 8, 5), (0, 9, 4), (0, 8, 4)]) == [False, False, True]

    def test_disabled_it_hands_everything_on_and_remembers_nothing_but_time_passes(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=1)
        assert run_story(small, [(0, 3, 3)]) == [False]
        story = [  # tick, x, y, enable -> stays
            (4, 4, 3, 0, True),
            (5, 15, 7, 0, True),  # beyond the sensor
            (6, 5, 3, 1, False),
            (10, 2, 3, 1, True),  # column 3: 10 ticks after the first event
            (21, 1, 3, 1, False),
        ]
        for tick, x, y, enable, stays in story:
            small.set(enable=enable)
            result = small.stream(ticked(tick, x, y))
            assert result.tolist() == [stays], tick

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=10, rowcol_radius=1, rowcol_support=1)
        small.reset()
        assert small.stream(ticked(0, [3, 4, 5], 1, 1), np.array([True, False, True])).tolist() == [False] * 3

    def test_reset_forgets(self, small: FilterDevice) -> None:
        small.set(rowcol_ticks=31, rowcol_radius=15, rowcol_support=1)
        everywhere = [(0, x, y) for x in range(9) for y in range(6)]
        assert any(run_story(small, everywhere))
        for _, x, y in everywhere:
            assert run_story(small, [(0, x, y)]) == [False]


# (width, height, stamp_w, tick_w) -> runs, events in each
SHAPES = {
    (1, 1, 24, 20): (5, 5_000),
    (3, 5, 4, 1): (5, 10_000),
    (3, 5, 4, 8): (10, 10_000),
    (40, 2, 6, 8): (5, 20_000),
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
        rng = np.random.default_rng([2028, run])
        oldest = (1 << (stamp_w - 1)) - 1
        ticks = oldest if run % 3 == 0 else int(2 ** rng.uniform(0, stamp_w - 1)) - 1
        device.set(
            rowcol_ticks=ticks, rowcol_radius=int(rng.choice([1, 1, 2, 7, 15])), rowcol_support=int(rng.choice([1, 1, 2, 3, 6]))
        )
        device.reset()
        device.stalls = Stalls.random(rng) if run % 2 else Stalls()
        rate, gap = float(rng.choice([0, 0.1, 1, 5])), (1 << stamp_w + 2)
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=rate, longest_gap=gap, gaps=50 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: golden(device, batch), parts=1 + run % 3))
    print(f"{shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert width * height == 1 or 0.05 < np.mean(stayed) < 0.95


def test_the_rule_as_it_stands_gives_the_same() -> None:
    device = device_of(9, 6, 6, 8)
    for run, (ticks, radius, support) in enumerate([(0, 1, 1), (5, 2, 2), (31, 1, 3), (31, 4, 4), (31, 15, 6)]):
        device.set(rowcol_ticks=ticks, rowcol_radius=radius, rowcol_support=support)
        device.reset()
        traffic = filter_traffic(np.random.default_rng(run), 2_000, 9, 6, longest_gap=300, gaps=0.05, beyond=1)
        rule = 9, 6, ticks, radius, support
        kept = compare_with_reference(device, traffic, lambda batch, rule=rule: by_the_rule(batch, *rule))  # type: ignore[misc]
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

    def test_an_event_takes_1_clock_and_comes_out_after_10(self) -> None:
        traffic = filter_traffic(np.random.default_rng(1), 200_000, 346, 260, ticks_per_event=0.01)
        _, times = device_of(346, 260, 20, 20).stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {10}

    def test_reset_takes_a_clock_for_each_four_columns_or_rows(self) -> None:
        for width, height, *widths in SHAPES:
            assert device_of(width, height, *widths).settled_after == -(-max(width, height) // 4) + 8

    def test_where_one_clock_in_four_is_taken_the_walk_holds_no_event_up(self) -> None:
        n = 20_000
        device = device_of(64, 48, 12, 8)
        device.stalls = Stalls(source=np.array([1, 0, 0, 0], np.uint8))
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
        assert 0 < times.accepted[-1] - (n - 1) <= segments * (16 + 8)


@pytest.mark.parametrize("end", [0, 1], ids=["below", "above"])
@pytest.mark.parametrize("name", ["x_w", "y_w", "tick_w", "width", "height", "stamp_w"])
def test_refuses_parameters_out_of_range(name: str, end: int) -> None:
    low, high = (SHAPE_RANGES | FILTER_SHAPE_RANGES)[name][:2]
    code, log = lint(TOP, **{name.upper(): (low - 1, high + 1)[end]})
    assert code != 0
    assert f"{name.upper()}_must_be_{low}_to_{high}" in log


@pytest.mark.parametrize(
    "limits",
    [
        {"X_W": 1, "Y_W": 1, "TICK_W": 1, "WIDTH": 1, "HEIGHT": 1, "STAMP_W": 4},
        {"X_W": 16, "Y_W": 16, "TICK_W": 32, "WIDTH": 65536, "HEIGHT": 65536, "STAMP_W": 32},
        {"X_W": 3, "Y_W": 16, "TICK_W": 32, "WIDTH": 300, "HEIGHT": 6, "STAMP_W": 32},
    ],
)
def test_the_limits_themselves_lint_clean(limits: dict[str, int]) -> None:
    assert lint(TOP, **limits) == (0, "")

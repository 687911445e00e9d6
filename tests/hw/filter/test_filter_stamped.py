# SPDX-License-Identifier: Apache-2.0
"""filter_refractory.v, filter_activity.v, filter_rowcol.v: stories, random traffic against model and rule, stamps, clocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.activity import ActivityFilter
from evcot.filters.contract import FilterShape
from evcot.filters.refractory import RefractoryFilter
from evcot.filters.registers import FilterRegisters
from evcot.filters.rowcol import RowColumnFilter
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

Keep = NDArray[np.bool_]


@dataclass(frozen=True)
class Stamped:
    """What differs between the filters; sizes are of the sensor, `registers` those of the stories."""

    model: Callable[[FilterRegisters, FilterShape], ActivityFilter | RefractoryFilter | RowColumnFilter]
    rule: Callable[..., Keep]
    registers: dict[str, int]  # the first is a time in ticks
    choices: dict[str, list[int]]  # random values of the others
    rules: list[tuple[int, ...]]  # values for comparison with the rule
    latency: int
    reset: Callable[[int, int], int]
    walk: int  # clocks of a walk over 64 x 48 pixels

    @property
    def name(self) -> str:
        return next(iter(self.registers)).removesuffix("_ticks")

    def device(self, width: int, height: int, stamp_w: int, tick_w: int, **registers: int) -> FilterDevice:
        given = parameters(width, height, tick_w=tick_w, STAMP_W=stamp_w)
        return FilterDevice(f"filter_{self.name}", given, {"enable": 1} | self.registers | registers)

    def golden(self, device: FilterDevice, traffic: FilterTraffic) -> Keep:
        """What the model keeps, with the registers that the hardware has."""
        given = device.model.parameters
        registers = replace(FilterRegisters(), **{name: int(device.sim.io[name]) for name in self.registers})  # type: ignore[arg-type]
        keep = traffic.keep.copy()
        self.model(registers, FilterShape(given["WIDTH"], given["HEIGHT"], given["STAMP_W"])).narrow(traffic, keep)
        return keep


def refractory_rule(traffic: FilterTraffic, width: int, height: int, ticks: int) -> Keep:
    """docs/filters.md, event by event: each compared with all that stayed before it."""
    keep = np.zeros(len(traffic.x), np.bool_)
    for i in np.flatnonzero(traffic.keep & (traffic.x < width) & (traffic.y < height)):
        here = keep[:i] & (traffic.x[:i] == traffic.x[i]) & (traffic.y[:i] == traffic.y[i])
        keep[i] = not (here & (traffic.ticks[i] - traffic.ticks[:i] < ticks)).any()
    return keep


def activity_rule(traffic: FilterTraffic, width: int, height: int, ticks: int, support: int) -> Keep:
    """docs/filters.md, event by event: each compared with all before it."""
    x, y = traffic.x.astype(int), traffic.y.astype(int)
    reached = traffic.keep & (x < width) & (y < height)
    keep = np.zeros(len(x), np.bool_)
    for i in np.flatnonzero(reached):
        beside = np.maximum(abs(x[:i] - x[i]), abs(y[:i] - y[i])) == 1
        supporters = reached[:i] & beside & (traffic.ticks[i] - traffic.ticks[:i] <= ticks)
        keep[i] = len(np.unique(x[:i][supporters] * height + y[:i][supporters])) >= support
    return keep


def rowcol_rule(traffic: FilterTraffic, width: int, height: int, ticks: int, radius: int, support: int) -> Keep:
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


REFRACTORY = Stamped(
    RefractoryFilter, refractory_rule, {"refractory_ticks": 10}, {}, [(1,), (5,), (31,), (31,)],
    latency=7, reset=lambda width, height: width * height + 6, walk=64 * 48 + 6,
)  # fmt: skip
ACTIVITY = Stamped(
    ActivityFilter, activity_rule, {"activity_ticks": 10, "activity_support": 1}, {"activity_support": [1, 1, 2, 3, 8]},
    [(0, 1), (5, 2), (31, 3), (31, 1)],
    latency=8, reset=lambda width, height: -(-width // 4) * -(-height // 4) + 6, walk=192 + 6,
)  # fmt: skip
ROWCOL = Stamped(
    RowColumnFilter, rowcol_rule, {"rowcol_ticks": 10, "rowcol_radius": 1, "rowcol_support": 1},
    {"rowcol_radius": [1, 1, 2, 7, 15], "rowcol_support": [1, 1, 2, 3, 6]},
    [(0, 1, 1), (5, 2, 2), (31, 1, 3), (31, 4, 4), (31, 15, 6)],
    latency=10, reset=lambda width, height: -(-max(width, height) // 4) + 8, walk=16 + 8,
)  # fmt: skip
FILTERS = {one.name: one for one in (REFRACTORY, ACTIVITY, ROWCOL)}

# (width, height, stamp_w, tick_w) -> runs, events in each
SHAPES = {
    (1, 1, 24, 20): (5, 5_000),
    (3, 5, 4, 1): (5, 10_000),
    (3, 5, 4, 8): (10, 10_000),
    (40, 2, 6, 8): (5, 20_000),
    (64, 48, 12, 8): (10, 20_000),
    (346, 260, 20, 20): (6, 40_000),
}
EVERYWHERE = [(0, x, y) for x in range(9) for y in range(6)]


@pytest.fixture(params=FILTERS)
def which(request: pytest.FixtureRequest) -> Stamped:
    return FILTERS[request.param]


@pytest.fixture(scope="module")
def devices() -> dict[str, FilterDevice]:
    """Of each filter one for 9 x 6 pixels."""
    return {name: one.device(9, 6, 6, 8) for name, one in FILTERS.items()}


@pytest.fixture
def small(which: Stamped, devices: dict[str, FilterDevice]) -> FilterDevice:
    devices[which.name].set(enable=1, **which.registers)
    return devices[which.name]


def only(which: Stamped) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("which", [which], ids=[which.name])


@only(REFRACTORY)
class TestRefractory:
    def test_a_pixel_is_silent_after_an_event_that_stayed(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 4, 3), (5, 4, 3), (9, 4, 3), (10, 4, 3), (12, 4, 3), (19, 4, 3), (20, 4, 3)]) == [
            True, False, False, True, False, False, True,
        ]  # fmt: skip

    def test_an_event_that_does_not_stay_does_not_prolong_the_silence(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 4, 3), *[(9, 4, 3)] * 5, (10, 4, 3)]) == [True, *[False] * 5, True]

    def test_other_pixels_are_not_silenced(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=31)
        assert run_story(small, EVERYWHERE + EVERYWHERE) == [True] * 54 + [False] * 54

    @pytest.mark.parametrize("ticks", [1, 2, 17, 31])
    def test_for_as_many_ticks_as_the_register_says(self, small: FilterDevice, ticks: int) -> None:
        small.set(refractory_ticks=ticks)
        assert run_story(small, [(5, 4, 3), (5 + ticks - 1, 4, 3)]) == [True, False]
        assert run_story(small, [(5, 4, 3), (5 + ticks, 4, 3)]) == [True, True]

    @pytest.mark.parametrize("between", range(8))
    def test_an_event_soon_after_another_knows_what_became_of_that(self, small: FilterDevice, between: int) -> None:
        small.set(refractory_ticks=4)
        others, later = ([(tick, x, 5) for x in range(between)] for tick in (0, 4))
        assert run_story(small, [(0, 4, 3), *others, (0, 4, 3)]) == [True] * (between + 1) + [False]
        stay = [True, False, *[True] * between, True, False]
        assert run_story(small, [(0, 4, 3), (3, 4, 3), *later, (4, 4, 3), (4, 4, 3)]) == stay

    def test_an_event_beyond_the_sensor_does_not_stay(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 9, 2), (0, 8, 6), (0, 15, 7), (0, 0, 3), (0, 8, 5)]) == [False, False, False, True, True]

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        small.reset()
        result = small.stream(ticked(0, [3, 3, 3], 1, 1), np.array([False, True, True]))
        assert result.tolist() == [False, True, False]

    def test_reset_forgets(self, small: FilterDevice) -> None:
        small.set(refractory_ticks=31)
        for x in range(9):
            assert run_story(small, [(0, x, 4)]) == [True]
            assert run_story(small, [(0, x, 4)]) == [True]


@only(ACTIVITY)
class TestActivity:
    @pytest.mark.parametrize("dx", [-1, 0, 1])
    @pytest.mark.parametrize("dy", [-1, 0, 1])
    def test_each_neighbour_supports_and_the_pixel_itself_does_not(self, small: FilterDevice, dx: int, dy: int) -> None:
        for x in range(1, 8):
            for y in range(1, 5):
                assert run_story(small, [(0, x + dx, y + dy), (3, x, y)]) == [False, (dx, dy) != (0, 0)]

    def test_no_pixel_further_away_supports(self, small: FilterDevice) -> None:
        x, y = 4, 3
        ring = [(x + dx, y + dy) for dx in range(-2, 3) for dy in range(-2, 3) if max(abs(dx), abs(dy)) == 2]
        for other in ring:
            assert run_story(small, [(0, *other), (0, x, y)]) == [False, False]

    def test_nothing_comes_round_the_border(self, small: FilterDevice) -> None:
        for x, y in [(0, 0), (8, 0), (0, 5), (8, 5), (0, 3), (8, 3), (4, 0), (4, 5)]:
            far = [event for event in EVERYWHERE if max(abs(event[1] - x), abs(event[2] - y)) > 1]
            assert not run_story(small, [*far, (0, x, y)])[-1]

    def test_as_many_neighbours_as_asked_for(self, small: FilterDevice) -> None:
        around = [(3, 2), (4, 2), (5, 2), (3, 3), (5, 3), (3, 4), (4, 4), (5, 4)]
        for support in range(1, 9):
            small.set(activity_support=support)
            for n in range(9):
                events = [(5 * i // 8, *pixel) for i, pixel in enumerate(around[:n])]
                twice = [(9, *around[0])] * (n > 0)  # an event again is no second neighbour
                assert run_story(small, [*events, *twice, (10, 4, 3)])[-1] == (n >= support)

    def test_an_event_that_does_not_stay_is_remembered(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 2, 2), (20, 3, 2), (29, 4, 2), (31, 3, 2)]) == [False, False, True, True]

    def test_an_event_beyond_the_sensor_neither_stays_nor_supports(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 8, 5), (0, 9, 5), (0, 8, 6), (0, 9, 6), (0, 8, 4)]) == [False, False, False, False, True]
        assert run_story(small, [(0, 9, 3), (0, 8, 3), (0, 3, 6), (0, 3, 5), (0, 0, 4)]) == [False] * 5


@only(ROWCOL)
class TestRowcol:
    @pytest.mark.parametrize("dx", range(-2, 3))
    @pytest.mark.parametrize("dy", range(-2, 3))
    def test_each_neighbour_supports_and_no_pixel_further_away(self, small: FilterDevice, dx: int, dy: int) -> None:
        for x in range(2, 7):
            for y in range(2, 4):
                supports = max(abs(dx), abs(dy)) == 1
                assert run_story(small, [(0, x + dx, y + dy), (3, x, y)]) == [False, supports]

    def test_the_radius_reaches_along_a_column_and_a_row_and_not_across(self, small: FilterDevice) -> None:
        small.set(rowcol_radius=3)
        for dx in range(-4, 5):
            for dy in range(-2, 4):
                supports = (dx, dy) != (0, 0) and ((abs(dx) <= 1 and abs(dy) <= 3) or (abs(dy) <= 1 and abs(dx) <= 3))
                assert run_story(small, [(0, 4 + dx, 2 + dy), (3, 4, 2)]) == [False, supports]

    def test_an_event_beside_supports_as_column_and_as_row(self, small: FilterDevice) -> None:
        for support, stays in ((2, True), (3, False)):
            small.set(rowcol_support=support)
            assert run_story(small, [(0, 3, 3), (1, 4, 3)]) == [False, stays]

    def test_as_many_rows_and_columns_as_asked_for(self, small: FilterDevice) -> None:
        corners = [(3, 2), (4, 2), (5, 3), (4, 4), (3, 3)]  # columns 3, 4, 5 and rows 2, 3, 4, the last of each near (4, 3)
        for support, stays in ((6, True), (7, False)):
            small.set(rowcol_support=support)
            assert run_story(small, [*[(0, *pixel) for pixel in corners], (5, 4, 3)])[-1] == stays

    def test_only_the_last_event_of_a_column_and_of_a_row_counts(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 3, 3), (1, 4, 3)]) == [False, True]
        assert run_story(small, [(0, 3, 3), (0, 3, 0), (1, 4, 3)]) == [False, False, True]  # row 3 still holds it
        assert run_story(small, [(0, 3, 3), (0, 3, 0), (0, 8, 3), (1, 4, 3)]) == [False] * 4

    def test_the_pixel_itself_does_not_support_and_hides_what_was_before(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 4, 3)] * 5) == [False] * 5

    @pytest.mark.parametrize("between", range(8))
    def test_an_event_soon_after_another_knows_it(self, small: FilterDevice, between: int) -> None:
        """However many slots are between them: in each, what was read is corrected by what is written meanwhile."""
        small.set(rowcol_support=2)
        others = [(0, 8, 0)] * between
        assert run_story(small, [(0, 3, 4), *others, (0, 4, 4)])[-1]
        assert run_story(small, [(0, 4, 3), *others, (0, 4, 4)])[-1]
        assert not run_story(small, [(0, 4, 3), *others, (0, 4, 0), (0, 4, 4)])[-1]

    def test_an_event_beyond_the_sensor_neither_stays_nor_supports(self, small: FilterDevice) -> None:
        assert run_story(small, [(0, 9, 5), (0, 8, 6), (0, 9, 6), (0, 8, 5)]) == [False] * 4
        assert run_story(small, [(0, 8, 5), (0, 9, 4), (0, 8, 4)]) == [False, False, True]


@pytest.mark.parametrize("which", [ACTIVITY, ROWCOL], ids=["activity", "rowcol"])
class TestSupport:
    @pytest.mark.parametrize("ticks", [0, 1, 7, 31])
    def test_up_to_the_oldest_age_and_not_beyond(self, which: Stamped, small: FilterDevice, ticks: int) -> None:
        small.set(**{f"{which.name}_ticks": ticks})
        assert run_story(small, [(5, 4, 3), (5 + ticks, 5, 3)]) == [False, True]
        assert run_story(small, [(5, 4, 3), (5 + ticks + 1, 5, 3)]) == [False, False]

    def test_a_skipped_event_is_not_remembered(self, small: FilterDevice) -> None:
        small.reset()
        assert small.stream(ticked(0, [3, 4, 5], 1, 1), np.array([True, False, True])).tolist() == [False] * 3

    def test_reset_forgets(self, which: Stamped, small: FilterDevice) -> None:
        small.set(**{f"{which.name}_ticks": 31}, **({"rowcol_radius": 15} if which is ROWCOL else {}))
        assert any(run_story(small, EVERYWHERE))
        for _, x, y in EVERYWHERE:
            assert run_story(small, [(0, x, y)]) == [False]


# tick, x, y, enable -> stays; (3, 3) fired at tick 0, (15, 7) is beyond the sensor
DISABLED = {
    "refractory": [(4, 3, 3, 0, True), (5, 15, 7, 0, True), (9, 3, 3, 1, False), (10, 3, 3, 1, True), (11, 4, 3, 0, True),
                   (12, 4, 3, 1, True)],
    "activity": [(4, 4, 3, 0, True), (5, 15, 7, 0, True), (6, 5, 3, 1, False), (10, 2, 3, 1, True), (11, 2, 2, 0, True),
                 (21, 1, 3, 1, False)],
    "rowcol": [(4, 4, 3, 0, True), (5, 15, 7, 0, True), (6, 5, 3, 1, False), (10, 2, 3, 1, True), (21, 1, 3, 1, False)],
}  # fmt: skip


def test_disabled_filter_passes_events_and_remembers_none_while_time_passes(which: Stamped, small: FilterDevice) -> None:
    assert run_story(small, [(0, 3, 3)]) == [which is REFRACTORY]
    for tick, x, y, enable, stays in DISABLED[which.name]:
        small.set(enable=enable)
        assert small.stream(ticked(tick, x, y)).tolist() == [stays], tick


def test_reset_amid_events_leaves_nothing(which: Stamped) -> None:
    check_reset_amid_events(which.device(9, 6, 6, 8))


@pytest.mark.parametrize("shape", SHAPES)
def test_random_traffic_is_exact_under_stalls(which: Stamped, shape: tuple[int, int, int, int]) -> None:
    width, height, stamp_w, _ = shape
    runs, n = SHAPES[shape]
    device = which.device(*shape)
    stayed = []
    for run in range(runs):
        rng = np.random.default_rng([2026, run])
        longest = (1 << (stamp_w - 1)) - 1
        ticks = longest if run % 3 == 0 else int(2 ** rng.uniform(0, stamp_w - 1)) - 1
        chosen = {name: int(rng.choice(values)) for name, values in which.choices.items()}
        device.set(**{f"{which.name}_ticks": max(ticks, which is REFRACTORY)}, **chosen)
        device.reset()
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        rate, gap = float(rng.choice([0, 0.1, 1, 5])), (1 << stamp_w + 2)
        traffic = filter_traffic(rng, n, width, height, ticks_per_event=rate, longest_gap=gap, gaps=50 / n, beyond=1)
        stayed.append(compare_with_reference(device, traffic, lambda batch: which.golden(device, batch), parts=1 + run % 3))
    print(f"{which.name} {shape}: {runs * n} events, {np.mean(stayed):.2f} stay")
    assert width * height == 1 or 0.05 < np.mean(stayed) < 0.95


def test_the_rule_as_it_stands_gives_the_same(which: Stamped, small: FilterDevice) -> None:
    for run, values in enumerate(which.rules):
        small.set(**dict(zip(which.registers, values, strict=True)))
        small.reset()
        traffic = filter_traffic(np.random.default_rng(run), 2_000, 9, 6, longest_gap=300, gaps=0.05, beyond=1)
        wanted = which.rule(traffic, 9, 6, *values)
        assert 0.05 < compare_with_reference(small, traffic, lambda _, wanted=wanted: wanted) < 0.95  # type: ignore[misc]


@pytest.mark.parametrize("tick_w", [1, 8])
def test_every_age_at_every_phase_of_the_stamps(which: Stamped, tick_w: int) -> None:
    """Two events, any time apart, up to five turns of a 4-bit stamp; then long enough silence for the next two."""
    device = which.device(3, 5, 4, tick_w, **{f"{which.name}_ticks": 7})
    ages, phases = (axis.ravel() for axis in np.meshgrid(np.arange(81), np.arange(16)))
    ticks = np.cumsum(np.stack([90 + (phases - np.roll(phases, 1)) % 16, ages], axis=1).ravel())
    x = np.tile(np.array([1, 1 if which is REFRACTORY else 2], np.uint16), len(ages))
    first, second = device.stream(ticked(ticks, x, 1 if which is REFRACTORY else x)).reshape(-1, 2).T
    assert (first == (which is REFRACTORY)).all()
    assert second.tolist() == (ages >= 7 if which is REFRACTORY else ages <= 7).tolist()


class TestClocks:
    """What the headers claim."""

    def test_an_event_takes_one_clock_and_the_stated_latency(self, which: Stamped) -> None:
        traffic = filter_traffic(np.random.default_rng(1), 200_000, 346, 260, ticks_per_event=0.01)
        _, times = which.device(346, 260, 20, 20).stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {which.latency}

    @pytest.mark.parametrize("shape", SHAPES)
    def test_reset_takes_the_stated_clocks(self, which: Stamped, shape: tuple[int, int, int, int]) -> None:
        assert which.device(*shape).settled_after == which.reset(*shape[:2])

    def test_where_one_clock_in_four_is_taken_the_walk_holds_no_event_up(self, which: Stamped) -> None:
        device = which.device(64, 48, 12, 8)
        device.stall(Stalls(source=np.array([1, 0, 0, 0], np.uint8)))
        # 0.4 ticks an event: a segment of 1,024 ticks has 7,680 free clocks.
        traffic = filter_traffic(np.random.default_rng(1), 20_000, 64, 48, ticks_per_event=0.4)
        keep, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {4}
        assert np.array_equal(keep, which.golden(device, traffic))

    def test_a_stream_without_a_free_clock_waits_for_one_walk_in_each_segment(self, which: Stamped) -> None:
        n, device = 50_000, which.device(64, 48, 12, 8)
        traffic = filter_traffic(np.random.default_rng(1), n, 64, 48, ticks_per_event=0.5, skips=0)
        _, times = device.stream_timed(traffic, traffic.keep)
        segments = traffic.ticks[-1] // 1024
        assert segments == 24
        assert 0 < times.accepted[-1] - (n - 1) <= segments * which.walk


class TestParameters:
    """Ranges are checked by common lines, of which filter_rowcol is the example."""

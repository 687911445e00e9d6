# SPDX-License-Identifier: Apache-2.0
"""Each filter follows docs/filters.md: compared with rules in plain Python with a dict of events, on random traffic."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.filters.chain import FILTERS, FilterChain, Total
from evcot.filters.config import FilterConfig
from evcot.filters.contract import Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.filters.run import apply, filtered
from evcot.ticks import TickedEvents
from support.refusals import refused
from support.tokens import ticked

Pixel = tuple[int, int]
Rule = Callable[[int, int, int, int], bool]  # now, x, y, p -> stays

ALL = (1 << len(Filter)) - 1
SEEDS = range(4)
SENSORS = [(1, 1), (1, 7), (7, 1), (2, 2), (6, 5), (40, 30)]
END = 1 << 62


def registers(random: np.random.Generator, width: int, height: int) -> FilterRegisters:
    """Registers with which each filter passes some events and drops others, in traffic of one event every few ticks."""
    x0, x1 = sorted(random.integers(0, width, 2).tolist())
    y0, y1 = sorted(random.integers(0, height, 2).tolist())
    ranges = {
        "polarity": (0, 2), "refractory_ticks": (1, 60), "activity_ticks": (0, 60), "activity_support": (1, 4),
        "recent_ticks": (0, 60), "recent_radius": (1, 4), "recent_support": (1, 4), "decay_rate": (1 << 20, 1 << 24),
        "decay_epsilon": (0, 100), "decay_support": (1, 600), "rowcol_ticks": (0, 60), "rowcol_radius": (1, 4),
        "rowcol_support": (1, 4),
    }  # fmt: skip
    drawn: dict[str, Any] = {name: int(random.integers(*limits)) for name, limits in ranges.items()}
    hot = ((int(random.integers(0, width)), int(random.integers(0, height))),)
    return FilterRegisters(region_x0=x0, region_x1=x1, region_y0=y0, region_y1=y1, hot_pixels=hot, **drawn)


def traffic(random: np.random.Generator, width: int, height: int, count: int = 3000, start: int = 0) -> TickedEvents:
    """Random events: many at one tick, some after a silence longer than stamps of 32 bits, a few off the sensor."""
    gaps = random.choice([0, 0, 1, 2, 5, 50], count)
    gaps[random.integers(0, count, 3)] = 1 << 33
    x, y = random.integers(0, width, count), random.integers(0, height, count)
    outside = random.random(count) < 0.05
    x[outside] += random.integers(0, 2, np.count_nonzero(outside)) * width
    y[outside] += random.integers(0, 2, np.count_nonzero(outside)) * height
    return ticked(start + np.cumsum(gaps), x, y, random.integers(0, 2, count))


def neighbours(x: int, y: int) -> Iterator[Pixel]:
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            if (dx, dy) != (0, 0):
                yield x + dx, y + dy


def rule_of(which: Filter, regs: FilterRegisters, shape: FilterShape) -> Rule:
    """The rule of docs/filters.md, word for word, with unlimited memory."""
    then: dict[Pixel, int] = {}
    fifo: list[tuple[int, int, int]] = []
    columns: dict[int, tuple[int, Pixel]] = {}
    rows: dict[int, tuple[int, Pixel]] = {}

    def on_sensor(x: int, y: int) -> bool:
        return x < shape.width and y < shape.height

    def region(_now: int, x: int, y: int, _p: int) -> bool:
        return regs.region_x0 <= x <= regs.region_x1 and regs.region_y0 <= y <= regs.region_y1

    def polarity(_now: int, _x: int, _y: int, p: int) -> bool:
        return p == regs.polarity

    def mask(_now: int, x: int, y: int, _p: int) -> bool:
        return on_sensor(x, y) and (x, y) not in regs.hot_pixels

    def refractory(now: int, x: int, y: int, _p: int) -> bool:
        stays = on_sensor(x, y) and ((x, y) not in then or now - then[x, y] >= regs.refractory_ticks)
        if stays:
            then[x, y] = now
        return stays

    def activity(now: int, x: int, y: int, _p: int) -> bool:
        if not on_sensor(x, y):
            return False
        support = sum(now - then[pixel] <= regs.activity_ticks for pixel in neighbours(x, y) if pixel in then)
        then[x, y] = now
        return support >= regs.activity_support

    def recent(now: int, x: int, y: int, _p: int) -> bool:
        distances = [max(abs(x - a), abs(y - b)) for at, a, b in fifo[-shape.recent_depth :] if now - at <= regs.recent_ticks]
        fifo.append((now, x, y))
        return sum(1 <= distance <= regs.recent_radius for distance in distances) >= regs.recent_support

    def decay(now: int, x: int, y: int, _p: int) -> bool:
        if not on_sensor(x, y):
            return False
        unit = now * regs.decay_rate >> 24
        ages = [unit - then[pixel] for pixel in neighbours(x, y) if pixel in then]
        weights = [round(256 * 2 ** (-(age % 32) / 32)) >> age // 32 for age in ages]
        then[x, y] = unit
        return sum(weight for weight in weights if weight > regs.decay_epsilon) >= regs.decay_support

    def rowcol(now: int, x: int, y: int, _p: int) -> bool:
        if not on_sensor(x, y):
            return False
        last = [(columns.get(x + step), 1) for step in (-1, 0, 1)] + [(rows.get(y + step), 0) for step in (-1, 0, 1)]
        found = [(event, axis) for event, axis in last if event and now - event[0] <= regs.rowcol_ticks and event[1] != (x, y)]
        columns[x] = rows[y] = now, (x, y)
        return sum(abs(event[1][axis] - (x, y)[axis]) <= regs.rowcol_radius for event, axis in found) >= regs.rowcol_support

    return {
        Filter.REGION: region,
        Filter.POLARITY: polarity,
        Filter.MASK: mask,
        Filter.REFRACTORY: refractory,
        Filter.ACTIVITY: activity,
        Filter.RECENT: recent,
        Filter.DECAY: decay,
        Filter.ROWCOL: rowcol,
    }[which]


def decided(rules: list[Rule], events: TickedEvents) -> list[bool]:
    """What the rules say, each seeing only what those before it let stay."""
    columns = (column.tolist() for column in (events.ticks, events.x, events.y, events.p))
    return [all(rule(*event) for rule in rules) for event in zip(*columns, strict=True)]


@pytest.mark.parametrize("start", [0, END - (1 << 36)])
@pytest.mark.parametrize("size", SENSORS)
@pytest.mark.parametrize("which", Filter, ids=lambda which: which.name)
def test_a_filter_keeps_its_rule(which: Filter, size: Pixel, start: int) -> None:
    dropped = kept = 0
    for seed in SEEDS:
        random = np.random.default_rng(seed)
        shape = FilterShape(*size, recent_depth=int(random.integers(1, 40)))
        regs = registers(random, *size)
        events = traffic(random, *size, start=start)
        assert 0 <= events.ticks[0] <= events.ticks[-1] <= END
        wanted = decided([rule_of(which, regs, shape)], events)
        keep = FILTERS[which](regs, shape).feed(events)
        assert keep.dtype == np.bool_
        assert keep.tolist() == wanted, f"seed {seed}"
        dropped, kept = dropped + wanted.count(False), kept + wanted.count(True)
    assert dropped
    assert kept or (
        size == (1, 1) and which in (Filter.MASK, Filter.ACTIVITY, Filter.DECAY, Filter.ROWCOL)
    )  # a single pixel has no neighbour


@pytest.mark.parametrize("which", Filter, ids=lambda which: which.name)
def test_what_stays_does_not_depend_on_where_runs_are_cut(which: Filter) -> None:
    for seed in SEEDS:
        random = np.random.default_rng(seed)
        shape, regs = FilterShape(20, 15), registers(random, 20, 15)
        events = traffic(random, 20, 15)
        whole = FILTERS[which](regs, shape).feed(events)
        cuts = np.sort(random.integers(0, len(whole), 40)).tolist()  # some runs are empty
        one = FILTERS[which](regs, shape)
        parts = [one.feed(events[a:b]) for a, b in zip([0, *cuts], [*cuts, None], strict=True)]
        np.testing.assert_array_equal(np.concatenate(parts), whole, f"seed {seed}")


@pytest.mark.parametrize("which", Filter, ids=lambda which: which.name)
def test_the_first_event_of_all_may_come_at_the_last_tick(which: Filter) -> None:
    """An empty memory entry is never taken for a recent event, or for one in the future."""
    regs = FilterRegisters(
        refractory_ticks=(1 << 31) - 1,
        activity_ticks=(1 << 31) - 1,
        recent_ticks=(1 << 31) - 1,
        decay_rate=1 << 24,
        rowcol_ticks=(1 << 31) - 1,
    )
    keep = FILTERS[which](regs, FilterShape(1, 1, stamp_w=32)).feed(ticked(END, 0, 0, 1))
    assert keep[0] == (which not in (Filter.ACTIVITY, Filter.RECENT, Filter.DECAY, Filter.ROWCOL))


@pytest.mark.parametrize("depth", [1, 2, 31, 32, 256])
def test_the_fifo_holds_the_last_events_and_no_more(depth: int) -> None:
    """One event, then others far away that push it out, then its neighbour."""
    regs = FilterRegisters(recent_ticks=1000)
    for others in (depth - 1, depth):
        count = others + 2
        x = np.full(count, 900, np.uint16)
        x[0], x[-1] = 10, 11
        fifo = FILTERS[Filter.RECENT](regs, FilterShape(1000, 1, recent_depth=depth))
        assert fifo.feed(ticked(0, x, 0))[-1] == (others < depth)


class TestChain:
    @pytest.mark.parametrize("size", SENSORS)
    def test_each_filter_sees_what_those_before_it_let_stay(self, size: Pixel) -> None:
        for seed in range(12):
            random = np.random.default_rng(seed)
            shape = FilterShape(*size)
            regs = replace(registers(random, *size), enable=int(random.integers(0, ALL + 1)), region_x0=0, region_y0=0)
            events = traffic(random, *size)
            rules = [rule_of(which, regs, shape) for which in Filter if regs.enable >> which & 1]
            keep = FilterChain(regs, shape).feed(events)
            assert keep.tolist() == decided(rules, events), f"seed {seed}"

    def test_with_nothing_enabled_everything_stays(self) -> None:
        chain = FilterChain(FilterRegisters(), FilterShape(4, 4))
        assert chain.feed(traffic(np.random.default_rng(1), 4, 4)).all()
        assert chain.totals == {}
        assert apply(recording(), FilterConfig())[1].all()

    def test_totals_say_what_each_filter_saw_and_dropped(self) -> None:
        random = np.random.default_rng(5)
        regs = replace(registers(random, 20, 15), enable=ALL, region_x0=0, region_y0=0)
        chain = FilterChain(regs, FilterShape(20, 15))
        events = traffic(random, 20, 15)
        kept = sum(np.count_nonzero(chain.feed(part)) for part in (events[:700], events[700:]))
        assert list(chain.totals) == list(Filter)
        left = len(events.x)
        for total in chain.totals.values():
            assert total.seen == left
            left -= total.dropped
        assert left == kept
        alone = FILTERS[Filter.REGION](regs, FilterShape(20, 15)).feed(events)
        assert chain.totals[Filter.REGION] == Total(3000, 3000 - np.count_nonzero(alone))

    def test_events_that_were_dropped_before_do_not_reach_it(self) -> None:
        """A filter behind others has the memory of a filter that is fed their survivors alone."""
        random = np.random.default_rng(6)
        events = traffic(random, 9, 9)
        before = random.random(len(events.x)) < 0.5
        for which in Filter:
            regs = registers(np.random.default_rng(7), 9, 9)
            keep = before.copy()
            FILTERS[which](regs, FilterShape(9, 9)).narrow(events, keep)
            alone = FILTERS[which](regs, FilterShape(9, 9)).feed(events[before])
            np.testing.assert_array_equal(keep[before], alone, which.name)
            assert not keep[~before].any()

    @pytest.mark.parametrize(
        ("changed", "message"),
        [
            ({"refractory_ticks": 0}, "filters.refractory_ticks = 0: must be an integer from 1 to 127 (ticks for which "),
            ({"activity_ticks": 128}, "filters.activity_ticks = 128: must be an integer from 0 to 127 (oldest neighbour "),
            ({"decay_support": 2049}, "filters.decay_support = 2049: must be an integer from 1 to 2048 (sum of weights "),
            ({"recent_radius": 1.0}, "filters.recent_radius = 1.0: must be an integer from 1 to 15 (how near "),
            ({"hot_pixels": ((4, 0),)}, "filters.hot_pixels holds (4, 0): must lie on the 4x3 sensor"),
            ({"hot_pixels": ((0, 3),)}, "filters.hot_pixels holds (0, 3): must lie on the 4x3 sensor"),
        ],
    )
    def test_registers_have_limits(self, changed: dict[str, int], message: str) -> None:
        with refused(ConfigError, start=message):
            FilterChain(replace(FilterRegisters(), **changed), FilterShape(4, 3, stamp_w=8))  # type: ignore[arg-type]

    @pytest.mark.parametrize("which", [Filter.MASK, Filter.REFRACTORY, Filter.ACTIVITY, Filter.DECAY], ids=lambda f: f.name)
    def test_a_sensor_of_gigapixels_is_a_mistake(self, which: Filter) -> None:
        with pytest.raises(ConfigError, match=r"^sensor 65536x65536: filters remember at most 33554432 pixels$"):
            FilterChain(FilterRegisters(enable=1 << which), FilterShape(65536, 65536))


EPOCH_US = 1_718_925_184_590_631
CONFIG = FilterConfig(hot_pixels=((3, 3),), activity_us=3_000, refractory_us=1_000)


def recording(count: int = 2000) -> Recording:
    random = np.random.default_rng(4)
    x, y = (random.integers(0, 16, count).astype(np.uint16) for _ in range(2))
    t_us = EPOCH_US + np.sort(random.integers(0, 100_000, count))
    return Recording(Events(t_us, x, y, random.integers(0, 2, count).astype(np.uint8)), 16, 16, "random")


def test_a_recording_keeps_its_name_and_the_events_that_stay() -> None:
    whole = recording()
    part, keep = apply(whole, CONFIG)
    assert 0 < len(part.events) == np.count_nonzero(keep) < len(whole.events)
    assert (part.width, part.height, part.name) == (16, 16, "random")
    for name in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(part.events, name), getattr(whole.events, name)[keep])


def test_in_blocks_as_in_one_piece_with_totals() -> None:
    whole = recording()
    blocks = [Events.empty(), *(whole.events[begin : begin + 137] for begin in range(0, 2000, 137))]
    run = filtered(iter(blocks), CONFIG, (16, 16))
    assert run.totals == {Filter.MASK: Total(0, 0), Filter.REFRACTORY: Total(0, 0), Filter.ACTIVITY: Total(0, 0)}
    got, wanted = Events.joined(run), apply(whole, CONFIG)[0].events
    for name in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(got, name), getattr(wanted, name))
    seen = [total.seen for total in run.totals.values()]
    dropped = [total.dropped for total in run.totals.values()]
    assert seen == [2000, 2000 - dropped[0], 2000 - dropped[0] - dropped[1]]
    assert sum(dropped) == 2000 - len(got)
    assert dropped[0] == np.count_nonzero((whole.events.x == 3) & (whole.events.y == 3))


def test_ticks_count_from_the_first_event() -> None:
    """Two events of one pixel 900 us apart lie 1 tick of 1 ms apart when the first is 200 us after the first event of all."""
    events = Events(
        EPOCH_US + np.array([0, 200, 1100]), np.array([9, 1, 1], np.uint16), np.zeros(3, np.uint16), np.zeros(3, np.uint8)
    )
    config = FilterConfig(refractory_us=1_000)
    assert apply(Recording(events, 16, 16), config, tick_us=1_000)[1].tolist() == [True, True, True]
    assert apply(Recording(events, 16, 16), config, tick_us=1)[1].tolist() == [True, True, False]


def test_what_does_not_fit_is_refused_before_the_first_event() -> None:
    with pytest.raises(ConfigError, match=r"^filters\.hot_pixels holds \(3, 3\): must lie on the 3x3 sensor$"):
        filtered((), CONFIG, (3, 3))
    with pytest.raises(ConfigError, match=r"^filters\.refractory_us = 1000: must be from 2000 to "):
        filtered((), CONFIG, (16, 16), tick_us=2_000)

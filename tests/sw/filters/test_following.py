# SPDX-License-Identifier: Apache-2.0
"""Filters that follow the stream: the activity filter by the noise, and pixels that never rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.filters.chain import FilterChain
from evcot.filters.config import FilterConfig
from evcot.filters.contract import Filter
from evcot.filters.following import FollowingChain
from evcot.filters.noise import WINDOW_US
from evcot.filters.run import filtered
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig

SENSOR = 128, 96
FOLLOW = FilterConfig(refractory_us=1_000, activity_us=40_000, activity_noise_hz=0.03)
SEED = 4711


def chain(config: FilterConfig = FOLLOW) -> FollowingChain:
    return FollowingChain(config.registers(1), config.shape(*SENSOR), config.activity_noise_hz, 1)


def noise(noise_hz: float, lasts_us: int, begin_us: int = 0) -> TickedEvents:
    random = np.random.default_rng(SEED)
    count = random.poisson(noise_hz * 1e-6 * lasts_us * SENSOR[0] * SENSOR[1])
    ticks = begin_us + np.sort(random.integers(lasts_us, size=count))
    x, y = random.integers(SENSOR[0], size=count), random.integers(SENSOR[1], size=count)
    return TickedEvents(ticks, x.astype(np.uint16), y.astype(np.uint16), np.ones(count, np.uint8))


def joined(*parts: TickedEvents) -> TickedEvents:
    columns = [np.concatenate([getattr(part, name) for part in parts]) for name in ("ticks", "x", "y", "p")]
    order = np.argsort(columns[0], kind="stable")
    return TickedEvents(*(column[order] for column in columns))


def repeated(x: int, y: int, period_us: int, lasts_us: int) -> TickedEvents:
    ticks = np.arange(0, lasts_us, period_us)
    return TickedEvents(
        ticks, np.full(len(ticks), x, np.uint16), np.full(len(ticks), y, np.uint16), np.ones(len(ticks), np.uint8)
    )


@pytest.mark.parametrize("noise_hz", [0.1, 1.0, 3.0])
def test_no_more_noise_passes_than_asked_for_whatever_its_rate(noise_hz: float) -> None:
    lasts_us = 5_000_000
    keep = chain().feed(noise(noise_hz, lasts_us))
    passing_hz = np.count_nonzero(keep) / (1e-6 * lasts_us * SENSOR[0] * SENSOR[1])
    assert passing_hz <= 1.25 * FOLLOW.activity_noise_hz


def test_neighbours_follow_a_noise_that_changes() -> None:
    follows = chain()
    follows.feed(noise(0.005, 1_000_000))
    quiet = follows.support
    follows.feed(noise(3.0, 1_000_000, 1_000_000))
    loud = follows.support
    follows.feed(noise(0.005, 3_000_000, 2_000_000))
    assert (quiet, loud, follows.support) == (0, 5, 0)


def test_a_silence_is_windows_without_noise() -> None:
    follows = chain()
    follows.feed(noise(3.0, 1_000_000))
    before = follows.noise_hz
    follows.feed(joined(*(replace_times(repeated(5, 5, 1, 1), t_us) for t_us in (3_000_000, 3_000_001, 3_000_002))))
    assert before is not None
    assert follows.noise_hz == pytest.approx(before * 0.95**100, rel=0.3)


def test_a_neighbour_counts_up_to_the_time_of_the_filter_and_no_longer() -> None:
    pair = joined(repeated(5, 5, 1, 1), replace_times(repeated(6, 5, 1, 1), FOLLOW.activity_us))
    late = joined(repeated(5, 5, 1, 1), replace_times(repeated(6, 5, 1, 1), FOLLOW.activity_us + 1))
    for events, passes in ((pair, True), (late, False)):
        follows = chain(replace(FOLLOW, activity_noise_hz=0.12))
        begins = noise(0.5, 1_000_000)
        follows.feed(begins)
        assert follows.support == 1
        keep = follows.feed(replace_times(events, 1_100_000))
        assert keep.tolist() == [False, passes]


def test_nothing_passes_before_the_noise_is_known() -> None:
    follows = chain()
    events = noise(0.02, 3 * WINDOW_US)
    keep = follows.feed(events)
    assert not keep[events.ticks < WINDOW_US].any()
    assert keep[events.ticks >= WINDOW_US].all(), "of so little noise each event may pass"
    assert chain().support is None


def test_with_a_noise_that_holds_it_is_the_chain_with_that_support() -> None:
    follows, events = chain(), noise(1.3, 2_000_000)
    keep = follows.feed(events)
    late = events.ticks >= 500_000
    support = follows.support
    assert support is not None
    held = replace(FOLLOW, activity_noise_hz=0.0, activity_support=support)
    wanted = FilterChain(held.registers(1), held.shape(*SENSOR)).feed(events)
    assert np.array_equal(keep[late], wanted[late])
    assert wanted[late].any()


def test_the_other_filters_stand_before_and_behind_it() -> None:
    every = replace(
        FOLLOW,
        region=(3, 0, 100, 90),
        polarity="on",
        hot_pixels=((7, 8),),
        activity_noise_hz=0.2,
        recent_us=40_000,
        decay_tau_us=20_000.0,
        rowcol_us=40_000,
    )
    follows, events = chain(every), noise(1.3, 2_000_000)
    events = TickedEvents(events.ticks, events.x, events.y, (np.arange(len(events)) % 3 > 0).astype(np.uint8))
    keep = follows.feed(events)
    late = events.ticks >= 500_000
    support = follows.support
    assert support is not None
    held = replace(every, activity_noise_hz=0.0, activity_support=support)
    fixed = FilterChain(held.registers(1), held.shape(*SENSOR))
    wanted = fixed.feed(events)
    assert np.array_equal(keep[late], wanted[late])
    assert wanted[late].any()
    assert list(follows.totals) == list(Filter)
    for which in (Filter.REGION, Filter.POLARITY, Filter.MASK, Filter.REFRACTORY):
        assert follows.totals[which] == fixed.totals[which]
        assert follows.totals[which].dropped > 0
    seen = [total.seen for total in follows.totals.values()]
    dropped = [total.dropped for total in follows.totals.values()]
    assert seen == [len(events), *(total - less for total, less in zip(seen, dropped, strict=True))][: len(seen)]


def test_without_a_refractory_filter_there_is_none() -> None:
    config = replace(FOLLOW, refractory_us=0)
    follows, events = chain(config), repeated(5, 5, 1, 100)
    follows.feed(joined(events, events, noise(0.02, 100)))
    assert list(follows.totals) == [Filter.MASK, Filter.ACTIVITY]
    assert follows.totals[Filter.ACTIVITY].seen >= 2 * len(events), "two in one tick among them"


def test_a_pixel_that_never_rests_is_masked_after_ten_epochs_and_passes_again_once_it_rests() -> None:
    hot, around = (40, 30), noise(0.005, 4_000_000)
    events = joined(around, repeated(*hot, 5_000, 2_000_000), replace_times(repeated(*hot, 1_000_000, 1_000_000), 3_500_000))
    follows = chain()
    keep = follows.feed(events)
    there = (events.x == hot[0]) & (events.y == hot[1])
    begins = there & (events.ticks > WINDOW_US) & (events.ticks < 600_000)
    assert keep[begins].all()
    assert not keep[there & (events.ticks > 800_000) & (events.ticks < 2_000_000)].any()
    assert keep[there & (events.ticks == 3_500_000)].all()
    assert not follows.restless.any()
    assert follows.totals[Filter.MASK].dropped == np.count_nonzero(there & ~keep & (events.ticks > 600_000))


def replace_times(events: TickedEvents, by_us: int) -> TickedEvents:
    return TickedEvents(events.ticks + by_us, events.x, events.y, events.p)


def test_hot_pixels_that_are_known_are_masked_from_the_first_event_on() -> None:
    events = joined(noise(0.02, 400_000), repeated(7, 8, 5_000, 400_000))
    keep = chain(replace(FOLLOW, hot_pixels=((7, 8),))).feed(events)
    assert not keep[(events.x == 7) & (events.y == 8)].any()


def test_only_events_that_reach_the_mask_are_noise() -> None:
    region = replace(FOLLOW, region=(0, 0, 63, 95))  # half of the sensor
    everywhere, there = chain(), chain(region)
    events = noise(1.0, 1_000_000)
    everywhere.feed(events)
    there.feed(events)
    assert everywhere.noise_hz is not None
    assert there.noise_hz is not None
    assert there.noise_hz < 0.7 * everywhere.noise_hz


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_it_does_not_depend_on_how_events_are_split_into_runs(size: int) -> None:
    events = joined(noise(1.0, 400_000), repeated(40, 30, 5_000, 400_000))
    events = events[: 20 * size] if size < 50 else events
    runs = chain()
    parts: list[NDArray[np.bool_]] = [runs.feed(events[begin : begin + size]) for begin in range(0, len(events), size)]
    assert np.array_equal(np.concatenate(parts), chain().feed(events))


def test_in_other_ticks_windows_last_as_long() -> None:
    config = replace(FOLLOW, refractory_us=1_000)
    events = noise(1.0, 1_000_000)
    coarse = TickedEvents(events.ticks // 1_000, events.x, events.y, events.p)
    of_ms = FollowingChain(config.registers(1_000), config.shape(*SENSOR), config.activity_noise_hz, 1_000)
    for begin in range(0, len(coarse), 1_000):
        of_ms.feed(coarse[begin : begin + 1_000])
    of_us = chain()
    of_us.feed(events)
    assert of_ms.noise_hz == pytest.approx(of_us.noise_hz)
    assert of_ms.support == of_us.support


def test_filtering_a_recording_uses_it() -> None:
    ticked = noise(1.0, 500_000)
    events = Events(ticked.ticks + 77, ticked.x, ticked.y, ticked.p)
    assert np.array_equal(filtered((), FOLLOW, SENSOR).keep(events), chain().feed(ticked))


def test_hardware_refuses_it() -> None:
    with pytest.raises(ConfigError, match=r"filters.activity_noise_hz = 0.03: must be 0 in hardware, whose registers hold"):
        RunConfig(filters=FOLLOW).device_config(*SENSOR)

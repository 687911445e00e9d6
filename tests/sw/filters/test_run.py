# SPDX-License-Identifier: Apache-2.0
"""Filters over recordings, whole and in blocks."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.filters.chain import Total
from evcot.filters.config import FilterConfig
from evcot.filters.contract import Filter
from evcot.filters.run import apply, filtered

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


def test_with_all_filters_off_every_event_stays() -> None:
    whole = recording()
    part, keep = apply(whole, FilterConfig())
    assert keep.all()
    assert len(part.events) == len(whole.events)


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

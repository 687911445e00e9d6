# SPDX-License-Identifier: Apache-2.0
"""The bounded queue between two threads, and statistics of durations."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from evcot_cosim.live.queues import Arrival, Latency, Taken, Waiting

from .stories import events


def arrival(count: int, age_s: float = 0.0) -> Arrival:
    return Arrival(events(*range(count)), time.perf_counter() - age_s)


def taken(waiting: Waiting[Arrival], most: int | None = None) -> Taken[Arrival]:
    got = waiting.take(most=most)
    assert got is not None
    return got


def test_what_was_put_comes_in_turn() -> None:
    waiting: Waiting[Arrival] = Waiting(10, 100)
    put = [arrival(n) for n in (3, 4, 5)]
    for each in put:
        waiting.put(each)
    assert taken(waiting, most=1) == Taken(0, put[:1])
    assert taken(waiting) == Taken(0, put[1:])
    assert taken(waiting) == Taken(0, [])


def test_of_too_many_events_the_oldest_are_given_up_and_counted_once() -> None:
    waiting: Waiting[Arrival] = Waiting(10, 10)
    put = [arrival(4) for _ in range(5)]
    for each in put:
        waiting.put(each)
    assert taken(waiting) == Taken(12, put[3:])
    assert waiting.lost == 12
    waiting.put(put[0])
    assert taken(waiting) == Taken(0, put[:1])


def test_what_has_waited_too_long_is_given_up_as_long_as_there_is_something_newer() -> None:
    waiting: Waiting[Arrival] = Waiting(0.5, 100)
    for age_s in (2.0, 1.0):
        waiting.put(arrival(2, age_s))
    newest = arrival(3, 0.9)
    waiting.put(newest)
    assert taken(waiting) == Taken(4, [newest])


def test_one_item_larger_than_all_the_room_still_passes() -> None:
    waiting: Waiting[Arrival] = Waiting(10, 5)
    waiting.put(arrival(50))
    assert len(taken(waiting).items[0].events) == 50


def test_closed_it_gives_what_is_left_and_then_nothing() -> None:
    waiting: Waiting[Arrival] = Waiting(10, 5)
    last = arrival(1)
    waiting.put(last)
    waiting.close()
    assert taken(waiting) == Taken(0, [last])
    assert waiting.take(timeout_s=10) is None


def test_one_who_waits_is_woken() -> None:
    waiting: Waiting[Arrival] = Waiting(10, 5)
    put = arrival(1)
    threading.Timer(0.1, waiting.put, [put]).start()
    assert waiting.take(timeout_s=10) == Taken(0, [put])
    threading.Timer(0.1, waiting.close).start()
    assert waiting.take(timeout_s=10) is None


def test_before_the_first_nothing_is_known() -> None:
    assert Latency().recent_ms(0.5) is None
    assert Latency().overall_ms(0.5) is None


def test_quantiles() -> None:
    latency = Latency()
    durations_s = np.random.default_rng(1).lognormal(-4, 1, 20_000)
    for part in np.split(durations_s, 100):
        latency.add(part)
    for share in (0.5, 0.99):
        assert latency.recent_ms(share) == pytest.approx(1e3 * np.quantile(durations_s[-2_000:], share))
        assert latency.overall_ms(share) == pytest.approx(1e3 * np.quantile(durations_s, share), rel=0.02)


def test_what_no_clock_can_mean_stays_in_range() -> None:
    latency = Latency()
    latency.add(np.array([-1.0, 0.0, 1e9]))
    assert latency.overall_ms(0.3) == pytest.approx(1e-3, rel=0.02)
    assert latency.overall_ms(1.0) == pytest.approx(1e6, rel=0.02)

# SPDX-License-Identifier: Apache-2.0
"""Queues, frames and messages: the newest event of each pixel, and bytes at the offsets of the documented layout."""

from __future__ import annotations

import json
import struct
import threading
import time
from typing import Any

import numpy as np
import pytest

from evcot.events import Events
from evcot.scenes.registry import simulate_scene
from evcot.trackers.rct.config import PRESETS
from evcot.trackers.rct.tracker import track
from evcot.tracks.log import DROPPED, TRACK, Kind
from evcot.tracks.timeline import sample
from evcot_cosim.live.messages import FrameMaker, drawn_number, pack_frame, wish_in
from evcot_cosim.live.player import Wish
from evcot_cosim.live.queues import Arrival, Latency, Taken, Waiting
from evcot_cosim.live.session import Step
from evcot_cosim.live.visible_clusters import Alive, Clusters
from support.logs import verdicts_of

from .stories import SENSOR, events, random_events, record


def step(some: Events, owner: int = -1, arrived_s: float = 0.0) -> Step:
    return Step(some, np.full(len(some), owner, np.int16), arrived_s)


def test_a_frame_has_the_newest_event_of_every_pixel() -> None:
    maker = FrameMaker(SENSOR)
    for seed in range(3):
        some = [random_events(4_000, 10 * seed + i) for i in range(2)]
        later = Events(some[1].t_us + 1_000_000, some[1].x, some[1].y, some[1].p)
        frame = maker.make([step(some[0], arrived_s=1), step(later, arrived_s=2)], Clusters())
        whole = Events.joined([some[0], later])
        newest = {(int(x), int(y)): i for i, (x, y) in enumerate(zip(whole.x, whole.y, strict=True))}
        chosen = sorted(newest.values())
        assert len(chosen) < 64 * 48
        assert np.array_equal(frame.events_t_us, whole.t_us[chosen])
        assert np.array_equal(frame.on, whole.p[chosen] == 1)
        assert (frame.number, frame.hidden, frame.t_us) == (seed, 8_000 - len(chosen), int(whole.t_us[-1]))
        assert frame.arrived_s.tolist() == [1, 2]


def test_the_layout() -> None:
    alive = Alive({4: "cup"})
    one, other = record(Kind.BORN, 1_000, 0, 5, x=1), record(Kind.BORN, 2_000, 0, (1 << 32) + 6, x=7.5)
    other["angle"], other["vx"], other["vy"], other["confidence"] = 0.5, -20, 30, 0.75
    alive.apply(np.concatenate([one, other]), verdicts_of((1_500, 5, 4)))
    some = Events.joined([events(10_000, x=1, y=2), events(20_000, x=3, y=4), events(30_000, x=63, y=47)])
    on = Events(some.t_us, some.x, some.y, np.array([1, 0, 1], np.uint8))
    below = Alive()
    below.apply(other)
    frame = FrameMaker(SENSOR, 7).make([step(on[:2]), step(on[2:], DROPPED)], alive.clusters, [Clusters(), below.clusters])
    data = pack_frame(frame, 5_000)
    assert data[0] == 1
    assert struct.unpack_from("<BHIII", data, 1) == (4, 3, 7, 3, 0)
    t_us, unit_us, zero = struct.unpack_from("<dfI", data, 16)
    assert (t_us, zero) == (25_000, 0)
    assert struct.unpack_from("<I9fII", data, 32) == (5, 1, 5, 7, 5, 0, 0, 0, 0, pytest.approx(0.029), 0, 2)
    assert struct.unpack_from("<I9fII", data, 80) == (6, 7.5, 5, 7, 5, 0.5, -20, 30, 0.75, pytest.approx(0.028), 0, 0)
    assert struct.unpack_from("<I9fII", data, 128)[-2:] == (2, 0), "of the second tracker beside it"
    x, y, age = (np.frombuffer(data, "<u2", 3, 176 + 8 * i) for i in range(3))
    assert (x.tolist(), y.tolist()) == ([1, 3, 63], [2, 4, 47])
    assert age * unit_us == pytest.approx([20_000, 10_000, 0], abs=1)
    assert list(data[200:203]) == [1, 0, 3]
    assert len(data) == 204


def test_ages_are_as_fine_as_the_frame_is_short() -> None:
    for span_us in (3, 1_000, 30_000_000):
        frame = FrameMaker(SENSOR).make(
            [step(Events.joined([events(0, x=1), events(span_us // 3, x=2), events(span_us, x=3)]))], Clusters()
        )
        data = pack_frame(frame, 0)
        unit_us = struct.unpack_from("<f", data, 24)[0]
        age_us = np.frombuffer(data, "<u2", 3, 32 + 16) * unit_us
        assert age_us == pytest.approx([span_us, span_us - span_us // 3, 0], abs=span_us / 60_000)


def test_an_answer() -> None:
    assert drawn_number(struct.pack("<B3xI", 2, 77)) == 77
    for other in ("2", b"", struct.pack("<B3xI", 1, 77), struct.pack("<B3xIx", 2, 77)):
        assert drawn_number(other) is None


PLAY: dict[str, Any] = {"type": "play", "engine": "rct", "preset": "plain", "hardware": True, "at_s": 1.5}


def test_a_wish() -> None:
    assert wish_in(json.dumps(PLAY)) == Wish("rct", "plain", True, 1.5)
    assert wish_in(json.dumps({**PLAY, "preset": None, "at_s": 0})) == Wish("rct", None, True, 0.0)


@pytest.mark.parametrize(
    "change",
    [
        {"type": "stop"}, {"engine": 1}, {"engine": None}, {"preset": ["plain"]}, {"hardware": 1}, {"hardware": None},
        {"at_s": None}, {"at_s": "1"}, {"at_s": True}, {"at_s": -0.1}, {"at_s": 1e10}, {"at_s": float("nan")},
        {"at_s": float("inf")}, {"save": "a.raw"},
    ],
)  # fmt: skip
def test_what_is_no_wish(change: dict[str, Any]) -> None:
    assert wish_in(json.dumps({**PLAY, **change})) is None


@pytest.mark.parametrize("text", ["", "play", "[]", "null", "1", "{}", "[" * 200, json.dumps(PLAY)[:-1]])
def test_what_is_no_message(text: str) -> None:
    assert wish_in(text) is None


@pytest.mark.parametrize("missing", PLAY)
def test_a_wish_says_all(missing: str) -> None:
    assert wish_in(json.dumps({key: value for key, value in PLAY.items() if key != missing})) is None


def test_a_life() -> None:
    alive = Alive()
    alive.apply(record(Kind.BORN, 100, 0, 7, x=1))
    assert (alive.clusters.states["track_id"].tolist(), alive.clusters.birth_us.tolist()) == ([7], [100])
    alive.apply(
        np.concatenate([record(Kind.MOVED, 110, 1, 7, x=2), record(Kind.BORN, 120, 2, 3), record(Kind.MOVED, 130, 3, 7, x=4)])
    )
    assert alive.clusters.states["track_id"].tolist() == [3, 7]
    assert alive.clusters.states["x"].tolist() == [0, 4]
    assert alive.clusters.birth_us.tolist() == [120, 100]
    alive.apply(record(Kind.MERGED, 140, 4, 3))
    assert alive.clusters.states["track_id"].tolist() == [7]
    alive.apply(np.concatenate([record(Kind.BORN, 150, 5, 8), record(Kind.LOST, 160, 6, 8), record(Kind.LOST, 170, 7, 7)]))
    assert len(alive.clusters.states) == len(alive.clusters.birth_us) == 0
    assert [alive.count[kind] for kind in Kind] == [3, 2, 1, 2]


def test_a_cluster_has_the_class_of_its_tracks_last_verdict() -> None:
    alive = Alive({9: "cup", 4: "plate"})
    assert alive.labels == ("", "?", "cup", "plate")
    alive.apply(np.concatenate([record(Kind.BORN, 100, 0, 1), record(Kind.BORN, 100, 0, 2)]))
    labels = [alive.clusters.label.tolist()]
    one, other = verdicts_of((110, 1, 9)), verdicts_of((120, 2, 4), (130, 2, -1))
    other["slot"] = 1
    for verdicts, records in (
        (one, []),
        (other, []),
        (verdicts_of(), [record(Kind.LOST, 140, 2, 1)]),
        (verdicts_of(), [record(Kind.MOVED, 150, 3, 1)]),
        (verdicts_of(), [record(Kind.LOST, 160, 4, 1), record(Kind.BORN, 170, 5, 3)]),  # another track in slot 0
    ):
        alive.apply(np.concatenate([np.empty(0, TRACK), *records]), verdicts)
        labels.append(alive.clusters.label.tolist())
    assert labels == [[0, 0], [2, 0], [2, 0], [0], [2, 0], [0, 0]]


def test_a_track_that_was_lost_and_is_found_again_is_visible_since_then() -> None:
    alive = Alive()
    alive.apply(record(Kind.BORN, 100, 0, 7))
    alive.apply(record(Kind.LOST, 150, 5, 7))
    assert len(alive.clusters.states) == 0
    alive.apply(record(Kind.MOVED, 200, 9, 7, x=3))
    assert (alive.clusters.states["x"].tolist(), alive.clusters.birth_us.tolist()) == ([3], [200])
    alive.apply(np.concatenate([record(Kind.LOST, 210, 10, 7), record(Kind.MOVED, 220, 11, 7), record(Kind.MOVED, 230, 12, 7)]))
    assert alive.clusters.birth_us.tolist() == [220]
    assert alive.count[Kind.BORN] == 1


@pytest.mark.parametrize("size", [1, 7, 1_000_000])
def test_it_agrees_with_the_whole_log_however_the_records_are_cut(size: int) -> None:
    recording = simulate_scene("discs", 5, {"duration_us": 200_000}).recording
    log = track(recording, PRESETS["plain"])
    alive = Alive()
    for begin in range(0, len(log.records), size):
        part = log.records[begin : begin + size]
        alive.apply(part)
        following = log.records[begin + size : begin + size + 1]
        t_us = int(part["t_us"][-1])
        if len(following) and following["t_us"][0] == t_us:
            continue
        wanted = sample(log, np.array([t_us]))
        wanted = wanted[np.argsort(wanted["track_id"])]
        for name in ("track_id", "x", "y", "radius"):
            assert np.array_equal(alive.clusters.states[name], wanted[name]), name
    assert alive.count[Kind.BORN] == len(log.of_kind(Kind.BORN)) >= 4


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

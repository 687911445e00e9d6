# SPDX-License-Identifier: Apache-2.0
"""The adaptive tracker needs no setting for size, speed or noise: objects become tracks, and what does not move does not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import evcot
from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.recordings.files import read_recording
from evcot.trackers.adaptive import tracker as adaptive_tracker
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.layout import UNSET_US, Rules, World, make_rules, make_world
from evcot.trackers.adaptive.life import RECORDS_PER_PACKET, close_packet
from evcot.trackers.adaptive.tracker import AdaptiveTracker, track
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.timeline import sample
from shared import SHARED
from support.interpreted import interpret, scene

WIDTH, HEIGHT = 346, 260
SEED = 7


def ring(
    x: float, y: float, vx: float, vy: float, radius_px: float, duration_us: int, per_px: float = 3.0
) -> tuple[NDArray[np.float64], ...]:
    """Times and places of events on a disc's contour: `per_px` for each pixel of the contour and pixel travelled."""
    random = np.random.default_rng(SEED)
    n = int(per_px * 2 * np.pi * radius_px * np.hypot(vx, vy) * duration_us * 1e-6)
    t_us, angle = np.sort(random.uniform(0, duration_us, n)), random.uniform(0, 2 * np.pi, n)
    return t_us, x + vx * 1e-6 * t_us + radius_px * np.cos(angle), y + vy * 1e-6 * t_us + radius_px * np.sin(angle)


def noise(hz: float, duration_us: int, width: int = WIDTH, height: int = HEIGHT) -> tuple[NDArray[np.float64], ...]:
    random = np.random.default_rng(SEED + 1)
    n = random.poisson(hz * width * height * duration_us * 1e-6)
    return random.uniform(0, duration_us, n), random.uniform(-0.5, width - 0.5, n), random.uniform(-0.5, height - 0.5, n)


def together(*parts: tuple[NDArray[np.float64], ...], width: int = WIDTH, height: int = HEIGHT) -> Recording:
    t_us, x, y = (np.concatenate([part[i] for part in parts]) for i in range(3))
    x, y = np.rint(x), np.rint(y)
    seen = np.flatnonzero((x >= 0) & (x < width) & (y >= 0) & (y < height))
    order = seen[np.argsort(t_us[seen], kind="stable")]
    p = np.random.default_rng(SEED + 2).integers(0, 2, len(order), dtype=np.uint8)
    events = Events(t_us[order].astype(np.int64), x[order].astype(np.uint16), y[order].astype(np.uint16), p)
    return Recording(events, width, height, "test")


def run(recording: Recording) -> TrackLog:
    return track(recording, AdaptiveConfig())


def fed(
    monkeypatch: pytest.MonkeyPatch,
    events: list[tuple[int, int, int]],
    *objects: dict[str, Any],
    begin: int = 0,
    rows: int = 99,
) -> tuple[int, list[int], World]:
    """Feed events (t_us, x, y) of the open packet, which ends at 5,000 us: the number done, their owners, the world."""
    interpret(monkeypatch)
    rules, world = scene(*objects)
    for i in range(len(objects)):
        world.objects["x"][i], world.objects["y"][i] = world.state[i, :, 0]
        world.objects["half_x"][i], world.objects["half_y"][i] = world.state[i, :, 2]
        world.near[:, :, i] = i
    world.run[0].packet_end_us = 5_000 if objects else UNSET_US
    ts, xs, ys = np.array(events).T
    owner, out = np.full(len(events), -9, np.int16), np.zeros(rows, TRACK).view(np.recarray)
    return adaptive_tracker.feed(rules, world, ts, xs, ys, begin, owner, out), owner.tolist(), world


@pytest.mark.parametrize(
    ("x", "y", "owner"),
    [
        (88, 60, 0),  # half sides of 10 and a gate of 2 px around (100, 60)
        (87, 60, -1),
        (100, 48, 0),
        (100, 47, -1),
        (100, 72, 0),
        (100, 73, -1),
        (104, 60, 0),  # 0.4 half sides; of the other at 110, with half sides of 5, 1.2
        (106, 60, 0),
        (107, 60, 1),
        (117, 60, 1),
        (118, 60, -1),
        (110, 67, 0),  # 1 half side of both: the first
        (110, 53, 0),
        (110, 64, 1),
    ],
)
def test_an_event_is_of_the_object_in_whose_gate_it_lies_closest(
    x: int, y: int, owner: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = {"x": 110, "hx": 5, "hy": 7}
    done, owners, world = fed(monkeypatch, [(10, x, y), (20, x, y)], {}, other)
    assert (done, owners) == (2, [owner, owner])
    assert world.objects["packet_events"].tolist() == [2 if owner == k else 0 for k in (0, 1)]
    assert world.seen[y, x] == 20
    assert np.argwhere(world.pixels).tolist() == [[0, y >> 3, x >> 3]]
    assert world.pixels[0, y >> 3, x >> 3] == 1 << (8 * (y & 7) + (x & 7))


def test_events_are_counted_from_where_a_run_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    done, owners, world = fed(monkeypatch, [(10, 1, 1), (20, 100, 60), (4_999, 100, 60)], {}, begin=1)
    assert (done, owners) == (3, [-9, 0, 0])
    assert (world.run[0].index, world.run[0].last_us, world.run[0].settled) == (2, 4_999, 0)


def test_a_packet_is_closed_by_the_first_event_after_it_if_its_records_have_room(monkeypatch: pytest.MonkeyPatch) -> None:
    events = [(4_999, 100, 60), (5_000, 100, 60)]
    done, owners, world = fed(monkeypatch, events, {}, rows=RECORDS_PER_PACKET)
    assert (done, owners, world.run[0].settled, world.run[0].packet_end_us > 5_000) == (2, [0, 0], 1, True)
    done, owners, world = fed(monkeypatch, events, {}, rows=RECORDS_PER_PACKET - 1)
    assert (done, owners, world.run[0].index, world.run[0].packet_end_us) == (1, [0, -9], 1, 5_000)


def test_time_begins_with_the_first_event(monkeypatch: pytest.MonkeyPatch) -> None:
    _, _, world = fed(monkeypatch, [(70, 3, 4), (80, 3, 4)])
    assert (world.run[0].first_us, world.run[0].packet_end_us, world.run[0].last_us) == (70, 5_070, 80)


@pytest.mark.parametrize(("radius_px", "speed_px_s"), [(6, 60), (6, 400), (12, 40), (12, 150), (12, 1000), (40, 80), (40, 600)])
def test_a_disc_of_any_size_and_speed_is_one_track_with_its_box(radius_px: float, speed_px_s: float) -> None:
    duration_us = int(1e6 * 200 / speed_px_s)
    recording = together(ring(60, 130, speed_px_s, 0, radius_px, duration_us), noise(0.2, duration_us))
    log = run(recording)
    assert len(np.unique(log.records["track_id"])) == 1
    seen = sample(log, np.linspace(0.5 * duration_us, 0.95 * duration_us, 20).astype(np.int64))
    assert len(seen) == 20
    x = 60 + speed_px_s * 1e-6 * np.linspace(0.5 * duration_us, 0.95 * duration_us, 20)
    assert np.median(np.hypot(seen["x"] - x, seen["y"] - 130)) < max(1.0, 0.1 * radius_px)
    for side in ("width", "height"):
        assert np.median(seen[side]) == pytest.approx(2 * radius_px, rel=0.2, abs=2)
    assert np.median(seen["vx"]) == pytest.approx(speed_px_s, rel=0.15)


def test_two_edges_of_one_object_are_one_track() -> None:
    random = np.random.default_rng(SEED)
    n, duration_us = 12_000, 1_500_000
    t_us = np.sort(random.uniform(0, duration_us, n))
    x = 40 + 150e-6 * t_us + np.where(random.random(n) < 0.5, -12, 12) + random.normal(0, 0.5, n)
    log = run(together((t_us, x, 120 + random.uniform(-12, 12, n)), noise(0.1, duration_us)))
    assert len(sample(log, np.array([1_000_000]))) == 1
    (seen,) = sample(log, np.array([1_000_000]))
    assert seen["x"] == pytest.approx(190, abs=2)
    assert seen["width"] == pytest.approx(25, abs=4)


def test_what_swings_over_the_edge_of_the_sensor_comes_back_with_its_name() -> None:
    random = np.random.default_rng(SEED)
    swing, radius_px, rate_per_us = 2 * np.pi / 1.2e6, 8, 3.0 * 2 * np.pi * 8 * 65 * 2 * np.pi / 1.2e6
    t_us = np.sort(random.uniform(0, 2_600_000, int(rate_per_us * 2_600_000)))
    t_us = t_us[random.random(len(t_us)) < np.abs(np.cos(swing * t_us))]  # as many as it travels pixels
    angle = random.uniform(0, 2 * np.pi, len(t_us))
    x = 300 + 65 * np.sin(swing * t_us) + radius_px * np.cos(angle)
    log = run(together((t_us, x, 130 + radius_px * np.sin(angle)), noise(0.2, 2_600_000)))
    assert len(np.unique(log.records["track_id"])) == 1
    # At 0.3 and 1.5 s its centre is 19 px outside.
    assert [len(sample(log, np.array([at]))) for at in (300_000, 900_000, 1_500_000, 2_100_000)] == [0, 1, 0, 1]


def stops_and_goes_on(*, beside: bool) -> TrackLog:
    """A disc of 10 px that stops for 0.8 s at 1 s, and goes back; with or without another that passes close by."""
    there, back = ring(60, 130, 100, 0, 10, 1_000_000), ring(160, 130, -100, 0, 10, 1_000_000)
    parts = [there, (back[0] + 1_800_000, back[1], back[2]), noise(0.2, 2_800_000)]
    if beside:
        parts.append(ring(60, 165, 100, 0, 10, 2_800_000))
    return run(together(*parts))


def test_what_stops_goes_on_with_its_name_unless_it_stopped_beside_another() -> None:
    log = stops_and_goes_on(beside=False)
    assert len(np.unique(log.records["track_id"])) == 1
    assert len(log.of_kind(Kind.BORN)) == 1
    assert [len(sample(log, np.array([at]))) for at in (900_000, 1_780_000, 2_200_000, 2_700_000)] == [1, 0, 1, 1]
    assert len(np.unique(stops_and_goes_on(beside=True).records["track_id"])) == 3


@pytest.mark.parametrize(("ran_us", "tracks"), [(800_000, 1), (60_000, 2)])
def test_what_turns_unseen_is_looked_for_as_far_as_it_can_have_come_if_its_speed_is_known(ran_us: int, tracks: int) -> None:
    """A disc of 3 px that sends nothing for 0.1 s, in which it flies 20 px at right angles."""
    x, unseen_us = 60 + 200e-6 * ran_us, 100_000
    first, then = ring(60, 130, 200, 0, 3, ran_us), ring(x, 130 + 200e-6 * unseen_us, 0, 200, 3, 400_000)
    log = run(together(first, (then[0] + ran_us + unseen_us, then[1], then[2]), noise(0.2, ran_us + 600_000)))
    assert len(np.unique(log.records["track_id"])) == tracks
    (seen,) = sample(log, np.array([ran_us + unseen_us + 350_000]))
    assert seen["y"] == pytest.approx(130 + 200e-6 * (unseen_us + 350_000), abs=3)


def alive(*boxes: tuple[float, float, float], visible: bool = True) -> tuple[Rules, World]:
    """Rules, and a world with objects around y = 100 that move alike; x, half width and half height of each."""
    n = len(boxes)
    rules, world = make_rules(AdaptiveConfig(max_objects=n), WIDTH, HEIGHT), make_world(n, WIDTH, HEIGHT)
    world.run["noise"], world.run["live"], world.run["birth_end_us"] = 0.1, n, 10_000_000
    world.slots[:] = np.arange(n)
    for name, value in (("alive", True), ("away", -1), ("inside", -1), ("edge", -1), ("name", -1)):
        world.objects[name] = value
    world.objects["track_id"] = np.arange(n) if visible else -1
    world.objects["speed"], world.objects["usual"], world.objects["travel"] = 20.0, 20.0, 1.0
    world.objects["contrast"] = np.inf
    world.state[:, 1, 0] = 100
    world.state[:, 0, 0], world.state[:, 0, 2], world.state[:, 1, 2] = np.array(boxes).T
    world.cov[:] = np.diag([1.0, 0.01, 1.0, 0.01])
    return rules, world


def look_once(radius_px: float, ago_us: int, travel: float) -> tuple[float, float]:
    """One look at a slow object with half sides of 6 px, where a disc has sent events: its `missed`, and its half side."""
    rules, world = alive((100, 6, 6))
    t_us = 2_000_000
    world.objects["travel"], world.objects["missed"], world.objects["unseen_us"] = travel, 0.1, 500_000
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    world.seen[np.hypot(x - 100, y - 100) <= radius_px] = t_us - ago_us
    close_packet(rules, world, t_us, 5_000, np.zeros(RECORDS_PER_PACKET, TRACK))
    return float(world.objects["missed"][0]), float(world.state[0, 0, 2])


def test_what_sent_events_once_is_no_longer_there() -> None:
    assert look_once(6, 150_000, 1.0)[0] == 0.0
    assert look_once(6, 300_000, 1.0)[0] > 0.1
    new, known = look_once(3, 50_000, 1.0)[1], look_once(3, 50_000, 5.0)[1]
    assert new < 5.5
    assert known > new + 0.3, "few pixels change a known size less"


@pytest.mark.parametrize(
    ("half_px", "gap_px", "visible", "left"), [(12, 7, True, 2), (12, 4, True, 1), (2, 7, True, 1), (12, 7, False, 1)]
)
def test_what_moves_beyond_the_gate_is_no_part_unless_an_edge_or_new(
    half_px: float, gap_px: float, visible: bool, left: int
) -> None:
    rules, world = alive((100, 12, 20), (112 + gap_px + half_px, half_px, 20), visible=visible)
    world.state[:, 0, 1] = 20.0
    close_packet(rules, world, 2_000_000, 1_000, np.zeros(2 * RECORDS_PER_PACKET, TRACK))
    assert int(world.run["live"][0]) == left


def test_discs_that_cross_keep_their_names() -> None:
    duration_us = 1_400_000
    log = run(
        together(ring(60, 126, 150, 0, 10, duration_us), ring(280, 134, -150, 0, 10, duration_us), noise(0.2, duration_us))
    )
    begin, end = sample(log, np.array([300_000])), sample(log, np.array([1_300_000]))
    assert len(begin) == len(end) == 2
    at = {int(row["track_id"]): float(row["x"]) for row in begin}
    for row in end:
        assert abs(row["x"] - at[int(row["track_id"])]) == pytest.approx(150, abs=6)


@pytest.mark.parametrize("hz", [0.1, 1.0, 5.0])
def test_noise_is_no_track_and_a_disc_is_found_in_it(hz: float) -> None:
    assert not len(run(together(noise(hz, 4_000_000))).records)
    log = run(together(ring(60, 130, 150, 0, 12, 1_500_000, per_px=6), noise(hz, 1_500_000)))
    seen = sample(log, np.arange(600_000, 1_500_000, 50_000))
    assert len(seen) == 18
    assert np.median(np.abs(seen["y"] - 130)) < 1.5


def test_a_hot_pixel_and_a_lamp_are_no_track() -> None:
    random = np.random.default_rng(SEED)
    hot = np.arange(0, 6_000_000, 200.0), np.full(30_000, 200.0), np.full(30_000, 90.0)
    flashes = np.repeat(np.arange(1200) * 5_000.0, 40)
    lamp = flashes + random.uniform(0, 1_500, 48_000), 300 + random.uniform(0, 12, 48_000), 20 + random.uniform(0, 12, 48_000)
    log = run(together(hot, lamp, noise(0.5, 6_000_000)))
    # The lamp is one object until ten epochs have shown that its pixels never rest.
    assert len(np.unique(log.records["track_id"])) <= 1
    assert not len(sample(log, np.arange(1_500_000, 6_000_000, 50_000)))


def test_the_split_into_runs_does_not_matter() -> None:
    recording = together(ring(60, 130, 200, 20, 12, 1_000_000), noise(0.5, 1_000_000))
    whole, parted = AdaptiveTracker(AdaptiveConfig(), WIDTH, HEIGHT), AdaptiveTracker(AdaptiveConfig(), WIDTH, HEIGHT)
    records, owner = whole.feed(recording.events)
    parts = [parted.feed(recording.events[at : at + 997]) for at in range(0, len(recording.events), 997)]
    np.testing.assert_array_equal(np.concatenate([part[0] for part in parts]), records)
    np.testing.assert_array_equal(np.concatenate([part[1] for part in parts]), owner)
    np.testing.assert_array_equal(parted.finish(), whole.finish())


def test_a_full_buffer_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiled loop returns when records could overflow; what it knows of the stream's beginning must survive that."""
    parts = [ring(60, 60 + 60 * k, 200, 0, 12, 1_300_000, per_px=6) for k in range(3)]
    hot = np.arange(0, 1_300_000, 100.0), np.full(13_000, 200.0), np.full(13_000, 90.0)
    recording = together(*parts, hot)
    whole = AdaptiveTracker(AdaptiveConfig(max_objects=8), WIDTH, HEIGHT)
    monkeypatch.setattr("evcot.trackers.compiled.SPARE_RECORDS", 0)
    small = AdaptiveTracker(AdaptiveConfig(max_objects=8), WIDTH, HEIGHT)
    for one, other in zip(whole.feed(recording.events), small.feed(recording.events), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("times", [1, 3])
def test_time_may_run_at_any_rate(times: int) -> None:
    events = together(ring(60, 130, 200, 20, 12, 1_000_000, per_px=6)).events
    slow = Recording(Events(times * events.t_us, events.x, events.y, events.p), WIDTH, HEIGHT, "slow")
    (seen,) = sample(run(slow), np.array([900_000 * times]))
    assert seen["x"] == pytest.approx(240, abs=1.5)
    assert seen["vx"] * times == pytest.approx(200, rel=0.15)


def test_records_tell_a_life() -> None:
    log = run(together(ring(60, 130, 300, 0, 12, 2_000_000), noise(0.2, 2_000_000)))
    kinds = log.records["kind"]
    assert kinds[0] == Kind.BORN
    assert (np.diff(log.records["t_us"]) >= 0).all()
    assert kinds[-1] == Kind.LOST  # it has left the sensor
    assert log.records["t_us"][-1] < 1_400_000
    assert (log.owner >= 0).mean() > 0.5


def test_refused() -> None:
    with pytest.raises(ConfigError, match=r"adaptive\.gate = 9\.0: must be from 0\.01 to 4"):
        AdaptiveConfig(gate=9.0)
    tracker = AdaptiveTracker(AdaptiveConfig(), 10, 10)
    assert (len(tracker.finish()), tracker.noise_hz) == (0, None)
    one = Events(np.array([5]), np.array([3], np.uint16), np.array([3], np.uint16), np.array([1], np.uint8))
    tracker.feed(one)
    with pytest.raises(RecordingError, match="time must not run back"):
        tracker.feed(Events(np.array([4]), one.x, one.y, one.p))
    with pytest.raises(RecordingError, match="must lie on the sensor"):
        tracker.feed(Events(np.array([6]), np.array([10], np.uint16), one.y, one.p))


@pytest.mark.skipif(not (SHARED / "traffic_outbound.aedat4").is_file(), reason="the shared recordings are not here")
def test_the_real_motorway_with_its_hot_pixel() -> None:
    rule = load_rule("traffic")
    recording = read_recording(SHARED / "traffic_outbound.aedat4")
    scores = evaluate(run(recording), read_truth(SHARED / "traffic_outbound_gt.csv", rule), rule)
    assert scores.hota > 0.75
    assert scores.idf1 > 0.87
    assert scores.idsw <= 2


def test_a_merge_names_a_track_that_was_born() -> None:
    """Objects that merge into one that is not visible yet are lost: there is no track that they could have merged into."""
    log = evcot.track(evcot.simulate("insects", seed=2, duration_us=1_500_000).recording, "adaptive")
    merged = log.of_kind(Kind.MERGED)
    assert len(merged) > 0
    assert np.isin(merged["other_id"], log.of_kind(Kind.BORN)["track_id"]).all()

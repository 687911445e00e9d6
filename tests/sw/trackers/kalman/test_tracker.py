# SPDX-License-Identifier: Apache-2.0
"""The Kalman tracker locates extended objects, keeps them apart when they cross, and does not report noise."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.recordings.files import read_recording
from evcot.trackers.kalman.config import KalmanConfig
from evcot.trackers.kalman.presets import PRESETS
from evcot.trackers.kalman.tracker import KalmanTracker, track
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.timeline import sample
from shared import SHARED

WIDTH, HEIGHT = 346, 260
RADIUS_PX = 10.0
SEED = 7


def discs(paths: list[tuple[float, float, float, float]], duration_us: int, noise: float = 0.05) -> Events:
    """Contours of discs at (x, y) with (vx, vy) px/s that bounce off the walls, 60 events/ms each, and a share of noise."""
    random = np.random.default_rng(SEED)
    n = int(len(paths) * 0.06 * duration_us / (1 - noise))
    t_us = np.sort(random.integers(0, duration_us, n))
    x0, y0, vx, vy = np.array(paths)[random.integers(0, len(paths), n)].T
    angle = random.uniform(0, 2 * np.pi, n)
    x = folded(x0 + vx * 1e-6 * t_us, WIDTH) + RADIUS_PX * np.cos(angle)
    y = folded(y0 + vy * 1e-6 * t_us, HEIGHT) + RADIUS_PX * np.sin(angle)
    stray = random.random(n) < noise
    x[stray], y[stray] = random.uniform(0, WIDTH - 1, stray.sum()), random.uniform(0, HEIGHT - 1, stray.sum())
    return Events(
        t_us.astype(np.int64),
        np.clip(np.rint(x), 0, WIDTH - 1).astype(np.uint16),
        np.clip(np.rint(y), 0, HEIGHT - 1).astype(np.uint16),
        random.integers(0, 2, n).astype(np.uint8),
    )


def folded(way: NDArray[Any], size: int) -> NDArray[Any]:
    """Where a disc is whose way is folded back at the walls."""
    room = size - 1 - 2 * RADIUS_PX
    return RADIUS_PX + room - np.abs((way - RADIUS_PX) % (2 * room) - room)


def run(events: Events, config: KalmanConfig) -> TrackLog:
    return track(Recording(events, WIDTH, HEIGHT, "test"), config)


def test_a_disc_is_where_it_is_and_as_large_as_it_is() -> None:
    log = run(discs([(60, 120, 150, 30)], 1_000_000), PRESETS["discs"])
    times_us = np.arange(100_000, 1_000_000, 50_000)
    seen = sample(log, times_us)
    assert len(log.of_kind(Kind.BORN)) == 1
    assert len(log.of_kind(Kind.LOST)) == 0
    error = np.hypot(seen["x"] - 60 - 150e-6 * times_us, seen["y"] - 120 - 30e-6 * times_us)
    assert np.median(error) < 0.7
    for side in ("width", "height"):
        assert np.median(np.abs(seen[side] - 2 * RADIUS_PX)) < 1.4
    assert np.hypot(np.median(seen["vx"]) - 150, np.median(seen["vy"]) - 30) < 8
    assert ((seen["confidence"] > 0.5) & (seen["confidence"] < 1)).all()
    np.testing.assert_allclose(log.records["radius"], (log.records["width"] + log.records["height"]) / 4)


def test_discs_that_cross_keep_their_ids() -> None:
    log = run(discs([(60, 130, 150, 0), (280, 134, -150, 0)], 1_400_000), PRESETS["discs"])
    begin, end = sample(log, np.array([200_000])), sample(log, np.array([1_300_000]))
    ids = {int(row["track_id"]): float(row["x"]) for row in begin}
    assert sorted(ids) == [0, 1]
    for row in end:
        moved = row["x"] - ids[int(row["track_id"])]
        assert abs(moved) == pytest.approx(165, abs=3)
    assert len(end) == 2


SIDE_BY_SIDE = [(100, 100, 150, 60), (128, 70, 95, 115)]
AT_THE_WALL = [(294, 43, 107, -6), (317, 99, 30, -127)]


@pytest.mark.parametrize("paths", [SIDE_BY_SIDE, AT_THE_WALL])
def test_discs_that_meet_keep_their_ids_and_sizes(paths: list[tuple[float, float, float, float]]) -> None:
    """For long since they go much the same way; or while one of them turns back at the wall."""
    log = run(discs(paths, 900_000), PRESETS["discs"])
    times_us = np.arange(50_000, 900_000, 10_000)
    seen = sample(log, times_us)
    assert len(log.of_kind(Kind.BORN)) == 2
    for x0, y0, vx, vy in paths:
        x, y = (folded(at + v * 1e-6 * times_us, size) for at, v, size in ((x0, vx, WIDTH), (y0, vy, HEIGHT)))
        away = np.hypot(seen["x"] - x[seen["sample"]], seen["y"] - y[seen["sample"]])
        track_id = seen["track_id"][away.argmin()]
        assert away[seen["track_id"] == track_id].max() < 4
    assert np.abs(seen["radius"] - RADIUS_PX).max() < 1


def test_a_box_around_two_is_split_when_they_part() -> None:
    """They begin as one group of pixels."""
    log = run(discs([(150, 130, -100, 0), (175, 130, 100, 0)], 800_000), PRESETS["discs"])
    end = sample(log, np.array([780_000]))
    assert sorted(float(x) for x in end["x"]) == pytest.approx([72, 253], abs=2)


def test_a_hot_pixel_and_noise_are_nothing() -> None:
    random = np.random.default_rng(SEED)
    hot = np.arange(0, 500_000, 110)
    noise = random.integers(0, 500_000, 5_000)
    t_us = np.concatenate((hot, noise))
    x = np.concatenate((np.full(len(hot), 192), random.integers(0, WIDTH, 5_000)))
    y = np.concatenate((np.full(len(hot), 209), random.integers(0, HEIGHT, 5_000)))
    order = np.argsort(t_us, kind="stable")
    events = Events(t_us[order], x[order].astype(np.uint16), y[order].astype(np.uint16), np.zeros(len(t_us), np.uint8))
    for config in PRESETS.values():
        log = run(events, config)
        assert len(log.records) == 0
        assert (log.owner == -1).all()


def test_what_falls_silent_is_lost() -> None:
    one = discs([(100, 100, 50, 0)], 300_000)
    later = Events(
        *(np.append(a, b).astype(a.dtype) for a, b in zip((one.t_us, one.x, one.y, one.p), (900_000, 5, 5, 0), strict=True))
    )
    lost = run(later, PRESETS["discs"]).of_kind(Kind.LOST)
    assert len(lost) == 1
    assert 300_000 + PRESETS["discs"].coast_us <= lost["t_us"][0] <= 500_000 + PRESETS["discs"].coast_us


@pytest.mark.parametrize("name", PRESETS)
def test_the_cuts_do_not_matter(name: str) -> None:
    events = discs([(60, 130, 150, 0), (280, 134, -150, 0)], 400_000)
    whole = run(events, PRESETS[name])
    tracker = KalmanTracker(PRESETS[name], WIDTH, HEIGHT)
    cuts = [0, *np.sort(np.random.default_rng(SEED).integers(0, len(events), 40)).tolist(), len(events)]
    parts = [tracker.feed(events[slice(a, b)]) for a, b in pairwise(cuts)]
    records = np.concatenate([part[0] for part in parts] + [tracker.finish()])
    np.testing.assert_array_equal(records, whole.records)
    np.testing.assert_array_equal(np.concatenate([part[1] for part in parts]), whole.owner)
    assert (np.diff(records["t_us"]) >= 0).all()


def test_events_that_a_filter_took_out() -> None:
    events = discs([(100, 100, 50, 0)], 200_000)
    keep = np.arange(len(events)) % 4 > 0
    recording = Recording(events, WIDTH, HEIGHT, "test")
    log = track(recording, PRESETS["discs"], keep)
    assert (log.owner[~keep] == -2).all()
    assert (log.owner[keep] >= -1).all()
    assert keep[log.records["event_index"][log.records["event_index"] < len(events)]].all()


def test_time_must_not_run_back() -> None:
    events = discs([(100, 100, 50, 0)], 10_000)
    tracker = KalmanTracker(PRESETS["discs"], WIDTH, HEIGHT)
    tracker.feed(events)
    with pytest.raises(RecordingError, match=r"^event \d+: t = \d+ us follows t = \d+ us: time must not run back$"):
        tracker.feed(events)


def test_an_event_off_the_sensor() -> None:
    tracker = KalmanTracker(PRESETS["discs"], 100, 100)
    with pytest.raises(RecordingError, match=r"^event \d+: \(\d+, \d+\): must lie on the sensor, 100x100$"):
        tracker.feed(discs([(110, 100, 50, 0)], 10_000))


def test_settings_out_of_range() -> None:
    with pytest.raises(ConfigError, match=r"^kalman\.quantile = 0\.5: must be from 0\.001 to 0\.4 \(share of"):
        KalmanConfig(quantile=0.5)
    with pytest.raises(ConfigError, match=r"^kalman\.walls = 1: must be true or false$"):
        KalmanConfig(walls=1)  # type: ignore[arg-type]


@pytest.mark.skipif(not SHARED.exists(), reason="the shared recordings are not here")
def test_real_traffic() -> None:
    rule = load_rule("traffic")
    log = track(read_recording(SHARED / "traffic_outbound.aedat4"), PRESETS["traffic"])
    scores = evaluate(log, read_truth(SHARED / "traffic_outbound_gt.csv", rule), rule)
    assert scores.hota >= 0.85
    assert scores.idf1 >= 0.95
    assert scores.idsw <= 1

# SPDX-License-Identifier: Apache-2.0
"""Identities of detections, trackers made of a stream of them, and detections in a frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.scenes import Scene, simulate_scene
from evcot.trackers.detections import DETECTION, DetectionTracker, Identities, IdentityConfig
from evcot.trackers.engines import ENGINES
from evcot.trackers.frame_based import FRAME_RANGES, FrameConfig, FrameTracker, detect
from evcot.trackers.mean_shift.tracker import MEAN_SHIFT_RANGES, MeanShiftConfig
from evcot.tracks.log import DROPPED, TRACK, Kind, TrackLog
from evcot.tracks.tracking import track_recording
from support.refusals import refused

SENSOR = (346, 260)
LIFETIME_US = 150_000  # of both presets
both = pytest.mark.parametrize("engine", ["frames", "mean-shift"])


def tracker(engine: str) -> DetectionTracker:
    made = ENGINES[engine].start(ENGINES[engine].presets["discs"], FilterConfig(), SENSOR)
    assert isinstance(made, DetectionTracker)
    return made


def track(engine: str, events: Events, keep: np.ndarray | None = None) -> TrackLog:  # type: ignore[type-arg]
    return track_recording(engine, tracker(engine), Recording(events, *SENSOR), keep)


@cache
def scene() -> Scene:
    return simulate_scene("discs", 5, {"count": 4, "ways": "separate", "duration_us": 600_000})


@both
def test_where_the_stream_is_cut_changes_nothing(engine: str) -> None:
    events, log = scene().recording.events, track(engine, scene().recording.events)
    n = len(events)
    assert np.bincount(log.records["kind"])[Kind.MOVED] > 100
    random = np.random.default_rng(2)
    for cuts in ([0, n // 2, n // 2], sorted(random.integers(0, n, 300).tolist()), list(range(1, 1_000))):
        streamed = tracker(engine)
        runs = [streamed.feed(events[begin:end]) for begin, end in zip([0, *cuts], [*cuts, n], strict=True)]
        np.testing.assert_array_equal(np.concatenate([*(run[0] for run in runs), streamed.finish()]), log.records)
        np.testing.assert_array_equal(np.concatenate([run[1] for run in runs]), log.owner)


@both
def test_a_caller_may_reuse_its_arrays(engine: str) -> None:
    events, streamed, parts = scene().recording.events, tracker(engine), []
    room = Events.allocated(50)
    for begin in range(0, 10_000, 50):
        for field in ("t_us", "x", "y", "p"):
            getattr(room, field)[:] = getattr(events, field)[begin : begin + 50]
        parts.append(streamed.feed(room)[0])
    whole, _ = tracker(engine).feed(events[:10_000])
    assert len(whole) > 20
    np.testing.assert_array_equal(np.concatenate(parts), whole)


@both
def test_a_loss_is_stamped_with_its_time_and_the_next_event(engine: str) -> None:
    """In the upper part of the picture everything ends at 0.3 s."""
    events = scene().recording.events
    events = events.where((events.t_us < 300_000) | (events.y > 170))
    log = track(engine, events)
    lost = log.of_kind(Kind.LOST)
    assert len(lost) >= 2
    assert (lost["event_index"] == np.searchsorted(events.t_us, lost["t_us"])).all()
    for row in lost:
        own = log.records[log.records["track_id"] == row["track_id"]]
        assert own["t_us"][-1] == row["t_us"] == own["t_us"][-2] + LIFETIME_US


@both
def test_shifting_the_recording_in_time_shifts_the_log(engine: str) -> None:
    events = scene().recording.events
    shifted = track(engine, Events(events.t_us + 1_718_925_184_590_631, events.x, events.y, events.p)).records.copy()
    shifted["t_us"] -= 1_718_925_184_590_631
    np.testing.assert_array_equal(shifted, track(engine, events).records)


@both
def test_filtered_events_are_numbered_as_in_the_recording(engine: str) -> None:
    events, keep = scene().recording.events, np.arange(len(scene().recording.events)) % 3 > 0
    log, alone = track(engine, events, keep), track(engine, events.where(keep))
    assert (log.owner[~keep] == DROPPED).all()
    np.testing.assert_array_equal(log.owner[keep], alone.owner)
    place = np.append(np.flatnonzero(keep), len(keep))
    np.testing.assert_array_equal(log.records["event_index"], place[alone.records["event_index"]])


@pytest.mark.parametrize(
    ("engine", "position_px", "hota", "owned"), [("frames", 1.5, 0.75, 0.5), ("mean-shift", 1.0, 0.85, 0.8)]
)
def test_a_track_per_disc_near_its_disc(engine: str, position_px: float, hota: float, owned: float, tmp_path: Path) -> None:
    """`owned` is a share of the later half of the events, when all are visible."""
    scene().truth.save(tmp_path / "truth.csv")
    rule = load_rule("scene")
    log = track(engine, scene().recording.events)
    scores = evaluate(log, read_truth(tmp_path / "truth.csv", rule), rule)
    assert (scores.track_ids, scores.idsw) == (4, 0)
    assert scores.position_error_px_median is not None
    assert scores.velocity_error_median is not None
    assert scores.position_error_px_median < position_px
    assert scores.velocity_error_median < 20.0  # of 75 to 225 px/s
    assert scores.hota > hota
    assert (log.owner[len(log.owner) // 2 :] >= 0).mean() > owned


@both
def test_time_must_not_run_back(engine: str) -> None:
    log = track(engine, Events.empty())
    assert (log.engine, len(log.records), len(log.owner)) == (engine, 0, 0)
    streamed, one = tracker(engine), np.zeros(1, np.uint16)
    for t_us in (100, 105, 30_000):
        streamed.feed(Events(np.array([t_us]), one, one, one.astype(np.uint8)))
    with refused(RecordingError, "event 3: t = 129 us follows t = 30000 us: time must not run back"):
        streamed.feed(Events(np.array([129]), one, one, one.astype(np.uint8)))


Moment = tuple[int, list[tuple[float, float]]]

QUICK = IdentityConfig(gate_px=10.0, smoothing_us=0, visible_hits=2, lifetime_us=5_000)


def detections(places: list[tuple[float, float]], **fields: float) -> np.ndarray:  # type: ignore[type-arg]
    found = np.zeros(len(places), DETECTION)
    found["x"], found["y"] = np.array(places).reshape(-1, 2).T
    found["radius"], found["n"] = 3.0, 10
    for name, value in fields.items():
        found[name] = value
    return found


def followed(identities: Identities, moments: list[Moment]) -> np.ndarray:  # type: ignore[type-arg]
    """The records of one frame per moment, each with a single event."""
    records = []
    for index, (t_us, places) in enumerate(moments):
        records += identities.follow(np.array([t_us]), index, detections(places))
    return np.array(records, TRACK)


def told(moments: list[Moment], config: IdentityConfig = QUICK) -> list[tuple[str, int, int, float, float]]:
    """(kind, t_us, track id, x, y) of every record."""
    records = followed(Identities(config, 1_500), moments)
    return [(Kind(row["kind"]).name, *row[["t_us", "track_id", "x", "y"]].tolist()) for row in records]


def test_a_life() -> None:
    story = told(
        [(0, [(5, 5)]), (1_000, [(6, 5)]), (2_000, [(7, 5)]), (3_000, []), (4_000, [(9, 5)]), (8_999, []), (9_500, [])]
    )
    assert story == [
        ("BORN", 1_000, 0, 6.0, 5.0),  # with its second detection
        ("MOVED", 2_000, 0, 7.0, 5.0),
        ("MOVED", 4_000, 0, 9.0, 5.0),  # found again where its velocity has taken it
        ("LOST", 9_000, 0, 9.0, 5.0),  # at the end of its silence, not when it was noticed
    ]


def test_a_loss_is_stamped_with_the_next_event() -> None:
    records = followed(Identities(QUICK, 1_500), [(0, [(5, 5)]), (1_000, [(5, 5)]), (5_999, []), (6_000, []), (9_000, [])])
    assert records[["kind", "t_us", "event_index"]].tolist()[-1] == (Kind.LOST, 6_000, 3)


def test_a_candidate_that_is_not_detected_again_soon_never_becomes_visible() -> None:
    assert told([(0, [(5, 5)]), (1_600, [(5, 5)]), (3_200, [(5, 5)])]) == []


def test_a_record_has_the_predicted_position_at_the_frames_end() -> None:
    """Detections are of the mean time of their events: what moves has moved on since."""
    identities = Identities(IdentityConfig(gate_px=20.0, smoothing_us=0, visible_hits=2), 20_000)
    records = []
    for k in range(4):
        t_us = np.arange(10_000 * k, 10_000 * k + 10_000, 1_000)
        records += identities.follow(t_us, 10 * k, detections([(100 + 5.0 * k, 0.0)], after_us=4_500.0))  # 500 px/s
    made = np.array(records, TRACK)
    assert made[["t_us", "event_index"]].tolist() == [(19_000, 19), (29_000, 29), (39_000, 39)]
    assert made["x"].tolist() == pytest.approx([107.25, 112.25, 117.25])


def test_a_record_has_the_tracks_box_velocity_and_confidence() -> None:
    identities, records = Identities(QUICK, 1_500), []
    for k in range(5):
        found = detections([(10 + 0.25 * k, 80 - 0.5 * k)], width=20 + k, height=10 - k)
        records += identities.follow(np.array([1_000 * k]), k, found)
    made = np.array(records, TRACK)
    assert made["width"].tolist() == pytest.approx([21, 22, 23, 24])  # without smoothing the newest
    assert made["height"].tolist() == pytest.approx([9, 8, 7, 6])
    assert (made["vx"].tolist(), made["vy"].tolist()) == (pytest.approx([250] * 4), pytest.approx([-500] * 4))
    assert made["confidence"].tolist() == [2 / 4, 3 / 5, 4 / 6, 5 / 7]  # by detections; 2 make it visible
    assert made[["n_ev", "support", "other_id"]].tolist() == [(10, 10 * k, -1) for k in range(2, 6)]


def test_the_assignment_is_optimal_where_the_nearest_first_would_lose_a_pair() -> None:
    """Track 0 is nearest to the detection that is the only one within track 1's gate."""
    start: list[Moment] = [(t, [(20.0, 5.0), (28.0, 5.0)]) for t in (0, 1_000)]
    story = told([*start, (2_000, [(22.0, 5.0), (11.0, 5.0)])])
    assert story[2:] == [("MOVED", 2_000, 0, 11.0, 5.0), ("MOVED", 2_000, 1, 22.0, 5.0)]


def test_visible_tracks_choose_first() -> None:
    start: list[Moment] = [(t, [(20.0, 5.0)]) for t in (0, 1_000)]
    moments: list[Moment] = [*start, (2_000, [(20.0, 5.0), (27.0, 5.0)]), (3_000, [(24.5, 5.0)])]
    assert told(moments)[-1] == ("MOVED", 3_000, 0, 24.5, 5.0)


def test_at_most_64_tracks() -> None:
    places = [(20.0 * k, 5.0) for k in range(66)]
    assert {row[2] for row in told([(t, places) for t in range(0, 5_000, 1_000)])} == {*range(64)}


def test_an_event_belongs_to_the_nearest_visible_window() -> None:
    identities = Identities(QUICK, 1_500)
    followed(identities, [(t, [(20.0, 20.0), (25.0, 20.0)]) for t in (0, 1_000)])
    x, y = np.array([[17, 22, 23, 28, 29, 20], [20, 20, 20, 23, 20, 24]], np.uint16)
    later = Events(np.full(6, 2_000, np.int64), x, y, np.zeros(6, np.uint8)).read_only()
    assert identities.own(later).tolist() == [0, 0, 1, 1, -1, -1]


@dataclass
class Naive:
    """A track of the naive reading; x, y are of the time t."""

    x: float
    y: float
    t: int
    slot: int
    vx: float = 0.0
    vy: float = 0.0
    hits: int = 1
    track_id: int | None = None


def naive(moments: list[Moment], config: IdentityConfig, candidate_us: int) -> list[tuple[object, ...]]:
    """The rules, with an assignment in every frame."""
    tracks: list[Naive] = []
    log: list[tuple[object, ...]] = []
    births = 0

    def end(until: int, index: int) -> None:
        over = []
        for c in tracks:
            at = c.t + (candidate_us if c.track_id is None else config.lifetime_us)
            if at <= until:
                over.append((at, c))
        for at, c in sorted(over, key=lambda entry: entry[0]):
            tracks.remove(c)
            if c.track_id is not None:
                log.append((at, index, int(Kind.LOST), c.track_id, c.slot, c.x, c.y))

    for index, (t, places) in enumerate(moments):
        end(t, index)
        cost = np.full((len(tracks), len(places)), 1e9)
        for i, c in enumerate(tracks):
            for k, (x, y) in enumerate(places):
                away = np.hypot(x - c.x - c.vx * (t - c.t) * 1e-6, y - c.y - c.vy * (t - c.t) * 1e-6)
                if away <= config.gate_px:
                    cost[i, k] = away + (config.gate_px if c.track_id is None else 0)
        pairs = {k: tracks[i] for i, k in zip(*linear_sum_assignment(cost), strict=True) if cost[i, k] < 1e9}
        for k, (x, y) in enumerate(places):
            if k in pairs:
                c = pairs[k]
                fading = np.exp(-(t - c.t) / config.smoothing_us) if config.smoothing_us else 0.0
                dt = (t - c.t) * 1e-6
                c.x, c.y = c.x + c.vx * dt, c.y + c.vy * dt
                off_x, off_y = x - c.x, y - c.y
                gain = max(1 - fading**2, 1 / (c.hits + 1))
                c.x, c.y, c.hits, c.t = c.x + gain * off_x, c.y + gain * off_y, c.hits + 1, t
                c.vx, c.vy = c.vx + (1 - fading) ** 2 * off_x / dt, c.vy + (1 - fading) ** 2 * off_y / dt
            else:
                tracks.append(Naive(x, y, t, min(set(range(64)) - {c.slot for c in tracks})))
        for c in tracks:
            if c.t == t and c.hits >= config.visible_hits:
                kind = Kind.MOVED
                if c.track_id is None:
                    c.track_id, births, kind = births, births + 1, Kind.BORN
                log.append((t, index, int(kind), c.track_id, c.slot, c.x, c.y))
    return log


@pytest.mark.parametrize("smoothing_us", [0, 4_000])
def test_record_for_record_like_the_naive_reading(smoothing_us: int) -> None:
    config = IdentityConfig(9.0, smoothing_us, 3, 6_000)
    for seed in range(5):
        random = np.random.default_rng(seed)
        moments: list[Moment] = []
        t = 10**9
        for k in range(400):
            t += int(random.integers(200, 3_000))
            ways = [(50 + 40 * np.sin(0.02 * k + 2 * j), 50 + 40 * np.cos(0.03 * k + j)) for j in range(4)]
            places = [(x + random.normal(), y + random.normal()) for x, y in ways if random.random() < 0.8]
            places += [tuple(random.uniform(0, 100, 2)) for _ in range(random.poisson(0.5))]
            moments.append((t, [(float(x), float(y)) for x, y in places]))
        records = followed(Identities(config, 2_500), moments)
        rows = [tuple(row) for row in records[["t_us", "event_index", "kind", "track_id", "slot", "x", "y"]].tolist()]
        expected = naive(moments, config, 2_500)
        assert [row[:5] for row in rows] == [row[:5] for row in expected]
        np.testing.assert_allclose([row[5:] for row in rows], [row[5:] for row in expected], rtol=0, atol=1e-6)
        assert {row[2] for row in rows} == {Kind.BORN, Kind.MOVED, Kind.LOST}


RANGES = [("frames", FrameConfig, field, *FRAME_RANGES[field]) for field in FRAME_RANGES]
RANGES += [("mean_shift", MeanShiftConfig, field, *MEAN_SHIFT_RANGES[field]) for field in MEAN_SHIFT_RANGES]


@pytest.mark.parametrize(("name", "config", "field", "low", "high", "meaning"), RANGES)
def test_each_field_has_its_range(name: str, config: Any, field: str, low: float, high: float, meaning: str) -> None:
    for value in (low - 1, high + 1, "7", True, float("nan")):
        with pytest.raises(ConfigError, match=rf"^{name}\.{field} = .*: must be from .* \(") as caught:
            config(**{field: value})
        assert meaning in str(caught.value)


def test_a_median_filter_has_an_odd_side() -> None:
    with pytest.raises(ConfigError, match=r"^frames\.median_px = 4: must be odd, so that the square has a middle$"):
        FrameConfig(median_px=4)


PLAIN = FrameConfig(median_px=1, link_px=0, area_min_px=1)


def block(left: int, top: int, width: int, height: int) -> np.ndarray:  # type: ignore[type-arg]
    """The pixels of a rectangle, (2, n)."""
    return np.stack(np.meshgrid(np.arange(left, left + width), np.arange(top, top + height))).reshape(2, -1)


def events(*parts: np.ndarray) -> Events:  # type: ignore[type-arg]
    x, y = np.concatenate(parts, axis=1).astype(np.uint16)
    return Events(1_000 + np.arange(len(x)), x, y, np.zeros(len(x), np.uint8))


def objects(found: np.ndarray) -> set[tuple[float, ...]]:  # type: ignore[type-arg]
    return {tuple(row) for row in found[["x", "y", "radius", "width", "height", "n"]].tolist()}


def test_frames_count_from_the_first_event_and_empty_frames_are_skipped() -> None:
    t_us = np.array([1005, 1014, 1016, 1024, 1025, 1059, 1064, 1065])
    assert FrameTracker(FrameConfig(frame_us=10)).frame_ends(t_us).tolist() == [2, 4, 5, 7]


def test_an_object_is_its_box_and_its_pixels_at_the_mean_time() -> None:
    found = detect(events(block(0, 0, 5, 3), block(20, 30, 4, 4)), PLAIN)
    assert objects(found) == {(2.0, 1.0, 2.0, 5.0, 3.0, 15), (21.5, 31.5, 2.0, 4.0, 4.0, 16)}
    assert found["after_us"].tolist() == [15.0, 15.0]


def test_pixels_count_once_and_touch_by_their_corners() -> None:
    diagonal = np.array([[7, 8, 9, 9, 9], [7, 8, 9, 9, 9]])
    assert objects(detect(events(diagonal), PLAIN)) == {(8.0, 8.0, 1.5, 3.0, 3.0, 3)}


@pytest.mark.parametrize(("link_px", "objects_expected"), [(2, 2), (3, 1), (4, 1)])
def test_pieces_are_joined_across_a_gap_of_link_px(link_px: int, objects_expected: int) -> None:
    for first, second in ((block(0, 0, 3, 3), block(6, 0, 3, 3)), (block(0, 0, 3, 3), block(0, 6, 3, 3))):
        config = FrameConfig(median_px=1, link_px=link_px, area_min_px=1)
        assert len(detect(events(first, second), config)) == objects_expected


def test_the_median_removes_single_pixels_and_rounds_corners_and_small_objects_are_discarded() -> None:
    config = replace(PLAIN, median_px=3)
    noise = np.array([[40, 60, 61], [40, 3, 4]])
    assert objects(detect(events(block(10, 10, 5, 5), noise), config)) == {(12.0, 12.0, 2.5, 5.0, 5.0, 21)}
    assert len(detect(events(noise), config)) == 0
    small = detect(events(block(0, 0, 3, 1), block(10, 0, 2, 2)), replace(PLAIN, area_min_px=4))
    assert objects(small) == {(10.5, 0.5, 1.0, 2.0, 2.0, 4)}


def test_a_frame_that_spans_too_many_pixels_is_refused() -> None:
    message = r"^frame from t = 1000 us: spans 65511x65511 pixels: must be at most 2\^26 in all$"
    with pytest.raises(RecordingError, match=message):
        detect(events(np.array([[0, 65_500], [0, 65_500]])), FrameConfig())

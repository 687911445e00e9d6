# SPDX-License-Identifier: Apache-2.0
"""Both baselines as streams, and on scenes whose truth is known."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.scenes import Scene, simulate_scene
from evcot.trackers.detections.stream import DetectionTracker
from evcot.trackers.engines import ENGINES
from evcot.tracks.log import DROPPED, Kind, TrackLog
from evcot.tracks.tracking import track_recording

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
    for cuts in ([0, n // 2, n // 2], sorted(random.integers(0, n, 300).tolist()), list(range(1, 3_000))):
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
def test_no_events(engine: str) -> None:
    log = track(engine, Events.empty())
    assert (log.engine, len(log.records), len(log.owner)) == (engine, 0, 0)


@both
def test_time_must_not_run_back(engine: str) -> None:
    streamed, one = tracker(engine), np.zeros(1, np.uint16)
    for t_us in (100, 105, 30_000):
        streamed.feed(Events(np.array([t_us]), one, one, one.astype(np.uint8)))
    with pytest.raises(RecordingError, match=r"^event 3: t = 129 us follows t = 30000 us: time must not run back$"):
        streamed.feed(Events(np.array([129]), one, one, one.astype(np.uint8)))

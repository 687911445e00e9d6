# SPDX-License-Identifier: Apache-2.0
"""The frame pipeline as a stream, and on a scene whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.scenes import Scene, simulate_scene
from evcot.trackers.frame_based.presets import PRESETS
from evcot.trackers.frame_based.tracker import FrameTracker, track
from evcot.tracks.log import DROPPED, Kind

CONFIG = PRESETS["discs"]


@cache
def scene() -> Scene:
    return simulate_scene("discs", 5, {"count": 3, "ways": "separate", "duration_us": 600_000})


def cut(events: Events, cuts: list[int]) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Records and owners of a stream that comes in runs."""
    tracker = FrameTracker(CONFIG)
    told = [tracker.feed(events[begin:end]) for begin, end in zip([0, *cuts], [*cuts, len(events)], strict=True)]
    return np.concatenate([*(part[0] for part in told), tracker.finish()]), np.concatenate([part[1] for part in told])


def test_where_the_stream_is_cut_changes_nothing() -> None:
    log, n = track(scene().recording, CONFIG), len(scene().recording.events)
    assert np.bincount(log.records["kind"])[Kind.MOVED] > 100
    assert (log.owner >= 0).mean() > 0.5
    random = np.random.default_rng(2)
    for cuts in ([n], [0, n // 2, n // 2], sorted(random.integers(0, n, 300).tolist()), list(range(1, 3_000))):
        records, owner = cut(scene().recording.events, cuts)
        np.testing.assert_array_equal(records, log.records)
        np.testing.assert_array_equal(owner, log.owner)


def test_a_caller_may_fill_its_arrays_anew() -> None:
    events, tracker, parts = scene().recording.events, FrameTracker(CONFIG), []
    room, n = Events.allocated(50), 200
    for begin in range(0, 50 * n, 50):
        for field in ("t_us", "x", "y", "p"):
            getattr(room, field)[:] = getattr(events, field)[begin : begin + 50]
        parts.append(tracker.feed(room)[0])
    whole, _ = FrameTracker(CONFIG).feed(events[: 50 * n])
    assert len(whole) > 20
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_the_log_is_in_order_and_its_events_are_there() -> None:
    log, events = track(scene().recording, CONFIG), scene().recording.events
    assert (np.diff(log.records["t_us"]) >= 0).all()
    assert (np.diff(log.records["event_index"]) >= 0).all()
    caused = log.records[log.records["kind"] != Kind.LOST]
    assert (events.t_us[caused["event_index"]] == caused["t_us"]).all()


def test_a_loss_is_stamped_with_its_time_and_the_next_event() -> None:
    """In the upper part of the picture everything ends at 0.3 s."""
    events = scene().recording.events
    events = events.where((events.t_us < 300_000) | (events.y > 170))
    log = track(Recording(events, 346, 260), CONFIG)
    lost = log.of_kind(Kind.LOST)
    assert len(lost) == 2
    assert (lost["event_index"] == np.searchsorted(events.t_us, lost["t_us"])).all()
    for row in lost:
        own = log.records[log.records["track_id"] == row["track_id"]]
        assert own["t_us"][-1] == row["t_us"] == own["t_us"][-2] + CONFIG.lifetime_us


def test_shifting_the_recording_in_time_shifts_the_log() -> None:
    events = scene().recording.events
    later = Events(events.t_us + 1_718_925_184_590_631, events.x, events.y, events.p)
    log = track(scene().recording, CONFIG)
    shifted = track(Recording(later, 346, 260), CONFIG).records.copy()
    shifted["t_us"] -= 1_718_925_184_590_631
    np.testing.assert_array_equal(shifted, log.records)


def test_filtered_events_are_numbered_as_in_the_recording() -> None:
    recording, keep = scene().recording, np.arange(len(scene().recording.events)) % 3 > 0
    kept = Recording(recording.events.where(keep), recording.width, recording.height)
    log, alone = track(recording, CONFIG, keep), track(kept, CONFIG)
    assert (log.owner[~keep] == DROPPED).all()
    np.testing.assert_array_equal(log.owner[keep], alone.owner)
    place = np.append(np.flatnonzero(keep), len(keep))
    np.testing.assert_array_equal(log.records["event_index"], place[alone.records["event_index"]])


def test_a_track_per_disc_near_its_disc(tmp_path: Path) -> None:
    scene().truth.save(tmp_path / "truth.csv")
    rule = load_rule("scene")
    scores = evaluate(track(scene().recording, CONFIG), read_truth(tmp_path / "truth.csv", rule), rule)
    assert scores.track_ids == 3
    assert scores.idsw == 0
    assert scores.position_error_px_median is not None
    assert scores.position_error_px_median < 1.5
    assert scores.hota > 0.75


def test_no_events() -> None:
    log = track(Recording(Events.empty(), 346, 260), CONFIG)
    assert (log.engine, len(log.records), len(log.owner)) == ("frames", 0, 0)


def test_time_must_not_run_back() -> None:
    tracker = FrameTracker(replace(CONFIG, frame_us=10))
    one = np.zeros(1, np.uint16)
    for t_us in (100, 105, 130):
        tracker.feed(Events(np.array([t_us]), one, one, one.astype(np.uint8)))
    with pytest.raises(RecordingError, match=r"^event 3: t = 129 us follows t = 130 us: time must not run back$"):
        tracker.feed(Events(np.array([129]), one, one, one.astype(np.uint8)))

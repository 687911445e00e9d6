# SPDX-License-Identifier: Apache-2.0
"""The main job on real recordings and on small ones: exact, its figures consistent, and whole or not there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.run import apply
from evcot.hardware.golden import track as cot_track
from evcot.hardware.modules import Module
from evcot.recordings.files import read_recording, write_recording
from evcot.trackers.presets import fit, for_sensor, preset, run_config
from evcot.trackers.rct.tracker import track as rct_track
from evcot.tracks.log import DROPPED, Kind, TrackLog
from evcot_cosim.lockstep.cosim import CosimRun, run_cosim
from evcot_cosim.lockstep.summary import summarise, table
from shared import SHARED

from ..conftest import Refused

RECORDINGS = {
    "traffic_outbound.aedat4": 788_761,
    "hand_dvs128.aedat4": 149_629,
    "fixture_evt2_640x480.raw": 521_252,
    "fixture_evt3_1280x720.raw": 219_596,
}


def same(a: TrackLog, b: TrackLog) -> bool:
    return np.array_equal(a.records, b.records) and np.array_equal(a.owner, b.owner)


def run(recording: Recording, preset_name: str | None = None, stall_seed: int | None = None) -> CosimRun:
    base = preset(preset_name) if preset_name else for_sensor(recording.width)
    return run_cosim(recording, fit(base, recording.width, recording.height), stall_seed=stall_seed)


@pytest.mark.parametrize(("name", "events"), RECORDINGS.items())
def test_real_recordings_are_exact_and_none_of_their_events_is_skipped(name: str, events: int) -> None:
    if not (SHARED / name).exists():
        pytest.skip(f"no {SHARED / name}: recordings are not part of the project")
    recording = read_recording(SHARED / name)
    done = run(recording)
    assert len(done.hardware.owner) == len(recording.events) == events
    assert same(done.hardware, done.model)
    assert len(done.hardware.of_kind(Kind.BORN)) > 0
    assert done.cycles >= events


@pytest.fixture(scope="module")
def blob() -> Recording:
    """A blob that crosses a 64x64 sensor from left to right, stops for 40 ms and comes back."""
    random = np.random.default_rng(1)
    half = np.arange(3_000, dtype=np.int64) * 10
    t_us = 1_000_000 + np.concatenate([half, half + half[-1] + 40_000])
    along = np.concatenate([10 + 44 * half / half[-1], 54 - 44 * half / half[-1]])
    x = np.clip(along + random.normal(0, 2, len(t_us)), 0, 63).astype(np.uint16)
    y = np.clip(32 + random.normal(0, 2, len(t_us)), 0, 63).astype(np.uint16)
    return Recording(Events(t_us, x, y, random.integers(2, size=len(t_us)).astype(np.uint8)), 64, 64, "blob")


def test_each_engine_logs_what_it_logs_alone(blob: Recording) -> None:
    done = run(blob)
    assert same(done.model, cot_track(blob, done.config.hardware))
    assert same(done.hardware, done.model)
    assert same(done.software, rct_track(blob, done.config.rct))
    assert [log.engine for log in (done.hardware, done.model, done.software)] == ["cot_array", "cot_array", "rct"]


def test_the_story_of_the_blob(blob: Recording) -> None:
    """Born, lost in the pause at last event + lifetime, born again; times are the recording's own."""
    done = run(blob)
    first, second = done.hardware.of_kind(Kind.BORN)
    (lost,) = done.hardware.of_kind(Kind.LOST)
    assert lost["track_id"] == first["track_id"] != second["track_id"]
    assert lost["t_us"] == blob.events.t_us[2_999] + done.config.hardware.slots[0].max_ticks
    assert lost["event_index"] == 3_000
    assert first["t_us"] == blob.events.t_us[first["event_index"]]
    assert (first["x"], second["x"]) == (pytest.approx(10, abs=3), pytest.approx(54, abs=3))
    assert done.agreement.tracks_corresponding == 2
    assert done.agreement.begin_us == 1_000_000


def test_stalls_change_clocks_and_nothing_else(blob: Recording) -> None:
    free, stalled = run(blob), run(blob, stall_seed=1)
    assert same(free.hardware, stalled.hardware)
    assert stalled.cycles > 2 * free.cycles


def test_progress_is_told_after_each_run_of_events(blob: Recording) -> None:
    result: list[tuple[int, int]] = []
    run_cosim(blob, fit(preset("dvs128"), 64, 64), progress=lambda events, t_us, _rate: result.append((events, t_us)))
    assert result == [(6_000, blob.duration_us)]


def test_a_recording_without_events_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"^nothing: holds no events$"):
        run(Recording(Events.empty(), 64, 64, "nothing"))


HOT = (20, 100)


def noisy_blob(count: int = 6_000) -> Recording:
    """A blob that wanders to the right, and a hot pixel at `HOT` that sends every third event."""
    rng = np.random.default_rng(4)
    t_us = np.sort(rng.integers(0, 300_000, count))
    x = np.clip(30 + t_us / 5_000 + rng.normal(0, 3, count), 0, 127).astype(np.uint16)
    y = np.clip(50 + rng.normal(0, 3, count), 0, 127).astype(np.uint16)
    hot = np.arange(count) % 3 == 0
    x[hot], y[hot] = HOT
    return Recording(Events(t_us, x, y, rng.integers(0, 2, count).astype(np.uint8)), 128, 128, "noisy")


def near(log: TrackLog, place: tuple[int, int], reach_px: float = 5) -> int:
    """How many records lie within `reach_px` of a pixel."""
    return int(np.count_nonzero(np.hypot(log.records["x"] - place[0], log.records["y"] - place[1]) < reach_px))


@pytest.mark.parametrize("module", ["cot_array", "cot_chain"])
def test_all_engines_work_behind_the_same_filters(module: Module) -> None:
    recording = noisy_blob()
    filters = FilterConfig(hot_pixels=(HOT,), activity_us=20_000)
    config = replace(run_config(128, 128, n_slots=4, hardware=module), filters=filters)
    run = run_cosim(recording, config)
    _, keep = apply(recording, filters)
    for log in (run.hardware, run.model, run.software):
        np.testing.assert_array_equal(log.owner == DROPPED, ~keep)
        assert len(log.records) > 10
        assert near(log, HOT) == 0
    assert np.array_equal(run.hardware.records, run.model.records)
    moved = run.hardware.records[run.hardware.records["kind"] == 1]
    assert keep[moved["event_index"]].all()  # in the recording's numbers: what moves a centre has stayed
    np.testing.assert_array_equal(moved["t_us"], recording.events.t_us[moved["event_index"]])
    bare = run_cosim(recording, replace(config, filters=FilterConfig()))
    assert near(bare.hardware, HOT) > 10  # it would have held a cluster
    assert near(bare.software, HOT) > 10


def test_hardware_and_model_have_the_same_memory_of_cells() -> None:
    recording = noisy_blob()
    filters = FilterConfig(refractory_us=5_000, activity_us=20_000, decay_tau_us=20_000.0, rowcol_us=90_000, cell_px=2)
    config = replace(fit(for_sensor(128), 128, 128, 4), filters=filters)
    run = run_cosim(recording, config)
    _, keep = apply(recording, filters)
    assert 0.02 < keep.mean() < 0.9
    for log in (run.hardware, run.model, run.software):
        np.testing.assert_array_equal(log.owner == DROPPED, ~keep)
    assert np.array_equal(run.hardware.records, run.model.records)


def test_a_summary_says_what_filters_removed() -> None:
    filters = FilterConfig(hot_pixels=(HOT,), activity_us=20_000)
    run = run_cosim(noisy_blob(), replace(run_config(128, 128, n_slots=4, hardware="cot_array"), filters=filters))
    summary = summarise(run, "")
    assert (summary["exact"], summary["filters"]) == (True, ["mask", "activity"])
    assert 0.3 < summary["filtered_fraction"] < 0.5
    assert summary["config"]["filters"]["hot_pixels"] == (HOT,)
    assert dict(table(summary))["filtered out"].endswith("of the events, by mask, activity")


def test_a_hot_pixel_outside_the_sensor_is_refused(home: Path, refused: Refused) -> None:
    write_recording(noisy_blob(100), home / "noisy.npz")
    (home / "run.toml").write_text("[filters]\nhot_pixels = [[200, 5]]\n")
    assert "(200, 5): must lie on the 128x128 sensor" in refused("cosim", "noisy.npz", "--config", "run.toml")


def test_a_sensor_that_trackers_cannot_remember_is_refused_before_anything_is_built(
    blob: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("evcot_cosim.lockstep.cosim.build_device", None)
    for width, height in ((65536, 65536), (4097, 4096)):
        with pytest.raises(RecordingError, match=rf"sensor {width}x{height}: .* must be at most 16,777,216"):
            run_cosim(replace(blob, width=width, height=height), run_config(width, height))

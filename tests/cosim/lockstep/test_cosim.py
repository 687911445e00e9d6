# SPDX-License-Identifier: Apache-2.0
"""The main job on real recordings and on small ones: exact, its figures consistent, and whole or not there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.hardware.golden import track as cot_track
from evcot.recordings.files import read_recording
from evcot.trackers.presets import fit, for_sensor, preset
from evcot.trackers.rct.tracker import track as rct_track
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.lockstep.cosim import CosimRun, check_addresses, run_cosim, stalls_from
from shared import SHARED

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
    assert len(stalls_from(None).source) == 0
    assert np.array_equal(stalls_from(1).source, stalls_from(1).source)


def test_progress_is_told_after_each_run_of_events(blob: Recording) -> None:
    result: list[tuple[int, int]] = []
    run_cosim(blob, fit(preset("dvs128"), 64, 64), progress=lambda events, t_us, _rate: result.append((events, t_us)))
    assert result == [(6_000, blob.duration_us)]


def test_a_recording_without_events_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"^nothing: holds no events$"):
        run(Recording(Events.empty(), 64, 64, "nothing"))


def test_addresses_must_reach_the_whole_sensor(blob: Recording) -> None:
    cot = fit(preset("dvs128"), 64, 64).hardware
    check_addresses(blob, cot)
    with pytest.raises(ConfigError, match=r"^shape.y_w = 6: too few bits for 65 pixels of blob$"):
        check_addresses(replace(blob, height=65), cot)

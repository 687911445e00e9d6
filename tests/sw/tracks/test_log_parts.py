# SPDX-License-Identifier: Apache-2.0
"""A log in parts: its parts are together the whole, and what is counted in them is what is counted in the whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Recording
from evcot.hardware.golden import track as cot_track
from evcot.metrics.quality import QualityCounter, isolated, isolation, quality_of
from evcot.scenes.registry import simulate_scene
from evcot.trackers.presets import run_config
from evcot.trackers.rct.config import PRESETS
from evcot.trackers.rct.tracker import track as rct_track
from evcot.tracks import column
from evcot.tracks.compare import Comparison, compare
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.log_parts import LogParts, life_lengths
from evcot.tracks.parquet import LogFile
from evcot.tracks.timeline import lifetimes
from evcot.tracks.track_pairs import ROW

PART = 2_003


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_scene("discs", 5, {"duration_us": 300_000}).recording


@pytest.fixture(scope="module")
def logs(recording: Recording) -> tuple[TrackLog, TrackLog]:
    """Of the hardware's model, whose records come with their events, and of a tracker that reports packet by packet."""
    config = run_config(recording.width, recording.height, hardware="cot_array")
    return cot_track(recording, config.device_config(recording.width, recording.height)), rct_track(recording, PRESETS["discs"])


def cut(log: TrackLog, n: int) -> list[tuple[TrackLog, TrackLog]]:
    parts = LogParts(log)
    return [parts.take(min(PART, n - begin), last=begin + PART >= n) for begin in range(0, n, PART)]


@pytest.mark.parametrize("which", [0, 1])
def test_the_parts_are_together_the_log(which: int, recording: Recording, logs: tuple[TrackLog, TrackLog]) -> None:
    log, n = logs[which], len(recording.events)
    assert n > 8 * PART
    own, past = [], 0
    for number, (whole, shown) in enumerate(cut(log, n)):
        records = whole.records[3 * past :].copy()
        assert np.array_equal(shown.records[past:][["t_us", "track_id", "x"]], records[["t_us", "track_id", "x"]])
        assert shown.records["event_index"].min(initial=0) == 0
        assert not len(records) or records["event_index"].max() <= PART
        records["event_index"] += number * PART
        own.append(records)
        past = int((lifetimes(whole, 0)["ended"] == -1).sum())
    assert np.array_equal(np.concatenate(own), log.records)
    assert np.array_equal(np.concatenate([whole.owner for whole, _ in cut(log, n)]), log.owner)


@pytest.mark.parametrize("which", [0, 1])
def test_quality_in_parts_is_that_of_the_whole(which: int, recording: Recording, logs: tuple[TrackLog, TrackLog]) -> None:
    log, events = logs[which], recording.events
    sensor = recording.width, recording.height
    counter, alone_in = QualityCounter(int(events.t_us[0]), int(events.t_us[-1])), isolation(sensor)
    parts = cut(log, len(events))
    for number, (whole, _) in enumerate(parts):
        own = events[number * PART : (number + 1) * PART]
        counter.add(whole, own, alone_in(own), last=number == len(parts) - 1)
    found, wanted = counter.quality(), quality_of(log, events, isolated(events, sensor))
    assert wanted.short or wanted.noise_tracks or wanted.tracks > 4
    assert found.owned_fraction == pytest.approx(wanted.owned_fraction, abs=2e-3)  # an event at a boundary's microsecond
    assert found.isolated_owned_fraction == pytest.approx(wanted.isolated_owned_fraction, abs=2e-3)
    alike = {name: getattr(wanted, name) for name in ("owned_fraction", "isolated_owned_fraction")}
    assert replace(found, **alike) == wanted


@pytest.mark.parametrize("most", [None, 2])
@pytest.mark.parametrize("in_files", [False, True])
def test_agreement_in_parts_is_that_of_the_whole(
    recording: Recording, logs: tuple[TrackLog, TrackLog], tmp_path: Path, in_files: bool, most: int | None
) -> None:
    t_us = recording.events.t_us
    begin_us, end_us = int(t_us[0]), int(t_us[-1])
    comparison = Comparison(begin_us, end_us, folder=tmp_path if in_files else None, most=most)
    hardware, software = (cut(log, len(t_us)) for log in logs)
    since_us = begin_us
    for number, (mine, theirs) in enumerate(zip(hardware, software, strict=True)):
        last = number == len(hardware) - 1
        until_us = int(t_us[min((number + 1) * PART, len(t_us)) - 1])
        comparison.add(mine[0], theirs[0], comparison.times_us(since_us, None if last else until_us), last=last)
        since_us = until_us
    found, wanted = comparison.agreement().to_dict(), compare(*logs, span_us=(begin_us, end_us)).to_dict()
    assert wanted["tracks"]
    assert len(wanted["merges_unpaired_hardware"]) > 2
    assert wanted["samples"] > 100
    assert found == {name: value[:most] if isinstance(value, tuple) else value for name, value in wanted.items()}
    for lengths, log in zip(comparison.lives, logs, strict=True):
        lives = lifetimes(log, end_us)
        lengths_s = (lives["end_us"] - lives["birth_us"]) / 1e6
        assert life_lengths(lengths) == {
            "tracks": len(lives), "lost": int((lives["ended"] == Kind.LOST).sum()),
            "median_s": float(np.median(lengths_s)), "longest_s": float(lengths_s.max()),
        }  # fmt: skip
    comparison.close()


def test_a_parquet_file_comes_in_the_same_parts(recording: Recording, logs: tuple[TrackLog, TrackLog], tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    log = logs[0]
    log.save(tmp_path / "log.parquet")
    file, n = LogFile(tmp_path / "log.parquet"), len(recording.events)
    parts = LogParts(file)
    for whole, _ in cut(log, n):
        other, _ = parts.take(len(whole.owner), last=len(whole.owner) < PART)
        assert np.array_equal(other.records, whole.records)
        assert np.array_equal(other.owner, whole.owner)


def test_long_stretches_without_a_record_come_back_from_parquet(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    records = np.zeros(3, TRACK)
    records["event_index"] = 5, 200_000, 3_000_000
    owner = (np.arange(3_000_000) % 7 - 2).astype(np.int16)
    log = TrackLog("cot_array", records, owner, "0123")
    log.save(tmp_path / "log.parquet")
    loaded = TrackLog.load(tmp_path / "log.parquet")
    assert np.array_equal(loaded.records, records)
    assert np.array_equal(loaded.owner, owner)
    assert (loaded.engine, loaded.recording) == ("cot_array", "0123")
    with parquet.ParquetFile(tmp_path / "log.parquet") as file:
        assert file.num_row_groups == 6, "2^19 owners each"
        lengths = [len(own) for own in file.read(columns=["owners"]).column("owners").to_pylist()]
    assert max(lengths) == 1 << 16
    assert sum(lengths) == len(owner)


@pytest.mark.parametrize("count", [1, 2, 7, 50])
@pytest.mark.parametrize("longest_us", [0, 5, 1 << 16, 3_000_000, 1 << 44])
def test_lengths_of_lives_are_those_of_numpy(count: int, longest_us: int) -> None:
    rng = np.random.default_rng(count + longest_us)
    lives = column.HeldColumn(ROW)
    lives.append(np.zeros(0, ROW))
    assert life_lengths(lives) == {"tracks": 0, "lost": 0, "median_s": None, "longest_s": None}
    for _ in range(3):
        part = np.zeros(count, ROW)
        part["birth_us"] = rng.integers(0, 1_000, count)
        part["end_us"] = part["birth_us"] + rng.integers(0, longest_us + 1, count)
        part["ended"] = rng.integers(-1, 4, count)
        lives.append(part)
    rows = lives[:]
    lengths_s = (rows["end_us"] - rows["birth_us"]) / 1e6
    assert life_lengths(lives) == {
        "tracks": 3 * count, "lost": int((rows["ended"] == Kind.LOST).sum()),
        "median_s": float(np.median(lengths_s)), "longest_s": float(lengths_s.max()),
    }  # fmt: skip

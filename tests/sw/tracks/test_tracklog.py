# SPDX-License-Identifier: Apache-2.0
"""The track log, and counts that are kept while it grows."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import EvcotError, OutputError, TrackLogError
from evcot.tracks.log import TRACK, VERDICT, Kind, TrackLog
from evcot.tracks.tally import IdSet, Tally


@pytest.fixture
def log() -> TrackLog:
    """Numbers that a careless format would round, and every kind of record."""
    rng = np.random.default_rng(5)
    records = np.zeros(200_000, TRACK)
    records["t_us"] = np.sort(rng.integers(-(10**15), 10**15, len(records)))
    records["event_index"] = np.arange(len(records)) + 2**53
    records["kind"] = rng.integers(0, len(Kind), len(records))
    for name in ("x", "y", "radius", "width", "height", "angle", "vx", "vy", "confidence"):
        records[name] = rng.random(len(records)) * 10.0 ** rng.integers(-9, 9, len(records))
    records["other_id"] = -1
    return TrackLog("cot_array", records, rng.integers(-1, 64, 300_000).astype(np.int16))


def test_npz_gives_back_what_it_got(log: TrackLog, tmp_path: Path) -> None:
    log.save_npz(tmp_path / "log.npz")
    back = TrackLog.load_npz(tmp_path / "log.npz")
    assert back.engine == "cot_array"
    assert back.records.dtype == TRACK
    assert back.owner.dtype == np.dtype(np.int16)
    np.testing.assert_array_equal(back.records, log.records)
    np.testing.assert_array_equal(back.owner, log.owner)


def test_an_empty_log_goes_both_ways(tmp_path: Path) -> None:
    TrackLog.empty("rct").save_npz(tmp_path / "log.npz")
    back = TrackLog.load_npz(tmp_path / "log.npz")
    assert (back.engine, len(back.records), len(back.owner)) == ("rct", 0, 0)
    back.write_csv(tmp_path / "log.csv")
    assert (tmp_path / "log.csv").read_text() == ",".join(TRACK.names or ()) + "\n"


def test_the_same_log_gives_the_same_bytes(log: TrackLog, tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        log.save_npz(tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.fixture
def verdicts() -> np.ndarray:
    """Track 0 is a 7, and later none of the classes."""
    made = np.zeros(2, VERDICT)
    made["t_us"], made["class_id"], made["margin"], made["windows"] = (0, 10**14), (7, -1), (40, 3), (1, 2)
    return made


def test_verdicts_come_back_and_are_in_the_csv(log: TrackLog, verdicts: np.ndarray, tmp_path: Path) -> None:
    own = replace(log, verdicts=verdicts)
    own.save_npz(tmp_path / "log.npz")
    np.testing.assert_array_equal(TrackLog.load_npz(tmp_path / "log.npz").verdicts, verdicts)
    own.write_csv(tmp_path / "log.csv")
    with (tmp_path / "log.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    t_us = log.records["t_us"]
    assert [int(row["class_id"]) for row in rows] == np.where((t_us >= 0) & (t_us < 10**14), 7, -1).tolist()


def test_verdicts_are_not_lost_in_parquet(log: TrackLog, verdicts: np.ndarray, tmp_path: Path) -> None:
    with pytest.raises(TrackLogError, match=r"log.parquet: the log has verdicts, which Parquet does not keep: must be"):
        replace(log, verdicts=verdicts).save(tmp_path / "log.parquet")
    assert not list(tmp_path.iterdir())


def test_verdicts_of_another_type_are_refused(log: TrackLog, tmp_path: Path) -> None:
    log.save_npz(tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz") as archive:
        np.savez(tmp_path / "other.npz", **archive, verdicts=np.zeros(3))
    with pytest.raises(TrackLogError, match=r"other.npz: verdicts is 1-d float64: must be 1-d"):
        TrackLog.load_npz(tmp_path / "other.npz")


def test_csv_is_exact_and_names_the_kinds(log: TrackLog, tmp_path: Path) -> None:
    log.write_csv(tmp_path / "log.csv")
    with (tmp_path / "log.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(log.records)
    assert list(rows[0]) == list(TRACK.names or ())
    assert [row["kind"] for row in rows[:50]] == [Kind(kind).name for kind in log.records["kind"][:50]]
    for name, number in (
        ("t_us", int),
        ("event_index", int),
        ("x", float),
        ("radius", float),
        ("height", float),
        ("vy", float),
        ("confidence", float),
        ("other_id", int),
    ):
        assert [number(row[name]) for row in rows] == log.records[name].tolist()


def test_nothing_is_left_behind_when_writing_fails(log: TrackLog, tmp_path: Path) -> None:
    target = tmp_path / "taken"
    target.mkdir()
    for write in (log.save_npz, log.write_csv):
        with pytest.raises(OutputError, match=r"taken: is a folder: must be a file$"):
            write(target)
    with pytest.raises(OutputError, match=r"log\.npz: cannot be written: No such file or directory$"):
        log.save_npz(tmp_path / "absent" / "log.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_an_interrupted_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.npz"
    TrackLog.empty("rct").save_npz(path)

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(np.lib.format, "write_array_header_1_0", interrupted)
    with pytest.raises(KeyboardInterrupt):
        TrackLog.empty("cot_array").save_npz(path, force=True)
    assert TrackLog.load_npz(path).engine == "rct"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_no_whole_log_is_refused_in_one_line(log: TrackLog, tmp_path: Path) -> None:
    path = tmp_path / "log.npz"

    def refused(reason: str) -> None:
        with pytest.raises(TrackLogError, match=rf"log\.npz: {reason}") as caught:
            TrackLog.load_npz(path)
        assert "\n" not in str(caught.value)
        assert isinstance(caught.value, (EvcotError, ValueError))

    refused("cannot be read: No such file or directory$")
    path.write_bytes(b"")
    refused("is not an npz file, or is cut off$")
    path.write_text("t_us,event_index\n")
    refused("is not an npz file, or is cut off$")
    log.save_npz(path, force=True)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    refused("is not an npz file, or is cut off$")
    path.write_bytes(whole[:2000] + bytes([whole[2000] ^ 1]) + whole[2001:])
    refused("is damaged: ")
    np.savez(path, engine=np.array("rct"), records=log.records)
    refused("has no array owner: must have engine, records, owner$")
    np.savez(path, engine=np.array("rct"), records=np.zeros(3), owner=log.owner)
    refused(r"records is 1-d float64: must be 1-d \[")
    older = [name for name in TRACK.names or () if name not in ("width", "height", "angle", "vx", "vy", "confidence")]
    np.savez(path, engine=np.array("rct"), records=np.zeros(3, [(name, TRACK[name]) for name in older]), owner=log.owner)
    refused("records lacks width, height, angle, vx, vy, confidence: must be a log of this version: track the recording again$")
    np.savez(path, engine=np.array("rct"), records=log.records, owner=log.owner.reshape(2, -1))
    refused("owner is 2-d int16: must be 1-d int16$")


def test_a_track_that_was_lost_and_is_found_again_is_alive() -> None:
    kinds = [Kind.BORN, Kind.MOVED, Kind.BORN, Kind.LOST, Kind.LOST, Kind.MOVED, Kind.BORN, Kind.MERGED]
    records = np.zeros(len(kinds), TRACK)
    records["kind"] = kinds
    records["track_id"] = [0, 0, 1, 0, 1, 0, 2, 2]
    records["t_us"] = np.arange(len(kinds))
    for size in (1, 3, len(kinds)):
        tally = Tally()
        for begin in range(0, len(kinds), size):
            tally.add(records[begin : begin + size], np.empty(0, np.int16))
        assert tally.alive == 1
        assert tally.kinds[Kind.LOST] == 2


def test_ids_that_were_added_are_there_and_no_others() -> None:
    ids, wanted = IdSet(), set[int]()
    assert 0 not in ids
    for part in ([], [3, 3, 0], [8, 1_000], [-1, 1 << 27, (1 << 62) + 1], [(1 << 27) - 1, 7]):
        ids.add(np.array(part, np.int64))
        wanted |= set(part)
        for each in {-2, 1, 2, 9, 999, 1_001, (1 << 27) + 1, (1 << 27) - 2, 1 << 62, *wanted}:
            assert (each in ids) == (each in wanted), each


def test_a_million_ids_take_a_bit_each() -> None:
    ids = IdSet()
    for begin in range(0, 1_000_000, 50_000):
        ids.add(np.arange(begin, begin + 50_000))
    assert ids.nbytes <= 2 * 1_000_000 // 8 + 8
    assert 999_999 in ids
    assert 1_000_000 not in ids

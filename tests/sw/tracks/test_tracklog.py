# SPDX-License-Identifier: Apache-2.0
"""The track log, and counts that are kept while it grows."""

from __future__ import annotations

import csv
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from evcot.digest import EventsDigest, digest
from evcot.errors import EvcotError, OutputError, TrackLogError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.scenes.registry import simulate_scene
from evcot.trackers.engines import ENGINES
from evcot.tracks.log import TRACK, VERDICT, Kind, TrackLog
from evcot.tracks.log_files import Extent, check_belongs
from evcot.tracks.tally import IdSet, Tally
from evcot.tracks.tracking import log_of
from support.refusals import refused


@pytest.fixture
def log() -> TrackLog:
    """Numbers that a careless format would round, and every kind of record."""
    rng = np.random.default_rng(5)
    records = np.zeros(20_000, TRACK)
    records["t_us"] = np.sort(rng.integers(-(10**15), 10**15, len(records)))
    records["event_index"] = np.arange(len(records)) + 2**53
    records["kind"] = rng.integers(0, len(Kind), len(records))
    for name in ("x", "y", "radius", "width", "height", "angle", "vx", "vy", "confidence"):
        records[name] = rng.random(len(records)) * 10.0 ** rng.integers(-9, 9, len(records))
    records["other_id"] = -1
    return TrackLog("cot_array", records, rng.integers(-1, 64, 30_000).astype(np.int16))


def test_npz_gives_back_what_it_got_and_has_the_same_bytes_each_time(log: TrackLog, tmp_path: Path) -> None:
    for name in ("log.npz", "again.npz"):
        log.save_npz(tmp_path / name)
    assert (tmp_path / "log.npz").read_bytes() == (tmp_path / "again.npz").read_bytes()
    back = TrackLog.load_npz(tmp_path / "log.npz")
    assert (back.engine, back.records.dtype, back.owner.dtype) == ("cot_array", TRACK, np.dtype(np.int16))
    np.testing.assert_array_equal(back.records, log.records)
    np.testing.assert_array_equal(back.owner, log.owner)


def test_an_empty_log_goes_both_ways(tmp_path: Path) -> None:
    TrackLog.empty("rct").save_npz(tmp_path / "log.npz")
    back = TrackLog.load_npz(tmp_path / "log.npz")
    assert (back.engine, len(back.records), len(back.owner)) == ("rct", 0, 0)
    back.write_csv(tmp_path / "log.csv")
    assert (tmp_path / "log.csv").read_text() == ",".join(TRACK.names or ()) + "\n"


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


@pytest.mark.parametrize("suffix", ["npz", "parquet"])
def test_verdicts_come_back_with_the_names_of_their_classes(
    log: TrackLog, verdicts: np.ndarray, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"log.{suffix}"
    replace(log, verdicts=verdicts, class_names={7: "car", 10: "größer"}).save(path)
    found = TrackLog.load(path)
    np.testing.assert_array_equal(found.verdicts, verdicts)
    assert found.class_names == {7: "car", 10: "größer"}
    np.testing.assert_array_equal(found.records, log.records)
    np.testing.assert_array_equal(found.owner, log.owner)


@pytest.mark.parametrize("names", ["[1]", "{", '{"a": "car"}', '{"1": ""}', '{"1": "two\\nlines"}', '{"1": 1}'])
def test_names_that_no_log_has_are_refused(log: TrackLog, tmp_path: Path, names: str) -> None:
    log.save_npz(tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz") as archive:
        np.savez(tmp_path / "other.npz", **archive, class_names=np.array(names))
    with pytest.raises(TrackLogError, match=r"other.npz: class_names = .*: must be JSON, an object of class numbers and names"):
        TrackLog.load_npz(tmp_path / "other.npz")


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
    assert list(rows[0]) == list(TRACK.names or ())
    assert [row["kind"] for row in rows] == [Kind(kind).name for kind in log.records["kind"]]
    for name in ("t_us", "event_index", "x", "radius", "height", "vy", "confidence", "other_id"):
        number = int if TRACK[name].kind in "iu" else float
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


@cache
def scene() -> Recording:
    return simulate_scene("discs", 3, {"duration_us": 100_000}).recording


def make_events(count: int, first_us: int = 100) -> Events:
    return Events(first_us + np.arange(count), *(np.arange(count, dtype=np.uint16),) * 2, np.zeros(count, np.uint8))


def make_log(events: Events) -> TrackLog:
    """A track that is born with the first event, and moves with the last."""
    records = np.zeros(2, TRACK)
    records["kind"] = Kind.BORN, Kind.MOVED
    records["event_index"] = 0, len(events) - 1
    records["t_us"] = events.t_us[[0, -1]]
    return TrackLog("rct", records, np.zeros(len(events), np.int16))


def test_a_log_belongs_to_its_events() -> None:
    events = make_events(10)
    check_belongs(make_log(events), Extent.of([events[:3], events[3:3], events[3:]]))
    check_belongs(replace(make_log(events), recording=digest(events)), Extent.of([events]))
    check_belongs(TrackLog.empty("rct"), Extent.of([]))


@pytest.mark.parametrize(
    ("of", "message"),
    [
        (make_events(11), "owner has 10 entries: must be one for each of the recording's 11 events"),
        (make_events(10, 101), "record 0: t_us = 100: must be from 101 to 110, as the recording's events are"),
        (make_events(10, 99), "record 1: t_us = 109: must be from 99 to 108, as the recording's events are"),
    ],
)
def test_a_log_of_other_events_is_refused_by_what_it_shows(of: Events, message: str) -> None:
    with refused(TrackLogError, message):
        check_belongs(make_log(make_events(10)), Extent.of([of]))


@pytest.mark.parametrize("index", [-1, 11])
def test_a_record_of_no_event_is_refused(index: int) -> None:
    events = make_events(10)
    log = make_log(events)
    log.records["event_index"][1] = index
    with pytest.raises(TrackLogError, match=f"record 1: event_index = {index}: must be from 0 to 10"):
        check_belongs(log, Extent.of([events]))


def test_a_digest_tells_apart_what_looks_alike() -> None:
    events = make_events(10)
    other = replace(events, x=events.x[::-1].copy())
    check_belongs(make_log(events), Extent.of([other]))
    with pytest.raises(TrackLogError) as caught:
        check_belongs(replace(make_log(events), recording=digest(events)), Extent.of([other]))
    expected = f"recording = '{digest(events)}': must be the digest of the recording's events, '{digest(other)}'"
    assert str(caught.value) == expected


def test_a_digest_does_not_depend_on_where_blocks_are_cut_but_on_every_column() -> None:
    events, summary = scene().events, EventsDigest()
    for begin in range(0, len(events), 1_013):
        summary.add(events[begin : begin + 1_013])
    assert summary.hex() == digest(events)
    for name in ("t_us", "x", "y", "p"):
        column = getattr(events, name).copy()
        column[-1] ^= 1
        assert digest(replace(events, **{name: column})) != digest(events)


def test_a_stored_log_keeps_the_digest_of_its_recording(tmp_path: Path) -> None:
    log = make_log(make_events(10))
    log.save_npz(tmp_path / "none.npz")
    assert TrackLog.load_npz(tmp_path / "none.npz").recording == ""
    replace(log, recording="0123456789abcdef").save_npz(tmp_path / "one.npz")
    assert TrackLog.load_npz(tmp_path / "one.npz").recording == "0123456789abcdef"


@pytest.mark.parametrize("engine", ENGINES)
def test_every_engines_log_belongs(engine: str) -> None:
    """No record has a time after the recording's end, wherever the recording is cut."""
    kind = ENGINES[engine]
    preset = "discs" if "discs" in kind.presets else next(iter(kind.presets))
    for count in (1, 997, len(scene().events) // 2, len(scene().events)):
        events = scene().events[:count]
        tracker = kind.start(kind.presets[preset], FilterConfig(), (scene().width, scene().height))
        log = log_of(engine, tracker, [events])
        check_belongs(log, Extent.of([events]))
    assert len(log.of_kind(Kind.MOVED)) > 0

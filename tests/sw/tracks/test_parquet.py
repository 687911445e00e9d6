# SPDX-License-Identifier: Apache-2.0
"""A TrackLog as Parquet: the same log comes back, other programs read it, and what is none is refused in a line."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.errors import TrackLogError
from evcot.tracks.log import TRACK, VERDICT, TrackLog
from evcot_cosim.cli import main
from support.sweeping import recorded

arrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> TrackLog:
    path = recorded(tmp_path_factory.mktemp("log"), 1)
    return evcot.track(path, "rct", "discs", filters=evcot.FilterConfig(polarity="on"))


def same(one: TrackLog, other: TrackLog) -> bool:
    arrays = all(getattr(one, name).dtype == getattr(other, name).dtype for name in ("records", "owner"))
    equal = np.array_equal(one.records, other.records) and np.array_equal(one.owner, other.owner)
    return arrays and equal and (one.engine, one.recording) == (other.engine, other.recording)


def test_a_log_comes_back(log: TrackLog, tmp_path: Path) -> None:
    assert len(log.records) > 10
    assert set(np.unique(log.owner).tolist()) >= {-2, -1, 0}
    log.save(tmp_path / "log.parquet")
    assert same(TrackLog.load(tmp_path / "log.parquet"), log)
    log.save(tmp_path / "again.parquet")
    assert (tmp_path / "again.parquet").read_bytes() == (tmp_path / "log.parquet").read_bytes()
    log.save(tmp_path / "log.npz")
    assert same(TrackLog.load(tmp_path / "log.npz"), log)


def test_logs_without_records_or_events_come_back(tmp_path: Path) -> None:
    for name, log in (
        ("empty", TrackLog.empty("rct")),
        ("passed", TrackLog("cot_array", np.empty(0, TRACK), np.full(7, -1, np.int16))),
    ):
        log.save(tmp_path / f"{name}.parquet")
        assert same(TrackLog.load(tmp_path / f"{name}.parquet"), log)


def test_others_read_records_and_owners(log: TrackLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    duckdb = pytest.importorskip("duckdb")
    log.save(tmp_path / "log.parquet")
    monkeypatch.chdir(tmp_path)
    born = duckdb.sql("SELECT t_us, x FROM 'log.parquet' WHERE kind = 'BORN'").fetchall()
    assert born == [(int(row["t_us"]), float(row["x"])) for row in log.of_kind(evcot.Kind.BORN)]
    assert [row[0] for row in duckdb.sql("SELECT unnest(owners) FROM 'log.parquet'").fetchall()] == log.owner.tolist()
    # The owners of a row end with the event of its record.
    ends = np.cumsum([len(own) for own in parquet.read_table("log.parquet").column("owners").to_pylist()])[:-1]
    assert np.array_equal(ends, np.minimum(log.records["event_index"] + 1, len(log.owner)))


def test_the_commands_take_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = recorded(tmp_path, 2)
    for suffix in ("npz", "parquet"):
        assert (
            main(["track", str(path), "--engine", "rct", "--preset", "discs", "-q", "-o", str(tmp_path / f"log.{suffix}")]) == 0
        )
    assert same(TrackLog.load(tmp_path / "log.npz"), TrackLog.load(tmp_path / "log.parquet"))
    printed = []
    for suffix in ("npz", "parquet"):
        truth = str(tmp_path / "discs2.truth.csv")
        assert main(["evaluate", str(tmp_path / f"log.{suffix}"), "--truth", truth, "--sensor", "96x64"]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]
    assert main(["track", str(path), "-q", "-o", str(tmp_path / "log.parquet")]) == 2, "it exists"


@pytest.fixture
def in_files(log: TrackLog, monkeypatch: pytest.MonkeyPatch) -> int:
    """Files of three groups of 8 records; how many the log has."""
    monkeypatch.setattr(evcot.tracks.parquet, "_RECORDS", 8)
    monkeypatch.setattr(evcot.tracks.parquet, "_FILE_GROUPS", 3)
    files = -(-(len(log.records) + 1) // 24)
    assert files >= 3
    return files


def test_verdicts_come_first_and_others_read_them(log: TrackLog, in_files: int, tmp_path: Path) -> None:
    verdicts = np.zeros(61, VERDICT)  # eight groups of rows in three files
    for number, name in enumerate(VERDICT.names or ()):
        verdicts[name] = np.arange(61) % 17 + number
    classified = replace(log, verdicts=verdicts, class_names={4: "car"})
    path = tmp_path / "log.parquet"
    classified.save(path)
    found = TrackLog.load(path)
    assert same(found, log)
    assert found.class_names == {4: "car"}
    assert np.array_equal(found.verdicts, verdicts)
    names = ["log.parquet", *(f"log.{number}.parquet" for number in (1, 2))]
    table = arrow.concat_tables([parquet.read_table(tmp_path / name) for name in names]).slice(0, 62).to_pylist()
    assert [row["kind"] for row in table] == ["VERDICT"] * 61 + ["BORN"]
    assert [row["class_id"] for row in table] == [*verdicts["class_id"].tolist(), None]
    assert [row["x"] for row in table[:61]] == [None] * 61


def test_a_long_log_goes_on_in_other_files(log: TrackLog, in_files: int, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    log.save(path)
    names = ["log.parquet", *(f"log.{number}.parquet" for number in range(1, in_files))]
    assert {file.name for file in tmp_path.iterdir()} == set(names)
    kinds = [parquet.read_table(tmp_path / name, columns=["kind"]).column("kind").to_pylist() for name in names]
    assert [len(kind) for kind in kinds[:-1]] == [24] * (in_files - 1)
    assert ["END" in kind for kind in kinds] == [False] * (in_files - 1) + [True]
    assert same(TrackLog.load(path), log)
    # A shorter one in its place: what an earlier log left is no part of it.
    short = TrackLog(log.engine, log.records[:10], log.owner[: int(log.records[9]["event_index"]) + 1], log.recording)
    short.save(path, force=True)
    assert (tmp_path / names[1]).exists()
    assert same(TrackLog.load(path), short)


def test_every_file_of_a_long_log_must_be_there_and_none_is_overwritten(log: TrackLog, in_files: int, tmp_path: Path) -> None:
    path, last = tmp_path / "log.parquet", tmp_path / f"log.{in_files - 1}.parquet"
    short = TrackLog(log.engine, log.records[:5], log.owner[: int(log.records[4]["event_index"]) + 1], log.recording)
    for make in (
        lambda: last.write_text("mine"),
        lambda: short.save(last, force=True),
    ):  # a log of its own is no part of another
        make()
        mine = last.read_bytes()
        for force in (False, True):  # nobody has named that file
            with pytest.raises(evcot.errors.OutputError, match=f"{last.name}: exists"):
                log.save(path, force=force)
            assert [file.name for file in tmp_path.iterdir()] == [last.name]
            assert last.read_bytes() == mine
    last.unlink()
    for force in (False, True):
        log.save(path, force=force)
        assert same(TrackLog.load(path), log)
    stranger = TrackLog("frames", log.records, log.owner, log.recording)
    stranger.save(tmp_path / "stranger.parquet")
    (tmp_path / f"stranger.{in_files - 1}.parquet").replace(last)
    with pytest.raises(TrackLogError, match=f"{last.name}: is of engine, recording .'frames', .*: must go on with log.parquet"):
        TrackLog.load(path)
    last.unlink()
    with pytest.raises(TrackLogError, match=f"log.parquet: the last row is no END, and there is no {last.name}: must be"):
        TrackLog.load(path)


def test_what_is_no_log_is_refused(log: TrackLog, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    log.save(path)
    whole, table = path.read_bytes(), parquet.read_table(path)

    def refused(why: str) -> None:
        with pytest.raises(TrackLogError) as error:
            TrackLog.load(path)
        assert str(error.value).startswith(f"{path}: ")
        assert why in str(error.value)
        assert "\n" not in str(error.value)

    path.write_bytes(whole[: len(whole) // 2])
    refused("is damaged, or no Parquet file")
    group = parquet.read_metadata(arrow.BufferReader(whole)).row_group(0)
    column = group.column(group.num_columns - 1)  # the owners
    at = column.data_page_offset + column.total_compressed_size - 5
    at = min(at, (column.dictionary_page_offset or column.data_page_offset) + column.total_compressed_size - 5)
    path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
    refused("is damaged, or no Parquet file")
    for changed, why in (
        (table.slice(0, table.num_rows - 1), "the last row is no END, and there is no log.1.parquet: must be a whole log"),
        (table.drop_columns(["vx", "owners"]), "lacks vx, owners: must be a log as `evcot track -o LOG.parquet` writes it"),
        (table.set_column(0, "t_us", table.column("t_us").cast("int32")), "t_us is int32: must be int64"),
        (arrow.concat_tables([table.slice(table.num_rows - 1), table]), "row 0: kind = 'END': must be one of BORN, MOVED"),
    ):
        parquet.write_table(changed, path)
        refused(why)
    path.unlink()
    refused("cannot be read: No such file or directory")


def test_pyarrow_is_asked_for(log: TrackLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(TrackLogError, match=r"log.parquet: pyarrow is not installed: .* pip install 'evcot\[sweep\]'"):
        log.save(tmp_path / "log.parquet")
    assert not list(tmp_path.iterdir())

# SPDX-License-Identifier: Apache-2.0
"""The store: one row a run, complete files alone, nothing lost when the writer is killed."""

from __future__ import annotations

import json
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from evcot.errors import ConfigError, OutputError, RecordingWarning
from evcot.unfinished import Unfinished
from evcot_cosim.sweep import execute
from evcot_cosim.sweep import store as store_module
from evcot_cosim.sweep.metrics import METRICS
from evcot_cosim.sweep.plan import Planner, points_of
from evcot_cosim.sweep.pool import LocalPool
from evcot_cosim.sweep.spec import spec_from
from evcot_cosim.sweep.store import COLUMNS, Store, read_rows
from evcot_cosim.sweep.task import Task
from support.sweeping import BLOCK, CHECKPOINT, dies_once, recorded, small

pytest.importorskip("pyarrow")


def row(number: int, status: str = "done", **settings: Any) -> dict[str, Any]:
    return {"key": f"{number:016x}", "status": status, "engine": "rct", "hota": number / 7, "settings": settings, "task": "{}"}


def keys(folder: Path) -> list[str]:
    return [each["key"] for each in read_rows(folder)]


def test_rows_are_a_dataset_of_one_file_in_the_end(tmp_path: Path) -> None:
    for begin in (0, 3):
        with Store(tmp_path) as store:
            for number in range(begin, begin + 3):
                store.add(row(number, **{"rct.radius_px": 1.5 * number, "cot.init_radix": number}))
                store.flush()
    rows = read_rows(tmp_path)
    assert [each["hota"] for each in rows] == [number / 7 for number in range(6)], "bit for bit"
    assert [each["rct.radius_px"] for each in rows] == [1.5 * number for number in range(6)]
    assert [each["cot.init_radix"] for each in rows] == list(range(6))
    assert set(COLUMNS) <= rows[0].keys()
    assert len(list((tmp_path / "runs").iterdir())) == 1
    assert (tmp_path / "journal.jsonl").read_bytes() == b""


def test_fields_that_only_some_runs_have_are_null_elsewhere(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        store.add(row(1, a=1))
        store.flush()
        store.add(row(2, a=2.5, b="text", c=[1, 2]))
    assert [(each["a"], each["b"], each["c"]) for each in read_rows(tmp_path)] == [(1.0, None, None), (2.5, "text", "[1, 2]")]


def test_a_writer_that_is_killed_loses_no_row(tmp_path: Path) -> None:
    first = Store(tmp_path)
    first.add(row(1))
    first.flush()
    first.add(row(2))
    first.add(row(3))
    copy = tmp_path.with_name("copy")
    shutil.copytree(tmp_path, copy)  # as the disk is at that moment
    with (copy / "journal.jsonl").open("ab") as journal:
        journal.write(json.dumps(row(4)).encode()[:40])  # and a line that is cut off
    (copy / "runs.json").write_text('{"files": ["runs-000001.parquet", "runs-000002.parquet"]}')  # before its file is written
    (copy / "runs" / ".runs-000002.parquet.partial").write_bytes(b"half a file")
    with Store(copy) as again:
        assert again.status == {f"{number:016x}": "done" for number in (1, 2, 3)}
        assert again.read(["status"]) == [{"key": f"{number:016x}", "status": "done"} for number in (1, 2, 3)]
        again.add(row(4))
    assert keys(copy) == [f"{number:016x}" for number in (1, 2, 3, 4)]
    first._journal.close()


def test_a_journal_whose_rows_are_in_the_dataset_already_adds_none(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        store.add(row(1))
        line = (tmp_path / "journal.jsonl").read_bytes()
    (tmp_path / "journal.jsonl").write_bytes(line)
    with Store(tmp_path):
        pass
    assert keys(tmp_path) == [f"{1:016x}"]
    assert store_module.require_pyarrow().parquet.read_table(tmp_path / "runs").num_rows == 1


def test_of_a_run_that_is_done_again_the_later_row_counts(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        store.add(row(1, "failed"))
        store.flush()
        store.add(row(1, "done"))
    assert [(each["key"], each["status"]) for each in read_rows(tmp_path)] == [(f"{1:016x}", "done")]
    assert store_module.require_pyarrow().parquet.read_table(tmp_path / "runs").num_rows == 1


def test_a_full_disk_leaves_whole_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Store(tmp_path) as store:
        store.add(row(1))
        with Path("/dev/full").open("r+b", buffering=0) as full:
            journal = store._journal

            class Full:
                def fileno(self) -> int:
                    return journal.fileno()

                def write(self, data: bytes) -> int:
                    journal.write(data[:10])
                    return full.write(data)

                def truncate(self, size: int) -> int:
                    return journal.truncate(size)

                def close(self) -> None:
                    journal.close()

            monkeypatch.setattr(store, "_journal", Full())
            with pytest.raises(OutputError, match=r"journal.jsonl: cannot be written: No space left"):
                store.add(row(2))
            assert (tmp_path / "journal.jsonl").read_bytes().endswith(b"\n")
    assert keys(tmp_path) == [f"{1:016x}"]


def test_files_that_the_index_does_not_name_are_the_users(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        store.add(row(1))
    runs = tmp_path / "runs"
    mine = [
        "runs-backup.parquet",
        "runs-000007.parquet",
        ".runs-000001.parquet.partial.partial",
        ".runs-000008.parquet.partial",
    ]
    for name in mine:
        (runs / name).write_bytes(b"mine")
    with Store(tmp_path) as store:
        store.add(row(2))
    assert keys(tmp_path) == [f"{1:016x}", f"{2:016x}"]
    assert [(runs / name).read_bytes() for name in mine] == [b"mine"] * len(mine)
    assert sorted(path.name for path in runs.iterdir()) == sorted([*mine, "runs-000010.parquet"])


@pytest.mark.parametrize("name", ["runs", "journal.jsonl"])
def test_a_store_is_not_made_over_something_else(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    with pytest.raises(OutputError, match=f"{name}: exists, and no sweep made it: must be moved away"):
        Store(tmp_path)


@pytest.mark.parametrize("name", ["../mine.parquet", "/tmp/runs-000001.parquet", "runs-1.parquet", 7])
def test_an_index_names_files_of_the_store_alone(tmp_path: Path, name: object) -> None:
    (tmp_path / "runs.json").write_text(json.dumps({"files": [name]}))
    with pytest.raises(ConfigError, match=r"runs\.json: files: .*: must be a name such as runs-000001\.parquet$"):
        read_rows(tmp_path)


def test_a_key_is_no_path(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        store.add(row(1) | {"key": "../../mine"})
    with pytest.raises(ConfigError, match=r"runs-000001.parquet: key = '../../mine': must have 16 hexadecimal digits"):
        read_rows(tmp_path)


def test_a_damaged_line_of_the_journal_costs_that_line(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        for number in range(1, 4):
            store.add(row(number))
        lines = (tmp_path / "journal.jsonl").read_bytes().splitlines(keepends=True)
    shutil.rmtree(tmp_path / "runs")
    (tmp_path / "runs.json").write_text('{"files": []}')
    (tmp_path / "journal.jsonl").write_bytes(
        lines[0] + b'{"key": 1}\n' + b"\x00" * 40 + b"\n" + b"[" * 99_999 + b"\n" + lines[2]
    )
    with pytest.warns(RecordingWarning, match=r"journal\.jsonl: line [234] is damaged") as warned, Store(tmp_path):
        pass
    assert len(warned) == 3
    assert keys(tmp_path) == [f"{1:016x}", f"{3:016x}"]


def test_two_sweeps_do_not_write_at_a_time(tmp_path: Path) -> None:
    with Store(tmp_path), pytest.raises(ConfigError, match="another sweep writes here"):
        Store(tmp_path)


def test_a_file_that_is_no_parquet_is_named(tmp_path: Path) -> None:
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "runs-000001.parquet").write_bytes(b"text")
    (tmp_path / "runs.json").write_text('{"files": ["runs-000001.parquet"]}')
    with pytest.raises(ConfigError, match=r"runs-000001.parquet: cannot be read"):
        read_rows(tmp_path)


SHAPE = {  # as in lockstep/test_resuming.py: the same model
    "n_slots": 2, "x_w": 7, "y_w": 7, "radix_w": 5, "nev_w": 6, "tc_w": 12, "sup_w": 8, "id_w": 16, "seq_w": 16, "time_w": 20,
    "tick_w": 3,
}  # fmt: skip
SLOT = {
    "init_radix": 4, "radix_th": 2, "radix_step": 0, "radix_min": 4, "radix_max": 31, "hist_avg": 0, "max_ticks": 30,
    "clust_nev": 1, "nev_min": 1, "nev_max": 8, "nev_th": 4000, "detect_ticks": 100,
}  # fmt: skip


def task_of(folder: Path, engine: str) -> Task:
    recorded(folder, 1)
    tables = {"shape": SHAPE, "cot": SLOT} if engine == "rtl" else {}
    values = {"recordings": ["discs1.npz"], "engines": [engine], "hardware": ["cot_array"], "tables": tables, "stalls": True}
    spec = spec_from(values | {"seeds": [5]}, folder, "one")
    (task,) = Planner(spec).plan(points_of(spec)).tasks
    return task


def exact(row: dict[str, Any]) -> dict[str, Any]:
    return {name: row.get(name) for name in ("key", "status", "error", "warnings", "content", *METRICS)}


@pytest.mark.parametrize("engine", ["rtl", "cot_array", "rct"])
def test_a_run_that_is_ended_goes_on(engine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    task = task_of(tmp_path, engine)
    saved: list[int] = []
    save = Unfinished.save

    def end(work: Unfinished, state: dict[str, Any]) -> None:
        save(work, state)
        saved.append(state["tally"].events)
        if len(saved) == 2:
            raise KeyboardInterrupt

    small(monkeypatch, tmp_path)
    unbroken = execute.execute(task)
    assert unbroken["status"] == "done", unbroken["error"]
    assert unbroken["events"] > 4 * CHECKPOINT
    assert unbroken["records"] > 100
    monkeypatch.setattr(Unfinished, "save", end)
    with pytest.raises(KeyboardInterrupt):
        execute.execute(task)
    row = execute.execute(task)
    assert exact(row) == exact(unbroken)
    assert row["cpu_s"] > 0
    steps = 3 * BLOCK  # a checkpoint at the first end of a block after 600 events
    assert saved == list(range(steps, unbroken["events"] + 1, steps)), "none twice: nothing before the second was done again"


def test_a_worker_that_is_killed_is_followed_by_one_that_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    task = task_of(tmp_path, "cot_array")
    with LocalPool(partial(dies_once, tmp_path), 1) as pool:
        (done,) = pool.run([task])
    assert done.attempts == 2
    assert done.result is not None
    assert done.result["continues"]
    assert not list((tmp_path / "sweep").iterdir()), "the checkpoint is gone"
    small(monkeypatch, tmp_path)
    assert exact(done.result) == exact(execute.execute(task))


def test_without_a_cache_a_run_is_done_without_checkpoints(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    small(monkeypatch, tmp_path / "file")
    row = execute.execute(task_of(tmp_path, "cot_array"))
    assert (row["status"], row["error"]) == ("done", "")

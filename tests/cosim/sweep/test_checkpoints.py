# SPDX-License-Identifier: Apache-2.0
"""A run of a sweep that is killed goes on from its last checkpoint: its row is the one of an unbroken run, bit for bit."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import pytest

from evcot.unfinished import Unfinished
from evcot_cosim.sweep import execute
from evcot_cosim.sweep.metrics import METRICS
from evcot_cosim.sweep.plan import Planner, points_of
from evcot_cosim.sweep.pool import LocalPool
from evcot_cosim.sweep.spec import spec_from
from evcot_cosim.sweep.task import Task
from support.interrupted import BLOCK, CHECKPOINT, dies_once, small
from support.sweeping import recorded

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
        saved.append(state["count"]["events"])
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

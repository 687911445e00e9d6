# SPDX-License-Identifier: Apache-2.0
"""The scheduler of one machine: every task ends once, whatever becomes of the processes."""

from __future__ import annotations

import multiprocessing
import os
from pathlib import Path

import pytest

from evcot_cosim.sweep.pool import Done, LocalPool
from support.sweeping import Chore, chore, seen_by_worker

Ends = dict[int, Done[Chore, dict[str, int]]]


def ends(tasks: list[Chore], workers: int = 2, timeout_s: float = 0.0) -> Ends:
    with LocalPool(chore, workers, timeout_s) as pool:
        found = list(pool.run(tasks))
    assert sorted(done.task.number for done in found) == sorted(task.number for task in tasks), "each ends once"
    return {done.task.number: done for done in found}


def test_every_task_is_done_in_another_process() -> None:
    found = ends([Chore(i) for i in range(200)])
    assert all(done.result is not None and done.result["number"] == i for i, done in found.items())
    assert all(done.attempts == 1 for done in found.values())
    assert len({done.result["pid"] for done in found.values() if done.result}) == 2


@pytest.mark.skipif("forkserver" not in multiprocessing.get_all_start_methods(), reason="workers import by themselves here")
def test_workers_are_forked_where_evcot_is_imported_and_have_the_environment_of_now(monkeypatch: pytest.MonkeyPatch) -> None:
    parents = set()
    for value in ("one", "other"):
        monkeypatch.setenv("EVCOT_OF_A_TEST", value)
        with LocalPool(seen_by_worker, 2) as pool:
            for done in pool.run(["EVCOT_OF_A_TEST"] * 4):
                assert done.result is not None
                parents.add(done.result.pop("parent"))
                assert done.result == {"preloaded": True, "deaf": True, "variable": value}
    assert len(parents) == 1
    assert parents != {os.getpid()}


def test_no_task_starts_no_process() -> None:
    assert ends([]) == {}


def test_a_task_whose_worker_dies_once_is_done(tmp_path: Path) -> None:
    found = ends([Chore(i, "die once" if i == 3 else "return", str(tmp_path)) for i in range(8)])
    assert found[3].result is not None
    assert found[3].attempts == 2
    assert {i: len((tmp_path / str(i)).read_text()) for i in range(8)} == dict.fromkeys(range(8), 1) | {3: 2}, (
        "no other is repeated"
    )


@pytest.mark.parametrize(
    ("does", "cause"), [("die", "worker was killed by SIGKILL, 2 times"), ("exit", "worker ended with exit code 3, 2 times")]
)
def test_a_task_whose_worker_dies_twice_is_named(does: str, cause: str, tmp_path: Path) -> None:
    found = ends([Chore(i, does if i == 2 else "return", str(tmp_path)) for i in range(6)])
    assert found[2] == Done(Chore(2, does, str(tmp_path)), None, cause, 2)
    assert all(found[i].result is not None for i in range(6) if i != 2)
    assert {i: len((tmp_path / str(i)).read_text()) for i in range(6)} == dict.fromkeys(range(6), 1) | {2: 2}


def test_a_task_that_takes_too_long_is_ended() -> None:
    found = ends([Chore(0, "sleep"), Chore(1)], timeout_s=1.0)
    assert found[0].fault == "worker took longer than 1 s, 2 times"
    assert found[1].result is not None


def test_a_worker_has_more_of_short_tasks_and_two_of_long_ones() -> None:
    with LocalPool(chore, 1) as pool:
        assert pool.ahead == 2
        for _ in pool.run([Chore(i) for i in range(300)]):
            pass
        assert pool.ahead > 2
        pool._took(1e6)
        assert pool.ahead == 2

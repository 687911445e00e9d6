# SPDX-License-Identifier: Apache-2.0
"""A sweep from its specification to a full store: does the runs that the store does not have, and writes rows as they come."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from .axes import Point
from .cluster import Cluster
from .execute import DONE, FAILED, execute, row_of
from .folder import begin, counted
from .optuna_points import Asker
from .plan import Invalid, Plan, Planner, points_of
from .pool import Done, LocalPool
from .results import merit
from .spec import Spec
from .store import Store, require_pyarrow
from .task import Task

__all__ = ["Progress", "Swept", "run_sweep"]

Progress = Callable[[int, int, str], None]
"""Called after each run: with how many have ended, of how many, and a word on the last."""


class Scheduler(Protocol):
    """Does tasks somewhere."""

    def run(self, tasks: Iterable[Task]) -> Iterator[Done[Task, dict[str, Any]]]:
        """Do tasks; yields each as it ends, in no order."""
        ...


@dataclass(frozen=True)
class Swept:
    """The end of a sweep.

    Attributes:
        folder: with store and report.
        runs: distinct runs of the plan, those that cannot be included.
        new: those that this call has done.
        counts: status -> runs of the store.
        keys: the plan's.
    """

    folder: Path
    runs: int
    new: int
    counts: Mapping[str, int]
    keys: frozenset[str]


def run_sweep(
    spec: Spec,
    folder: Path,
    *,
    jobs: int,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    again: bool = False,
    progress: Progress | None = None,
    planned: Callable[[Plan], None] | None = None,
) -> Swept:
    """Do all runs of a specification that the folder's store does not have.

    Args:
        folder: made, or gone on in.
        jobs: processes on this machine, without a scheduler.
        scheduler, scheduler_file: of a Dask cluster.
        again: runs that have failed before are tried again.
        planned: called with the plan before anything runs; with Optuna it is that of the first batch.

    Raises:
        ConfigError, RecordingError: what was asked for cannot be done; nothing has run.
        OutputError: the store cannot be written; what has ended before is in it.
    """
    require_pyarrow()
    planner = Planner(spec)
    askers = {engine: Asker(spec) for engine in spec.engines} if spec.method == "optuna" and spec.fuzz is None else {}
    asked: dict[str, list[Point]] = {}
    if spec.fuzz is not None:
        plan = planner.fuzz()
    elif askers:
        plan = Plan()
        for engine, asker in askers.items():
            asked[engine] = asker.ask(min(spec.batch, spec.samples))
            planner.plan(asked[engine], [engine])
    else:
        plan = planner.plan(points_of(spec))
    if planned is not None:
        planned(plan)
    with _schedule(spec, jobs, scheduler, scheduler_file) as own:
        if isinstance(own, Cluster):
            own.check(planner.paths)
        begin(folder, spec)
        with Store(folder) as store:
            doing = _Doing(store, folder, own, again, progress)
            if askers:
                _ask_and_tell(spec, planner, askers, asked, doing)
            else:
                doing.do(plan)
            store.flush()
            counts = counted({key: status for key, status in store.status.items() if key in doing.keys})
            return Swept(folder, len(doing.keys), doing.new, counts, frozenset(doing.keys))


def _schedule(spec: Spec, jobs: int, scheduler: str | None, file: Path | None) -> AbstractContextManager[Scheduler]:
    if scheduler is not None or file is not None:
        return Cluster(execute, scheduler, file)
    return LocalPool(execute, jobs, spec.timeout_s)


class _Doing:
    """Plans into rows."""

    def __init__(self, store: Store, folder: Path, scheduler: Scheduler, again: bool, progress: Progress | None) -> None:
        self.keys: set[str] = set()
        self.new = 0
        self._ended = 0
        self._store, self._folder, self._scheduler = store, folder, scheduler
        self._again, self._progress = again, progress

    def do(self, plan: Plan) -> dict[str, dict[str, Any]]:
        """Do what the store does not have; returns the new rows by their keys."""
        store, rows = self._store, {}
        self.keys |= {task.key for task in plan.tasks} | {each.task.key for each in plan.invalid}
        for each in plan.invalid:
            if each.task.key not in store.status:
                rows[each.task.key] = self._add(
                    {**row_of(each.task), "status": each.status, "error": each.error, "attempts": 0}
                )
        status = store.status
        left = [task for task in plan.tasks if task.key not in status or (self._again and status[task.key] == FAILED)]
        self._ended += len(plan.tasks) - len(left)
        self._tell("")
        for done in self._scheduler.run(left):
            row = done.result
            if row is None:
                row = {**row_of(done.task), "status": FAILED, "error": done.fault}
            rows[row["key"]] = self._add({**row, "attempts": done.attempts})
            self.new += 1
            self._ended += 1
            self._tell(row["status"] if row["status"] == DONE else f"{row['status']}: {row['error']}")
        return rows

    def stored(self, columns: Sequence[str]) -> list[dict[str, Any]]:
        """Columns of the rows that the store has."""
        return self._store.read(columns)

    def _add(self, row: dict[str, Any]) -> dict[str, Any]:
        row["command"] = shlex.join(["evcot", "sweep", str(self._folder.absolute()), "--only", row["key"]])
        self._store.add(row)
        return row

    def _tell(self, word: str) -> None:
        if self._progress is not None:
            self._progress(self._ended, len(self.keys), word)


def _ask_and_tell(
    spec: Spec, planner: Planner, askers: Mapping[str, Asker], asked: dict[str, list[Point]], doing: _Doing
) -> None:
    """Batches of points until there are enough of them; results come from the store where they are there."""
    known = {row["key"]: row for row in doing.stored(["key", "status", *spec.objectives])}
    count = 0
    while count < spec.samples:
        size = min(spec.batch, spec.samples - count)
        plans: list[tuple[str, list[Plan]]] = []
        whole = Plan()
        for engine, asker in askers.items():
            points = asked.pop(engine, None) or asker.ask(size)
            own = [planner.plan([point], [engine], strict=False) for point in points]
            plans.append((engine, own))
            whole.tasks += [task for plan in own for task in plan.tasks]
            whole.invalid += [each for plan in own for each in plan.invalid]
        known |= doing.do(_each_once(whole))
        for engine, own in plans:
            askers[engine].tell([_objectives(spec, plan, known) for plan in own])
        count += size


def _each_once(plan: Plan) -> Plan:
    tasks = {task.key: task for task in plan.tasks}
    invalid: dict[str, Invalid] = {each.task.key: each for each in plan.invalid}
    return Plan(list(tasks.values()), list(invalid.values()))


def _objectives(spec: Spec, plan: Plan, known: Mapping[str, Mapping[str, Any]]) -> list[float] | None:
    """Means over the runs of one point."""
    rows: Sequence[Mapping[str, Any]] = [known[task.key] for task in plan.tasks]
    if plan.invalid or not rows:
        return None
    means = [merit([{metric: row.get(metric), "status": row["status"]} for row in rows], metric) for metric in spec.objectives]
    return [mean for mean in means if mean is not None] if None not in means else None

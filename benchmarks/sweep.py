# SPDX-License-Identifier: Apache-2.0
"""Sweeps: speed-up of processes, overhead of a task, time to the first result, and a cluster against the local pool."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import evcot
from evcot.recordings.files import write_recording
from evcot_cosim.sweep.cluster import Cluster
from evcot_cosim.sweep.execute import execute
from evcot_cosim.sweep.pool import LocalPool, cores
from evcot_cosim.sweep.run import run_sweep
from evcot_cosim.sweep.spec import Spec, spec_from
from evcot_cosim.sweep.store import read_rows
from measure import Goal, Result, Skip

__all__ = ["measure"]

_RUN_S = 6.0  # so that runs of other settings, which may be shorter, take 5 s, too
_PROBE_US, _LONGEST_US = 5_000_000, 150_000_000
_OVERHEAD_MS = 5.0


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """sweep_speed_up, sweep_overhead, sweep_first_result, sweep_memory, sweep_cluster."""
    if cores() < 2:
        raise Skip("one core alone")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        yield from _overhead(folder, 1_000 if quick else 10_000)
        yield from _speed_up(folder, 4 if quick else 16)
        yield from _cluster(folder, 400 if quick else 2_000)


def _recorded(folder: Path, name: str, **settings: Any) -> Path:
    (folder / name).mkdir()
    scene = evcot.simulate("discs", seed=1, **settings)
    write_recording(scene.recording, folder / name / "discs.npz")
    scene.truth.save(folder / name / "discs.truth.csv")
    return folder / name


def _spec(recordings: Path, samples: int, **more: Any) -> Spec:
    """As many distinct runs as samples."""
    fields = {"rct.radius_px": {"from": 5.0, "to": 20.0}}
    values = {"recordings": [str(recordings)], "engines": ["rct"], "preset": "discs", "method": "random", "fields": fields}
    return spec_from({**values, "samples": samples, **more}, recordings, "benchmark")


def _overhead(folder: Path, tasks: int) -> Iterator[Result]:
    """What a task takes beside its own work: planning, handing out, the row, the store; with one process."""
    recordings = _recorded(folder, "tiny", width=64, height=64, duration_us=2_000, count=1)
    begun = time.perf_counter()
    first_s = 0.0

    def progress(done: int, _runs: int, _word: str) -> None:
        nonlocal first_s
        if done and not first_s:
            first_s = time.perf_counter() - begun

    swept = run_sweep(_spec(recordings, tasks), folder / "overhead", jobs=1, progress=progress)
    took_s = time.perf_counter() - begun
    rows = read_rows(swept.folder, ["wall_s", "memory_mb"])
    work_s = sum(row["wall_s"] for row in rows)
    each_ms = (took_s - first_s - work_s + rows[0]["wall_s"]) / swept.runs * 1e3
    how = f"{swept.runs:,} runs of {median(row['wall_s'] for row in rows) * 1e3:.2f} ms, one process; wall time"
    yield Result("sweep_overhead", each_ms, "ms a task", _OVERHEAD_MS, "goal", goal=Goal(1, at_most=True), how=how)
    yield Result("sweep_first_result", first_s, "s", how=f"with the plan of {tasks:,} runs, from the call to the first row")
    yield Result("sweep_memory", max(row["memory_mb"] for row in rows), "MB", how="peak of a worker, small recording")


def _speed_up(folder: Path, runs: int) -> Iterator[Result]:
    """Two processes against one, with runs of 5 s and more."""
    recordings = _recorded(folder, "long", duration_us=_PROBE_US)
    run_sweep(_spec(recordings, 3), folder / "probe", jobs=1)
    run_s = min(row["cpu_s"] for row in read_rows(folder / "probe", ["cpu_s"]))
    shutil.rmtree(recordings)
    recordings = _recorded(folder, "long", duration_us=int(min(_PROBE_US * max(_RUN_S / run_s, 1.0), _LONGEST_US)))
    took_s, rows = {}, {}
    for jobs in (1, 2):
        begun = time.perf_counter()
        swept = run_sweep(_spec(recordings, runs), folder / f"jobs{jobs}", jobs=jobs)
        took_s[jobs] = time.perf_counter() - begun
        rows[jobs] = read_rows(swept.folder, ["wall_s", "cpu_s"])
    own_s = {jobs: sum(row["wall_s"] for row in own) / jobs for jobs, own in rows.items()}
    slower = sum(row["cpu_s"] for row in rows[2]) / sum(row["cpu_s"] for row in rows[1]) - 1
    how = (
        f"{runs} runs of {median(row['wall_s'] for row in rows[1]):.1f} s, 1 process {took_s[1]:.1f} s, 2 processes "
        f"{took_s[2]:.1f} s, of which {took_s[2] - own_s[2]:.1f} s beside runs; two at once take {slower:.1%} more CPU time; "
        "wall time"
    )
    yield Result("sweep_speed_up", took_s[1] / took_s[2], "times", 1.9, "goal", goal=Goal(1), how=how)


def _cluster(folder: Path, tasks: int) -> Iterator[Result]:
    """Two Dask workers against two processes, with runs of a few milliseconds: what the schedulers themselves take."""
    recordings = _recorded(folder, "small", width=64, height=64, duration_us=2_000, count=1)
    spec = _spec(recordings, tasks)
    with LocalPool(execute, 2) as pool:
        local_s = _timed(pool, spec)
    try:
        with _dask(folder) as file, Cluster(execute, file=file) as cluster:
            cluster._client.wait_for_workers(2, timeout=120)
            dask_s = _timed(cluster, spec)
    except ImportError as error:
        raise Skip(f"{error.name} is not installed") from error
    how = f"{tasks:,} runs; workers started and warmed up; wall time"
    yield Result("sweep_cluster", tasks / dask_s, "runs/s", tasks / local_s, "two local processes", how=how)


def _timed(scheduler: Any, spec: Spec) -> float:
    from evcot_cosim.sweep.plan import Planner, points_of

    plan = Planner(spec).plan(points_of(spec)).tasks
    for _ in scheduler.run(plan[:8]):
        pass
    begun = time.perf_counter()
    for done in scheduler.run(plan):
        assert done.result is not None
    return time.perf_counter() - begun


@contextmanager
def _dask(folder: Path) -> Iterator[Path]:
    import distributed  # noqa: F401

    file = folder / "cluster.json"
    common = {"env": os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}, "stderr": subprocess.DEVNULL, "cwd": folder}
    command = [sys.executable, "-m"]
    started = [
        subprocess.Popen(
            [*command, "distributed.cli.dask_scheduler", "--no-dashboard", "--port", "0", "--scheduler-file", str(file)],
            **common,
        )
    ]
    while not file.exists():
        time.sleep(0.1)
    worker = [*command, "distributed.cli.dask_worker", "--no-dashboard", "--nthreads", "1", "--scheduler-file", str(file)]
    started += [subprocess.Popen(worker, **common) for _ in range(2)]
    try:
        yield file
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait(30)

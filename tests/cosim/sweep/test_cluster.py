# SPDX-License-Identifier: Apache-2.0
"""A Dask cluster gives what the processes of one machine give, and loses nothing when parts of it die."""

from __future__ import annotations

import contextlib
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from subprocess import Popen
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot_cosim.sweep import cluster as cluster_module
from evcot_cosim.sweep.cluster import Cluster
from evcot_cosim.sweep.execute import execute
from evcot_cosim.sweep.metrics import METRICS
from evcot_cosim.sweep.run import run_sweep
from evcot_cosim.sweep.spec import Spec, spec_from
from evcot_cosim.sweep.store import read_rows
from support.sweeping import Chore, chore, recorded
from support.testing import exhaustive

pytest.importorskip("pyarrow")
pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")  # of Dask itself, and of its threads when a scheduler dies

Start = Callable[..., Popen[bytes]]


def free_port() -> int:
    with contextlib.closing(socket.create_server(("127.0.0.1", 0))) as server:
        port: int = server.getsockname()[1]
        return port


@pytest.fixture
def port() -> int:
    return free_port()


def started(port: int, dask: Start) -> Popen[bytes]:
    """A scheduler that answers."""
    process = dask("scheduler", "--host", "127.0.0.1", "--port", str(port))
    deadline = time.monotonic() + 90
    while time.monotonic() < deadline:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1):
            return process
        time.sleep(0.1)
    raise TimeoutError("no scheduler after 90 s")


def two_workers(port: int, dask: Start, *options: str) -> str:
    """A scheduler with two workers; its address."""
    started(port, dask)
    for _ in range(2):
        dask("worker", f"tcp://127.0.0.1:{port}", "--nthreads", "1", *options)
    return f"tcp://127.0.0.1:{port}"


def connected(function: Callable[[Any], Any], address: str, workers: int = 2) -> Cluster:
    cluster = Cluster(function, address)
    cluster._client.wait_for_workers(workers, timeout=90)
    return cluster


def spec_of(folder: Path) -> Spec:
    values: dict[str, Any] = {
        "recordings": [str(folder)], "engines": ["rct", "cot_array"], "preset": "discs", "objectives": {"hota": "max"},
        "fields": {"rct.radius_px": [6.0, 9.0], "cot.init_radix": [8, 10]},
    }  # fmt: skip
    return spec_from(values, folder, "small")


def exact(folder: Path) -> dict[str, tuple[Any, ...]]:
    return {row["key"]: tuple(row[name] for name in ("status", "error", "task", *METRICS)) for row in read_rows(folder)}


@pytest.fixture(scope="module")
def cluster(shared_dask: Start, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """A scheduler with two workers, which run in the folders `one` and `two`; its address, and where the folders are."""
    port, place = free_port(), tmp_path_factory.mktemp("workers")
    started(port, shared_dask)
    for name in ("one", "two"):
        (place / name).mkdir()
        shared_dask("worker", f"tcp://127.0.0.1:{port}", "--nthreads", "1", "--no-nanny", folder=place / name)
    return f"tcp://127.0.0.1:{port}", place


def test_a_cluster_gives_the_same_bit_for_bit(cluster: tuple[str, Path], tmp_path: Path) -> None:
    address, _ = cluster
    recorded(tmp_path, 1)
    connected(execute, address).__exit__(None, None, None)
    there = run_sweep(spec_of(tmp_path), tmp_path.with_name("there"), jobs=1, scheduler=address)
    here = run_sweep(spec_of(tmp_path), tmp_path.with_name("here"), jobs=1)
    assert (there.new, here.new) == (4, 4)
    assert exact(there.folder) == exact(here.folder)


def test_a_recording_that_is_missing_on_one_worker_is_named(cluster: tuple[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """The workers run in different folders, and are asked for a path relative to them."""
    address, place = cluster
    recorded(place / "one", 1)
    monkeypatch.chdir(place / "one")
    with connected(execute, address) as there:
        with pytest.raises(ConfigError, match=r"^discs1.npz: is missing on worker tcp://.* on .*: must be the same file"):
            there.check(["discs1.npz"])
        (place / "two" / "discs1.npz").write_bytes(Path("discs1.npz").read_bytes())
        assert len(there.check(["discs1.npz"])) == 2


def test_no_scheduler_and_no_workers_are_said(port: int, dask: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("evcot_cosim.sweep.cluster._CONNECT_S", 1)
    with pytest.raises(ConfigError, match=rf"^--scheduler tcp://127.0.0.1:{port}: no scheduler answers: "):
        Cluster(chore, f"tcp://127.0.0.1:{port}")
    for text in (None, "no JSON", "[]"):
        if text is not None:
            (tmp_path / "file.json").write_text(text)
        with pytest.raises(ConfigError, match=rf"^--scheduler-file {tmp_path}/file.json: no scheduler answers: "):
            Cluster(chore, file=tmp_path / "file.json")
    monkeypatch.undo()
    started(port, dask)
    with Cluster(chore, f"tcp://127.0.0.1:{port}") as cluster, pytest.raises(ConfigError, match="has no workers"):
        cluster.check([])


@exhaustive
def test_a_task_that_kills_its_workers_is_named_and_the_others_are_done(port: int, dask: Start, tmp_path: Path) -> None:
    address = two_workers(port, dask)
    tasks = [Chore(i, {3: "die", 5: "die once"}.get(i, "return"), str(tmp_path)) for i in range(10)]
    with connected(chore, address) as cluster:
        found = {done.task.number: done for done in cluster.run(tasks)}
    assert sorted(found) == list(range(10))
    assert found[3].result is None
    assert found[3].fault == f"worker was killed, {found[3].attempts} times"
    assert all(found[i].result is not None for i in range(10) if i != 3)


def test_a_result_that_cannot_be_fetched_is_computed_again(
    cluster: tuple[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The scheduler goes away between a task's end and the fetching of its result."""
    failures = iter([OSError("the scheduler has gone")])

    def fetched(*arguments: Any) -> Any:
        if error := next(failures, None):
            raise error
        return done(*arguments)

    done = cluster_module._done
    monkeypatch.setattr(cluster_module, "_done", fetched)
    with connected(chore, cluster[0]) as there:
        numbers = [done.task.number for done in there.run(Chore(i, "return", str(tmp_path)) for i in range(20))]
    assert sorted(numbers) == list(range(20)), "each once"


@exhaustive
def test_a_scheduler_that_is_restarted_gets_the_rest(port: int, dask: Start, tmp_path: Path) -> None:
    scheduler = started(port, dask)
    address = f"tcp://127.0.0.1:{port}"
    dask("worker", address, "--nthreads", "1", "--no-nanny", "--death-timeout", "120")
    tasks = [Chore(i, "return", str(tmp_path)) for i in range(200)]

    def slowly() -> Iterator[Chore]:
        for task in tasks:
            if task.number == 60:
                scheduler.send_signal(signal.SIGKILL)
                scheduler.wait()
                threading.Timer(1.0, lambda: restarted.append(start())).start()
            yield task

    def start() -> Popen[bytes]:
        process = dask("scheduler", "--host", "127.0.0.1", "--port", str(port))
        dask("worker", address, "--nthreads", "1", "--no-nanny")
        return process

    restarted: list[Popen[bytes]] = []
    with connected(chore, address, 1) as cluster:
        numbers = [done.task.number for done in cluster.run(slowly()) if done.result is not None]
    assert sorted(numbers) == list(range(200)), "each once"
    assert len(restarted) == 1

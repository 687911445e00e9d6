# SPDX-License-Identifier: Apache-2.0
"""The scheduler of many machines: an existing Dask cluster. Recordings are read where they lie; tasks and rows are small."""

from __future__ import annotations

import contextlib
import itertools
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from evcot.errors import ConfigError

from .machine import Machine, check_same, probe
from .pool import Done

__all__ = ["Cluster"]

_CONNECT_S = 10
_RECONNECT_S = 120  # for a scheduler that is restarted
_AHEAD = 4  # tasks per thread of the cluster that are handed out


class Cluster:
    """A connection to a Dask scheduler, as a context.

    Args:
        function: does a task; importable on every worker, and raises nothing.
        address: of the scheduler, `tcp://HOST:PORT`; or
        file: the file that `dask scheduler --scheduler-file` writes.

    Raises:
        ConfigError: Dask is not installed, or no scheduler answers.
    """

    def __init__(self, function: Callable[[Any], Any], address: str | None = None, file: Path | None = None) -> None:
        try:
            import distributed
        except ImportError as error:
            raise ConfigError("--scheduler: distributed is not installed: pip install 'evcot[distributed]'") from error
        self._dask = distributed
        self._function = function
        self._address, self._file = address, file
        self._numbers = itertools.count()
        self._client: Any = self._connected(_CONNECT_S)

    @property
    def name(self) -> str:
        """The option as it was given."""
        return f"--scheduler {self._address}" if self._file is None else f"--scheduler-file {self._file}"

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._close()

    def _close(self) -> None:
        with contextlib.suppress(TimeoutError):  # a scheduler that has gone may not say goodbye in time
            self._client.close(timeout=2)

    def check(self, paths: Sequence[str]) -> Mapping[str, Machine]:
        """Compare every worker with this process: versions, program, and the contents of these paths.

        Raises:
            ConfigError: no worker, or one that differs; names worker, what, both values.
        """
        own = probe(paths)
        workers: Mapping[str, Machine] = self._client.run(probe, list(paths), on_error="return")
        for worker, found in workers.items():
            if isinstance(found, BaseException):
                text = " ".join(str(found).split())
                raise ConfigError(f"{self.name}: worker {worker} cannot run evcot: {type(found).__name__}: {text[:160]}")
        if not workers:
            raise ConfigError(f"{self.name}: has no workers: must have one at least")
        check_same(own, workers)
        return workers

    def run(self, tasks: Iterable[Any]) -> Iterator[Done[Any, Any]]:
        """Do tasks; yields each as it ends, in no order. A scheduler that is restarted gets those that had not ended again.

        Dask blames every task assigned to a worker that was killed, including those that were only queued there. So the tasks
        that it gives up are tried again at the end, one at a time.

        Raises:
            ConfigError: the scheduler is gone for good; what has ended before has been yielded.
        """
        waiting: Iterator[Any] = iter(tasks)
        open_tasks: dict[str, Any] = {}  # what was handed out and has not ended, by the key of its future
        suspects: list[Any] = []  # whose workers were killed while others were under way
        alone = False
        while True:
            completed = self._dask.as_completed(loop=self._client.loop)
            lost = False
            try:
                self._hand_out(waiting, open_tasks, completed)
                for future in completed:
                    if future.status not in ("finished", "error"):
                        lost = True
                        break
                    task = open_tasks[future.key]
                    done = None if not alone and _was_killed(future) else _done(future, task, 1 + alone)
                    del open_tasks[future.key]  # not before its result is here: the scheduler may go away while it is fetched
                    if done is None:
                        suspects.append(task)
                    else:
                        yield done
                    future.release()
                    self._hand_out(waiting, open_tasks, completed)
            except (OSError, self._dask.CancelledError):  # the connection has gone, in one of many ways
                lost = True
            if not lost and not suspects:
                return
            if not lost:
                waiting, alone = iter([suspects.pop(0)]), True
                continue
            waiting = itertools.chain(list(open_tasks.values()), waiting)
            open_tasks = {}
            self._close()
            self._client = self._connected(_RECONNECT_S)

    def _hand_out(self, waiting: Iterator[Any], open_tasks: dict[str, Any], completed: Any) -> None:
        wanted = _AHEAD * max(1, sum(self._client.nthreads().values()))
        while len(open_tasks) < wanted:
            task = next(waiting, None)
            if task is None:
                return
            key = f"evcot-{task.key}-{next(self._numbers)}"
            open_tasks[key] = task
            completed.add(self._client.submit(self._function, task, key=key, pure=False))

    def _connected(self, patience_s: float) -> Any:
        deadline = time.monotonic() + patience_s
        while True:
            try:
                address = self._address if self._file is None else json.loads(self._file.read_text())["address"]
                return self._dask.Client(address, timeout=min(patience_s, _CONNECT_S), set_as_default=False)
            except (OSError, TimeoutError, ValueError, KeyError, TypeError) as error:
                if time.monotonic() > deadline or patience_s <= _CONNECT_S:
                    why = (isinstance(error, OSError) and error.strerror) or " ".join(str(error).split())[:120]
                    raise ConfigError(f"{self.name}: no scheduler answers: {why}") from error
                time.sleep(0.5)


def _was_killed(future: Any) -> bool:
    return future.status == "error" and type(future.exception()).__name__ == "KilledWorker"


def _done(future: Any, task: Any, tries: int) -> Done[Any, Any]:
    if future.status == "finished":
        return Done(task, future.result(), "", 1)
    error = future.exception()
    if _was_killed(future):
        killed = tries * (getattr(error, "allowed_failures", 3) + 1)
        return Done(task, None, f"worker was killed, {killed} times", killed)
    return Done(task, None, f"{type(error).__name__}: {' '.join(str(error).split())[:200]}", 1)

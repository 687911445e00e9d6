# SPDX-License-Identifier: Apache-2.0
"""The scheduler of one machine: processes that do tasks; one that dies takes its task along once, and is replaced.

A worker has one task at work and others that wait, so that it never idles while the caller writes a row or waits for a core:
one where tasks take long, so that the last ones are shared evenly, and more of short ones.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any, Generic, NamedTuple, TypeVar

from .starting import started

__all__ = ["Done", "LocalPool", "cores"]

T = TypeVar("T")
R = TypeVar("R")
_AHEAD = 2, 12  # tasks that a worker has: least, most
_AHEAD_S = 0.1  # and how long they take together, in between
_NEWEST = 0.1  # weight of a task's time in the mean of all
_TRIES = 2  # of a task whose worker dies
_FAREWELL_S = 2.0  # for a build to end with its worker


class Done(NamedTuple, Generic[T, R]):
    """A task's end: its result, or why there is none; and how often it was begun."""

    task: T
    result: R | None
    fault: str
    attempts: int


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Worker(Generic[T]):
    def __init__(self, function: Callable[[T], Any]) -> None:
        self.connection, theirs = multiprocessing.Pipe()
        self.process = started(_work, theirs, function, dict(os.environ))
        theirs.close()
        self.tasks: deque[tuple[T, int]] = deque()  # with the number of tries; the first is at work
        self.ready = False  # its start counts for no task
        self.since = time.monotonic()

    def give(self, task: T, attempt: int) -> None:
        if not self.tasks:
            self.since = time.monotonic()
        self.tasks.append((task, attempt))
        try:
            self.connection.send(task)
        except (BrokenPipeError, ConnectionError):
            return  # its end is noticed by the sentinel

    def end(self) -> None:
        """End the process, and what it has started."""
        self.connection.close()  # one without a task ends by that
        if self.tasks:
            self.process.terminate()
        self.process.join(_FAREWELL_S)
        self.process.kill()
        self.process.join()


class LocalPool(Generic[T, R]):
    """Processes on this machine, as a context: they end with it.

    Args:
        function: does a task; it must be importable, and raise nothing.
        workers: number of processes.
        timeout_s: time after which a task's worker is killed; 0 for none.
    """

    def __init__(self, function: Callable[[T], R], workers: int, timeout_s: float = 0.0) -> None:
        self._function = function
        self._timeout_s = timeout_s
        self._workers: list[_Worker[T]] = []
        self._count = workers
        self._again: deque[tuple[T, int]] = deque()
        self._each_s: float | None = None

    @property
    def ahead(self) -> int:
        """How many tasks a worker has."""
        least, most = _AHEAD
        return least if self._each_s is None else min(max(least, int(_AHEAD_S / max(self._each_s, _AHEAD_S / most))), most)

    def __enter__(self) -> LocalPool[T, R]:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for worker in self._workers:
            worker.end()
        self._workers = []

    def run(self, tasks: Iterable[T]) -> Iterator[Done[T, R]]:
        """Do tasks; yields each as it ends, in no order."""
        waiting = iter(tasks)
        while True:
            self._hand_out(waiting)
            busy = [worker for worker in self._workers if worker.tasks]
            if not busy:
                return
            by_handle: dict[Any, _Worker[T]] = {worker.connection: worker for worker in busy}
            by_handle |= {worker.process.sentinel: worker for worker in busy}
            ready = wait(list(by_handle), self._patience_s(busy))
            for worker in dict.fromkeys(by_handle[handle] for handle in ready):
                yield from self._collect(worker)
            if self._timeout_s:
                yield from self._overdue()

    def _hand_out(self, waiting: Iterator[T]) -> None:
        while len(self._workers) < self._count:
            task = self._next(waiting)
            if task is None:
                break
            worker = _Worker(self._function)
            self._workers.append(worker)
            worker.give(*task)
        for ahead in range(self.ahead):
            for worker in self._workers:
                if len(worker.tasks) <= ahead:
                    task = self._next(waiting)
                    if task is None:
                        return
                    worker.give(*task)

    def _next(self, waiting: Iterator[T]) -> tuple[T, int] | None:
        if self._again:
            return self._again.popleft()
        for task in waiting:
            return task, 1
        return None

    def _collect(self, worker: _Worker[T]) -> Iterator[Done[T, R]]:
        """What a worker has sent; where it has died, what becomes of its tasks."""
        try:
            while worker.tasks and worker.connection.poll():
                result = worker.connection.recv()
                if not worker.ready:
                    worker.ready, worker.since = True, time.monotonic()
                    continue
                task, attempt = worker.tasks.popleft()
                self._took(time.monotonic() - worker.since)
                worker.since = time.monotonic()
                yield Done(task, result, "", attempt)
        except (EOFError, ConnectionError):
            pass
        else:
            if worker.process.is_alive():
                return
            if worker.tasks and worker.connection.poll():  # sent just before its end
                yield from self._collect(worker)
                return
        yield from self._buried(worker, f"worker {_cause(worker.process)}")

    def _took(self, task_s: float) -> None:
        self._each_s = task_s if self._each_s is None else (1 - _NEWEST) * self._each_s + _NEWEST * task_s

    def _buried(self, worker: _Worker[T], fault: str) -> Iterator[Done[T, R]]:
        worker.end()
        if worker in self._workers:
            self._workers.remove(worker)
        if worker.tasks:
            task, attempt = worker.tasks.popleft()
            if attempt < _TRIES:
                self._again.append((task, attempt + 1))
            else:
                yield Done(task, None, f"{fault}, {attempt} times", attempt)
        self._again.extendleft(reversed(worker.tasks))  # they had not begun
        worker.tasks.clear()

    def _patience_s(self, busy: list[_Worker[T]]) -> float | None:
        began = [worker.since for worker in busy if worker.ready]
        if not self._timeout_s or not began:
            return None
        return max(0.0, min(began) + self._timeout_s - time.monotonic())

    def _overdue(self) -> Iterator[Done[T, R]]:
        for worker in list(self._workers):
            if worker.ready and worker.tasks and time.monotonic() - worker.since > self._timeout_s:
                yield from self._buried(worker, f"worker took longer than {self._timeout_s:g} s")


def _cause(process: BaseProcess) -> str:
    process.join(1)
    code = process.exitcode
    if code is None:
        return "broke its connection"
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"was killed by signal {-code}"


def _exit(*_: object) -> None:
    """Leave through all `finally`: what the task has started ends, too."""
    raise SystemExit(1)


def _work(connection: Connection, function: Callable[[Any], Any], environment: dict[str, str]) -> None:
    """A worker's life: until the caller closes the connection. The environment is the caller's as it is now."""
    if environment != os.environ:
        os.environ.clear()
        os.environ.update(environment)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the caller ends it
    signal.signal(signal.SIGTERM, _exit)
    try:
        connection.send(None)
    except OSError:
        return
    while True:
        try:
            task = connection.recv()
            connection.send(function(task))
        except (EOFError, OSError):
            return

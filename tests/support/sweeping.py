# SPDX-License-Identifier: Apache-2.0
"""Support for tests of sweeps: small recordings with truths, tasks that end their worker, runs with many checkpoints."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

import evcot
from evcot.events import Events
from evcot.recordings.files import write_recording
from evcot_cosim.sweep import checkpoints, execute, inputs
from evcot_cosim.sweep.task import Input, Task

__all__ = ["Chore", "chore", "recorded", "seen_by_worker", "until"]


@dataclass(frozen=True)
class Chore:
    """A task for a scheduler alone.

    Attributes:
        number: which one.
        does: "return", "die" by a signal, "die once" (then return), "exit", or "sleep" for a minute.
        folder: where it notes that it was begun.
    """

    number: int
    does: str = "return"
    folder: str = ""

    @property
    def key(self) -> str:
        return str(self.number)


def chore(task: Chore) -> dict[str, int]:
    """Do a chore; returns its number and the process."""
    begun = 0
    if task.folder:
        note = Path(task.folder) / f"{task.number}"
        begun = len(note.read_text()) if note.exists() else 0
        note.write_text("x" * (begun + 1))
    if task.does == "die" or (task.does == "die once" and not begun):
        os.kill(os.getpid(), signal.SIGKILL)
    if task.does == "exit":
        os._exit(3)
    if task.does == "sleep":
        time.sleep(60)
    return {"number": task.number, "pid": os.getpid()}


def seen_by_worker(variable: str) -> dict[str, object]:
    """A worker as its task finds it: whose child it is, whether evcot is imported, deaf to interrupts; a variable's value."""
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    return {
        "parent": os.getppid(), "preloaded": "evcot_cosim.sweep.preload" in sys.modules, "deaf": signal.SIGINT in blocked,
        "variable": os.environ.get(variable),
    }  # fmt: skip


def recorded(folder: Path, seed: int, duration_us: int = 120_000) -> Path:
    """A recording of two discs on a small sensor, with its truth beside it."""
    scene = evcot.simulate("discs", seed=seed, width=96, height=64, duration_us=duration_us, count=2)
    path = folder / f"discs{seed}.npz"
    write_recording(scene.recording, path)
    scene.truth.save(path.with_name(f"{path.stem}.truth.csv"))
    return path


def until(true: Callable[[], bool], what: str, patience_s: float = 90.0) -> None:
    """Wait until something is so."""
    deadline = time.monotonic() + patience_s
    while not true():
        assert time.monotonic() < deadline, what
        time.sleep(0.05)


BLOCK, CHECKPOINT = 250, 600


@contextmanager
def in_small_blocks(source: Input, seen: Callable[[Events], None]) -> Iterator[inputs.Stream]:
    """As `inputs.opened`, in blocks of a small recording; `seen` is told each."""

    def blocks(stream: inputs.Stream) -> Iterator[Events]:
        for whole in stream.blocks:
            for begin in range(0, len(whole), BLOCK):
                seen(whole[begin : begin + BLOCK])
                yield whole[begin : begin + BLOCK]

    with inputs.opened(source) as stream:
        yield replace(stream, blocks=blocks(stream))


def small(patch: pytest.MonkeyPatch, cache: Path, seen: Callable[[Events], None] = lambda _: None) -> None:
    patch.setattr(execute, "opened", lambda source: in_small_blocks(source, seen))
    patch.setattr(checkpoints, "CHECKPOINT_EVENTS", CHECKPOINT)
    patch.setattr(checkpoints, "cache_dir", lambda: cache)


def dies_once(cache: Path, task: Task) -> dict[str, Any]:
    """A run whose process is killed before its last block, if it began at the beginning."""
    continues = bool(list(cache.glob("sweep/.*.unfinished/checkpoint")))

    def seen(block: Events) -> None:
        if not continues and len(block) < BLOCK:
            os.kill(os.getpid(), signal.SIGKILL)

    with pytest.MonkeyPatch.context() as patch:
        small(patch, cache, seen)
        return execute.execute(task) | {"continues": continues}

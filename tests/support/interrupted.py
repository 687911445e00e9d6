# SPDX-License-Identifier: Apache-2.0
"""Runs of a sweep in small blocks with checkpoints between them, and one whose process is killed; workers import this."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from evcot.events import Events
from evcot_cosim.sweep import checkpoints, execute, inputs
from evcot_cosim.sweep.task import Input, Task

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

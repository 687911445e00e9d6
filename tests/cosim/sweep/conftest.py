# SPDX-License-Identifier: Apache-2.0
"""A Dask cluster on loopback: a scheduler and workers, each a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

Start = Callable[..., subprocess.Popen[bytes]]


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[Start]:
    """Starts `scheduler` or `worker` with options, in a folder of its own; all end with the test."""
    yield from _starting(tmp_path)


@pytest.fixture(scope="module")
def shared_dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Start]:
    """As `dask`; all end with the last test of the file."""
    yield from _starting(tmp_path_factory.mktemp("dask"))


def _starting(place: Path) -> Iterator[Start]:
    pytest.importorskip("distributed")
    started: list[subprocess.Popen[bytes]] = []

    def start(what: str, *options: str, folder: Path | None = None) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", "--no-dashboard", *options]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
        process = subprocess.Popen(
            command, cwd=folder or place, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        started.append(process)
        return process

    yield start
    for process in reversed(started):  # what a worker has started ends with it; a farewell would take seconds
        process.kill()
    for process in started:
        process.wait()

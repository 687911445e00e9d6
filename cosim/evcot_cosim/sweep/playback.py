# SPDX-License-Identifier: Apache-2.0
"""Runs of a sweep again: by their key, compared with the store, as report pages in the sweep's folder, or as tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evcot.errors import ConfigError, OutputError, reason_of
from evcot.events import Events, Recording
from evcot.hardware.modules import MODULES
from evcot.trackers.config import RunConfig

from ..lockstep.random_runs import Design, random_case
from ..lockstep.shrink import difference_in, shrunk, write_test
from ..report import Material, Side, Truth, write_report
from ..rtl.files import versions
from .execute import TaskResult, execute, tracked
from .fields import RTL
from .folder import MISMATCHES, PLAYBACK, spec_of
from .inputs import opened, truth_of
from .metrics import METRICS
from .store import read_rows
from .task import Task, configuration

__all__ = ["Difference", "repeat", "write_mismatches", "write_playback"]


_LEAST = 6  # digits of a key: enough to distinguish runs


@dataclass(frozen=True)
class Difference:
    """A column in which a run and its row differ."""

    name: str
    stored: Any
    now: Any


@dataclass(frozen=True)
class Repeated:
    """A run that was done again: its row, and where that differs from the stored one."""

    row: Mapping[str, Any]
    stored: bool
    differences: tuple[Difference, ...]

    @property
    def shown(self) -> list[tuple[str, str]]:
        """The result as a table for people."""
        names = ("key", "status", "engine", "hardware", "preset", "input", "error")
        rows = [(name, str(self.row[name])) for name in names if self.row.get(name)]
        rows += [(name, str(value)) for name, value in self.row["settings"].items()]
        return rows + [(name, f"{self.row[name]:.6g}") for name in METRICS if self.row.get(name) is not None]


def repeat(folder: Path, key: str) -> Repeated:
    """Do a run of the sweep in a folder again; the store stays as it is.

    Args:
        key: of the run, or its first digits.

    Raises:
        ConfigError: no such folder or run, or a program that has changed since.
    """
    spec_of(folder)
    matching = [row for row in read_rows(folder) if row["key"].startswith(key)] if len(key) >= _LEAST else []
    if len(matching) != 1:
        raise ConfigError(f"--only {key}: is the key of {len(matching)} runs in {folder}: must be that of one")
    stored = matching[0]
    row = execute(Task.from_json(stored["task"]))
    names = ("status", "error", *METRICS)
    compared = [Difference(name, stored[name], row.get(name)) for name in names]
    different = tuple(each for each in compared if each.stored != each.now)
    return Repeated(row, True, different)


_TESTS = 3  # that are written: one error makes many runs differ
_EVENTS_MAX = 20_000_000  # that a page is made of: it holds them in memory


def write_playback(folder: Path, rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Write a page for each of these runs, where there is none; returns key -> path in the folder.

    Raises:
        OutputError: it cannot be written.
    """
    written = {}
    for row in rows:
        name = f"{PLAYBACK}/{row['key']}.html"
        path = folder / name
        if path.is_file():
            written[row["key"]] = name
        elif (row["events"] or 0) <= _EVENTS_MAX:
            _make(path.parent)
            write_report(_material(row), path)
            written[row["key"]] = name
    return written


def write_mismatches(folder: Path, rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Write a test with a waveform for the first of these random runs that differ; returns their paths in the folder.

    Those of `evcot_top` are left out: its registers change within a run.

    Raises:
        OutputError: it cannot be written.
    """
    written = []
    alone = [task for task in (Task.from_json(row["task"]) for row in rows) if "top" not in task.tables]
    for task in alone[:_TESTS]:
        name = f"{MISMATCHES}/test_{task.key}.py"
        if not (folder / name).is_file():
            design = Design.from_tables(task.tables)
            case = random_case(design, task.seed or 0, task.events)
            if difference_in(case) is None:
                continue  # what was broken is not any more
            _make(folder / MISMATCHES)
            write_test(*shrunk(case), folder / MISMATCHES, task.key)
        written.append(name)
    return written


def _material(row: Mapping[str, Any]) -> Material:
    task = Task.from_json(row["task"])
    assert task.input is not None
    with opened(task.input) as stream:
        found: TaskResult = tracked(task, stream, whole=True)
        scored = truth_of(task.input, stream.sensor, stream.first_us)
    events = _joined(found.events)
    recording = Recording(events, *stream.sensor, Path(task.input.name).stem)
    settings, filters = configuration(task.engine, stream.sensor, task.preset, task.tables, task.hardware)
    plain = (
        settings.to_dict() if isinstance(settings, RunConfig) else {task.engine: asdict(settings), "filters": asdict(filters)}
    )
    side = "hardware" if task.engine == RTL else "model" if task.engine in MODULES else "software"
    summary = {"name": recording.name, "command": row["command"], "versions": versions(), "config": plain}
    truth = None if scored is None else Truth(*scored)
    return Material(recording, summary, (Side(side, found.log),), truth)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {reason_of(error, folder)}") from error


def _joined(blocks: Sequence[Events]) -> Events:
    columns = ("t_us", "x", "y", "p")
    return Events(*(np.concatenate([getattr(block, name) for block in blocks]) for name in columns))

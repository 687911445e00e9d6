# SPDX-License-Identifier: Apache-2.0
"""Report pages of single runs of a sweep: each is run again, and its report written into the sweep's folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from evcot.errors import OutputError
from evcot.events import Events, Recording
from evcot.hardware.modules import MODULES
from evcot.trackers.config import RunConfig

from ..report import Material, Side, Truth, write_report
from ..rtl.fingerprint import versions
from .configure import configuration
from .execute import Tracked, tracked
from .fields import RTL
from .folder import PLAYBACK
from .inputs import opened, truth_of
from .task import Task

__all__ = ["write_playback"]

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
            try:
                path.parent.mkdir(exist_ok=True)
            except OSError as error:
                raise OutputError(f"{path.parent}: cannot be written: {error.strerror or error}") from error
            write_report(_material(row), path)
            written[row["key"]] = name
    return written


def _material(row: Mapping[str, Any]) -> Material:
    task = Task.from_json(row["task"])
    assert task.input is not None
    with opened(task.input) as stream:
        found: Tracked = tracked(task, stream, whole=True)
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


def _joined(blocks: Sequence[Events]) -> Events:
    columns = ("t_us", "x", "y", "p")
    return Events(*(np.concatenate([getattr(block, name) for block in blocks]) for name in columns))

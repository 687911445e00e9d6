# SPDX-License-Identifier: Apache-2.0
"""Pages for notebooks: the report of a recording with its logs, and of a run, with few events."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import evcot
from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.page import Page
from evcot.ranges import check_integer
from evcot.tracks.log import TrackLog

from .lockstep.cosim import CosimRun
from .lockstep.summary import summarise
from .report import Material, Side, truth_of, write_report
from .report.material import side_names

__all__ = ["recording_page", "run_page"]

_EVENTS = (1_000, 2_000_000)
_HEIGHT_PX = (100, 10_000)


def recording_page(recording: Recording, logs: Sequence[TrackLog], events_max: int, height_px: int) -> Page:
    """See `Recording.show`."""
    for log in logs:
        if not isinstance(log, TrackLog):
            raise ConfigError(f"show: a log of type {type(log).__name__}: must be a TrackLog")
    names = ["software"] if len(logs) == 1 else side_names((), [(log.engine, log.engine) for log in logs])
    sides = tuple(map(Side, names, logs))
    summary = {"name": recording.name, "command": "recording.show", "versions": {"evcot": evcot.__version__}}
    return _page(Material(recording, summary, sides), events_max, height_px)


def run_page(run: CosimRun, events_max: int, height_px: int) -> Page:
    """See `CosimRun.show`."""
    sides = Side("hardware", run.hardware), Side("software", run.software)
    truth = truth_of(run.source, run.recording) if run.source is not None else None
    return _page(Material(run.recording, summarise(run, "run.show"), sides, truth), events_max, height_px)


def _page(material: Material, events_max: int, height_px: int) -> Page:
    check_integer("events_max", events_max, *_EVENTS, "events in the page")
    check_integer("height_px", height_px, *_HEIGHT_PX, "height of the frame")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        write_report(material, path, events_max=events_max)
        return Page(material.recording.name, path.read_text(encoding="utf-8"), height_px)

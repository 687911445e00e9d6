# SPDX-License-Identifier: Apache-2.0
"""What a run leaves behind: a folder with summary, logs, picture and waveform, whole or not there."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from evcot.config import RunConfig
from evcot.contract import Kind
from evcot.errors import OutputError
from evcot.events import Recording
from evcot.picture import draw

from .cosim import CosimRun, stalls_from
from .lockstep import MismatchError
from .summary import summarise, summarise_mismatch, write_summary
from .waves import Window, write_waves

__all__ = ["folder_written_aside", "write_mismatch", "write_run"]

_WAVES_EVENTS = 400  # events before and after the moment that the default waveform shows
_MISMATCH_EVENTS = 50  # the same, around a mismatch


def write_run(run: CosimRun, folder: Path, *, command: str, window: Window | None = None, waves: bool = True) -> dict[str, Any]:
    """Write summary.json, the logs, the picture and the waveform of a run; returns the summary.

    The folder takes the place of an older one only when all of it is written.

    Args:
        window: what the waveform shows; by default the surroundings of the first merge, else of the first birth.

    Raises:
        OutputError: something cannot be written.
    """
    summary = summarise(run, command)
    with folder_written_aside(folder) as aside:
        for name, log in (("hardware", run.hardware), ("model", run.model), ("software", run.software)):
            log.save_npz(aside / f"{name}.npz")
            log.write_csv(aside / f"{name}.csv")
        draw(run.recording, run.hardware, run.software, aside / "picture.png", f"{run.recording.name}: {run.config.name}")
        if waves:
            shown = window or _telling_window(run)
            write_waves(
                run.recording.events, run.config.hardware(run.recording.width, run.recording.height), aside, shown,
                top=run.top, stalls=stalls_from(run.seed), name="waves",
            )  # fmt: skip
        write_summary(summary, aside / "summary.json")
    return summary


def write_mismatch(error: MismatchError, recording: Recording, config: RunConfig, folder: Path, *, command: str) -> None:
    """Write what a mismatch leaves: summary.json with its record, a waveform of the events around it and the view.

    Raises:
        OutputError: something cannot be written.
    """
    found = error.mismatch
    with folder_written_aside(folder) as aside:
        window = Window.around(found.event_index, len(recording.events), _MISMATCH_EVENTS)
        write_waves(
            recording.events, config.hardware(recording.width, recording.height), aside, window,
            top=found.top, stalls=stalls_from(found.seed), name="mismatch",
        )  # fmt: skip
        write_summary(summarise_mismatch(found, recording, config, command), aside / "summary.json")


def _telling_window(run: CosimRun) -> Window:
    for kind in (Kind.MERGED, Kind.BORN):
        records = run.hardware.of_kind(kind)
        if len(records):
            return Window.around(int(records["event_index"][0]), len(run.recording.events), _WAVES_EVENTS)
    return Window(0, min(2 * _WAVES_EVENTS, len(run.recording.events) - 1))


@contextmanager
def folder_written_aside(folder: Path) -> Iterator[Path]:
    """A folder beside `folder` that takes its place when the block ends without an error; else nothing of it stays.

    Raises:
        OutputError: something cannot be written.
    """
    aside = folder.with_name(f".{folder.name}.partial")
    try:
        shutil.rmtree(aside, ignore_errors=True)
        aside.mkdir(parents=True)
        try:
            yield aside
            if folder.exists():
                shutil.rmtree(folder)
            aside.rename(folder)
        finally:
            shutil.rmtree(aside, ignore_errors=True)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{error.filename or folder}: cannot be written: {error.strerror or error}") from error

# SPDX-License-Identifier: Apache-2.0
"""Output folder of a run: summary, logs, picture, report and waveform, written completely or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from evcot.digest import digest
from evcot.errors import OutputError
from evcot.events import Recording
from evcot.outputs import check_folder, folder_written_aside
from evcot.recordings.files import write_recording
from evcot.tracks.log import Kind

from ..devices.base import Stalls
from ..lockstep.cosim import CosimRun, rerun
from ..lockstep.mismatch import MismatchError
from ..lockstep.moments import Moment
from ..lockstep.run_file import RUN_FILE, RunFile, Source, write_run_file
from ..lockstep.summary import SUMMARY, summarise, summarise_mismatch, write_summary
from ..waves.window import Window, wave_names, write_waves
from . import REPORT, Material, Side, truth_of, write_report

__all__ = ["files_of", "run_names", "save_run", "write_mismatch", "write_run"]

_RECORDING = "recording.npz"  # in the folder of a run of a recording that was made in memory

_WAVES_EVENTS = 400  # events before and after the moment that the default waveform shows
_MISMATCH_EVENTS = 50  # the same, around a mismatch


def run_names() -> list[str]:
    """Names of the files that `write_run` and `write_mismatch` may write."""
    logs = [f"{name}.{suffix}" for name in ("hardware", "model", "software") for suffix in ("npz", "csv", "parquet")]
    return [RUN_FILE, SUMMARY, REPORT, _RECORDING, "picture.png", *logs, *wave_names("waves"), *wave_names("mismatch")]


def files_of(folder: Path) -> tuple[tuple[str, int], ...]:
    """The files of a run in its folder, without the report: name and size in bytes, in the order of `run_names`."""
    paths = (folder / name for name in run_names() if name != REPORT)
    return tuple((path.name, path.stat().st_size) for path in paths if path.is_file())


def write_run(run: CosimRun, folder: Path, made_of: RunFile, *, command: str, waves: bool = True) -> dict[str, Any]:
    """Write run.toml, summary.json, the logs, picture, report and waveform of a run; returns the summary.

    They replace those of an older run only when all of them are written; other files in the folder are kept.

    Args:
        made_of: contents of run.toml.
        waves: whether to write a waveform, of a window around the first merge, else around the first birth.

    Raises:
        OutputError: a file cannot be written.
    """
    truth = truth_of(made_of.source, run.recording)
    t_us = run.recording.events.t_us
    truth = truth.within(int(t_us[0]), int(t_us[-1])) if truth else None
    summary = summarise(run, command, truth)
    with folder_written_aside(folder, "cosim") as aside:
        if run.source is None:
            write_recording(run.recording, aside / _RECORDING)
        for name, log in (("hardware", run.hardware), ("model", run.model), ("software", run.software)):
            replace(log, recording=made_of.digest).save_npz(aside / f"{name}.npz")
            log.write_csv(aside / f"{name}.csv")
        from evcot.pictures.picture import draw  # Matplotlib is 50 MB, which a long run does not need

        draw(run.recording, run.hardware, run.software, aside / "picture.png", f"{run.recording.name}: {run.config.name}")
        if waves:
            moment = _telling_moment(run)
            window = Window.around(moment.event_index, len(run.recording.events), _WAVES_EVENTS)
            write_waves(
                run.recording.events, run.config.device_config(run.recording.width, run.recording.height), aside, window,
                stalls=Stalls.seeded(run.seed), name="waves", moment=moment,
            )  # fmt: skip
        write_run_file(aside / RUN_FILE, made_of)
        write_summary(summary, aside / SUMMARY)
        sides = (Side("hardware", run.hardware, str(folder)), Side("software", run.software))
        write_report(Material(run.recording, summary, sides, truth, files=files_of(aside)), aside / REPORT)
    return summary


def save_run(run: CosimRun, folder: Path, *, waves: bool = True) -> dict[str, Any]:
    """See `CosimRun.save`."""
    check_folder(folder, "cosim", run_names())
    if run.source and not run.source.is_scene and Path(run.source.recording).resolve().is_relative_to(folder.resolve()):
        raise OutputError(f"{folder}: holds {run.source.recording}, which the run has read: must be another folder")
    source = run.source or Source(str(folder.absolute() / _RECORDING))
    made_of = RunFile(source, run.seed, digest(run.recording.events), run.config)
    return write_run(run, folder, made_of, command=f"evcot_cosim.cosim, {run.recording.name}", waves=waves)


def write_mismatch(error: MismatchError, recording: Recording, made_of: RunFile, folder: Path, *, command: str) -> None:
    """Write the files of a run with a mismatch: run.toml, summary.json, the logs up to it, the report, and a waveform
    of the events around it with its view.

    Raises:
        OutputError: a file cannot be written.
    """
    found, config = error.mismatch, made_of.config
    with folder_written_aside(folder, "cosim") as aside:
        window = Window.around(found.event_index, len(recording.events), _MISMATCH_EVENTS)
        write_waves(
            recording.events, config.device_config(recording.width, recording.height), aside, window,
            stalls=Stalls.seeded(found.seed), name="mismatch", moment=Moment(found.event_index, "mismatch"),
        )  # fmt: skip
        write_run_file(aside / RUN_FILE, made_of)
        summary = summarise_mismatch(found, recording, config, command)
        write_summary(summary, aside / SUMMARY)
        hardware, model = rerun(recording, config, found)
        for name, log in (("hardware", hardware), ("model", model)):
            log.save_npz(aside / f"{name}.npz")
        sides = (Side("hardware", hardware, str(folder)), Side("model", model))
        truth = truth_of(made_of.source, recording)
        write_report(Material(recording, summary, sides, truth, files=files_of(aside)), aside / REPORT)


def _telling_moment(run: CosimRun) -> Moment:
    for kind, name in ((Kind.MERGED, "merge"), (Kind.BORN, "birth")):
        records = run.hardware.of_kind(kind)
        if len(records):
            track_id = int(records["track_id"][0])
            return Moment(int(records["event_index"][0]), f"{name} {track_id}", kind, track_id)
    return Moment(0, "event 0")

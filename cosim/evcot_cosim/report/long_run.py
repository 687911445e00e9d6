# SPDX-License-Identifier: Apache-2.0
"""Output folder of a run of any length: logs, summary, an overview, and a page for each part of the recording.

The events are read a second time, in parts, beside the logs, while another thread writes those; memory holds one part, and what
`Comparison` holds. The summary counts all pairs and differences of hardware and software, and lists the first `_LISTED`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from contextvars import copy_context
from pathlib import Path
from typing import Any

import evcot
from evcot.errors import TrackLogError
from evcot.events import Recording
from evcot.outputs import folder_written_aside
from evcot.tracks import PARQUET
from evcot.tracks.compare import Comparison
from evcot.tracks.log import Kind
from evcot.tracks.log_files import Extent, save_log
from evcot.tracks.npz import NpzFile
from evcot.tracks.parquet import LogFile, check_parquet

from ..devices.base import Stalls
from ..lockstep.cosim import LongRun, near_px
from ..lockstep.moments import Moment
from ..lockstep.run_file import RUN_FILE, RunFile, Source, write_run_file
from ..lockstep.summary import SUMMARY, summarise_long, write_summary
from ..lockstep.verdict import verdict_by
from ..memory import give_back
from ..waves.window import Window, write_waves
from . import REPORT
from .part_pages import LongRecording, part_names, write_overview, write_parts

__all__ = ["long_names", "write_long_logs", "write_long_run"]


# Report of the logs of a recording that is not held in memory: an overview, and a folder with a page for each part.
#
# The recording is read twice: to see that the logs belong to it, and in parts beside the logs.


def write_long_logs(
    logs: Mapping[str, LogFile | NpzFile],
    source: Source,
    path: Path,
    command: str,
    *,
    check: Callable[[Extent], None],
    claim: Callable[[Path, Sequence[str]], None],
    force: bool = False,
    progress: Callable[[int], None] | None = None,
) -> dict[str, Any]:
    """Write `path`, and the pages of the parts into a folder of the same name that ends with .parts; returns the summary.

    Args:
        logs: by side.
        check: called with the extent of the recording, to refuse logs of another one.
        claim: called with the folder and its files before they are written.
        progress: called with the number of events done.

    Raises:
        OutputError: a file exists (without `force`), or cannot be written.
        RecordingError, TrackLogError: an input cannot be read.
    """
    with source.opened() as file:
        extent, sensor, name = Extent.of(source.blocks(file)), file.sensor, file.name
    check(extent)
    folder = path.with_name(f"{path.stem}.parts")
    claim(folder, [RUN_FILE, *part_names(extent.events)])
    with folder_written_aside(folder, "report") as aside, source.opened() as file:
        recording = LongRecording(name, sensor, source.blocks(file), extent.events, extent.first_us, extent.last_us)
        paged = write_parts(recording, logs, aside, {}, progress=progress)
        (aside / RUN_FILE).write_text(f"# Pages that {path.name} shows.\n", encoding="utf-8")
    summary = {
        "name": name,
        "command": command,
        "versions": {"evcot": evcot.__version__},
        "events": extent.events,
        "recording_s": (extent.last_us - extent.first_us) / 1e6,
        "sensor": {"width": sensor[0], "height": sensor[1]},
        "verdict": verdict_by(paged.quality, {}).to_dict(),
        "parts": [part | {"page": f"{folder.name}/{part['page']}"} for part in paged.parts],
    }
    write_overview(summary, path, force=force)
    return summary


_NUMBERED = re.compile(r"part-[0-9]{5,}\.html|(hardware|software)\.[0-9]+\.parquet")
_LISTED = 1_000  # pairs of tracks, and others
_WAVES_EVENTS = 400  # around the first birth
_RECORDS_BESIDE = 1 << 22  # longer logs are written before the pages, not beside them: Arrow needs memory, too


def long_names(folder: Path) -> list[str]:
    """Names of files in a folder that `write_long_run` may write besides `run_names`: their number depends on the run."""
    return [name for name in os.listdir(folder) if _NUMBERED.fullmatch(name)] if folder.is_dir() else []


def write_long_run(
    run: LongRun,
    source: Source,
    folder: Path,
    made_of: RunFile,
    head: Recording,
    *,
    scratch: Path,
    command: str,
    waves: bool = True,
    progress: Callable[[int], None] | None = None,
) -> dict[str, Any]:
    """Write run.toml, summary.json, both logs, the overview, a page for each part, and a waveform; returns the summary.

    Args:
        scratch: a folder for files that the caller removes.
        head: the first events; a waveform is written if the first birth is among them.
        progress: called with the number of events done.

    Raises:
        OutputError: a file cannot be written.
        RecordingError: the recording cannot be read a second time.
    """
    give_back()
    before = len(run.hardware.records) > _RECORDS_BESIDE
    with (
        closing(
            Comparison(run.begin_us, run.end_us, radius_px=near_px(run.config), folder=scratch, most=_LISTED)
        ) as comparison,
        folder_written_aside(folder, "cosim") as aside,
        ThreadPoolExecutor(2 if before else 1) as others,
    ):
        both = {"hardware": run.hardware, "software": run.software}
        logs = [others.submit(copy_context().run, save_log, log, aside / f"{name}{_suffix()}") for name, log in both.items()]
        if before:
            for log_written in logs:
                log_written.result()
            give_back()
        about = {"config": run.config.to_dict()}
        with source.opened() as file:
            recording = LongRecording(run.name, run.sensor, source.blocks(file), run.events, run.begin_us, run.end_us)
            paged = write_parts(recording, both, aside, about, comparison, progress)
        summary = summarise_long(run, comparison, paged.quality, command)
        summary["parts"] = paged.parts
        if waves:
            _write_waves(run, aside, head)
        for log_written in logs:
            log_written.result()
        write_run_file(aside / RUN_FILE, made_of)
        write_summary(summary, aside / SUMMARY)
        write_overview(summary, aside / REPORT)
    return summary


def _suffix() -> str:
    """Parquet where it can be written."""
    try:
        check_parquet("")
    except TrackLogError:
        return ".npz"
    return PARQUET


def _write_waves(run: LongRun, folder: Path, head: Recording) -> None:
    for begin in range(0, len(run.hardware.records), 1 << 16):
        records = run.hardware.records[begin : begin + (1 << 16)]
        born = records[records["kind"] == Kind.BORN]
        if len(born):
            index = int(born["event_index"][0])
            if index + _WAVES_EVENTS < len(head.events):
                track_id = int(born["track_id"][0])
                moment = Moment(index, f"birth {track_id}", Kind.BORN, track_id)
                window = Window.around(index, len(head.events), _WAVES_EVENTS)
                write_waves(
                    head.events, run.config.device_config(*run.sensor), folder, window,
                    stalls=Stalls.seeded(run.seed), model=run.build, name="waves", moment=moment,
                )  # fmt: skip
            return

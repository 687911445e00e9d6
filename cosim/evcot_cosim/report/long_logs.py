# SPDX-License-Identifier: Apache-2.0
"""Report of the logs of a recording that is not held in memory: an overview, and a folder with a page for each part.

The recording is read twice: to see that the logs belong to it, and in parts beside the logs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import evcot
from evcot.outputs import folder_written_aside
from evcot.tracks.log_match import Extent
from evcot.tracks.log_parts import in_step
from evcot.tracks.npz import NpzFile
from evcot.tracks.parquet import LogFile

from ..lockstep.run_file import RUN_FILE, Source
from ..lockstep.verdict import verdict_by
from .overview import write_overview
from .part_pages import LongLog, LongRecording, part_names, write_parts

__all__ = ["write_long_logs"]


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
        paged = write_parts(recording, {side: _long(log) for side, log in logs.items()}, aside, {}, progress=progress)
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


def _long(log: LogFile | NpzFile) -> LongLog:
    runs = log.blocks() if isinstance(log, LogFile) else in_step(log.record_runs(), log.owner_runs())
    return LongLog(log.engine, runs)

# SPDX-License-Identifier: Apache-2.0
"""Output folder of a run of any length: logs, summary, an overview, and a page for each part of the recording.

The events are read a second time, in parts, beside the logs, while another thread writes those; memory holds one part, and what
`Comparison` holds.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from evcot.errors import TrackLogError
from evcot.events import Events, Recording
from evcot.metrics.quality import QualityCounter, isolation, quality_of
from evcot.outputs import folder_written_aside
from evcot.tracks.compare import Comparison
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.parquet import SUFFIX, check_parquet
from evcot.tracks.parts import Parts, runs_of
from evcot.tracks.writing import save_log

from ..lockstep.cosim import near_px, stalls_from
from ..lockstep.long import LongRun
from ..lockstep.moments import Moment
from ..lockstep.run_file import RUN_FILE, RunFile, Source, write_run_file
from ..lockstep.summary import SUMMARY, summarise_long, write_summary
from ..lockstep.verdict import verdict_by
from ..waves.window import Window, write_waves
from . import REPORT
from .material import Material, Side
from .overview import write_overview
from .page import write_report

__all__ = ["PART_EVENTS", "Part", "write_long_run"]

PART_EVENTS = 1 << 18
_DRAWN = 40_000  # events of a part's page
_WAVES_EVENTS = 400  # around the first birth


@dataclass(frozen=True)
class Part:
    """A line of the overview; counts and times are those of the part, times from the recording's first event on.

    Attributes:
        page: its file.
        alive_hardware, alive_software: mean number of tracks; None without a sample.
        paired_fraction: share of the hardware's track time with a software track nearby.
        grade: of the part's verdict.
    """

    page: str
    from_us: int
    to_us: int
    events: int
    births_hardware: int
    births_software: int
    alive_hardware: float | None
    alive_software: float | None
    paired_fraction: float | None
    grade: str


def write_long_run(
    run: LongRun,
    source: Source,
    folder: Path,
    made_of: RunFile,
    head: Recording,
    *,
    command: str,
    waves: bool = True,
    progress: Callable[[int], None] | None = None,
) -> dict[str, Any]:
    """Write run.toml, summary.json, both logs, the overview, a page for each part, and a waveform; returns the summary.

    Args:
        head: the first events; a waveform is written if the first birth is among them.
        progress: told how many events are done.

    Raises:
        OutputError: a file cannot be written.
        RecordingError: the recording cannot be read a second time.
    """
    _give_back()
    with folder_written_aside(folder) as aside, ThreadPoolExecutor(1) as second:
        logs = second.submit(copy_context().run, _save_logs, run, aside)
        comparison = Comparison(run.begin_us, run.end_us, radius_px=near_px(run.config))
        quality = {name: QualityCounter(run.begin_us, run.end_us) for name in ("hardware", "software")}
        parts = list(_parts(run, source, aside, comparison, quality, progress))
        figures = {name: counter.quality() for name, counter in quality.items()}
        summary = summarise_long(run, comparison, figures, command) | ({"auto": made_of.said} if made_of.said else {})
        summary["parts"] = [asdict(part) for part in parts]
        if waves:
            _write_waves(run, aside, head)
        logs.result()
        write_run_file(aside / RUN_FILE, made_of)
        write_summary(summary, aside / SUMMARY)
        write_overview(summary, aside / REPORT)
    return summary


def _save_logs(run: LongRun, folder: Path) -> None:
    for name, log in (("hardware", run.hardware), ("software", run.software)):
        save_log(log, folder / f"{name}{_suffix()}")


def _suffix() -> str:
    """Parquet where it can be written."""
    try:
        check_parquet("")
    except TrackLogError:
        return ".npz"
    return SUFFIX


def _parts(
    run: LongRun,
    source: Source,
    folder: Path,
    comparison: Comparison,
    quality: dict[str, QualityCounter],
    progress: Callable[[int], None] | None,
) -> Iterator[Part]:
    logs = {name: Parts(log.engine, runs_of(log)) for name, log in (("hardware", run.hardware), ("software", run.software))}
    alone_in = isolation(run.sensor)
    done, since_us = 0, run.begin_us
    with source.opened() as file:
        for number, events in enumerate(_cut(source.blocks(file), PART_EVENTS)):
            done += len(events)
            last = done == run.events
            alone = alone_in(events)
            whole, shown = {}, {}
            for name, log in logs.items():
                whole[name], shown[name] = log.take(len(events), last=last)
                quality[name].add(whole[name], events, alone, last=last)
            until_us = int(events.t_us[-1])
            times_us = comparison.times_us(since_us, None if last else until_us)
            hardware, software, pairs = comparison.add(whole["hardware"], whole["software"], times_us, last=last)
            own = {name: quality_of(log, events, alone) for name, log in shown.items()}
            verdict = verdict_by(own, {}).to_dict()
            page = f"part-{number:05}.html"
            title = f"{run.name}, {(since_us - run.begin_us) / 1e6:.3f} s to {(until_us - run.begin_us) / 1e6:.3f} s"
            summary = {"name": title, "verdict": verdict, "config": run.config.to_dict()}
            sides = tuple(Side(name, log) for name, log in shown.items())
            write_report(Material(Recording(events, *run.sensor, title), summary, sides), folder / page, events_max=_DRAWN)
            yield Part(
                page=page,
                from_us=since_us - run.begin_us,
                to_us=until_us - run.begin_us,
                events=len(events),
                births_hardware=_births(whole["hardware"]),
                births_software=_births(whole["software"]),
                alive_hardware=float(hardware.mean()) if len(hardware) else None,
                alive_software=float(software.mean()) if len(software) else None,
                paired_fraction=pairs / int(hardware.sum()) if hardware.sum() else None,
                grade=verdict["grade"],
            )
            since_us = until_us
            del events, alone, whole, shown, sides, own  # before the next ones are made
            _give_back()
            if progress is not None:
                progress(done)


def _give_back() -> None:
    """Hand what was freed back to the system, where the C library can: it keeps tens of megabytes otherwise."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if trim is not None:
        trim(0)


def _births(log: TrackLog) -> int:
    return len(log.of_kind(Kind.BORN))


def _cut(blocks: Iterator[Events], size: int) -> Iterator[Events]:
    """Runs of exactly `size` events, and a last one."""
    waiting: list[Events] = []
    have = 0
    for block in blocks:
        waiting.append(block)
        have += len(block)
        while have >= size:
            joined = Events.joined(waiting)
            yield joined[:size].packed()
            waiting, have = [joined[size:]], have - size
    if have:
        yield Events.joined(waiting).packed()


def _write_waves(run: LongRun, folder: Path, head: Recording) -> None:
    for begin in range(0, len(run.hardware.records), 1 << 16):
        records = run.hardware.records[begin : begin + (1 << 16)]
        born = records[records["kind"] == Kind.BORN]
        if len(born):
            index = int(born["event_index"][0])
            if index + _WAVES_EVENTS < len(head.events):
                moment = Moment(index, "birth 1", Kind.BORN, int(born["track_id"][0]))
                window = Window.around(index, len(head.events), _WAVES_EVENTS)
                write_waves(
                    head.events, run.config.hardware(*run.sensor), folder, window,
                    top=run.top, stalls=stalls_from(run.seed), name="waves", moment=moment,
                )  # fmt: skip
            return

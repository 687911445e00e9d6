# SPDX-License-Identifier: Apache-2.0
"""Pages of a recording of any length: one for each part, and an overview of all. Memory holds two parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.compiling import compiled_aside
from evcot.events import Events, Recording
from evcot.metrics.quality import Quality, QualityCounter, isolation, quality_of
from evcot.outputs import written_aside
from evcot.recordings.formats.source import Sensor
from evcot.templating import html_templates
from evcot.tracks.compare import Comparison
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.log_parts import AnyLog, LogParts
from evcot.tracks.timeline import alive

from ..lockstep.lockstep import cut
from ..lockstep.verdict import verdict_by, verdict_from
from ..memory import give_back, keep_little
from .collect import collect, looks_of
from .facts import agreement_rows, flat, latency_bars, run_rows
from .material import Material, Side
from .page import inline_script, inline_styles, write_report

__all__ = ["PART_EVENTS", "LongRecording", "part_names", "write_overview", "write_parts"]


PART_EVENTS = 1 << 18
_DRAWN = 40_000  # events of a part's page
# Returned to the system at once: 10 to 20 MB less than from 1 MB on, which a lock-step needs for its rate.
_LARGE_BYTES = 1 << 17


@dataclass(frozen=True)
class LongRecording:
    """A recording that is not held in memory.

    Attributes:
        blocks: its events, block by block.
        begin_us, end_us: times of the first and the last event.
    """

    name: str
    sensor: Sensor
    blocks: Iterator[Events]
    events: int
    begin_us: int
    end_us: int


@dataclass(frozen=True)
class Paged:
    """What `write_parts` found.

    Attributes:
        parts: a line of the overview each: `page`, its file; `events`; `from_us`, `to_us` from the recording's first event on;
            `births_SIDE`, and `alive_SIDE`, the mean number of tracks, None without a sample; `paired_fraction`, where logs are
            compared, the share of the hardware's track time with a software track nearby; `grade` of the part's verdict.
        quality: of each side, over all parts.
    """

    parts: list[dict[str, Any]]
    quality: dict[str, Quality]


def part_names(events: int) -> list[str]:
    """The files of the pages of so many events."""
    return [f"part-{number:05}.html" for number in range(-(-events // PART_EVENTS))]


def write_parts(
    recording: LongRecording,
    logs: Mapping[str, AnyLog],
    folder: Path,
    about: Mapping[str, Any],
    comparison: Comparison | None = None,
    progress: Callable[[int], None] | None = None,
) -> Paged:
    """Write the page of each part into a folder.

    Args:
        logs: by side.
        about: what the pages' summaries have besides name and verdict.
        comparison: of the sides hardware and software; every part is added to it.
        progress: called with the number of events done.

    Raises:
        OutputError: a file cannot be written.
    """
    keep_little(_LARGE_BYTES)
    compiled_aside(_compile_kernels, recording.sensor)
    in_parts = {name: LogParts(log) for name, log in logs.items()}
    quality = {name: QualityCounter(recording.begin_us, recording.end_us) for name in logs}
    times = comparison or Comparison(recording.begin_us, recording.end_us)
    alone_in = isolation(recording.sensor)
    parts: list[dict[str, Any]] = []
    done, since_us = 0, recording.begin_us
    with ThreadPoolExecutor(1) as other:  # writes a page while the next part is looked at
        grades: list[Future[str]] = []
        for events in cut(recording.blocks, PART_EVENTS):
            done += len(events)
            last = done == recording.events
            until_us = int(events.t_us[-1])
            alone, times_us = alone_in(events), times.times_us(since_us, None if last else until_us)
            whole, shown = {}, {}
            for name, log in in_parts.items():
                whole[name], shown[name] = log.take(len(events), last=last)
                quality[name].add(whole[name], events, alone, last=last)
            part: dict[str, Any] = {
                "page": f"part-{len(parts):05}.html",
                "from_us": since_us - recording.begin_us,
                "to_us": until_us - recording.begin_us,
                "events": len(events),
                **{f"births_{name}": len(log.of_kind(Kind.BORN)) for name, log in whole.items()},
                **_alive(whole, times_us, comparison, last=last),
            }
            del whole  # it takes some megabytes
            if grades:
                grades[-1].result()  # never two pages behind; and what went wrong ends the run here
            title = f"{recording.name}, {part['from_us'] / 1e6:.3f} s to {part['to_us'] / 1e6:.3f} s"
            shown_part = Recording(events, *recording.sensor, title)
            grades.append(other.submit(copy_context().run, _write_page, shown_part, shown, alone, about, folder / part["page"]))
            parts.append(part)
            since_us = until_us
            del events, alone, shown, shown_part  # before the next ones are made
            give_back()
            if progress is not None:
                progress(done)
        parts = [part | {"grade": grade.result()} for part, grade in zip(parts, grades, strict=True)]
    return Paged(parts, {name: counter.quality() for name, counter in quality.items()})


def _compile_kernels(sensor: Sensor) -> None:
    """Make Numba compile what looks at a part and draws its page."""
    nowhere = np.zeros(1, np.uint16)
    events = Events(np.zeros(1, np.int64), nowhere, nowhere, np.zeros(1, np.uint8))
    log = TrackLog("", np.empty(0, TRACK), np.full(1, -1, np.int16))
    quality_of(log, events, isolation(sensor)(events))
    collect(Material(Recording(events, *sensor, ""), {}, (Side("hardware", log),)), 1)


def _write_page(
    recording: Recording, logs: Mapping[str, TrackLog], alone: NDArray[np.bool_], about: Mapping[str, Any], path: Path
) -> str:
    """Write the page of a part; returns the grade of its verdict."""
    events = recording.events
    verdict = verdict_by({name: quality_of(log, events, alone) for name, log in logs.items()}, {}).to_dict()
    summary = {"name": recording.name, "verdict": verdict, **about}
    sides = tuple(Side(name, log) for name, log in logs.items())
    write_report(Material(recording, summary, sides), path, events_max=_DRAWN)
    return str(verdict["grade"])


def _alive(
    logs: Mapping[str, TrackLog], times_us: NDArray[np.int64], comparison: Comparison | None, *, last: bool
) -> dict[str, float | None]:
    """Mean numbers of tracks at these times and, of a comparison, how much of the hardware's time is paired."""
    if comparison is None:
        return {f"alive_{name}": _mean(alive(log, times_us)) for name, log in logs.items()}
    hardware, software, pairs = comparison.add(logs["hardware"], logs["software"], times_us, last=last)
    paired = pairs / int(hardware.sum()) if hardware.sum() else None
    return {"alive_hardware": _mean(hardware), "alive_software": _mean(software), "paired_fraction": paired}


def _mean(counts: NDArray[np.int64]) -> float | None:
    return float(counts.mean()) if len(counts) else None


_MODULE = "overview.js"
_ALIVE = "alive_"  # what the fields of a part that are there once for each side begin with


def write_overview(summary: Mapping[str, Any], path: Path, *, force: bool = False) -> None:
    """Write the page; the pages of the parts that `summary` lists are beside it, or in a folder that they name.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    folder = files("evcot_cosim.report") / "templates"
    script = (folder / _MODULE).read_text(encoding="utf-8")
    environment = html_templates("evcot_cosim.report")
    verdict = verdict_from(summary["verdict"])
    names = [name.removeprefix(_ALIVE) for name in summary["parts"][0] if name.startswith(_ALIVE)]
    looks = looks_of(names)
    sides = [{"name": name, "look": looks[name]} for name in names]
    text = environment.get_template("overview.html.j2").render(
        title=summary["name"],
        summary=summary,
        verdict=verdict,
        sides=sides,
        folder=summary["parts"][0]["page"].rpartition("/")[0],
        marks={"good": "✓", "fair": "!", "poor": "✗"},
        agreement=agreement_rows(summary),
        engine_rows=(),  # of long runs the pages of parts have them
        run_rows=run_rows(summary),
        config_rows=flat(summary.get("config", {})),
        versions=summary["versions"],
        latency=latency_bars(summary),
        comparison=None,
        run=None,
        style=inline_styles("style"),
        **inline_script(script, {"parts": summary["parts"], "sides": sides}),
    )
    with written_aside(path, force=force) as file:
        file.write(text.encode())

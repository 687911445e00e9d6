# SPDX-License-Identifier: Apache-2.0
"""`evcot report`: write the page for exploring a run, software trackers' logs, or two runs."""

from __future__ import annotations

import argparse
import json
import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import evcot
from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.metrics import evaluate
from evcot.metrics.scores import warn_of_other_truth
from evcot.outputs import is_own_file, remade
from evcot.tracks.log import TrackLog
from evcot.tracks.log_files import Extent, open_log

from ...lockstep.run_file import RUN_FILE, Source, read_run_file
from ...lockstep.summary import SUMMARY, read_summary
from ...report import REPORT, ComparedRun, Material, Side, Truth, comparison_of, truth_of, write_report
from ...report.artifacts import files_of
from ...report.long_run import write_long_logs
from ...report.material import side_name, side_names
from ...report.pack import EVENTS_MAX
from ...report.part_pages import write_overview
from ...standard_streams import as_file
from ..options import sensor_from, window_from
from .files import check_logs, open_from, run_extent
from .progress import Progress

__all__ = ["run"]

_PAGE = re.compile(r"part-[0-9]{5,}\.html")  # of a part of a long run


def run(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Write the page; 0."""
    if options.rule and not options.truth:
        raise ConfigError("--rule: must be given with --truth")
    given = [as_file(path) for path in options.run]
    folders, logs = [path for path in given if path.is_dir()], [path for path in given if not path.is_dir()]
    if len(folders) > 2 or (len(folders) == 2 and logs):
        raise ConfigError("RUN: must be one folder, one folder and logs, logs, or two folders to compare")
    if len(folders) == 2 and options.output is None:
        raise ConfigError("-o: must be given to say where the comparison of two runs is written")
    path = options.output or (given[0] / REPORT if folders and not logs else given[0].with_suffix(".html"))
    if folders and logs and options.output is None:
        raise ConfigError("-o: must be given with further logs: report.html of the folder is the run's own")
    force = options.force or is_own_file(path)  # in the folder of a run its own report is made anew
    options.claims.write("-o", path, force=force)
    parts = read_summary(folders[0] / SUMMARY) if folders and (folders[0] / SUMMARY).is_file() else {}
    if "parts" in parts:
        return _overview(options, parts, folders[0], path, force)
    with Progress(str(path), None, enabled=not (options.quiet or options.json)) as progress:
        progress.note("reading the events")
        if len(folders) == 2:
            material = _of_two_runs(options, *folders)
        elif folders:
            material = _of_run(options, folders[0], logs)
        else:
            command = shlex.join(["evcot", *arguments])
            recording, source, more = _begin(options, logs[0])
            if more:
                return _of_long_logs(options, logs, source, command, path, progress)
            material = _of_logs(options, logs, recording, source, command)
        if options.truth and material.truth is not None:
            for side in material.sides:
                warn_of_other_truth(evaluate(side.log, material.truth.objects, material.truth.rule), str(options.truth))
        progress.note("writing the page")
        write_report(material, path, force=force)
        remade(path)
    return _said(options, path, len(material.events))


def _overview(options: argparse.Namespace, summary: dict[str, Any], folder: Path, path: Path, force: bool) -> int:
    """The overview of a long run, whose parts have pages of their own; 0."""
    if len(options.run) > 1 or options.truth or path.resolve().parent != folder.resolve():
        rule = "must be given alone, without -o, logs or truth: its pages are beside its report"
        raise ConfigError(f"{folder}: is a run of more than {EVENTS_MAX} events: {rule}")
    if not all(isinstance(part, dict) and _PAGE.fullmatch(str(part.get("page"))) for part in summary["parts"]):
        raise ConfigError(f"{folder / SUMMARY}: parts: each must have a page with a name such as part-00000.html")
    write_overview(summary, path, force=force)
    remade(path)
    return _said(options, path, summary["events"])


def _said(options: argparse.Namespace, path: Path, events: int) -> int:
    """Say what was written; 0."""
    if options.json:
        print(json.dumps({"report": str(path), "bytes": path.stat().st_size, "events": events}, indent=2))
    elif not options.quiet:
        print(f"{path}: {path.stat().st_size / 1e6:.1f} MB, to open in a browser")
    return 0


def _of_run(options: argparse.Namespace, folder: Path, logs: Sequence[Path]) -> Material:
    """A run, and further logs of its recording beside its engines."""
    summary = read_summary(folder / SUMMARY)
    names = ("hardware", "model") if "mismatch" in summary else ("hardware", "software")
    paths = [folder / f"{name}.npz" for name in names]
    waves = {"hardware": str(folder)}
    sides = [Side(name, TrackLog.load(path), waves.get(name)) for name, path in zip(names, paths, strict=True)]
    recording, source = _recording(options) if options.recording is not None else _recording_of_run(folder)
    extent = run_extent(recording.events, [side.log for side in sides], summary)
    sides = _named(sides, logs)
    check_logs(zip([*paths, *logs], (side.log for side in sides), strict=True), source.recording, extent)
    beside = options.output is None or options.output.resolve().parent == folder.resolve()
    known = {name: value for name, value in summary.items() if name != "truth" or not options.truth}
    truth = _truth(options, source, recording)
    return Material(recording, known, tuple(sides), truth, files=files_of(folder) if beside else ())


def _truth(options: argparse.Namespace, source: Source, recording: Recording) -> Truth | None:
    """The truth that is given, else that of the recording."""
    if not options.truth:
        return truth_of(source, recording)
    sensor = sensor_from(options) or (recording.width, recording.height)
    truth = Truth.read(options.truth, sensor, options.rule)
    t_us = recording.events.t_us
    if not len(t_us) or not len(truth.within(int(t_us[0]), int(t_us[-1])).objects.instants_us):
        raise ConfigError(
            f"{options.truth}: has no instant within the time of {recording.name}: must be the truth of this recording"
        )
    return truth


def _of_two_runs(options: argparse.Namespace, *folders: Path) -> Material:
    """Two runs of the same events."""
    if all((folder / RUN_FILE).is_file() for folder in folders):
        first, second = (read_run_file(folder / RUN_FILE) for folder in folders)
        if first and second and first.digest and second.digest and first.digest != second.digest:
            made = f"{folders[0]} was made of {first.source.name}, {folders[1]} of {second.source.name}"
            raise ConfigError(f"{made}: both runs must be of the same events")
    recording, source = _recording(options) if options.recording is not None else _recording_of_run(folders[0])
    runs = []
    for folder in folders:
        summary = read_summary(folder / SUMMARY)
        path = folder / "hardware.npz"
        if "mismatch" in summary:
            raise ConfigError(f"{folder}: ended in a mismatch of hardware and model: must be a complete run")
        log = TrackLog.load(path)
        check_logs([(path, log)], source.recording, Extent.of([recording.events]))
        runs.append(ComparedRun(folder.name or str(folder), str(folder), summary, log))
    return comparison_of(recording, runs[0], runs[1], _truth(options, source, recording))


def _named(sides: list[Side], paths: Sequence[Path]) -> list[Side]:
    """The sides with those of further logs."""
    logs = [TrackLog.load(path) for path in paths]
    names = side_names([side.name for side in sides], [(log.engine, path.stem) for log, path in zip(logs, paths, strict=True)])
    return [*sides, *(Side(name, log) for name, log in zip(names, logs, strict=True))]


def _recording_of_run(folder: Path) -> tuple[Recording, Source]:
    described = read_run_file(folder / RUN_FILE) if (folder / RUN_FILE).is_file() else None
    if described is None:
        raise ConfigError(f"{folder}: does not say what it was made of ({RUN_FILE}): must be given with --recording FILE")
    recording = described.source.read()
    described.check(folder / RUN_FILE, recording.events)
    return recording, described.source


def _begin(options: argparse.Namespace, log: Path) -> tuple[Recording, Source, bool]:
    """The recording of logs, where it came from, and whether it is too long to be held in memory: then, its beginning."""
    if options.recording is None:
        raise ConfigError(f"{log}: a log does not hold the events: must be given with --recording FILE")
    width, height = sensor_from(options) or (0, 0)
    from_us, to_us = window_from(options)
    source = Source(
        str(options.recording), from_us=from_us, to_us=to_us, width=width, height=height,
        skip_damaged=options.skip_damaged, struct=options.struct or "",
    )  # fmt: skip
    recording, more = source.begin(EVENTS_MAX)
    return recording, source, more


def _of_logs(
    options: argparse.Namespace, paths: Sequence[Path], recording: Recording, source: Source, command: str
) -> Material:
    if len(paths) == 1:
        log = TrackLog.load(paths[0])
        sides = [Side(side_name(log.engine, paths[0].stem, "software"), log)]
    else:
        sides = _named([], paths)
    check_logs(zip(paths, (side.log for side in sides), strict=True), source.recording, Extent.of([recording.events]))
    summary = {"name": recording.name, "command": command, "versions": {"evcot": evcot.__version__}}
    return Material(recording, summary, tuple(sides), _truth(options, source, recording))


def _of_long_logs(
    options: argparse.Namespace, paths: Sequence[Path], source: Source, command: str, path: Path, progress: Progress
) -> int:
    """An overview, and beside it a folder with a page for each part; 0."""
    if options.truth:
        rule = "must be of at most so many for a page with scores; `evcot evaluate` reads logs of any length"
        raise ConfigError(f"{source.recording}: has more than {EVENTS_MAX} events: {rule}")
    logs = [open_log(log) for log in paths]
    if len(paths) == 1:
        names = [side_name(logs[0].engine, paths[0].stem, "software")]
    else:
        names = side_names([], [(log.engine, path.stem) for log, path in zip(logs, paths, strict=True)])
    summary = write_long_logs(
        dict(zip(names, logs, strict=True)), source, path, command,
        check=lambda extent: check_logs(zip(paths, logs, strict=True), source.recording, extent),
        claim=lambda folder, pages: options.claims.write_folder("-o", folder, "report", pages),
        force=options.force,
        progress=lambda events: progress.note(f"writing the pages: {events:,} events done"),
    )  # fmt: skip
    return _said(options, path, summary["events"])


def _recording(options: argparse.Namespace) -> tuple[Recording, Source]:
    with open_from(options, options.recording) as file:
        return file.read(*window_from(options)), Source(str(options.recording))

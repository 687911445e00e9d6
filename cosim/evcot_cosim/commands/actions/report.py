# SPDX-License-Identifier: Apache-2.0
"""`evcot report`: the page to explore a run with, made again or made of a software tracker's log."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Sequence
from dataclasses import replace

import evcot
from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.outputs import is_own_file, remade
from evcot.tracks.belongs import Extent
from evcot.tracks.log import TrackLog

from ...lockstep.run_file import RUN_FILE, Source, read_run_file
from ...lockstep.summary import SUMMARY, read_summary
from ...report import REPORT, Material, Side, Truth, truth_of, write_report
from ..options import sensor_from, window_from
from .belonging import check_logs, run_extent
from .opening import open_from
from .progress import Progress

__all__ = ["run"]

_SIDES = {"cot-rtl": "hardware", "cot-model": "model"}  # names of engines; any other is software


def run(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Write the page; 0."""
    if options.rule and not options.truth:
        raise ConfigError("--rule: must be given with --truth")
    path = options.output or (options.run / REPORT if options.run.is_dir() else options.run.with_suffix(".html"))
    force = options.force or is_own_file(path)  # in the folder of a run its own report is made anew
    options.claims.write("-o", path, force=force)
    with Progress(str(path), None, enabled=not (options.quiet or options.json)) as progress:
        progress.note("reading the events")
        material = _of_run(options) if options.run.is_dir() else _of_log(options, shlex.join(["evcot", *arguments]))
        if options.truth:
            sensor = sensor_from(options) or (material.recording.width, material.recording.height)
            material = replace(material, truth=Truth.read(options.truth, sensor, options.rule))
        progress.note("writing the page")
        write_report(material, path, force=force)
        remade(path)
    if options.json:
        print(json.dumps({"report": str(path), "bytes": path.stat().st_size, "events": len(material.events)}, indent=2))
    elif not options.quiet:
        print(f"{path}: {path.stat().st_size / 1e6:.1f} MB, to open in a browser")
    return 0


def _of_run(options: argparse.Namespace) -> Material:
    summary = read_summary(options.run / SUMMARY)
    names = ("hardware", "model") if "mismatch" in summary else ("hardware", "software")
    sides = tuple(Side(name, TrackLog.load_npz(options.run / f"{name}.npz")) for name in names)
    recording, source = _recording(options) if options.recording is not None else _recording_of_run(options)
    extent = run_extent(recording.events, [side.log for side in sides], summary)
    check_logs([(options.run / f"{side.name}.npz", side.log) for side in sides], source.recording, extent)
    return Material(recording, summary, sides, None if options.truth else truth_of(source, recording))


def _recording_of_run(options: argparse.Namespace) -> tuple[Recording, Source]:
    described = read_run_file(options.run / RUN_FILE) if (options.run / RUN_FILE).is_file() else None
    if described is None:
        raise ConfigError(f"{options.run}: does not say what it was made of ({RUN_FILE}): must be given with --recording FILE")
    recording = described.source.read()
    described.check(options.run / RUN_FILE, recording.events)
    return recording, described.source


def _of_log(options: argparse.Namespace, command: str) -> Material:
    if options.recording is None:
        raise ConfigError(f"{options.run}: a log does not hold the events: must be given with --recording FILE")
    log = TrackLog.load(options.run)
    recording, source = _recording(options)
    check_logs([(options.run, log)], source.recording, Extent.of([recording.events]))
    summary = {"name": recording.name, "command": command, "versions": {"evcot": evcot.__version__}}
    side = Side(_SIDES.get(log.engine, "software"), log)
    return Material(recording, summary, (side,), None if options.truth else truth_of(source, recording))


def _recording(options: argparse.Namespace) -> tuple[Recording, Source]:
    with open_from(options, options.recording) as file:
        return file.read(*window_from(options)), Source(str(options.recording))

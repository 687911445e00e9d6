# SPDX-License-Identifier: Apache-2.0
"""`evcot waves` and `evcot assert`: simulate a part of a run again, to look at its waveform and to check its properties."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from evcot.errors import ConfigError
from evcot.outputs import RUN_FILE, folder_written_aside

from ...lockstep.moments import Moment, find_moment
from ...lockstep.run_file import write_run_file
from ...tables import print_table
from ...waves.properties import PropertyVerdict, judge, load_properties
from ...waves.window import Window, wave_names, write_waves
from ..hardware import REACH, WAVES_MS
from ..options import window_from
from ..parsing import BROKEN
from .job import Job, job_from
from .spinner import Counting

__all__ = ["check", "run"]

_NAMES = (RUN_FILE, *wave_names())


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write a waveform and its view; 0."""

    def folder_of(name: str) -> Path:
        moment = "" if options.around is None else f"-{options.around.replace(':', '-')}"
        return options.output or Path("build") / "waves" / f"{name}{moment}"

    with _counting(options):
        job, window, moment = _what(options, lambda name: options.claims.write_folder("-o", folder_of(name), "waves", _NAMES))
    folder = folder_of(job.name)
    with _counting(options), folder_written_aside(folder, "waves") as aside:
        _write(job, window, moment, aside)
        write_run_file(aside / RUN_FILE, job.run_file)
    job.filters.save_learned()
    files = sorted(path.name for path in folder.glob("waves.*"))
    if options.json:
        print(json.dumps({"folder": str(folder), "files": files, "first_event": window.first, "last_event": window.last}))
    elif not options.quiet:
        print(f"events {window.first} to {window.last} in {folder}/; open with: cd {folder} && gtkwave waves.vcd waves.gtkw")
    return 0


def check(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Check properties and print the verdicts; `BROKEN` where one does not hold, else 0."""
    properties = load_properties(options.properties)
    given = _waveform(options)
    if given is not None:
        with _counting(options):
            verdicts = judge(properties, given, options.clock)
    else:
        with _counting(options), tempfile.TemporaryDirectory() as folder:
            job, window, moment = _what(options)
            verdicts = judge(properties, _write(job, window, moment, Path(folder)), options.clock)
        job.filters.save_learned()
    broken = sum(not verdict.holds for verdict in verdicts)
    if options.json:
        print(json.dumps([verdict._asdict() for verdict in verdicts], indent=2))
    elif not options.quiet:
        _report(verdicts)
    return BROKEN if broken else 0


def _counting(options: argparse.Namespace) -> Counting:
    return Counting("simulating (the hardware is compiled once)", enabled=not (options.quiet or options.json))


def _what(options: argparse.Namespace, claim: Callable[[str], None] | None = None) -> tuple[Job, Window, Moment | None]:
    """The job, the events of it that are shown, and the moment that they surround."""
    if options.around is not None:
        if options.from_ms is not None or options.to_ms is not None:
            raise ConfigError("--around: must not be given with --from and --to")
        reach = REACH if options.reach is None else options.reach
        if not 0 <= reach <= 1_000_000:
            raise ConfigError(f"--reach {reach}: must be from 0 to 1000000 events")
        job = job_from(options, claim=claim)
        recording = job.recording
        config = job.config.device_config(recording.width, recording.height)
        moment = find_moment(options.around, recording, config, job.folder)
        return job, Window.around(moment.event_index, len(recording.events), reach), moment
    if options.reach is not None:
        raise ConfigError("--reach: must be given with --around")
    from_us, to_us = window_from(options, WAVES_MS)
    assert to_us is not None
    job = job_from(options, until_us=to_us, claim=claim)
    return job, Window.of_time(job.recording.events, from_us, to_us), None


def _write(job: Job, window: Window, moment: Moment | None, folder: Path) -> Path:
    recording = job.recording
    config = job.config.device_config(recording.width, recording.height)
    vcd, _ = write_waves(recording.events, config, folder, window, stalls=job.stalls, moment=moment)
    return vcd


def _waveform(options: argparse.Namespace) -> Path | None:
    """The VCD that is there already: the input itself, or the one that a run has left where no window is asked for."""
    if options.recording is None:
        return None
    path = Path(options.recording)
    if path.suffix == ".vcd":
        return path
    whole = options.around is None and options.from_ms is None and options.to_ms is None
    left = next((path / name for name in ("mismatch.vcd", "waves.vcd") if (path / name).is_file()), None)
    return left if whole else None


def _report(verdicts: Sequence[PropertyVerdict]) -> None:
    print_table([("property", "cases", ""), *((v.name, f"{v.cases:,}", "holds" if v.holds else "BROKEN") for v in verdicts)])
    for verdict in verdicts:
        if not verdict.holds:
            print(f"\n{verdict.name}: {verdict.message}")

# SPDX-License-Identifier: Apache-2.0
"""`evcot waves` and `evcot assert`: a part of a run simulated again, to look at and to ask."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from evcot.errors import ConfigError
from evcot.outputs import RUN_FILE, folder_written_aside

from ..lockstep.moments import MOMENTS, Moment, find_moment
from ..lockstep.run_file import write_run_file
from ..tables import print_table
from ..waves.properties import Verdict, judge, load_properties
from ..waves.window import Window, wave_names, write_waves
from .counting import Counting
from .filter_options import save_learned
from .job import Job, input_options, job_from
from .options import window_from
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

BROKEN = 1  # exit code: a property does not hold
_WAVES_MS = 2.0  # length of a waveform, if not given
_NAMES = (RUN_FILE, *wave_names())
_REACH = 400  # events before and after a moment

_WAVES_EXAMPLES = """
evcot waves drive.aedat4 --from 120 --to 125     # 5 ms of a recording
evcot waves build/cosim/drive --around merge:3   # the third merge of a run of `evcot cosim`, with markers
evcot waves build/cosim/drive --around mismatch
evcot waves boxes --around loss --reach 50
"""
_ASSERT_EXAMPLES = """
evcot assert build/cosim/boxes properties.py     # the waveform that the run has left
evcot assert build/cosim/boxes properties.py --around birth:2 --reach 1000
evcot assert waves.vcd properties.py --clock TOP.clk
evcot assert boxes --to 20                       # that every stream holds what it offers, in 20 ms of a scene

properties.py holds functions whose names begin with property_; each takes the signals and asserts on them:

  from evcot_cosim.waves import *
  def property_a_cluster_waits_for_events(s):
      return always(s["TOP.m_cm_n_ev"] > 0, where=s["TOP.m_cm_valid"])

docs/waveforms.md tells what can be said.
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add both commands to the command line."""
    title = "write a waveform of a moment or a time window, and its GTKWave view"
    waves = add_command(commands, "waves", title, _WAVES_EXAMPLES)
    _window_options(waves)
    output_option(waves, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/waves/NAME)")
    waves.add_argument("--json", action="store_true", help="print what was written as JSON")
    waves.set_defaults(command=_waves)

    title = "check properties of a waveform that a Python file states"
    asserts = add_command(commands, "assert", title, _ASSERT_EXAMPLES)
    _window_options(asserts)
    asserts.add_argument(
        "properties", nargs="?", type=input_path, metavar="PROPERTIES", help="a Python file (default: streams hold)"
    )
    asserts.add_argument("--clock", default="TOP.clk", metavar="SIGNAL", help="sample on its rising edge (default: TOP.clk)")
    asserts.add_argument("--json", action="store_true", help="print every verdict as JSON")
    asserts.set_defaults(command=_assert)


def _window_options(parser: argparse.ArgumentParser) -> None:
    input_options(parser, runs=True)
    parser.add_argument("--from", dest="from_ms", type=float, metavar="MS", help="begin (default: 0)")
    parser.add_argument("--to", dest="to_ms", type=float, metavar="MS", help=f"end (default: {_WAVES_MS:g} ms on)")
    parser.add_argument("--around", metavar="MOMENT", help=f"the surroundings of {MOMENTS}")
    parser.add_argument("--reach", type=int, metavar="N", help=f"so many events before and after it (default: {_REACH})")


def _waves(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    def folder_of(name: str) -> Path:
        moment = "" if options.around is None else f"-{options.around.replace(':', '-')}"
        return options.output or Path("build") / "waves" / f"{name}{moment}"

    with _counting(options):
        job, window, moment = _what(options, lambda name: options.claims.write_folder("-o", folder_of(name), _NAMES))
    folder = folder_of(job.name)
    with _counting(options), folder_written_aside(folder) as aside:
        _write(job, window, moment, aside)
        write_run_file(aside / RUN_FILE, job.run_file)
    save_learned(options)
    files = sorted(path.name for path in folder.glob("waves.*"))
    if options.json:
        print(json.dumps({"folder": str(folder), "files": files, "first_event": window.first, "last_event": window.last}))
    elif not options.quiet:
        print(f"events {window.first} to {window.last} in {folder}/; open with: cd {folder} && gtkwave waves.vcd waves.gtkw")
    return 0


def _assert(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    properties = load_properties(options.properties)
    given = _waveform(options)
    if given is not None:
        with _counting(options):
            verdicts = judge(properties, given, options.clock)
    else:
        with _counting(options), tempfile.TemporaryDirectory() as folder:
            job, window, moment = _what(options)
            verdicts = judge(properties, _write(job, window, moment, Path(folder)), options.clock)
        save_learned(options)
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
        reach = _REACH if options.reach is None else options.reach
        if not 0 <= reach <= 1_000_000:
            raise ConfigError(f"--reach {reach}: must be from 0 to 1000000 events")
        job = job_from(options, claim=claim)
        recording = job.recording
        config = job.config.hardware(recording.width, recording.height)
        moment = find_moment(options.around, recording, config, job.top, job.folder)
        return job, Window.around(moment.event_index, len(recording.events), reach), moment
    if options.reach is not None:
        raise ConfigError("--reach: must be given with --around")
    options.from_ms = options.from_ms or 0.0
    options.to_ms = options.from_ms + _WAVES_MS if options.to_ms is None else options.to_ms
    from_us, to_us = window_from(options)
    assert to_us is not None
    job = job_from(options, until_us=to_us, claim=claim)
    return job, Window.of_time(job.recording.events, from_us, to_us), None


def _write(job: Job, window: Window, moment: Moment | None, folder: Path) -> Path:
    recording = job.recording
    config = job.config.hardware(recording.width, recording.height)
    vcd, _ = write_waves(recording.events, config, folder, window, top=job.top, stalls=job.stalls, moment=moment)
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


def _report(verdicts: Sequence[Verdict]) -> None:
    print_table([("property", "cases", ""), *((v.name, f"{v.cases:,}", "holds" if v.holds else "BROKEN") for v in verdicts)])
    for verdict in verdicts:
        if not verdict.holds:
            print(f"\n{verdict.name}: {verdict.message}")

# SPDX-License-Identifier: Apache-2.0
"""The command line. Exit codes: 0 done, 1 hardware and model differ, 2 something that the user can mend."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import evcot
from evcot.config import RunConfig, load_toml
from evcot.errors import ConfigError, EvcotError, RecordingWarning
from evcot.events import Recording
from evcot.files import read_recording
from evcot.presets import PRESETS, fit, for_sensor, preset
from evcot.scenes.boxes import BoxExperiment, simulate

from .artifacts import folder_written_aside, write_mismatch, write_run
from .commands import filter as filter_command
from .commands import recordings
from .commands import simulate as simulate_command
from .cosim import check_addresses, run_cosim, stalls_from
from .lockstep import MismatchError
from .progress import Progress
from .summary import table
from .waves import Window, write_waves

__all__ = ["main"]

MISMATCH, USER_ERROR = 1, 2

_EXAMPLES = """examples:
  evcot cosim                                   the box experiment, nothing to download
  evcot cosim drive.aedat4                      a camera file, with the preset for its sensor
  evcot cosim drive.aedat4 --preset slow --slots 16 --stalls 7
  evcot waves drive.aedat4 --from 120 --to 125  a waveform of 5 ms, to open in GTKWave
  evcot presets --json
  evcot info drive.aedat4                       sensor, length, rates, busiest pixels
  evcot convert drive.aedat4 drive.csv --to 500 its first half second, as text
"""


@dataclass(frozen=True)
class Job:
    """What a command that simulates works on."""

    recording: Recording
    config: RunConfig
    name: str


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code. An interrupt is the caller's to report."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(arguments)
    try:
        with _warnings_in_one_line():
            code: int = options.command(options, arguments)
        return code
    except MismatchError as error:
        print(f"evcot: MISMATCH: {error}", file=sys.stderr)
        return MISMATCH
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        return USER_ERROR
    except BrokenPipeError:
        return 0


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """What is left out of a recording is told as errors are."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", RecordingWarning)
        show = warnings.showwarning

        def show_in_one_line(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, RecordingWarning):
                print(f"evcot: warning: {message}", file=sys.stderr)
            else:
                show(message, category, *place, **more)

        warnings.showwarning = show_in_one_line
        yield


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="evcot",
        description="Event-camera object tracking: hardware, model and software in lock-step.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"evcot {evcot.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    cosim = commands.add_parser("cosim", help="run hardware, model and software tracker on a recording and compare them")
    _input_options(cosim)
    cosim.add_argument("-o", "--output", type=Path, metavar="DIR", help="where to write (default: build/cosim/NAME)")
    cosim.add_argument("--no-waves", action="store_true", help="write no waveform")
    cosim.add_argument("--json", action="store_true", help="print summary.json instead of the table")
    cosim.set_defaults(command=_cosim)

    waves = commands.add_parser("waves", help="write a waveform of a time window and its GTKWave view")
    _input_options(waves)
    waves.add_argument("--from", dest="from_ms", type=float, default=0.0, metavar="MS", help="begin (default: 0)")
    waves.add_argument("--to", dest="to_ms", type=float, default=2.0, metavar="MS", help="end (default: 2)")
    waves.add_argument("-o", "--output", type=Path, metavar="DIR", help="where to write (default: build/waves/NAME)")
    waves.set_defaults(command=_waves)

    presets = commands.add_parser("presets", help="list the presets")
    presets.add_argument("--json", action="store_true", help="print every field")
    presets.set_defaults(command=_presets)
    filter_command.add(commands)
    simulate_command.add(commands)
    recordings.add(commands)
    return parser


def _input_options(parser: argparse.ArgumentParser) -> None:
    formats = "AEDAT4, EVT2, EVT3, DAT, ES, CSV or npz (default: the box experiment)"
    parser.add_argument("recording", nargs="?", type=Path, metavar="FILE", help=formats)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the box experiment (default: 1)")
    parser.add_argument("--preset", metavar="NAME", help="see `evcot presets` (default: the one for the sensor)")
    parser.add_argument("--config", type=Path, metavar="TOML", help="overrides of the preset")
    parser.add_argument("--slots", type=int, metavar="N", help="tracker slots (default: the preset's)")
    parser.add_argument("--hardware", choices=("cot_array", "cot_chain", "cot"), default="cot_array", help="which module")
    parser.add_argument("--stalls", type=int, metavar="SEED", help="stall every stream of the hardware at random")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")


def _job(options: argparse.Namespace) -> Job:
    if options.recording is None:
        if options.seed < 0:
            raise ConfigError(f"--seed {options.seed}: must not be negative")
        recording, name = simulate(BoxExperiment(seed=options.seed)).recording, "boxes"
    else:
        recording, name = read_recording(options.recording), options.recording.stem
    base = preset(options.preset) if options.preset else for_sensor(recording.width)
    slots = 1 if options.hardware == "cot" and options.slots is None else options.slots
    config = fit(base, recording.width, recording.height, slots)
    if options.config is not None:
        config = load_toml(options.config, config)
    check_addresses(recording, config.cot)
    return Job(recording, config, name)


def _cosim(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    job = _job(options)
    folder = options.output or Path("build") / "cosim" / job.name
    command = shlex.join(["evcot", *arguments])
    with Progress(job.recording.name, len(job.recording.events), enabled=not (options.quiet or options.json)) as progress:
        try:
            run = run_cosim(
                job.recording, job.config, options.hardware,
                stall_seed=options.stalls, building=progress.building, progress=progress.update,
            )  # fmt: skip
        except MismatchError as error:
            write_mismatch(error, job.recording, job.config, folder, command=command)
            print(f"evcot: {folder}/ holds summary.json, and mismatch.vcd with its view mismatch.gtkw", file=sys.stderr)
            raise
        progress.note("writing logs, picture and waveform")
        summary = write_run(run, folder, command=command, waves=not options.no_waves)
    if options.json:
        print(json.dumps(summary, indent=2, allow_nan=False))
    elif not options.quiet:
        _print_table(table(summary))
        print(f"\n{folder}/ holds summary.json, picture.png, logs (.npz, .csv) and waves.vcd with its view waves.gtkw")
    return 0 if summary["exact"] else MISMATCH


def _waves(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    job = _job(options)
    window = Window.of_time(job.recording.events, round(options.from_ms * 1000), round(options.to_ms * 1000))
    folder = options.output or Path("build") / "waves" / job.name
    with folder_written_aside(folder) as aside:
        write_waves(
            job.recording.events, job.config.cot, aside, window, top=options.hardware, stalls=stalls_from(options.stalls)
        )
    if not options.quiet:
        print(f"events {window.first} to {window.last} in {folder}/; open with: cd {folder} && gtkwave waves.vcd waves.gtkw")
    return 0


def _presets(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    if options.json:
        print(json.dumps({name: asdict(config) for name, config in PRESETS.items()}, indent=2))
        return 0
    rows = [("name", "N_ev", "window px", "lifetime", "tick")]
    for name, config in PRESETS.items():
        slot = config.cot.slots[0]
        lifetime_ms = slot.max_ticks * config.cot.tick_us / 1000
        rows.append(
            (
                name,
                f"{slot.clust_nev} ({slot.nev_min} to {slot.nev_max})",
                f"{slot.init_radix} + {slot.radix_th}",
                f"{lifetime_ms:g} ms",
                f"{config.cot.tick_us} us",
            )
        )
    _print_table(rows)
    return 0


def _print_table(rows: Sequence[Sequence[Any]]) -> None:
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print("  ".join(str(cell).ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())

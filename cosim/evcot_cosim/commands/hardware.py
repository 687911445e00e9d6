# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim` and `evcot waves`: what simulates the hardware."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from evcot.config import RunConfig, load_toml
from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.presets import fit, for_sensor, preset
from evcot.scenes.registry import SCENES, simulate_scene

from ..artifacts import folder_written_aside, write_mismatch, write_run
from ..cosim import check_addresses, run_cosim, stalls_from
from ..lockstep import MismatchError
from ..progress import Progress
from ..summary import table
from ..waves import Window, write_waves
from .filter_options import filter_options, filters_from
from .options import damage_options, open_from, window_from, window_options
from .tables import print_table

__all__ = ["MISMATCH", "add"]

MISMATCH = 1  # exit code: hardware and model differ
_DEFAULT_SCENE = "boxes"
_WAVES_MS = 2.0  # length of a waveform, if not given


@dataclass(frozen=True)
class Job:
    """What a command that simulates works on."""

    recording: Recording
    config: RunConfig
    name: str


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add both commands to the command line."""
    cosim = commands.add_parser("cosim", help="run hardware, model and software tracker on a recording and compare them")
    _input_options(cosim)
    window_options(cosim)
    cosim.add_argument("-o", "--output", type=Path, metavar="DIR", help="where to write (default: build/cosim/NAME)")
    cosim.add_argument("--no-waves", action="store_true", help="write no waveform")
    cosim.add_argument("--json", action="store_true", help="print summary.json instead of the table")
    cosim.set_defaults(command=_cosim)

    waves = commands.add_parser("waves", help="write a waveform of a time window and its GTKWave view")
    _input_options(waves)
    waves.add_argument("--from", dest="from_ms", type=float, default=0.0, metavar="MS", help="begin (default: 0)")
    waves.add_argument("--to", dest="to_ms", type=float, metavar="MS", help="end (default: 2 ms after the beginning)")
    waves.add_argument("-o", "--output", type=Path, metavar="DIR", help="where to write (default: build/waves/NAME)")
    waves.set_defaults(command=_waves)


def _input_options(parser: argparse.ArgumentParser) -> None:
    source = f"a recording, or a scene: {', '.join(SCENES)} (default: {_DEFAULT_SCENE})"
    parser.add_argument("recording", nargs="?", default=_DEFAULT_SCENE, metavar="FILE", help=source)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of a scene (default: 1)")
    parser.add_argument("--preset", metavar="NAME", help="see `evcot presets` (default: the one for the sensor)")
    parser.add_argument("--config", type=Path, metavar="TOML", help="overrides of the preset")
    parser.add_argument("--slots", type=int, metavar="N", help="tracker slots (default: the preset's)")
    parser.add_argument(
        "--hardware", choices=("cot_array", "cot_engine", "cot_chain", "cot"), default="cot_array", help="which module"
    )
    parser.add_argument("--stalls", type=int, metavar="SEED", help="stall every stream of the hardware at random")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
    damage_options(parser)
    filter_options(parser)


def _job(options: argparse.Namespace, window: tuple[int, int | None]) -> Job:
    recording, name = _recording(options, window)
    sensor = recording.width, recording.height
    base = preset(options.preset) if options.preset else for_sensor(recording.width)
    slots = 1 if options.hardware == "cot" and options.slots is None else options.slots
    config = fit(base, *sensor, slots)
    if options.config is not None:
        config = load_toml(options.config, config)
    config = replace(config, filters=filters_from(options, config.filters, [recording.events], sensor))
    check_addresses(recording, config.cot)
    return Job(recording, config, name)


def _recording(options: argparse.Namespace, window: tuple[int, int | None]) -> tuple[Recording, str]:
    path = Path(options.recording)
    if options.recording in SCENES and not path.exists():
        if options.seed < 0:
            raise ConfigError(f"--seed {options.seed}: must not be negative")
        return simulate_scene(options.recording, options.seed).recording.window(*window), options.recording
    with open_from(options, path) as file:
        return file.read(*window), file.name


def _cosim(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    job = _job(options, window_from(options))
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
        print_table(table(summary))
        print(f"\n{folder}/ holds summary.json, picture.png, logs (.npz, .csv) and waves.vcd with its view waves.gtkw")
    return 0 if summary["exact"] else MISMATCH


def _waves(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    if options.to_ms is None:
        options.to_ms = options.from_ms + _WAVES_MS
    from_us, to_us = window_from(options)
    assert to_us is not None
    job = _job(options, (0, to_us))
    events, sensor = job.recording.events, (job.recording.width, job.recording.height)
    window = Window.of_time(events, from_us, to_us)
    folder = options.output or Path("build") / "waves" / job.name
    with folder_written_aside(folder) as aside:
        config, stalls = job.config.hardware(*sensor), stalls_from(options.stalls)
        write_waves(events, config, aside, window, top=options.hardware, stalls=stalls)
    if not options.quiet:
        print(f"events {window.first} to {window.last} in {folder}/; open with: cd {folder} && gtkwave waves.vcd waves.gtkw")
    return 0

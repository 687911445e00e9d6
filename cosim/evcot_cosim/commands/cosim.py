# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim`: hardware, model and software tracker on one recording, checked and compared."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from ..lockstep.cosim import run_cosim
from ..lockstep.lockstep import MismatchError
from ..lockstep.run_file import run_toml
from ..lockstep.summary import table
from ..report.artifacts import run_names, write_mismatch, write_run
from ..tables import print_table
from .filter_options import save_learned
from .job import input_options, job_from
from .options import window_from, window_options
from .parsing import add_command, output_option
from .progress import Progress

__all__ = ["MISMATCH", "add"]

MISMATCH = 1  # exit code: hardware and model differ

_EXAMPLES = """
evcot cosim                                    # the box experiment, nothing to download
evcot cosim drive.aedat4                       # a camera file, with the preset for its sensor
evcot cosim drive.aedat4 --preset slow --slots 16 --stalls 7
evcot cosim highway --activity 5               # filters, then hardware, model and software tracker, on a scene
evcot cosim drive.raw --print-config           # what repeats the run: save it as run.toml
evcot cosim --config run.toml
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "run hardware, model and software tracker on a recording and compare them"
    cosim = add_command(commands, "cosim", title, _EXAMPLES)
    input_options(cosim)
    window_options(cosim)
    output_option(cosim, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/cosim/NAME)")
    cosim.add_argument("--no-waves", action="store_true", help="write no waveform")
    cosim.add_argument("--print-config", action="store_true", help="print a run.toml that repeats the run, and run nothing")
    cosim.add_argument("--json", action="store_true", help="print summary.json instead of the table")
    cosim.set_defaults(command=_cosim)


def _cosim(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    def folder_of(name: str) -> Path:
        return options.output or Path("build") / "cosim" / name

    def claim(name: str) -> None:
        if not options.print_config:
            options.claims.write_folder("-o", folder_of(name), run_names())

    job = job_from(options, window_from(options), claim=claim)
    if options.print_config:
        print(run_toml(job.run_file), end="")
        return 0
    folder = folder_of(job.name)
    command = shlex.join(["evcot", *arguments])
    with Progress(job.recording.name, len(job.recording.events), enabled=not (options.quiet or options.json)) as progress:
        try:
            run = run_cosim(
                job.recording, job.config, job.top,
                stall_seed=job.seed, building=progress.building, progress=progress.update,
            )  # fmt: skip
        except MismatchError as error:
            write_mismatch(error, job.recording, job.run_file, folder, command=command)
            left = "report.html, summary.json, logs (.npz), and mismatch.vcd with its view mismatch.gtkw"
            print(f"evcot: {folder}/ holds {left}", file=sys.stderr)
            raise
        progress.note("writing logs, picture, report and waveform")
        summary = write_run(run, folder, job.run_file, command=command, waves=not options.no_waves)
    save_learned(options)
    if options.json:
        print(json.dumps(summary, indent=2, allow_nan=False))
    elif not options.quiet:
        print_table(table(summary))
        waves = "" if options.no_waves else ", and waves.vcd with its view waves.gtkw"
        left = f"report.html, summary.json, run.toml, picture.png, logs (.npz, .csv){waves}"
        print(f"\n{folder}/ holds {left}")
    return 0 if summary["exact"] else MISMATCH

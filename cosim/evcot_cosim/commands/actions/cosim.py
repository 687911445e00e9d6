# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim`: hardware, model and software tracker on one recording, checked and compared."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from ...lockstep.cosim import run_cosim
from ...lockstep.mismatch import MismatchError
from ...lockstep.run_file import run_toml
from ...lockstep.summary import table, verdict_lines
from ...lockstep.verdict import verdict_from
from ...report.artifacts import run_names, write_mismatch, write_run
from ...tables import print_table
from ..exit_codes import MISMATCH
from ..options import window_from
from .filters import save_learned
from .job import Job, job_from
from .progress import Progress

__all__ = ["run"]


def run(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Run the co-simulation and write what it leaves; `MISMATCH` where hardware and model differ, else 0."""

    def folder_of(name: str) -> Path:
        return options.output or Path("build") / "cosim" / name

    def claim(name: str) -> None:
        if not options.print_config:
            options.claims.write_folder("-o", folder_of(name), run_names())

    job = job_from(options, window_from(options), claim=claim, auto=True)
    if options.print_config:
        _say(job, quiet=options.quiet)
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
    _say(job, quiet=options.quiet)
    if options.json:
        print(json.dumps(summary, indent=2, allow_nan=False))
    elif not options.quiet:
        print_table(table(summary))
        print("\n" + "\n".join(verdict_lines(verdict_from(summary["verdict"]))))
        waves = "" if options.no_waves else ", and waves.vcd with its view waves.gtkw"
        left = f"report.html, summary.json, run.toml, picture.png, logs (.npz, .csv){waves}"
        print(f"\n{folder}/ holds {left}")
    return 0 if summary["exact"] else MISMATCH


def _say(job: Job, *, quiet: bool) -> None:
    """Print what was seen in the recording and chosen by it, a line on stderr."""
    if job.said is not None and not quiet:
        print(job.said, file=sys.stderr)

# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim`: hardware, model and software tracker on one recording, checked and compared."""

from __future__ import annotations

import argparse
import json
import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError
from evcot.outputs import check_folder
from evcot.recognition.weights import Weights
from evcot.unfinished import unfinished

from ...lockstep.cosim import run_cosim, run_long
from ...lockstep.mismatch import MismatchError
from ...lockstep.run_file import run_toml
from ...lockstep.summary import table, verdict_lines
from ...lockstep.verdict import verdict_from
from ...report.artifacts import run_names, write_mismatch, write_run
from ...report.long_run import long_names, write_long_run
from ...report.pack import EVENTS_MAX
from ...rtl.files import design_fingerprint
from ...tables import print_table
from ..options import window_from
from ..parsing import MISMATCH
from .files import say_resumed, weights_from, work_key
from .job import Job, job_from
from .progress import Progress, counted_ahead

__all__ = ["run"]


def run(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Run the co-simulation and write what it leaves; `MISMATCH` where hardware and model differ, else 0."""

    def folder_of(name: str) -> Path:
        return options.output or Path("build") / "cosim" / name

    def claim(name: str) -> None:
        if not options.print_config:
            options.claims.write_folder("-o", folder_of(name), "cosim", run_names())

    if options.checkpoint < 0:
        raise ConfigError(f"--checkpoint {options.checkpoint}: must not be negative")
    most = None if options.print_config else EVENTS_MAX
    job = job_from(options, window_from(options), claim=claim, most=most)
    if options.print_config:
        print(run_toml(job.run_file), end="")
        return 0
    weights = weights_from(options)
    folder = folder_of(job.name)
    command = shlex.join(["evcot", *arguments])
    if job.more:
        return _report(options, job, folder, _run_long(options, job, weights, folder, command), _LONG)
    with Progress(job.recording.name, len(job.recording.events), enabled=not (options.quiet or options.json)) as progress:
        try:
            run = run_cosim(
                job.recording, job.config,
                stall_seed=job.seed, source=job.source, weights=weights,
                building=progress.building, progress=progress.update,
            )  # fmt: skip
        except MismatchError as error:
            write_mismatch(error, job.recording, job.run_file, folder, command=command)
            left = "report.html, summary.json, logs (.npz), and mismatch.vcd with its view mismatch.gtkw"
            print(f"evcot: {folder}/ holds {left}", file=sys.stderr)
            raise
        progress.note("writing logs, picture, report and waveform")
        summary = write_run(run, folder, job.run_file, command=command, waves=not options.no_waves)
    return _report(options, job, folder, summary, "picture.png, logs (.npz, .csv)")


_LONG = "a page for each part, logs"


def _run_long(options: argparse.Namespace, job: Job, weights: Weights | None, folder: Path, command: str) -> dict[str, Any]:
    """The same of a recording that is not held in memory; returns the summary."""
    check_folder(folder, "cosim", long_names(folder), "-o")

    def key() -> str:
        classes = weights and weights.checksum
        return work_key(job.source.path, "cosim", job.source, job.config, job.seed, design_fingerprint(), classes)

    quiet = options.quiet or options.json
    with (
        unfinished(folder, key) as work,
        Progress(job.recording.name, None, enabled=not quiet) as progress,
        counted_ahead(progress, job.source.opened, (job.source.from_us, job.source.to_us)),
    ):
        run = run_long(
            job.source, job.config, work,
            stall_seed=job.seed, every=options.checkpoint, weights=weights,
            building=progress.building, progress=progress.update,
            resumed=None if options.quiet else lambda events: say_resumed(job.recording.name, events),
        )  # fmt: skip
        progress.note("writing logs, report and waveform")
        return write_long_run(
            run, job.source, folder, job.run_file_of(run.digest), job.recording,
            scratch=work.folder, command=command, waves=not options.no_waves,
        )  # fmt: skip


def _report(options: argparse.Namespace, job: Job, folder: Path, summary: dict[str, Any], what: str) -> int:
    """Say what was found and written; the exit code."""
    job.filters.save_learned()
    if options.json:
        print(json.dumps(summary, indent=2, allow_nan=False))
    elif not options.quiet:
        print_table(table(summary))
        columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
        print("\n" + "\n".join(verdict_lines(verdict_from(summary["verdict"]), columns)))
        if job.source.truth_file is not None and not job.more:
            print(f"\n{job.source.truth_file} is the truth: report.html has the scores")
        waves = ", and waves.vcd with its view waves.gtkw" if (folder / "waves.vcd").exists() else ""
        print(f"\n{folder}/ holds report.html, summary.json, run.toml, {what}{waves}")
    return 0 if summary["exact"] else MISMATCH

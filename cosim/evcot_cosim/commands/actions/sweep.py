# SPDX-License-Identifier: Apache-2.0
"""`evcot sweep`: many runs over recordings, engines, settings and seeds."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError

from ...sweep.execute import MISMATCH as DIFFERS
from ...sweep.finish import finish, leaders
from ...sweep.folder import JUNIT, REPORT, folder_names
from ...sweep.plan import Plan, Planner, points_of
from ...sweep.playback import repeat
from ...sweep.pool import cores
from ...sweep.run import Swept, run_sweep
from ...sweep.spec import Spec, read_spec
from ...tables import counted as count
from ...tables import print_table
from ..parsing import MISMATCH
from .progress import Progress

__all__ = ["run", "swept"]

_LISTED = 5  # of failures, and of the best


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Do a sweep, or one of its runs; `MISMATCH` where hardware and model, or a run and its row, differ."""
    if options.only is not None:
        return _only(options)
    if Path(options.spec).is_dir():
        raise ConfigError(f"{options.spec}: is a folder: must be a specification; or --only KEY of the sweep in the folder")
    spec = read_spec(options.spec)
    folder = options.output or Path("build") / "sweep" / spec.name
    if options.dry_run:
        return _dry_run(options, spec)
    options.claims.write_folder("-o", folder, "sweep", folder_names())
    found = swept(options, spec, folder)
    summary = finish(spec, found)
    if options.json:
        print(json.dumps(summary, indent=2, allow_nan=False))
    elif not options.quiet:
        _print(spec, found, summary)
    return MISMATCH if found.counts.get(DIFFERS) else 0


def swept(options: argparse.Namespace, spec: Spec, folder: Path) -> Swept:
    """Do the runs, showing how far they are."""
    jobs = jobs_from(options)
    with Progress(spec.name, None, enabled=not (options.quiet or options.json)) as progress:

        def told(done: int, runs: int, word: str) -> None:
            progress.measured(runs)
            progress.advance(done, f"{done:,} of {runs:,} runs {word[:60]}")

        return run_sweep(
            spec, folder, jobs=jobs, scheduler=options.scheduler, scheduler_file=options.scheduler_file,
            again=getattr(options, "retry", False), progress=told,
        )  # fmt: skip


def jobs_from(options: argparse.Namespace) -> int:
    """The number of processes.

    Raises:
        ConfigError: none, or a scheduler and something else.
    """
    if options.scheduler is not None and options.scheduler_file is not None:
        raise ConfigError("--scheduler-file: must not be given with --scheduler")
    if options.jobs is None:
        return cores()
    if options.scheduler is not None or options.scheduler_file is not None:
        raise ConfigError("--jobs: must not be given with a scheduler, which has its workers")
    if options.jobs < 1:
        raise ConfigError(f"--jobs {options.jobs}: must be at least 1")
    jobs: int = options.jobs
    return jobs


def _dry_run(options: argparse.Namespace, spec: Spec) -> int:
    planner = Planner(spec)
    if spec.method == "optuna" and spec.fuzz is None:
        plan = Plan()
    else:
        plan = planner.plan(points_of(spec)) if spec.fuzz is None else planner.fuzz()
    told: dict[str, Any] = {
        "name": spec.name, "inputs": len(planner.inputs), "runs": len(plan.tasks), "invalid": len(plan.invalid),
        "designs": plan.designs,
    }  # fmt: skip
    if spec.method == "optuna":
        told |= {"runs": spec.samples * len(spec.engines) * len(planner.inputs), "invalid": None, "designs": None}
    if options.json:
        print(json.dumps(told, indent=2))
    else:
        print_table(
            [
                (key, value if isinstance(value, str) else "unknown" if value is None else f"{value:,}")
                for key, value in told.items()
            ]
        )
    return 0


def _only(options: argparse.Namespace) -> int:
    result = repeat(Path(options.spec), options.only)
    if options.json:
        print(json.dumps({"row": result.row, "differences": [asdict(each) for each in result.differences]}, indent=2))
    else:
        print_table([(key, value) for key, value in result.shown])
        for each in result.differences:
            print(f"evcot: {each.name} = {each.now!r}: stored is {each.stored!r}", file=sys.stderr)
        if not result.differences and not options.quiet:
            print("as stored" if result.stored else "not stored before")
    return MISMATCH if result.differences or result.row["status"] == DIFFERS else 0


def _suite(name: str, own: Mapping[str, int], columns: Sequence[str]) -> tuple[str, ...]:
    return name, *(f"{own[column]:,}" for column in columns)


def _print(spec: Spec, found: Swept, summary: dict[str, Any]) -> None:
    states = ", ".join(f"{number:,} {status}" for status, number in sorted(found.counts.items()))
    print(f"{count(found.runs, 'run')}: {states}; {found.new:,} now")
    for fault in summary["faults"][:_LISTED]:
        print(f"evcot: {fault['key']}: {fault['status']}: {fault['error']}", file=sys.stderr)
    for test in summary["tests"]:
        print(f"evcot: {found.folder}/{test}: fails, with as few events as were found", file=sys.stderr)
    if len(summary["faults"]) > _LISTED:
        print(f"evcot: and {len(summary['faults']) - _LISTED:,} more: docs/sweeps.md has the query", file=sys.stderr)
    if summary["modules"]:
        columns = ("shapes", "runs", "exact", "mismatches", "events", "records")
        print()
        print_table([("module", *columns), *(_suite(name, own, columns) for name, own in summary["modules"].items())])
    if summary["best"]:
        print()
        print_table(leaders(spec, summary["best"][:_LISTED]))
    for engine, left_out in summary["left_out"].items():
        print(f"\n{engine}: every family with what was best on all others")
        rows = [("family", "objective", "on the others", "best on it", "chosen")]
        rows += [
            (each["family"], f"{each['score']:.3f}", f"{each['others']:.3f}", f"{each['best_score']:.3f}", each["chosen"])
            for each in left_out
        ]
        print_table(rows)
    more = f", {JUNIT}" if spec.fuzz is not None else ""
    print(f"\n{found.folder}/ holds {REPORT}, sweep.toml, runs/*.parquet{more}")

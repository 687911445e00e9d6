# SPDX-License-Identifier: Apache-2.0
"""`evcot sweep`: many runs over recordings, engines, settings and seeds."""

from __future__ import annotations

import argparse

from .parsing import add_command, input_or_name, input_path, output_option

__all__ = ["add", "scheduler_options", "start_workers"]

_EXAMPLES = """
evcot sweep sweep.toml                                   # on all cores; called again, it continues where it stopped
evcot sweep sweep.toml --scheduler tcp://10.0.0.1:8786   # on a Dask cluster
evcot sweep fuzz --dry-run                               # comes with evcot: the RTL against the model, seed by seed
evcot sweep build/sweep/traffic --only 3f1c0a9be2d84f67  # repeat one run of a sweep and compare it with what is stored
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "run many settings over recordings, engines and seeds, and store the results"
    parser = add_command(commands, "sweep", title, _EXAMPLES, ahead=start_workers)
    parser.add_argument(
        "spec",
        type=input_or_name,
        metavar="SPEC",
        help="a TOML file (docs/sweeps.md), or one that comes with evcot: fuzz, leave_one_family_out",
    )
    output_option(parser, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/sweep/NAME)")
    scheduler_options(parser)
    parser.add_argument("--retry", action="store_true", help="repeat runs that failed before")
    parser.add_argument("--only", metavar="KEY", help="repeat only this run of the sweep in folder SPEC, and compare")
    parser.add_argument("--dry-run", action="store_true", help="print the number of runs, and run nothing")
    parser.add_argument("--json", action="store_true", help="print what was done as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")


def start_workers(options: argparse.Namespace) -> None:
    """Have the imports of workers begin, if there will be some here, while this process imports its own."""
    if any(getattr(options, name, None) for name in ("scheduler", "scheduler_file", "only", "dry_run")):
        return
    from ..sweep.starting import begin_starting  # here, as other commands need nothing of it

    begin_starting()


def scheduler_options(parser: argparse.ArgumentParser) -> None:
    """Add --jobs, --scheduler and --scheduler-file."""
    parser.add_argument("--jobs", type=int, metavar="N", help="processes on this machine (default: one per core)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="address of a running Dask cluster, as tcp://HOST:8786")
    parser.add_argument(
        "--scheduler-file", type=input_path, metavar="FILE", help="the same, from the file that `dask scheduler` writes"
    )

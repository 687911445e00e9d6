# SPDX-License-Identifier: Apache-2.0
"""Commands of many runs: `evcot sweep` and `evcot tune`."""

from __future__ import annotations

import argparse

from evcot.metrics import RULES
from evcot.trackers.engines import ENGINES

from .parsing import add_command, input_or_name, input_path, json_or_quiet, output_option

__all__ = ["add_sweep", "add_tune"]


_SWEEP_EXAMPLES = """
evcot sweep sweep.toml                                   # on all cores; called again, it continues where it stopped
evcot sweep sweep.toml --scheduler tcp://10.0.0.1:8786   # on a Dask cluster
evcot sweep fuzz --dry-run                               # comes with evcot: the RTL against the model, seed by seed
evcot sweep build/sweep/traffic --only 3f1c0a9be2d84f67  # repeat one run of a sweep and compare it with what is stored
"""


def add_sweep(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "run many settings over recordings, engines and seeds, and store the results"
    parser = add_command(commands, "sweep", title, _SWEEP_EXAMPLES, ahead=start_workers)
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
    json_or_quiet(parser, "print what was done as JSON", "no progress, no table")


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


_TUNE_EXAMPLES = """
evcot tune a.aedat4 b.aedat4 c.aedat4 --engine rct --preset traffic -o mine.toml     # truth: a.truth.csv or a_gt.csv beside a
evcot tune drive.aedat4 --truth drive.csv --engine frames -o mine.toml     # chosen on its first part, validated on the rest
evcot tune a.raw b.raw --engine cot --field cot.init_radix=6..20 --field shape.n_slots=4,8 -o mine.toml
evcot track d.aedat4 --engine rct --config mine.toml -o log.npz                      # use the result
"""


def add_tune(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "tune", "choose settings on some recordings, validate them on others", _TUNE_EXAMPLES, ahead=start_workers
    )
    parser.add_argument("recordings", type=input_path, nargs="+", metavar="FILE", help="recordings with a known truth")
    parser.add_argument(
        "--truth", type=input_path, action="append", default=[], metavar="TRUTH",
        help="ground truth of a recording; repeat it for each, in their order "
        "(default: NAME.truth.csv or NAME_gt.csv beside each)",
    )  # fmt: skip
    known = ", ".join(RULES)
    parser.add_argument(
        "--rule",
        type=input_or_name,
        metavar="RULE",
        help=f"how to read and score the truths: {known}, or a .toml file (default: by their columns)",
    )
    engines = [*ENGINES, "rtl"]
    parser.add_argument(
        "--engine", choices=engines, default="rct", metavar="NAME", help=f"one of {', '.join(engines)} (default: rct)"
    )
    parser.add_argument(
        "--preset", metavar="NAME", help="preset to start from (default: the engine's first, or the one for the sensor)"
    )
    parser.add_argument("--config", type=input_path, metavar="TOML", help="a file that overrides the preset")
    parser.add_argument(
        "--field", action="append", default=[], metavar="NAME=LOW..HIGH",
        help="a field to tune, such as rct.radius_px=6..20 or shape.n_slots=4,8; may be repeated (default: every number of the "
        "engine, from half to twice the preset's)",
    )  # fmt: skip
    parser.add_argument(
        "--method", choices=("random", "latin", "optuna"), default="random", help="how settings are chosen (default: random)"
    )
    parser.add_argument("--samples", type=int, default=60, metavar="N", help="number of settings to try (default: 60)")
    parser.add_argument(
        "--seed",
        type=int,
        default=1,
        metavar="N",
        help="seed of the settings tried and of the division of recordings (default: 1)",
    )
    parser.add_argument(
        "--objective",
        default="hota",
        metavar="METRIC",
        help="what to maximise: hota, idf1 or another score; idsw:min to minimise one (default: hota)",
    )
    parser.add_argument(
        "--validate",
        type=float,
        default=0.34,
        metavar="SHARE",
        help="share kept for validation: of the recordings, or of the time of a single one (default: 0.34)",
    )
    output_option(
        parser,
        "-o",
        "--output",
        suffixes=(".toml",),
        required=True,
        metavar="TOML",
        help="write the chosen settings, for --config",
    )
    json_or_quiet(parser, "print what was found as JSON", "no progress, no table")
    scheduler_options(parser)

# SPDX-License-Identifier: Apache-2.0
"""`evcot tune`: settings chosen on some recordings and validated on others."""

from __future__ import annotations

import argparse

from evcot.metrics import RULES
from evcot.trackers.engines import ENGINES

from .parsing import add_command, input_or_name, input_path, output_option
from .sweep import scheduler_options, start_workers

__all__ = ["add"]

_EXAMPLES = """
evcot tune a.aedat4 b.aedat4 c.aedat4 --engine rct --preset traffic -o mine.toml     # truth: a.truth.csv or a_gt.csv beside a
evcot tune drive.aedat4 --truth drive.csv --engine frames -o mine.toml     # chosen on its first part, validated on the rest
evcot tune a.raw b.raw --engine cot --field cot.init_radix=6..20 --field shape.n_slots=4,8 -o mine.toml
evcot track d.aedat4 --engine rct --config mine.toml -o log.npz                      # use the result
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "tune", "choose settings on some recordings, validate them on others", _EXAMPLES, ahead=start_workers
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
    parser.add_argument("--json", action="store_true", help="print what was found as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
    scheduler_options(parser)

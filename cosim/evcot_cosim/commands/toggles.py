# SPDX-License-Identifier: Apache-2.0
"""`evcot toggles`: how often the hardware's bits change, for an estimate of its power."""

from __future__ import annotations

import argparse

from evcot.hardware.modules import MODULES

from .job import input_options
from .parsing import add_command, output_option

__all__ = ["TOGGLES_MS", "add"]

TOGGLES_MS = 20.0  # length of what is simulated, if not given

_EXAMPLES = """
evcot toggles boxes --from 100                            # toggles per event, for each module of the array
evcot toggles boxes --from 100 --beside cot_chain         # and of the chain, on the same events
evcot toggles drive.aedat4 --from 500 --saif array.saif   # for a vendor's tool
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "count toggles by module, as a table and as SAIF, to estimate power"
    parser = add_command(commands, "toggles", title, _EXAMPLES)
    input_options(parser)
    parser.add_argument("--from", dest="from_ms", type=float, metavar="MS", help="begin this long after the first event")
    parser.add_argument(
        "--to",
        dest="to_ms",
        type=float,
        metavar="MS",
        help=f"end (default: {TOGGLES_MS:g} ms after --from)",
    )
    parser.add_argument("--beside", choices=MODULES, help="another RTL module on the same events, in the same table")
    output_option(
        parser, "--saif", suffixes=(".saif",), metavar="FILE", help="write the toggles of every net of --hardware in SAIF"
    )
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")

# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim`: hardware, model and software tracker on one recording, checked and compared."""

from __future__ import annotations

import argparse

from .options import checkpoint_option, input_options, window_options
from .parsing import add_command, output_option

__all__ = ["add"]


_EXAMPLES = """
evcot cosim                                    # the box experiment, nothing to download
evcot cosim drive.aedat4                       # a camera file; settings are chosen from what the recording shows
evcot cosim drive.aedat4 --preset slow --slots 16 --stalls 7
evcot cosim highway --activity 5               # filters, then hardware, model and software tracker, on a scene
evcot cosim drive.raw --print-config           # a file that repeats the run: save it as run.toml
evcot cosim --config run.toml
"""


_TERMS = """words in the output:
  record      a line of a track log: a track was born, has moved, has merged into another, or was lost
  owner       the tracker slot that took an event
  CM          a cluster's centre, updated after every N_ev of its events
  TC          the time since a cluster's last event
  isolated    an event without another one on the eight pixels around it in the 10 ms before
  short       a track that ended within 0.2 s, where it began
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "run hardware, model and software tracker on a recording and compare them"
    cosim = add_command(commands, "cosim", title, _EXAMPLES)
    cosim.epilog = _TERMS
    input_options(cosim)
    window_options(cosim)
    output_option(cosim, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/cosim/NAME)")
    checkpoint_option(cosim)
    cosim.add_argument("--no-waves", action="store_true", help="write no waveform")
    cosim.add_argument("--print-config", action="store_true", help="print a run.toml that repeats the run, and run nothing")
    cosim.add_argument("--json", action="store_true", help="print summary.json instead of the table")

# SPDX-License-Identifier: Apache-2.0
"""`evcot waves` and `evcot assert`: simulate a part of a run again, to look at its waveform and to check its properties."""

from __future__ import annotations

import argparse

from ..names import MOMENTS
from .job import input_options
from .parsing import add_command, input_path, output_option

__all__ = ["REACH", "WAVES_MS", "add"]

WAVES_MS = 2.0  # length of a waveform, if not given
REACH = 400  # events before and after a moment

_WAVES_EXAMPLES = """
evcot waves drive.aedat4 --from 120 --to 125     # 5 ms of a recording
evcot waves build/cosim/drive --around merge:3   # the third merge of a run of `evcot cosim`, with markers
evcot waves build/cosim/drive --around mismatch
evcot waves boxes --around loss --reach 50
"""
_ASSERT_EXAMPLES = """
evcot assert build/cosim/boxes properties.py     # the waveform that the run wrote
evcot assert build/cosim/boxes properties.py --around birth:2 --reach 1000
evcot assert waves.vcd properties.py --clock TOP.clk
evcot assert boxes --to 20                       # does every stream hold its data until it is taken? 20 ms of a scene

properties.py holds functions whose names begin with property_; each takes the signals and asserts on them:

  from evcot_cosim.waves import *
  def property_a_cluster_waits_for_events(s):
      return always(s["TOP.m_cm_n_ev"] > 0, where=s["TOP.m_cm_valid"])

docs/waveforms.md describes what can be stated.
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add both commands to the command line."""
    title = "write a waveform of a moment or a time window, and its GTKWave view"
    waves = add_command(commands, "waves", title, _WAVES_EXAMPLES)
    _window_options(waves)
    output_option(waves, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/waves/NAME)")
    waves.add_argument("--json", action="store_true", help="print what was written as JSON")

    title = "check properties of a waveform, stated in a Python file"
    asserts = add_command(commands, "assert", title, _ASSERT_EXAMPLES, "waves:check")
    _window_options(asserts)
    asserts.add_argument(
        "properties",
        nargs="?",
        type=input_path,
        metavar="PROPERTIES",
        help="a Python file (default: every stream must hold its data until it is taken)",
    )
    asserts.add_argument("--clock", default="TOP.clk", metavar="SIGNAL", help="sample on its rising edge (default: TOP.clk)")
    asserts.add_argument("--json", action="store_true", help="print every verdict as JSON")


def _window_options(parser: argparse.ArgumentParser) -> None:
    input_options(parser, runs=True)
    parser.add_argument("--from", dest="from_ms", type=float, metavar="MS", help="begin this long after the first event")
    parser.add_argument(
        "--to",
        dest="to_ms",
        type=float,
        metavar="MS",
        help=f"end (default: {WAVES_MS:g} ms after --from)",
    )
    parser.add_argument("--around", metavar="MOMENT", help=f"show the surroundings of {MOMENTS}")
    parser.add_argument("--reach", type=int, metavar="N", help=f"number of events before and after it (default: {REACH})")

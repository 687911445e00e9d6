# SPDX-License-Identifier: Apache-2.0
"""Commands about the hardware alone: `evcot bench`, `board`, `vectors`, `toggles`, `waves` and `assert`."""

from __future__ import annotations

import argparse

from evcot.hardware.modules import MODULES

from ..fpga import RECORDS
from ..lockstep import MOMENTS
from .options import input_options, window_options
from .parsing import add_command, input_path, output_option

__all__ = ["REACH", "TOGGLES_MS", "WAVES_MS", "add_bench", "add_board", "add_toggles", "add_vectors", "add_waves"]


_BENCH_EXAMPLES = """
evcot bench                                      # the box experiment
evcot bench drive.aedat4 --to 2000 --json
"""


def add_bench(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "bench", "measure how fast reading, filters, trackers and hardware run here", _BENCH_EXAMPLES
    )
    input_options(parser)
    window_options(parser)
    parser.add_argument("--json", action="store_true", help="print the figures as JSON instead of a table")


_BOARD_EXAMPLES = """
evcot board /dev/ttyUSB1                         # its build and counters, and 256 records against the golden model
evcot board /dev/ttyUSB1 --records 10000 --json
"""


def add_board(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    board = add_command(
        commands, "board", "compare a board's records with the golden model, over its serial line", _BOARD_EXAMPLES
    )
    board.add_argument("port", metavar="PORT", help="the line's device, such as /dev/ttyUSB1, or a URL of pyserial")
    board.add_argument("--records", type=int, default=RECORDS, metavar="N", help=f"records to compare (default: {RECORDS})")
    board.add_argument("--json", action="store_true", help="print one JSON object")


_VECTORS_EXAMPLES = """
evcot vectors drive.aedat4 --to 50               # the first 50 ms of a recording, default hardware
evcot vectors boxes --slots 4 --to 100           # a scene, four slots
evcot vectors drive.aedat4 --hardware cot_array --refractory 1
evcot vectors build/cosim/drive --to 50          # events and configuration of a run of `evcot cosim`

docs/vectors.md describes the files, and how a bench plays them.
"""


def add_vectors(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "write test vectors of evcot_top as hex files, expected beats included, and a Verilog bench that checks them"
    parser = add_command(commands, "vectors", title, _VECTORS_EXAMPLES)
    input_options(parser, runs=True, stalls=False)
    window_options(parser)
    output_option(parser, "-o", "--output", folder=True, metavar="DIR", help="where to write (default: build/vectors/NAME)")
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")


TOGGLES_MS = 20.0  # length of what is simulated, if not given

_TOGGLES_EXAMPLES = """
evcot toggles boxes --from 100                            # toggles per event, for each module of the array
evcot toggles boxes --from 100 --beside cot_chain         # and of the chain, on the same events
evcot toggles drive.aedat4 --from 500 --saif array.saif   # for a vendor's tool
"""


def add_toggles(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "count toggles by module, as a table and as SAIF, to estimate power"
    parser = add_command(commands, "toggles", title, _TOGGLES_EXAMPLES)
    input_options(parser)
    _moment_options(parser, TOGGLES_MS)
    parser.add_argument("--beside", choices=MODULES, help="another RTL module on the same events, in the same table")
    output_option(
        parser, "--saif", suffixes=(".saif",), metavar="FILE", help="write the toggles of every net of --hardware in SAIF"
    )
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


WAVES_MS = 2.0  # length of a waveform, if not given
REACH = 400  # events before and after a moment

_WAVES_EXAMPLES = """
evcot waves drive.aedat4 --from 120 --to 125     # 5 ms of a recording
evcot waves build/cosim/drive --around merge:3   # the merge of track 3 in a run of `evcot cosim`, with markers
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


def add_waves(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
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


def _moment_options(parser: argparse.ArgumentParser, length_ms: float) -> None:
    """Add --from and --to of a part that has a length if none is given."""
    parser.add_argument("--from", dest="from_ms", type=float, metavar="MS", help="begin this long after the first event")
    parser.add_argument("--to", dest="to_ms", type=float, metavar="MS", help=f"end (default: {length_ms:g} ms after --from)")


def _window_options(parser: argparse.ArgumentParser) -> None:
    input_options(parser, runs=True)
    _moment_options(parser, WAVES_MS)
    parser.add_argument("--around", metavar="MOMENT", help=f"show the surroundings of {MOMENTS}")
    parser.add_argument("--reach", type=int, metavar="N", help=f"number of events before and after it (default: {REACH})")

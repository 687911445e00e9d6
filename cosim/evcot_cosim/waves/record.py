# SPDX-License-Identifier: Apache-2.0
"""Recording a waveform while a simulation is driven by hand."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pyverilator import PyVerilator

__all__ = ["recorded"]


@contextmanager
def recorded(sim: PyVerilator, path: Path) -> Iterator[Path]:
    """While the block runs, every write to a port of `sim` goes into a VCD, which appears under its name at the end.

    pyverilator by itself dumps at clock edges only, so that an input seems to change together with the edge that it was
    set up for. Here an input shows its new value before that edge, as a flip-flop sees it.
    """
    aside = path.with_name(f".{path.name}.{os.getpid()}.partial")
    sim.start_vcd_trace(str(aside))
    try:
        sim.auto_tracing_mode = "eval"
        yield path
    finally:
        sim.stop_vcd_trace()
        os.replace(aside, path)

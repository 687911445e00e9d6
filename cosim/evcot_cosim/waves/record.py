# SPDX-License-Identifier: Apache-2.0
"""Waveform recording while a simulation is driven interactively."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pyverilator import PyVerilator

from evcot.outputs import path_written_aside

__all__ = ["recorded"]


@contextmanager
def recorded(sim: PyVerilator, path: Path, *, force: bool = False) -> Iterator[Path]:
    """Context that records every write to a port of `sim` in a VCD, which appears under its name at the end.

    pyverilator itself dumps at clock edges only, so that an input seems to change at the very edge that samples it. Here an
    input shows its new value before that edge, as a flip-flop sees it.

    Args:
        force: replace a file that exists.

    Raises:
        OutputError: the file exists, or cannot be written.
    """
    failure = None
    with path_written_aside(path, force=force) as aside:
        sim.start_vcd_trace(str(aside))
        try:
            sim.auto_tracing_mode = "eval"
            yield path
        except Exception as error:  # the waveform up to it is what shows why
            failure = error
        finally:
            sim.stop_vcd_trace()
    if failure is not None:
        raise failure

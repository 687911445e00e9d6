# SPDX-License-Identifier: Apache-2.0
"""The whole RTL as one file: no includes, any module of it may be the top."""

from __future__ import annotations

from pathlib import Path

import evcot
from evcot.outputs import written_aside

from .sources import flat, manifest

__all__ = ["release_text", "write_release"]

_HEADER = """\
// SPDX-License-Identifier: Apache-2.0
// evcot {version}: all RTL modules in one file, plain Verilog-2005, no includes and no vendor primitives.
//
// {count} modules, each after those that it instantiates. Pick a top: cot_array (to read), cot_engine (to build),
// cot_chain, cot_filtered, or a single filter or decoder; the header of each says its latency, throughput, stalls and reset.
// Generated from hw/verilog by `python -m evcot_cosim.fpga --release`: edit there.

"""


def release_text(verilog: Path | None = None) -> str:
    """The release as text."""
    modules = manifest(verilog)
    return _HEADER.format(version=evcot.__version__, count=len(modules)) + flat(modules, verilog, comments=True)


def write_release(path: Path, verilog: Path | None = None) -> Path:
    """Write the release; its folder is made.

    Raises:
        OutputError: it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_aside(path) as file:
        file.write(release_text(verilog).encode())
    return path

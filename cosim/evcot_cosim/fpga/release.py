# SPDX-License-Identifier: Apache-2.0
"""Generator of the release: the whole RTL as one file, IP-XACT for each top, timing constraints, device-specific modules."""

from __future__ import annotations

import re
from pathlib import Path

import evcot
from evcot.outputs import written_aside

from ..rtl.files import modules, rtl_files, verilog_dir
from .ipxact import component, constraints_file, dialogue, dialogue_file
from .sources import flat

__all__ = ["TOPS", "release_text", "write_release"]

TOPS = ("evcot_top", "cot_array")
"""Modules that are described for Vivado."""

_HEADER = """\
// SPDX-License-Identifier: Apache-2.0
// evcot {version}: all RTL modules in one file, plain Verilog-2005, no includes and no vendor primitives.
//
// {count} modules, each after those that it instantiates. Pick a top: evcot_top (standard buses), cot_array (tokens in),
// or a single filter or decoder; the header of each says its latency, throughput, stalls and reset.
// Generated from hw/verilog by `python -m evcot_cosim.fpga --release`: edit there.
/* verilator lint_off DECLFILENAME */

"""


def release_text(verilog: Path | None = None) -> str:
    """The release as text."""
    names = modules(verilog)
    return _HEADER.format(version=evcot.__version__, count=len(names)) + flat(names, verilog, comments=True)


_PAGES = ("hardware.md", "registers.md", "motion.md")
_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)#]+)(#[^)]*)?\)")


def _papers(root: Path) -> dict[str, bytes]:
    """Files for users of the hardware, besides the RTL. Links of a page to what is not in the release become text."""
    files = {path.name: path.read_bytes() for path in (root / "LICENSE", root / "hw" / "include" / "evcot_regs.h")}

    def link(found: re.Match[str]) -> str:
        image, text, target, _ = found.groups()
        if image:
            files[target] = (root / "docs" / target).read_bytes()
        return found[0] if image or target in _PAGES or "://" in target else text

    pages = {name: _LINK.sub(link, (root / "docs" / name).read_text(encoding="utf-8")).encode() for name in _PAGES}
    return files | pages


def write_release(folder: Path, verilog: Path | None = None) -> list[Path]:
    """Write the release to a new folder: evcot.v, constraints, ecp5/, examples/, scripts/, ip/TOP/ with a copy of evcot.v.

    Raises:
        OutputError: a file cannot be written.
    """
    text = release_text(verilog).encode()
    files = {"evcot.v": text}
    boards = (verilog or verilog_dir()).parent / "fpga"
    files |= {path.name: path.read_bytes() for path in sorted((boards / "constraints").iterdir())}
    files |= _papers(boards.parents[1])
    for path in sorted((boards / "ecp5").iterdir()):
        files[f"ecp5/{path.name}"] = path.read_bytes()
    for folder_name in ("examples", "scripts"):
        for path in sorted(path for path in (boards / folder_name).iterdir() if path.is_file()):
            files[f"{folder_name}/{path.name}"] = path.read_bytes()
    files["examples/evcot_regs.vh"] = rtl_files(verilog)["evcot_regs.vh"].read_bytes()
    for top in TOPS:
        files[f"ip/{top}/evcot.v"] = text
        files[f"ip/{top}/component.xml"] = component(top, "evcot.v", verilog).encode()
        files[f"ip/{top}/{dialogue_file(top)}"] = dialogue(top, verilog).encode()
        if name := constraints_file(top, verilog):
            files[f"ip/{top}/{name}"] = files[name]
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_aside(path, force=True) as file:
            file.write(content)
    return [folder / name for name in files]

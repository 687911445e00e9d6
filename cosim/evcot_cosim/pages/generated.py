# SPDX-License-Identifier: Apache-2.0
"""List of the generated files in the tree that take seconds to make, with the functions that return their text.

`python -m evcot_cosim.pages.generated` writes what is stale. What follows from the register map, and so what this module
imports, must be there first: `make generate` runs `python -m evcot.hardware.generate` before it. Figures that take synthesis
(hw/fpga/figures.json) are not among them; docs/fpga.md is, for the marks of figures that are outdated.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType

import evcot
from evcot.errors import EvcotError
from evcot.hardware.generate import render
from evcot.outputs import written_aside
from evcot.templating import templates

from ..fpga import board, selftest
from ..fpga.report import page as figures_page
from ..rtl.files import manifest, verilog_dir
from .guides import alike, guide, pictures, scripts
from .interfaces import DIAGRAMS
from .trace import Diagram, svg

__all__ = ["FILES", "stale", "write_stale"]


def _core() -> str:
    """The FuseSoC core, with the files of the manifest."""
    return templates("evcot_cosim.fpga").get_template("evcot.core.j2").render(version=evcot.__version__, files=manifest())


def _title(name: str) -> str:
    return (DIAGRAMS[name].__doc__ or "").splitlines()[0]


_VERSION = re.compile(r'(?<=^version: ).+$|(?<=<version>)[^<]+|(?<=^    version=")[^"]+', re.MULTILINE)


def _with_version(path: str) -> str:
    """A file that is written by hand, but for evcot's version."""
    text, count = _VERSION.subn(evcot.__version__, (verilog_dir().parents[1] / path).read_text(encoding="utf-8"))
    assert count == 1, path
    return text


_diagram: Callable[[str], Diagram] = cache(lambda name: DIAGRAMS[name]())
_rendered = cache(render)

_VERSIONED = ("CITATION.cff", "contrib/evcot_ros/package.xml", "contrib/evcot_ros/setup.py")

FILES: Mapping[str, Callable[[], str]] = MappingProxyType(
    {path: partial(lambda path: _rendered()[path], path) for path in _rendered()}
    | {"hw/evcot.core": _core}
    | {path: partial(_with_version, path) for path in _VERSIONED}
    | {"hw/fpga/evcot_selftest.vh": selftest.header, "hw/fpga/board_selftest.vh": board.header}
    | {f"docs/images/timing_{name}.svg": partial(lambda name: svg(_diagram(name), _title(name)), name) for name in DIAGRAMS}
    | {"docs/fpga.md": figures_page}
    | {f"docs/guides/{script.stem}.md": partial(lambda script: guide(script).page, script) for script in scripts()}
)
"""Path in the source tree -> function that returns its text."""


def stale(path: str, root: Path) -> str | None:
    """The text that a file should have, None if it has it.

    Raises:
        ToolchainError: a package or tool that makes it is not installed.
    """
    text, file = FILES[path](), root / path
    return None if file.is_file() and file.read_text(encoding="utf-8") == text else text


def write_stale(root: Path) -> list[str]:
    """Write every file that is not what it should be; returns which those were.

    Raises:
        ToolchainError: a package or tool that makes one is not installed.
        OutputError: a file cannot be written.
    """
    written = []
    for path in FILES:
        text = stale(path, root)
        if text is not None:
            with written_aside(root / path, force=True) as file:
                file.write(text.encode())
            written.append(path)
    for path, png in pictures().items():
        if not alike(png, root / path):
            with written_aside(root / path, force=True) as file:
                file.write(png)
            written.append(path)
    return written


def _main() -> int:
    for path in write_stale(verilog_dir().parents[1]):
        print(f"{path}: written")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(_main())
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        sys.exit(2)

# SPDX-License-Identifier: Apache-2.0
"""Write docs/timing/*.json, docs/images/timing_*.svg and docs/modules.md from the RTL."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from evcot.errors import EvcotError
from evcot.outputs import written_aside

from ..rtl.files import verilog_dir
from .drawing import svg
from .interfaces import DIAGRAMS
from .modules import page
from .trace import Diagram


def _write(path: Path, text: str) -> None:
    if not path.is_file() or path.read_text() != text:
        with written_aside(path, force=True) as file:
            file.write(text.encode())
        print(f"{path}: written")


def source_text(diagram: Diagram) -> str:
    """The JSON source of a diagram, with one lane per line."""
    lines = ",\n  ".join(json.dumps(lane, ensure_ascii=False) for lane in diagram["signal"])
    return f'{{"signal": [\n  {lines}\n],\n"config": {json.dumps(diagram["config"])}}}\n'


def title(name: str) -> str:
    """Title of a diagram."""
    return (DIAGRAMS[name].__doc__ or "").splitlines()[0]


def main() -> int:
    """Write the files that have changed; with names of diagrams, only those."""
    docs = verilog_dir().parents[1] / "docs"
    for name in sys.argv[1:] or DIAGRAMS:
        diagram = DIAGRAMS[name]()
        _write(docs / "timing" / f"{name}.json", source_text(diagram))
        _write(docs / "images" / f"timing_{name}.svg", svg(diagram, title(name)))
    if not sys.argv[1:]:
        _write(docs / "modules.md", page())
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except EvcotError as error:
        sys.exit(f"evcot: {error}")

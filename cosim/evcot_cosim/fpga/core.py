# SPDX-License-Identifier: Apache-2.0
"""Generator of the FuseSoC core hw/evcot.core, with the files of the manifest. Run as a program, it writes the file."""

from __future__ import annotations

import sys
from pathlib import Path

import evcot
from evcot.outputs import written_aside
from evcot.templating import templates

from ..rtl.files import manifest, verilog_dir

__all__ = ["core_text"]


def core_text(verilog: Path | None = None) -> str:
    """The core description."""
    return (
        templates("evcot_cosim.fpga").get_template("evcot.core.j2").render(version=evcot.__version__, files=manifest(verilog))
    )


def _main() -> int:
    path = verilog_dir().parent / "evcot.core"
    with written_aside(path, force=True) as file:
        file.write(core_text().encode())
    print(f"{path}: written")
    return 0


if __name__ == "__main__":
    sys.exit(_main())

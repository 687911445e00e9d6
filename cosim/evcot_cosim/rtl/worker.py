# SPDX-License-Identifier: Apache-2.0
"""Child process of a build: reads `request.json` in the current folder and builds the model there with pyverilator.

It is a separate process because pyverilator and its tools print, and because the two patches below must not affect the
caller's interpreter. It imports nothing from evcot, so that its behaviour depends on this file alone.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

from pyverilator import PyVerilator, verilatorcpp


def main() -> int:
    """Build as requested; the exit code is 0 if the shared object was built and loaded."""
    request = json.loads(Path("request.json").read_text())
    # pyverilator looks up the simulator by its usual name and reads a version number that some builds do not print.
    # Every Verilator that evcot accepts has the flush call that pyverilator tests for.
    shutil.which = lambda *_args, **_kwargs: request["executable"]
    verilatorcpp.verilator_flushcall_ok = lambda: True
    try:
        PyVerilator.build(
            request["top_file"],
            verilog_path=request["verilog_path"],
            build_dir=".",
            args=request["args"],
            cargs=request["cargs"],
        )
    except subprocess.CalledProcessError as error:
        print(f"exit code {error.returncode}: {' '.join(map(str, error.cmd))}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

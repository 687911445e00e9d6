# SPDX-License-Identifier: Apache-2.0
"""Child process of a build: reads `request.json` in the current folder and builds the model there with pyverilator.

It is a separate process because pyverilator and its tools print, and because the patches below must not affect the
caller's interpreter. It imports nothing from evcot, so that its behaviour depends on this file alone.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

from pyverilator import PyVerilator, pyverilator, verilatorcpp


def main() -> int:
    """Build as requested; the exit code is 0 if the shared object was built and loaded."""
    request = json.loads(Path("request.json").read_text())
    # pyverilator looks up the simulator by its usual name, starts it with perl, which drops empty arguments, and reads a
    # version number, which some builds do not print. It tests for a flush call, which every Verilator that evcot accepts has.
    shutil.which = lambda *_args, **_kwargs: request["verilator"][-1]
    verilatorcpp.verilator_flushcall_ok = lambda: True

    def call(command: list[str], quiet: bool = False) -> None:
        own = [*request["verilator"], *filter(None, command[2:])] if command[0] == "perl" else command
        subprocess.run(own, check=True, capture_output=quiet)

    pyverilator.call_process = call
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

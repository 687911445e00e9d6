# SPDX-License-Identifier: Apache-2.0
"""What works without POSIX, as on Windows: `evcot`, and commands that simulate no hardware. See docs/platforms.md."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Modules of Python that exist on POSIX alone: importing them fails, as it does on Windows.
HIDDEN = ("fcntl", "grp", "posix_ipc", "pty", "pwd", "resource", "termios", "tty")
WITHOUT_POSIX = f"""
import sys
for name in {HIDDEN!r}:
    sys.modules[name] = None
"""


def run(code: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run code without POSIX's modules, and without hardware that was compiled before."""
    cache = os.environ.get("EVCOT_CACHE")
    own = {"EVCOT_CACHE": str(cwd / "cache")} | ({"NUMBA_CACHE_DIR": f"{cache}/numba"} if cache else {})
    command = [sys.executable, "-c", WITHOUT_POSIX + code]
    return subprocess.run(command, cwd=cwd, env=os.environ | own, capture_output=True, text=True, check=False)


def test_posix_is_hidden(tmp_path: Path) -> None:
    assert "ModuleNotFoundError" in run("import fcntl", tmp_path).stderr


def test_every_module_of_evcot_can_be_imported(tmp_path: Path) -> None:
    code = """
import importlib, pkgutil, evcot
for module in pkgutil.walk_packages(evcot.__path__, "evcot."):
    importlib.import_module(module.name)
print("all")
"""
    done = run(code, tmp_path)
    assert done.stdout == "all\n", done.stderr


@pytest.mark.parametrize(
    "commands",
    [
        [
            "simulate discs --duration 0.1 -o discs.npz", "info discs.npz", "track discs.npz -o log.npz -q",
            "evaluate log.npz --truth discs.truth.csv", "convert discs.npz discs.csv", "plot discs.npz log.npz -o a.png",
            "boxes log.npz a.txt --frame-us 10000", "filter discs.npz b.npz --refractory 1 --force", "presets",
        ],
        ["simulate discs --duration 0.1 -o discs.npz", "live discs.npz -q --with-hardware --json"],
    ],
)  # fmt: skip
def test_commands_that_simulate_nothing(tmp_path: Path, commands: list[str]) -> None:
    code = f"""
from evcot_cosim.cli import main
for command in {commands!r}:
    assert main(command.split()) == 0, command
"""
    done = run(code, tmp_path)
    assert done.returncode == 0, done.stderr
    if "live" in commands[-1]:
        (beside,) = json.loads(done.stdout.splitlines()[-1])["beside"]
        assert beside["about"].startswith("golden model; "), "the RTL needs a compiler, and POSIX to drive it"

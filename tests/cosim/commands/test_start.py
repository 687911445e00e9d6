# SPDX-License-Identifier: Apache-2.0
"""The command line starts at once: help imports none of what the commands then do."""

from __future__ import annotations

import argparse
import inspect
import subprocess
import sys

import pytest

from evcot_cosim.cli import parser
from evcot_cosim.commands.parsing import Action

HEAVY = (
    "numpy", "numba", "llvmlite", "scipy", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "vcdvcd", "rich", "rosbags",
    "lz4", "backports.zstd", "websockets", "tomli_w", "shtab", "evcot_cosim.commands.actions",
)  # fmt: skip
COMMANDS: dict[str, argparse.ArgumentParser] = next(
    dict(action.choices) for action in parser()._actions if isinstance(action, argparse._SubParsersAction)
)


def imported(code: str) -> set[str]:
    """The modules of a fresh interpreter that has run this."""
    ran = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules, file=sys.stderr)"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return set(ran.stderr.split())


def test_help_of_every_command_imports_nothing_heavy() -> None:
    code = f"""
from evcot_cosim.cli import main
for words in {[["--help"], ["--version"], *([name, "-h"] for name in COMMANDS)]!r}:
    try:
        main(words)
    except SystemExit as end:
        assert end.code == 0
"""
    found = imported(code)
    assert "evcot_cosim.commands.track" in found
    assert not found & set(HEAVY)


def test_the_packages_alone_import_nothing_heavy() -> None:
    rooms = "evcot, evcot_cosim, evcot.trackers.engines, evcot.scenes, evcot.recordings.formats, evcot.metrics"
    found = imported(f"import {rooms}\nassert 'Events' in dir(evcot) and 'Device' in dir(evcot_cosim)")
    assert "evcot.trackers.engines" in found
    assert not found & set(HEAVY)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_finds_what_it_does(name: str) -> None:
    command = COMMANDS[name].get_default("command")
    assert isinstance(command, Action)
    assert len(inspect.signature(command.function).parameters) == 2

# SPDX-License-Identifier: Apache-2.0
"""The command line starts at once: help and errors import none of what the commands then do, and short commands little."""

from __future__ import annotations

import argparse
import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.recordings.files import write_recording
from evcot.tracks.log import Kind
from evcot_cosim.cli import parser
from evcot_cosim.commands.parsing import Action
from support.logs import log_of

HEAVY = (
    "numpy", "numba", "llvmlite", "scipy", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "vcdvcd", "rich", "rosbags",
    "lz4", "backports.zstd", "websockets", "tomli_w", "shtab", "evcot_cosim.commands.actions",
)  # fmt: skip
COMMANDS: dict[str, argparse.ArgumentParser] = next(
    dict(action.choices) for action in parser()._actions if isinstance(action, argparse._SubParsersAction)
)

# Commands with an input, `absent`, that does not exist.
ABSENT = (
    "info absent", "convert absent out.npz", "track absent", "filter absent out.npz", "cosim absent.raw",
    "cosim --config absent", "live absent.raw", "waves absent.raw", "toggles absent.raw", "evaluate absent --truth absent",
    "report absent", "plot absent -o out.png", "render absent -o out.gif", "boxes absent out.txt", "anomalies absent",
    "sweep absent.toml", "tune absent -o out.toml", "simulate absent.mp4 -o out.raw",
)  # fmt: skip


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
    assert "evcot_cosim.commands.tracking" in found
    assert not found & set(HEAVY)


def test_a_command_alone_has_the_options_that_it_has_among_all() -> None:
    for name, whole in COMMANDS.items():
        if name == "completion":
            continue
        alone = next(action.choices for action in parser(name)._actions if isinstance(action, argparse._SubParsersAction))
        assert alone[name].format_help() == whole.format_help()
        assert len(alone) <= 2


def test_a_command_imports_no_module_of_another_and_looks_for_no_trackers_of_other_packages() -> None:
    code = "from evcot_cosim.cli import main\nimport contextlib, io\nwith contextlib.redirect_stderr(io.StringIO()): main(%r)"
    found = imported(code % ["info", "absent.raw"])
    assert {name for name in found if name.startswith("evcot_cosim.commands.")} >= {"evcot_cosim.commands.recordings"}
    assert not found & {"evcot_cosim.commands.tracking", "evcot.trackers.engines", "importlib.metadata"}
    found = imported(code % ["track", "absent.raw", "--engine", "rct"])
    assert "evcot.trackers.engines" in found
    assert "importlib.metadata" not in found


def test_a_missing_input_and_an_unknown_option_are_reported_before_anything_heavy_is_imported() -> None:
    code = f"""
import contextlib, io
from evcot_cosim.cli import main
for words in {[words.split() for words in ABSENT]!r}:
    with contextlib.redirect_stderr(io.StringIO()) as said:
        assert main(words) == 2, words
    absent = next(word for word in words if word.startswith("absent"))
    assert said.getvalue() == f"evcot: {{absent}}: cannot be read: No such file or directory\\n", said.getvalue()
for name in {list(COMMANDS)!r}:
    with contextlib.suppress(SystemExit), contextlib.redirect_stderr(io.StringIO()) as said:
        main([name, "--no-such-option"])
    assert "unrecognized arguments: --no-such-option" in said.getvalue(), said.getvalue()
"""
    assert not imported(code) & set(HEAVY)


@pytest.mark.parametrize(
    ("command", "unneeded"),
    [
        ("presets", {"numba", "scipy", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "rich"}),
        ("presets --engine rct", {"scipy.linalg", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "rich"}),
        ("info few.raw", {"scipy.linalg", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "rich"}),
        ("evaluate log.npz --truth truth.csv", {"numba", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "rich"}),
    ],
)
def test_a_short_command_imports_only_what_it_needs(
    command: str, unneeded: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    few = Events(np.arange(9), *np.zeros((2, 9), np.uint16), np.zeros(9, np.uint8))
    write_recording(Recording(few, 32, 24, "few"), Path("few.raw"))
    log_of([(0, Kind.BORN, 1, 10.0, 10.0), (9_000, Kind.LOST, 1, 10.0, 10.0)]).save_npz("log.npz")
    names = "t_us,object_id,left,top,width,height,vx,vy,visible,occluded"
    Path("truth.csv").write_text(f"{names}\n0,0,0,4,20,12,0,0,1,0\n1000,0,0,4,20,12,0,0,1,0\n")
    code = f"from evcot_cosim.cli import main\nassert main({command.split()!r}) == 0"
    imported(code)  # which compiles the kernels
    assert not imported(code) & unneeded


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

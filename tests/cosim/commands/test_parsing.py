# SPDX-License-Identifier: Apache-2.0
"""Whatever a command is asked to write, no existing file is lost: tested for every command and every argument that names
a file, as the parser has them, so that a new one cannot be forgotten."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from hashlib import blake2b
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.outputs import RUN_FILE, folder_written_aside
from evcot.recordings.files import write_recording
from evcot.tracks.log import TRACK, TrackLog
from evcot_cosim.cli import main, parser
from evcot_cosim.commands.options import milliseconds, region
from evcot_cosim.commands.parsing import INPUT_TYPES, OUTPUT_TYPES, Action, output_file, output_folder

Capture = pytest.CaptureFixture[str]

_NUMBERS = (int, float, milliseconds, region)
# Text that names no file: every other argument without a type of its own is refused here.
_NO_FILES = {
    "around", "bind", "boxes_format", "clock", "field", "format", "kind", "labels_format", "log_format", "objective",
    "only", "port", "preset", "scheduler", "sensor", "set", "source_format", "struct", "truth_format",
}  # fmt: skip


def commands() -> dict[str, argparse.ArgumentParser]:
    (subparsers,) = (action for action in parser()._actions if isinstance(action, argparse._SubParsersAction))
    return dict(subparsers.choices)


def arguments_of(command: str, types: tuple[object, ...]) -> list[argparse.Action]:
    return [action for action in commands()[command]._actions if action.type in types]


def cases() -> Iterator[tuple[str, argparse.Action]]:
    for command in commands():
        for action in arguments_of(command, OUTPUT_TYPES):
            yield command, action


def label(value: object) -> str:
    return (value.option_strings or [value.dest])[0] if isinstance(value, argparse.Action) else str(value)


CASES = list(cases())
every_output = pytest.mark.parametrize(("command", "action"), CASES, ids=label)


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file of the user's, where every command runs; one above it holds another."""
    (tmp_path / "above").write_text("mine")
    folder = tmp_path / "home"
    folder.mkdir()
    monkeypatch.chdir(folder)
    Path("mine").write_text("mine")
    return folder


def everything(root: Path) -> dict[str, tuple[str, int, int]]:
    """Path -> kind or digest, inode and number of names of all that is there; links are not followed."""
    found = {}
    for folder, inner, files in os.walk(root):
        for name in (*inner, *files):
            path = Path(folder, name)
            state = path.lstat()
            what = (
                os.readlink(path)
                if path.is_symlink()
                else "folder"
                if path.is_dir()
                else blake2b(path.read_bytes()).hexdigest()
            )
            found[str(path)] = what, state.st_ino, state.st_nlink
    return found


def inputs_of(command: str) -> None:
    """A file of the user's for each input of a command, under that argument's name."""
    for source in arguments_of(command, INPUT_TYPES):
        Path(f"in_{source.dest}").write_text(f"{source.dest} of the user's")


def line(command: str, *outputs: tuple[argparse.Action, str], force: bool = False) -> list[str]:
    """A call with all inputs of a command and these outputs; those that must be there too are new."""
    values = {source.dest: f"in_{source.dest}" for source in arguments_of(command, INPUT_TYPES)}
    values |= {action.dest: f"new.{action.dest}" for action in arguments_of(command, OUTPUT_TYPES) if action.required}
    values |= {action.dest: target for action, target in outputs}
    named = [action for action in commands()[command]._actions if action.dest in values]
    places = [values[action.dest] for action in named if not action.option_strings]
    options = [text for action in named if action.option_strings for text in (action.option_strings[0], values[action.dest])]
    return [command, *places, *options, *(["--force"] if force else [])]


def refused(capture: Capture, home: Path, *arguments: str, why: str) -> None:
    """One line, exit code 2, and everything as it was."""
    before = everything(home.parent)
    code = main(arguments)
    printed = capture.readouterr()
    assert everything(home.parent) == before
    assert (code, printed.out) == (2, "")
    assert len(printed.err.splitlines()) == 1
    assert why in printed.err


def test_every_argument_says_whether_it_names_a_file() -> None:
    for command, its in commands().items():
        for action in its._actions:
            if action.nargs == 0 or action.choices is not None or isinstance(action, argparse._HelpAction):
                continue
            where = f"evcot {command}: {label(action)}"
            known = (*INPUT_TYPES, *OUTPUT_TYPES, *_NUMBERS)
            assert action.type in known or (action.type is None and action.dest in _NO_FILES), (
                f"{where}: input, output or no file?"
            )
            if action.type in OUTPUT_TYPES:
                assert action.nargs is None, f"{where}: swallows, or goes without, what follows"
            if action.type is output_file:
                assert "--force" in its._option_string_actions, where


def test_there_are_commands_that_write() -> None:
    assert len(CASES) >= 20
    assert {command for command, _ in CASES} >= {"cosim", "waves", "track", "convert", "filter", "simulate", "live", "report"}


@every_output
@pytest.mark.parametrize("name", ["itself", "hard link", "symbolic link"])
def test_an_output_is_no_input(command: str, action: argparse.Action, name: str, home: Path, capsys: Capture) -> None:
    inputs_of(command)
    for source in arguments_of(command, INPUT_TYPES):
        path = f"in_{source.dest}"
        target = path if name == "itself" else f"{source.dest}.{name.replace(' ', '_')}"
        if name == "hard link":
            os.link(path, target)
        elif name == "symbolic link":
            Path(target).symlink_to(path)
        why = "must be " if action.type is output_folder else f"is {path}, an input of the same call"
        for force in (False, True) if action.type is output_file else (False,):
            refused(capsys, home, *line(command, (action, target), force=force), why=why)


@every_output
def test_what_exists_is_not_written_over(command: str, action: argparse.Action, home: Path, capsys: Capture) -> None:
    inputs_of(command)
    os.link("mine", "hard")
    Path("soft").symlink_to("mine")
    folder = action.type is output_folder
    for target in ("mine", "hard", "soft", "../above"):
        why = "is not a folder" if folder else f"{target}: exists: must be another file, or --force"
        refused(capsys, home, *line(command, (action, target)), why=f"{label(action) if action.option_strings else 'output'} ")
        refused(capsys, home, *line(command, (action, target)), why=why)
    for target in (".", "..", str(home), "/"):
        why = "an input of the same call" if folder else "is a folder: must be a file"
        refused(capsys, home, *line(command, (action, target)), why=why)


@every_output
def test_a_folder_of_the_users_is_not_written_over(command: str, action: argparse.Action, home: Path, capsys: Capture) -> None:
    Path("full").mkdir()
    Path("full/mine").write_text("mine")
    inputs_of(command)
    why = "evcot did not make it" if action.type is output_folder else "is a folder: must be a file"
    refused(capsys, home, *line(command, (action, "full")), why=why)


@every_output
def test_the_files_of_a_folder_that_is_read_are_inputs(
    command: str, action: argparse.Action, home: Path, capsys: Capture
) -> None:
    inputs_of(command)
    source = arguments_of(command, INPUT_TYPES)[0]
    path = Path(f"in_{source.dest}")
    path.unlink()
    path.mkdir()
    Path(path, "1.png").write_text("mine")
    if action.type is output_folder:
        refused(capsys, home, *line(command, (action, str(path))), why="an input of the same call")
    else:
        refused(capsys, home, *line(command, (action, f"{path}/1.png"), force=True), why="an input of the same call")


@pytest.mark.parametrize("command", dict.fromkeys(command for command, _ in CASES))
def test_no_two_outputs_are_one_file(command: str, home: Path, capsys: Capture) -> None:
    inputs_of(command)
    Path("soft").symlink_to("new")
    for one, other in permutations(arguments_of(command, (output_file,)), 2):
        refused(capsys, home, *line(command, (one, "soft"), (other, "new")), why="must be another file")


def tiny(path: str) -> None:
    t_us = np.arange(200, dtype=np.int64) * 100
    x = np.full(200, 8, np.uint16)
    write_recording(Recording(Events(t_us, x, x, (x % 2).astype(np.uint8)), 16, 16, "tiny"), path)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("track drive.npz --learn-hot-pixels --save-hot-pixels drive.npz --force", "is drive.npz, an input"),
        ("track drive.npz --save-hot-pixels new.txt", "must be given with --learn-hot-pixels"),
        ("cosim run/drive.npz -o run", "-o run: holds drive.npz, an input of the same call"),
        ("cosim run/drive.npz -o full", "evcot did not make it"),
        ("cosim drive.npz", "build/cosim/drive: holds files, and evcot did not make it"),
        ("waves drive.npz", "build/waves/drive: holds files"),
        ("cosim build/cosim/boxes/drive.npz -o build/cosim", "holds drive.npz, an input"),
        ("cosim -o .", "-o .: holds files"),
        ("cosim -o ..", "-o ..: holds files"),
        ("cosim --config run/run.toml -o run", "holds run.toml, an input"),
        ("cosim --config named.toml -o run", "holds drive.npz, an input"),
        ("cosim drive.npz --learn-hot-pixels --save-hot-pixels drive.truth.csv --force -o new", "drive.truth.csv, an input"),
        ("filter drive.npz out.npz --config hot.toml --learn-hot-pixels --save-hot-pixels soft --force", "hot.txt, an input"),
        ("cosim --stalls -4", "--stalls -4: must not be negative"),
        ("cosim --seed -4", "--seed -4: must not be negative"),
        ("simulate boxes -o new.npz", "--truth new.truth.csv: exists"),
        ("simulate boxes -o new.csv --truth new.csv", "must be another file"),
        ("report log.npz --recording drive.npz", "-o log.html: exists"),
        ("evaluate log.npz --truth absent.csv", "absent.csv"),
        ("live tcp://127.0.0.1:1 --save mine.raw --quiet", "--save mine.raw: exists"),
    ],
)
def test_what_has_been_tried(line: str, why: str, home: Path, capsys: Capture) -> None:
    tiny("drive.npz")
    TrackLog("rct", np.empty(0, TRACK), np.empty(0, np.int16)).save_npz("log.npz")
    Path("hot.txt").write_text("1 1\n")
    Path("soft").symlink_to("hot.txt")
    Path("hot.toml").write_text('[filters]\nhot_pixels_file = "hot.txt"\n')
    with folder_written_aside(Path("run"), "cosim") as aside:
        (aside / RUN_FILE).write_text('[run]\nrecording = "boxes"\n')
        (aside / "summary.json").write_text("{}")
    tiny("run/drive.npz")
    Path("named.toml").write_text('[run]\nrecording = "run/drive.npz"\n')
    for name in ("full", "build/cosim/drive", "build/waves/drive", "build/cosim/boxes"):
        Path(name).mkdir(parents=True)
        tiny(f"{name}/drive.npz")
    for name in ("new.truth.csv", "drive.truth.csv", "log.html", "mine.raw"):
        Path(name).write_text("mine")
    refused(capsys, home, *line.split(), why=why)


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("options", ["", "--save-hot-pixels hot.txt"])
def test_print_config_writes_nothing(options: str, home: Path, capsys: Capture) -> None:
    tiny("drive.npz")
    before = everything(home)
    assert main(["cosim", "--learn-hot-pixels", "drive.npz", "--print-config", *options.split()]) == 0
    assert 'home/drive.npz"' in capsys.readouterr().out
    assert everything(home) == before


def test_a_device_stays_a_device_and_a_link_a_link(capsys: Capture) -> None:
    tiny("drive.npz")
    Path("link").symlink_to("target.npz")
    before = os.stat("/dev/null")
    assert main(["track", "drive.npz", "--quiet", "--csv", "/dev/null", "-o", "link"]) == 0
    assert os.stat("/dev/null").st_ino == before.st_ino
    assert Path("/dev/null").is_char_device()
    assert Path("link").is_symlink()
    assert TrackLog.load_npz("target.npz").engine == "cot_motion"
    assert main(["track", "drive.npz", "--quiet", "-o", "link"]) == 2
    assert main(["track", "drive.npz", "--quiet", "-o", "link", "--force"]) == 0
    assert Path("link").is_symlink()
    capsys.readouterr()


@pytest.mark.parametrize("command", ["cosim", "waves", "assert", "vectors", "toggles"])
def test_a_name_that_is_no_file_and_no_scene_is_told_before_the_command_is_loaded(
    command: str, home: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Action, "function", None)
    refused(capsys, home, command, "hihgway", why="hihgway: cannot be read: No such file or directory; nor is it a scene")

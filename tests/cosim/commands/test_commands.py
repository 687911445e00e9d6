# SPDX-License-Identifier: Apache-2.0
"""What all commands have in common: JSON, examples that are true, completion; and that they start at once.

Help and errors import none of what the commands then do, and short commands little.
"""

from __future__ import annotations

import argparse
import inspect
import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.recordings.files import write_recording
from evcot.tracks.log import Kind
from evcot_cosim.cli import main, parser
from evcot_cosim.commands.parsing import Action
from support.logs import log_of

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]

PARSER = parser()
COMMANDS: dict[str, argparse.ArgumentParser] = next(
    dict(action.choices) for action in PARSER._actions if isinstance(action, argparse._SubParsersAction)
)
EXAMPLE = re.compile(r"^ +(evcot [^#>\n]*)", re.MULTILINE)


def options(command: str) -> set[str]:
    return {option for action in COMMANDS[command]._actions for option in action.option_strings}


@pytest.mark.parametrize("command", sorted(COMMANDS.keys() - {"completion"}))
def test_every_command_speaks_json(command: str) -> None:
    assert "--json" in options(command)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_examples_that_its_parser_takes(command: str) -> None:
    examples = EXAMPLE.findall(COMMANDS[command].format_help().replace(" \\\n", " ").partition("examples:")[2])
    own = [shlex.split(example) for example in examples]
    assert any(words[1] == command for words in own)
    for words in own:
        assert PARSER.parse_args(words[1:]).command


def test_the_first_page_lists_examples_that_are_true() -> None:
    examples = EXAMPLE.findall(PARSER.format_help().partition("examples:")[2])
    assert len(examples) >= 5
    for example in examples:
        PARSER.parse_args(shlex.split(example)[1:])


@pytest.mark.parametrize("command", COMMANDS)
def test_one_word_means_the_same_in_every_command(command: str) -> None:
    """An option that two commands have takes an argument, or none, in both, and goes by the same short name."""
    for action in COMMANDS[command]._actions:
        for option in action.option_strings:
            for other in COMMANDS.values():
                twin = other._option_string_actions.get(option)
                if twin is not None:
                    assert (twin.nargs == 0) == (action.nargs == 0), option


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("evcot co", {"cosim", "convert", "completion"}),
        ("evcot track x --engine fr", {"frames"}),
        ("evcot cosim --sta", {"--stalls"}),
    ],
)
def test_bash_completes_commands_options_and_values(typed: str, offered: set[str], capsys: Capture, tmp_path: Path) -> None:
    assert main(["completion", "bash"]) == 0
    (tmp_path / "evcot.bash").write_text(capsys.readouterr().out)
    words = typed.split()
    script = f"source evcot.bash; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _shtab_evcot; echo ${{COMPREPLY[@]}}"
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) == offered


@pytest.mark.skipif(shutil.which("zsh") is None, reason="needs zsh")
def test_zsh_takes_its_script(capsys: Capture, tmp_path: Path) -> None:
    assert main(["completion", "zsh"]) == 0
    (tmp_path / "_evcot").write_text(capsys.readouterr().out)
    subprocess.run(["zsh", "-n", "_evcot"], cwd=tmp_path, check=True)


def fish_script(capsys: Capture) -> list[str]:
    assert main(["completion", "fish"]) == 0
    return capsys.readouterr().out.splitlines()


def test_fish_has_every_command_option_and_value(capsys: Capture) -> None:
    lines = fish_script(capsys)
    for name, one in COMMANDS.items():
        assert any(f"-n __fish_use_subcommand -a {name} " in line for line in lines)
        own = [line for line in lines if f"'__fish_seen_subcommand_from {name}'" in line]
        for option in (option for action in one._actions for option in action.option_strings if option.startswith("--")):
            assert any(f" -l {option.removeprefix('--')} " in line for line in own), (name, option)
    (engine,) = (line for line in lines if "_from track'" in line and "-l engine " in line)
    assert " -x -a 'cot_motion " in engine
    assert all(line.count("'") % 2 == line.count("\\'") % 2 for line in lines)


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish")
def test_fish_completes(capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "evcot.fish").write_text("\n".join(fish_script(capsys)))
    script = "source evcot.fish; complete -C 'evcot track x --engine fr'"
    done = subprocess.run(["fish", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "frames" in done.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_examples_before_options_and_filters_last(command: str) -> None:
    text = COMMANDS[command].format_help()
    assert text.index("examples:") < text.index("\noptions:")
    assert len(text.partition("\n\n")[0].splitlines()) == 1  # the usage
    titles = [group.title for group in COMMANDS[command]._action_groups if group._group_actions]
    assert "filters" not in titles[:-1]
    assert ("filters" in titles) == ("--activity" in options(command))
    (own,) = (group for group in COMMANDS[command]._action_groups if group.title == "options")
    listed = {option for action in own._group_actions for option in action.option_strings}
    assert "--force" in listed or "--force" not in options(command)


@pytest.mark.parametrize("columns", [80, 100])
def test_help_fits_the_terminal_and_its_examples_can_be_copied(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    for command in COMMANDS.values():
        shown = command.format_help()
        assert max(map(len, shown.splitlines())) <= columns
        for line in (command.description or "").splitlines():
            if line.startswith("  evcot "):
                words, _, remark = line.partition(" # ")
                assert " ".join(words.split()) in " ".join(shown.replace(" \\\n", " ").split()), line
                assert remark.strip() in " ".join(shown.replace("\n  # ", " ").split()), line


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["trak", "x"], "did you mean track?"),
        (["cosim", "--presett", "slow"], "did you mean --preset?"),
        (["track", "x", "--engine", "framse"], "did you mean frames?"),
        (
            ["track", "--engin", "rct"],
            "the following arguments are required: FILE",
        ),  # the beginning of one option is that option
        (["track", "--engne=rct"], "are required: FILE; unrecognized arguments: --engne; did you mean --engine?"),
        (["report", "-o", "x.html", "--recordng", "y"], "unrecognized arguments: --recordng; did you mean --recording?"),
    ],
)
def test_a_misspelled_word_is_answered_with_the_right_one(typed: list[str], meant: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit) as end:
        main(typed)
    assert end.value.code == 2
    complaint = capsys.readouterr().err
    assert complaint.endswith(f"{meant}\n")
    assert len(complaint.splitlines()) == 2  # usage and message


@pytest.mark.usefixtures("home")
def test_a_misspelled_scene_is_answered_with_the_right_one(refused: Refused) -> None:
    said = refused("cosim", "boxs")
    assert said.startswith("boxs: cannot be read: No such file or directory; nor is it a scene, one of boxes,")
    assert said.endswith("; did you mean boxes?")


def test_the_command_alone_prints_its_help(capsys: Capture) -> None:
    with pytest.raises(SystemExit) as end:
        main([])
    assert end.value.code == 0
    assert "COMMAND" in capsys.readouterr().out


def test_the_package_is_a_command_too() -> None:
    done = subprocess.run([sys.executable, "-m", "evcot", "--version"], capture_output=True, text=True, check=True)
    assert re.fullmatch(r"evcot \d+\.\d+\.\d+\n", done.stdout)


def test_cosim_explains_the_words_of_its_output() -> None:
    text = COMMANDS["cosim"].format_help().partition("words in the output:")[2]
    for word in ("record", "owner", "CM", "TC", "isolated", "short"):
        assert f"\n  {word} " in text


def test_nothing_is_suggested_for_a_word_that_is_near_none(capsys: Capture) -> None:
    with pytest.raises(SystemExit):
        main(["cosim", "--qqqqq"])
    assert "did you mean" not in capsys.readouterr().err


def test_convert_tells_what_it_wrote(capsys: Capture, home: Path) -> None:
    assert main(["simulate", "pendulum", "--duration", "0.1", "-o", "a.npz", "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert main(["convert", "a.npz", "b.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "recording": "b.csv", "format": "csv", "events": events, "width": 346, "height": 260
    }  # fmt: skip


def test_bench_measures_every_engine_and_the_hardware(capsys: Capture, home: Path) -> None:
    assert main(["simulate", "boxes", "--duration", "0.1", "-o", "boxes.npz", "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert main(["bench", "boxes.npz", "--json"]) == 0
    rates = {rate["what"]: rate for rate in json.loads(capsys.readouterr().out)}
    wanted = {"reading", "activity filter", "rct, plain", "golden model", "cot_motion", "cot_motion, checked against the model"}
    assert wanted <= rates.keys()
    for rate in rates.values():
        assert rate["events"] == events
        assert rate["events_per_s"] == pytest.approx(rate["events"] / rate["seconds"])


HEAVY = (
    "numpy", "numba", "llvmlite", "scipy", "matplotlib", "h5py", "PIL", "jinja2", "pyverilator", "vcdvcd", "rich", "rosbags",
    "lz4", "backports.zstd", "websockets", "tomli_w", "shtab", "evcot_cosim.commands.actions",
)  # fmt: skip
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
def test_a_short_command_imports_only_what_it_needs(command: str, unneeded: set[str], home: Path) -> None:
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

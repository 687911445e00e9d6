# SPDX-License-Identifier: Apache-2.0
"""What all commands have in common: JSON, quiet, examples that are true, completion."""

from __future__ import annotations

import argparse
import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import evcot_cosim.rtl.build
from evcot_cosim.cli import main, parser

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


@pytest.mark.parametrize(
    ("typed", "said", "meant"),
    [
        (["cosim", "boxs"], "boxs: cannot be read: No such file or directory; nor is it a scene, one of boxes,", "boxes"),
        (["simulate", "insect", "-o", "x.npz"], "SCENE 'insect': must be one of boxes,", "insects"),
    ],
)
def test_a_misspelled_scene_is_answered_with_the_right_one(typed: list[str], said: str, meant: str, capsys: Capture) -> None:
    assert main(typed) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"evcot: {said}")
    assert line.endswith(f"; did you mean {meant}?")


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


def test_convert_names_a_recording_that_is_not_there(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "boxes.npz", "x.npz"]) == 2
    assert "boxes.npz" in capsys.readouterr().err


def test_convert_tells_what_it_wrote(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "pendulum", "--duration", "0.1", "-o", "a.npz", "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert main(["convert", "a.npz", "b.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "recording": "b.csv", "format": "csv", "events": events, "width": 346, "height": 260
    }  # fmt: skip


def test_bench_measures_every_engine_and_the_hardware(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EVCOT_CACHE", str(evcot_cosim.rtl.build.cache_dir()))
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "boxes", "--duration", "0.1", "-o", "boxes.npz", "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert main(["bench", "boxes.npz", "--json"]) == 0
    rates = {rate["what"]: rate for rate in json.loads(capsys.readouterr().out)}
    wanted = {"reading", "activity filter", "rct, plain", "golden model", "cot_motion", "cot_motion, checked against the model"}
    assert wanted <= rates.keys()
    for rate in rates.values():
        assert rate["events"] == events
        assert rate["events_per_s"] == pytest.approx(rate["events"] / rate["seconds"])

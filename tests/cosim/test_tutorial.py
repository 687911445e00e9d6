# SPDX-License-Identifier: Apache-2.0
"""docs/tutorial.md is true: its commands are run one after the other, and what they print is what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from evcot_cosim.cli import main

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)


def pattern(expected: str) -> str:
    """A regular expression for what is expected: a line `...` stands for any lines, `...` within a line for anything."""
    return "".join(r"(?:.*\n)*?" if line == "...\n" else _line(line) for line in expected.splitlines(keepends=True))


def _line(line: str) -> str:
    return ".*".join(re.escape(part) for part in line.rstrip("\n").split("...")) + "\n"


def test_a_line_of_dots_stands_for_lines_and_dots_within_one_for_anything() -> None:
    assert re.fullmatch(pattern("a\n...\nb ...c\n"), "a\nx\ny\nb 12 c\n")
    assert not re.fullmatch(pattern("a\n...\nb\n"), "a\nx\nc\n")
    assert not re.fullmatch(pattern("a 1\n"), "a 2\n")


def test_every_step_does_what_it_says(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    commands = 0
    for kind, text in BLOCK.findall(TUTORIAL.read_text()):
        if kind == "python" and (name := re.match(r"# (\w+\.py)\n", text)):
            Path(name[1]).write_text(text)
        elif kind == "python":
            exec(compile(text, "tutorial.md", "exec"), {})
        elif kind == "console":
            for command, expected in COMMAND.findall(text):
                assert main(shlex.split(command)[1:]) == 0, command
                printed = "".join(line.rstrip() + "\n" for line in capsys.readouterr().out.splitlines())
                assert re.fullmatch(pattern(expected), printed), f"{command}\n{printed}"
                commands += 1
    assert commands == 8
    for name in ("hardware.npz", "software.npz"):
        assert Path("again", name).read_bytes() == Path("build/cosim/discs", name).read_bytes()
    assert settings_of("build/cosim/discs") == settings_of("again")


def settings_of(folder: str) -> list[str]:
    """What run.toml says without digests, also of measured times."""
    return Path(folder, "run.toml").read_text().partition("[made]")[0].splitlines()

# SPDX-License-Identifier: Apache-2.0
"""The Makefile: what it lists, what it hands to evcot, and what it says when the machine lacks something."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

# What an outer `make test` sets.
OUTER = ("MAKE", "MFLAGS", "EVCOT", "ARGS", "RECORDING", "PRESET", "CONFIG", "VENV", "PYTHON", "CXX")
REPOSITORY = Path(__file__).parents[1]


def make(*arguments: str, cwd: Path = REPOSITORY, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run make as a user would, in `cwd`."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith(OUTER)}
    command = ["make", "--no-print-directory", "-C", str(REPOSITORY), *arguments]
    return subprocess.run(
        command,
        cwd=cwd,
        env={**inherited, "PWD": str(cwd), "LC_ALL": "C", **environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def venv(tmp_path: Path) -> str:
    """An installed environment whose `evcot` prints its arguments, one a line, and ends with exit code 2."""
    folder = tmp_path / "venv"
    (folder / "bin").mkdir(parents=True)
    evcot = folder / "bin" / "evcot"
    evcot.write_text('#!/bin/sh\nprintf "%s\\n" "$@" "cache=$EVCOT_CACHE"\nexit 2\n')
    evcot.chmod(0o755)
    for stamp in (".created", ".installed-run"):
        (folder / stamp).touch()
    return f"VENV={folder}"


def test_help_is_the_default_and_lists_every_target() -> None:
    done = make()
    assert done.returncode == 0
    targets = re.findall(r"^\.PHONY: (.*)$", (REPOSITORY / "Makefile").read_text(), re.MULTILINE)[0].split()
    assert {"help", "cosim", "test", "bench", "lint", "waves", "clean"} <= set(targets)
    assert re.findall(r"^  ([\w-]+) +\S", done.stdout, re.MULTILINE) == targets


def test_cosim_without_arguments_runs_the_default(venv: str) -> None:
    done = make("cosim", venv)
    assert done.stdout.splitlines() == ["cosim", f"cache={REPOSITORY / 'build' / 'cache'}"]


def test_a_recording_may_be_named_from_the_callers_folder(venv: str, tmp_path: Path) -> None:
    recording = tmp_path / "my recording.aedat4"
    recording.touch()
    done = make("cosim", venv, f"RECORDING={recording.name}", "PRESET=fast", "CONFIG=a.toml", "ARGS=--slots 4", cwd=tmp_path)
    assert done.stdout.splitlines()[:-1] == [
        *("cosim", str(recording)),
        *("--config", "a.toml", "--preset", "fast", "--slots", "4"),
    ]


def test_the_exit_code_of_evcot_shows(venv: str) -> None:
    done = make("cosim", venv)
    assert done.returncode == 2
    assert re.fullmatch(r"make: \*\*\* \[Makefile:\d+: cosim\] Error 2\n", done.stderr)


def test_nothing_is_installed_twice(venv: str) -> None:
    folder = Path(venv.removeprefix("VENV="))
    (folder / "bin" / "python").write_text("#!/bin/sh\nexit 1\n")  # pip would fail
    (folder / "bin" / "python").chmod(0o755)
    assert make("setup", venv).returncode == 0
    (folder / ".installed-run").unlink()
    assert make("setup", venv).returncode == 2


def test_what_the_machine_lacks_is_named_in_one_line(tmp_path: Path) -> None:
    tools = tmp_path / "bin"
    tools.mkdir()
    for tool in ("sh", "make"):
        found = shutil.which(tool)
        assert found is not None
        (tools / tool).symlink_to(found)
    (tools / "python3").write_text("#!/bin/sh\nexit 1\n")  # as an old Python answers
    (tools / "python3").chmod(0o755)
    done = make("cosim", f"VENV={tmp_path / 'venv'}", PATH=str(tools))
    assert done.stderr.splitlines()[0] == (
        "evcot: not found: g++ (install the g++ package), perl (install the perl package), "
        "Python 3.11 or newer (install the python3 and python3-venv packages)"
    )
    (tools / "python3.12").write_text('#!/bin/sh\ncase "$2" in *ensurepip*) exit 1;; esac\necho 3.12\n')
    (tools / "python3.12").chmod(0o755)
    done = make("cosim", f"VENV={tmp_path / 'venv'}", PATH=str(tools))
    assert "venv for Python 3.12 (install the python3.12-venv package)" in done.stderr.splitlines()[0]

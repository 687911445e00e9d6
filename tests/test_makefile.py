# SPDX-License-Identifier: Apache-2.0
"""The Makefile: what it lists, what it hands to evcot, and what it says when the machine lacks something."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
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


@pytest.mark.parametrize("target", ["setup", "cosim"])
def test_what_to_type_next_is_said_where_it_worked(target: str, venv: str) -> None:
    folder = Path(venv.removeprefix("VENV="))
    assert "next:" not in make("cosim", venv).stdout  # it failed
    (folder / "bin" / "evcot").write_text("#!/bin/sh\n")
    first, second = make(target, venv).stdout.splitlines()[-2:]
    assert first == f"next: . {folder}/bin/activate"
    assert second.split()[:3] == ["evcot", "info", "FILE;"]


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


ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "Containerfile").read_text()
LINES = re.sub(r"\\\n", "", "\n".join(line for line in TEXT.splitlines() if not line.startswith("#")) + "\n").splitlines()
MAKEFILE = (ROOT / "Makefile").read_text()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def instructions(name: str) -> list[str]:
    return [line.partition(" ")[2] for line in LINES if line.startswith(f"{name} ")]


def copied() -> set[str]:
    return {source for line in instructions("COPY") for source in line.split()[:-1]}


def test_the_tools_that_the_makefile_checks_for_are_installed() -> None:
    checked = re.search(r"for tool in (.*); do", MAKEFILE)
    assert checked is not None
    tools = set(re.findall(r":([a-z+]+)(?=[\s\"]|$)", checked[1]))
    assert tools == {"g++", "perl"}
    installed = re.search(r"apt-get install -y --no-install-recommends ([^&]+)&&", " ".join(instructions("RUN")))
    assert installed is not None
    assert set(installed[1].split()) == tools | {"make"}


def test_its_python_is_one_that_the_package_takes_and_says_so() -> None:
    (base,) = instructions("FROM")
    version = re.search(r"python:(3\.\d+)-slim$", base)
    assert version is not None
    least = PROJECT["project"]["requires-python"].removeprefix(">=")
    assert tuple(map(int, version[1].split("."))) >= tuple(map(int, least.split(".")))
    assert f"Programming Language :: Python :: {version[1]}" in PROJECT["project"]["classifiers"]


def test_its_targets_are_the_makefile_s() -> None:
    phony = re.findall(r"^\.PHONY: (.*)$", MAKEFILE, re.MULTILINE)[0].split()
    assert instructions("ENTRYPOINT") == ['["make"]']
    assert instructions("CMD") == ['["cosim"]']
    assert {"setup", "cosim"} <= set(phony)
    assert any(line.endswith("make setup") for line in instructions("RUN"))


def test_what_the_package_is_built_from_is_copied_and_is_there() -> None:
    hatch = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert "custom" in PROJECT["tool"]["hatch"]["metadata"]["hooks"]  # hatch_build.py, which reads README.md
    needed = {"Makefile", "pyproject.toml", "hatch_build.py", "README.md", *PROJECT["project"]["license-files"]}
    needed |= {package.partition("/")[0] for package in hatch["packages"]} | set(hatch["force-include"])
    assert copied() == needed
    assert all((ROOT / path).exists() for path in needed)


def test_only_what_is_copied_is_enough_for_setup(tmp_path: Path) -> None:
    """The Makefile finds all that its targets name in what is copied, up to the installation itself."""
    for path in copied():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).symlink_to(ROOT / path)
    done = subprocess.run(["make", "-n", "cosim"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "pip install" in done.stdout
    assert "evcot" in done.stdout


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

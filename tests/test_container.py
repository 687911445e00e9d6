# SPDX-License-Identifier: Apache-2.0
"""The Containerfile has what the Makefile asks for, and what the package is built from."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

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

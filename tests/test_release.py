# SPDX-License-Identifier: Apache-2.0
"""What a release says of itself: one version, one licence, and metadata that a package index shows."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

import evcot

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_index_is_told_what_it_is_for_whom_and_by_whom() -> None:
    assert PROJECT["authors"]
    assert len(PROJECT["keywords"]) >= 5
    classifiers = PROJECT["classifiers"]
    for start in ("Development Status", "Intended Audience", "Operating System", "Topic", "Typing :: Typed"):
        assert any(classifier.startswith(start) for classifier in classifiers), start
    assert not any(classifier.startswith("License ::") for classifier in classifiers)  # the expression says it
    lowest = PROJECT["requires-python"].removeprefix(">=")
    assert f"Programming Language :: Python :: {lowest}" in classifiers


def test_the_citation_is_of_this_version_and_licence() -> None:
    text = (ROOT / "CITATION.cff").read_text()
    fields = dict(re.findall(r"^([\w-]+): (.+)$", text, re.MULTILINE))
    assert fields["version"] == evcot.__version__
    assert fields["license"] == PROJECT["license"]
    assert "authors:" in text


def test_the_licence_is_there_as_every_tool_looks_for_it() -> None:
    assert (ROOT / "LICENSES" / f"{PROJECT['license']}.txt").read_text() == (ROOT / "LICENSE").read_text()
    assert PROJECT["license-files"] == ["LICENSE"]
    annotation = tomllib.loads((ROOT / "REUSE.toml").read_text())["annotations"][0]
    assert (annotation["path"], annotation["SPDX-License-Identifier"]) == ("**", PROJECT["license"])


@pytest.mark.skipif(shutil.which("reuse") is None, reason="needs reuse: make package has it")
def test_every_file_says_its_licence() -> None:
    done = subprocess.run(["reuse", "lint", "--lines"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout

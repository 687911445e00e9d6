# SPDX-License-Identifier: Apache-2.0
"""What a release says of itself: one version, one licence, and metadata that a package index shows."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType

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


@pytest.fixture(scope="module")
def hook() -> ModuleType:
    """hatch_build.py, which the build imports by its path."""
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TARGETS = re.compile(r'(?:\]\(|src=")([^)"\s]+)[)"]')


@pytest.mark.parametrize("repository", ["", "https://example.org/me/evcot"])
def test_no_link_and_no_picture_of_the_readme_leads_nowhere_on_an_index(hook: ModuleType, repository: str) -> None:
    text = hook.readme_for_index((ROOT / "README.md").read_text(), repository, evcot.__version__)
    targets = TARGETS.findall(text)
    assert all(re.match("https?:|#", target) for target in targets), targets
    assert len(targets) > 20 if repository else all(target.startswith(("#", "http")) for target in targets)
    assert text.count("\n## ") == (ROOT / "README.md").read_text().count("\n## ")
    for target in targets:
        if target.startswith(repository or "nothing"):
            path = target.removeprefix(repository).partition(f"v{evcot.__version__}/")[2].partition("#")[0]
            assert (ROOT / path).exists(), target
            assert ("/raw/" in target) == path.endswith((".png", ".gif"))


def test_links_of_every_kind(hook: ModuleType) -> None:
    text = '<img src="a.gif" width="9">\n\n*caption* ![b](b.png) [c](c.md#d) [e](#f) [g](https://h.i/j)\n'
    assert hook.readme_for_index(text, "", "1") == "*caption*  c [e](#f) [g](https://h.i/j)\n"
    assert hook.readme_for_index(text, "https://r/o/p", "1") == (
        '<img src="https://r/o/p/raw/v1/a.gif" width="9">\n\n*caption* ![b](https://r/o/p/raw/v1/b.png) '
        "[c](https://r/o/p/blob/v1/c.md#d) [e](#f) [g](https://h.i/j)\n"
    )
    assert hook.urls("") == {}
    assert hook.urls("https://r/o/p")["Issues"] == "https://r/o/p/issues"


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

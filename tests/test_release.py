# SPDX-License-Identifier: Apache-2.0
"""What a release says of itself: one version, one licence, and metadata that a package index shows."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
from hashlib import sha256
from pathlib import Path
from types import ModuleType

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import evcot
from support.testing import module_at

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
    return module_at(ROOT / "hatch_build.py")


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


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of the checkout in another folder, with other times and modes, and without what other tests are building."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True, check=False
    )
    if listed.returncode:
        pytest.skip("no git checkout")
    folder = tmp_path_factory.mktemp("copy") / "elsewhere"
    for name in filter(None, listed.stdout.decode().split("\0")):
        source, target = ROOT / name, folder / name
        if source.is_file():
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(source.read_bytes())
            target.chmod(source.stat().st_mode & ~0o077)
            os.utime(target, (1_000_000_000, 1_000_000_000))
    return folder


@pytest.mark.skipif(shutil.which("reuse") is None, reason="needs reuse: make package has it")
def test_every_file_says_its_licence(copy: Path) -> None:
    done = subprocess.run(["reuse", "lint", "--lines"], cwd=copy, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_two_builds_give_the_same_files(copy: Path, tmp_path: Path) -> None:
    """From another folder, with other times and modes of files, whatever the locale and the time zone."""

    def built(root: Path, name: str, **more: str) -> dict[str, str]:
        folder = tmp_path / name
        command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(root)]
        done = subprocess.run(command, env=os.environ | more, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return {path.name: sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}

    first = built(ROOT, "first")
    assert len(first) == 2
    assert built(copy, "second", TZ="Asia/Tokyo", LC_ALL="C") == first


def declared() -> dict[str, importlib.metadata.Distribution]:
    """The distributions here that an installation of evcot without extras brings: what it declares, and what they declare."""
    found: dict[str, importlib.metadata.Distribution] = {}
    waiting = [importlib.metadata.distribution("evcot")]
    while waiting:
        for text in waiting.pop().requires or []:
            requirement = Requirement(text)
            name = canonicalize_name(requirement.name)
            if name in found or (requirement.marker is not None and not requirement.marker.evaluate({"extra": ""})):
                continue
            found[name] = importlib.metadata.distribution(requirement.name)
            waiting.append(found[name])
    return found


def link_declared(folder: Path) -> None:
    """Link the modules of `declared` into a folder, as if they were installed there."""
    folder.mkdir()
    for distribution in declared().values():
        for top in {file.parts[0] for file in distribution.files or [] if file.parts[0] != ".."}:
            source = Path(str(distribution.locate_file(top)))
            if source.exists() and not (folder / top).exists():
                (folder / top).symlink_to(source)


def test_the_wheel_runs_in_an_environment_of_its_own_from_another_folder(tmp_path: Path) -> None:
    """As `make package`, but the declared dependencies are links to those installed here; nothing else is there."""

    def run(*command: str | Path, **more: str) -> str:
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | more
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path / "dist", ROOT)
    made = sorted((tmp_path / "dist").iterdir())
    assert [path.suffix for path in made] == [".whl", ".gz"]
    assert run(sys.executable, "-m", "twine", "check", "--strict", *made).count("PASSED") == 2
    home = tmp_path / "empty"
    venv.create(home, symlinks=True)
    packages = next(home.glob("lib/python3*/site-packages"))
    link_declared(tmp_path / "declared")
    (packages / "declared.pth").write_text(f"{tmp_path / 'declared'}\n")
    run(sys.executable, "-m", "pip", "--python", home, "install", "-qq", "--no-deps", "--no-index", made[0])
    evcot_command = home / "bin" / "evcot"
    assert run(evcot_command, "--version").split() == ["evcot", evcot.__version__]
    where = run(home / "bin" / "python", "-c", "import evcot, evcot_cosim; print(evcot.__file__, evcot_cosim.__file__)")
    assert [Path(path).is_relative_to(packages) for path in where.split()] == [True, True]
    run(evcot_command, "simulate", "boxes", "--duration", "0.1", "-o", "boxes.npz")
    assert "[cot]" in run(evcot_command, "cosim", "boxes.npz", "--preset", "discs", "--print-config")
    for source, target in (("hw/verilog", "verilog"), ("hw/include", "include"), ("cosim/evcot_cosim", ".")):
        files = (path for path in (ROOT / source).rglob("*") if path.is_file() and "__pycache__" not in path.parts)
        there = {path.relative_to(ROOT / source) for path in files}
        assert there
        assert all((packages / "evcot_cosim" / target / path).exists() for path in there)

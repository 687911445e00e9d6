# SPDX-License-Identifier: Apache-2.0
"""What the Markdown pages refer to exists: linked files, headings, paths of the repository, modules and their names."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("sw", "cosim", "hw", "tests", "docs", "benchmarks", "contrib")
PAGES = sorted([*ROOT.glob("*.md"), *(page for folder in FOLDERS for page in (ROOT / folder).rglob("*.md"))])

_FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
_CODE = re.compile(r"`([^`\n]+)`")
_LINK = re.compile(r"\]\(([^)\s]+)\)")
_IMAGE = re.compile(r'<img src="([^"]+)"')
_PATH = re.compile(rf"(?<![\w./-])(?:{'|'.join(FOLDERS)})/[\w./-]*[\w/]")
_MODULE = re.compile(r"(?<![\w./-])evcot(?:_cosim)?(?:\.[A-Za-z_]\w*)+")
_IMPORT = re.compile(r"^from (evcot(?:_cosim)?(?:\.\w+)*) import ([\w, ]+)$", re.MULTILINE)
_FILES = frozenset({"core", "gtkw", "html", "json", "md", "npz", "py", "sdc", "toml", "v", "vh", "xdc"})


def missing_links(page: Path, text: str) -> list[str]:
    """Relative links whose file is not there, or has no such heading."""
    missing = []
    plain = _CODE.sub("", _FENCE.sub("", text))
    for target in (*_LINK.findall(plain), *_IMAGE.findall(plain)):
        if re.match(r"\w+:", target):
            continue
        path, _, heading = target.partition("#")
        file = page.parent / path if path else page
        if not file.exists() or (heading and file.suffix == ".md" and heading not in headings(file)):
            missing.append(target)
    return missing


def missing_paths(_page: Path, text: str) -> list[str]:
    """Paths of the repository, in code or in prose, that do not exist; NAME and ROLE stand for a reader's own."""
    return [path for path in _PATH.findall(text) if not re.search("NAME|ROLE", path) and not (ROOT / path).exists()]


def missing_names(_page: Path, text: str) -> list[str]:
    """Dotted names below `evcot` and `evcot_cosim` that cannot be imported, and what an example imports in vain."""
    names = {name for name in _MODULE.findall(text) if name.rpartition(".")[2] not in _FILES}
    for module, imported in _IMPORT.findall(text):
        names |= {f"{module}.{name.partition(' as ')[0].strip()}" for name in imported.split(",")}
    return sorted(name for name in names if not is_importable(name))


@cache
def headings(page: Path) -> frozenset[str]:
    """The anchors that GitHub gives the headings of a page."""
    lines = re.findall(r"^#+ +(.+)$", _FENCE.sub("", page.read_text()), re.MULTILINE)
    return frozenset(re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines)


@cache
def is_importable(name: str) -> bool:
    """Whether a dotted name is a module, or an attribute of one, to any depth."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        module = ".".join(parts[:length])
        try:
            found: object = importlib.import_module(module)
        except ModuleNotFoundError as error:
            if error.name is None or not f"{module}.".startswith(f"{error.name}."):
                raise
            continue
        for part in parts[length:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


def test_what_pages_refer_to_exists() -> None:
    searches = (missing_links, missing_paths, missing_names)
    texts = {page: page.read_text() for page in PAGES}
    found = {
        (str(page.relative_to(ROOT)), thing)
        for page, text in texts.items()
        for search in searches
        for thing in search(page, text)
    }
    assert found == set()


@pytest.mark.parametrize(
    ("missing", "text"),
    [
        (missing_links, "[a page](no_such_page.md)"),
        (missing_links, '<img src="no_such_picture.png" width="9">'),
        (missing_links, "[a heading](algorithm.md#no-such-heading)"),
        (missing_paths, "see `sw/evcot/no_such_file.py`"),
        (missing_paths, "see cosim/evcot_cosim/no_such_folder/"),
        (missing_names, "`evcot.no_such_module.Thing`"),
        (missing_names, "`evcot.hardware.contract.NO_SUCH_NAME`"),
        (missing_names, "from evcot.hardware.contract import State, no_such_name"),
    ],
)
def test_what_is_not_there_is_found(missing: Callable[[Path, str], list[str]], text: str) -> None:
    assert len(missing(ROOT / "docs" / "page.md", text)) == 1

# SPDX-License-Identifier: Apache-2.0
"""Builds the documentation's site with Sphinx: `make docs`.

The pages are the repository's own Markdown, each where it lies there, so that links between them work in both. Staged with
them is whatever they link to; a link to a folder leads to a list of its files. The navigation is that of docs/README.md, and
a section for the pages that are made here: the modules, the mutations of the RTL, and the API reference by pdoc. The first page
has the report of a simulated highway in it, to try. At the end every link of the site is followed: one that leads nowhere is an
error.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from collections import deque
from collections.abc import Iterator
from functools import partial
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from evcot_cosim.pages.guides import notebook, scripts
from evcot_cosim.pages.modules import page as modules_page

__all__ = ["build", "dead_links", "navigation", "stage"]

_ROOT = Path(__file__).parents[2]
_BEGIN = ("README.md", "docs/README.md", "CONTRIBUTING.md", "CHANGELOG.md")
_MAIN = "README.md"  # the first page, and the one that names the others: of the repository, and of docs
_API = "extra/api"  # in what is staged; in the site it is api
_REFERENCE = "reference.md"
_REFERENCE_TEXT = """# API reference

Every module, class and function, made from their docstrings: <a href="api/evcot.html">evcot</a>,
<a href="api/evcot_cosim.html">evcot_cosim</a>.
"""
_MODULES, _MUTATIONS = "docs/modules.md", "docs/mutations.md"
_MUTATIONS_HEAD = """# Mutations of the RTL

Each row is the RTL with one mistake in it, and the tests that fail on it. `make mutations` makes every mistake, runs these
tests on the broken copy, and fails if a mistake goes unnoticed. The list is `tests/mutations.toml`.

| mutation | in | caught by |
|---|---|---|
"""
_EXAMPLE = "example/report.html"  # in the site; next to the first page
_EXAMPLE_COMMAND = "cosim highway --to 2500"
_EXAMPLE_TEXT = f"""## Try it here

<iframe class="example" src="{_EXAMPLE}" title="Report of a simulated highway" loading="lazy"></iframe>

*The report of `evcot {_EXAMPLE_COMMAND}`, 2.5 s of a simulated highway with default settings: hardware, software tracker and
the scene's truth. Press play, click an object, drag the timeline. <a href="{_EXAMPLE}">Open it in the whole window</a>.*"""
_STATIC = ("site.css",)
_FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)
_CODE = re.compile(r"`[^`\n]+`")
_LINK = re.compile(r"\]\(([^)\s]+)\)")
_IMAGE = re.compile(r'<img src="([^"]+)"')
_SECTION = re.compile(r"^## +(.+)$", re.MULTILINE)


def links(text: str) -> list[str]:
    """The relative links of a page, without headings."""
    plain = _CODE.sub("", _FENCE.sub("", text))
    found = (
        target.partition("#")[0] for target in (*_LINK.findall(plain), *_IMAGE.findall(plain)) if not re.match(r"\w+:", target)
    )
    return [target for target in found if target]


def stage(into: Path) -> None:
    """Write the pages, and what they link to, into a folder, each where it lies, or would lie, in the repository."""
    made = {_MODULES: modules_page, _MUTATIONS: _mutations_page}
    waiting, done = deque((*_BEGIN, *made)), {*_BEGIN, *made}
    while waiting:
        path = waiting.popleft()
        source, target = _ROOT / path, into / path
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            (target / "index.md").parent.mkdir(parents=True, exist_ok=True)
            (target / "index.md").write_text(_listing(path), encoding="utf-8")
            found = [f"{path}/{each.name}" for each in _files(source)]
        elif source.suffix == ".md":
            text = made[path]() if path in made else source.read_text(encoding="utf-8")
            target.write_text(_LINK.sub(partial(_to_index, page=source), text), encoding="utf-8")
            found = [_within(source.parent / link) for link in links(text)]
        else:
            shutil.copyfile(source, target)
            found = []
        for each in found:
            if each not in done:
                done.add(each)
                waiting.append(each)


def _within(path: Path) -> str:
    """A path relative to the repository, without `..`."""
    return path.resolve().relative_to(_ROOT).as_posix()


def _files(folder: Path) -> list[Path]:
    return sorted(each for each in folder.iterdir() if each.is_file())


def _listing(path: str) -> str:
    lines = [f"- [{each.name}]({each.name})" for each in _files(_ROOT / path)]
    return "\n".join([f"# {path}", "", *lines, ""])


def _to_index(link: re.Match[str], page: Path) -> str:
    """A link to a folder leads to its list."""
    target = link[1]
    is_folder = not re.match(r"\w+:|#", target) and (page.parent / target).is_dir()
    return f"]({target.rstrip('/')}/index.md)" if is_folder else link[0]


def navigation() -> dict[str, list[str]]:
    """The sections of docs/README.md, and the pages that their tables name."""
    text = (_ROOT / "docs" / _MAIN).read_text(encoding="utf-8")
    parts = _SECTION.split(text)
    return {
        title: [_within(_ROOT / "docs" / link) for link in links(body) if link.endswith(".md")]
        for title, body in zip(parts[1::2], parts[2::2], strict=True)
    }


def _toctrees() -> str:
    """The navigation as Sphinx wants it, for the end of the first page."""
    trees = {"": ["docs/README.md"], **navigation(), "Reference": [_MODULES, _MUTATIONS, _REFERENCE], "Project": [*_BEGIN[2:]]}
    return "\n".join(_toctree(title, pages) for title, pages in trees.items())


def _toctree(title: str, pages: list[str]) -> str:
    caption = [f":caption: {title}"] if title else []
    return "\n".join(["", "```{toctree}", ":hidden:", *caption, "", *pages, "```", ""])


def _mutations_page() -> str:
    listed = tomllib.loads((_ROOT / "tests" / "mutations.toml").read_text(encoding="utf-8"))
    rows = [
        f"| {one['meaning']} | `{file}` | {', '.join(f'`{test}`' for test in one['tests'])} |\n"
        for file, mistakes in listed.items()
        for one in mistakes
    ]
    return _MUTATIONS_HEAD + "".join(rows)


def with_example(text: str) -> str:
    """The first page with the example in it, after the film and its caption.

    Raises:
        ValueError: the page shows no film.
    """
    blocks = text.split("\n\n")
    film = next((i for i, block in enumerate(blocks) if block.startswith("<img ")), None)
    if film is None:
        raise ValueError(f"{_MAIN}: has no film: must have an <img> after which the example stands")
    captions = sum(block.startswith("*") for block in blocks[film + 1 : film + 2])
    blocks.insert(film + 1 + captions, _EXAMPLE_TEXT)
    return "\n\n".join(blocks)


_MOVED = '<!DOCTYPE html><meta charset="utf-8"><meta http-equiv="refresh" content="0; url=README.html"><title>evcot</title>\n'


class _Page(HTMLParser):
    """What a page links to, and the places in it that can be linked to."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name == "id" or (tag == "a" and name == "name"):
                self.places.add(value or "")


def dead_links(site: Path) -> Iterator[str]:
    """The links of a site that lead to no file of it, or to no place in that file, one line each."""
    pages: dict[Path, _Page] = {}
    for path in sorted(site.rglob("*.html")):
        pages[path.resolve()] = page = _Page()
        page.feed(path.read_text(encoding="utf-8"))
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            place = unquote(parts.fragment)
            if not target.is_file():
                yield f"{path.relative_to(site.resolve())}: {link}: no such file"
            elif place and target in pages and place not in pages[target].places and not place.startswith("__"):
                yield f"{path.relative_to(site.resolve())}: {link}: no such place"


def build(folder: Path) -> Path:
    """Build the site in a folder, which is emptied first; returns the folder of the site.

    Raises:
        SystemExit: a page or a link is wrong.
    """
    shutil.rmtree(folder, ignore_errors=True)
    source, site, here = folder / "source", folder / "site", Path(__file__).parent
    stage(source)
    first = source / _MAIN
    first.write_text(with_example(first.read_text(encoding="utf-8")) + _toctrees(), encoding="utf-8")
    _add_example(source, folder / "run")
    (source / _REFERENCE).write_text(_REFERENCE_TEXT, encoding="utf-8")
    _add_notebooks(source)
    (folder / "static").mkdir()
    for name in _STATIC:
        shutil.copyfile(here / name, folder / "static" / name)
    shutil.copyfile(here / "conf.py", source / "conf.py")
    _run("pdoc", "--docformat", "google", "-o", str(source / _API), "evcot", "evcot_cosim")
    _run("sphinx", "-b", "html", "-W", "--keep-going", "-q", "-D", "root_doc=README", str(source), str(site))
    (site / "index.html").write_text(_MOVED, encoding="utf-8")
    dead = list(dead_links(site))
    if dead:
        sys.exit("\n".join(["docs: links that lead nowhere:", *dead]))
    return site


def _add_notebooks(source: Path) -> None:
    """Offer every guide as a notebook, next to its page."""
    folder = source / "extra" / "docs" / "guides"  # in the site it is docs/guides
    folder.mkdir(parents=True)
    for script in scripts():
        (folder / f"{script.stem}.ipynb").write_text(notebook(script.read_text(encoding="utf-8")), encoding="utf-8")
        with (source / "docs" / "guides" / f"{script.stem}.md").open("a", encoding="utf-8") as page:
            page.write(f'\n<a href="{script.stem}.ipynb" download>Download this guide as a Jupyter notebook</a>\n')


def _add_example(source: Path, run: Path) -> None:
    """Simulate the scene of the first page and put its report next to that page."""
    _run("evcot", *_EXAMPLE_COMMAND.split(), "--no-waves", "--quiet", "-o", str(run))
    target = source / "extra" / _EXAMPLE
    target.parent.mkdir(parents=True)
    _run("evcot", "report", str(run), "-o", str(target), "--quiet")  # without links to the run's other files


def _run(module: str, *arguments: str) -> None:
    done = subprocess.run([sys.executable, "-m", module, *arguments], check=False)
    if done.returncode:
        sys.exit(f"docs: {module} failed")


if __name__ == "__main__":
    print(build(_ROOT / "build" / "docs") / "index.html")

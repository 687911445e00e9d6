# SPDX-License-Identifier: Apache-2.0
"""The documentation's site: every page stands in its navigation, links work as in the repository, and dead ones are found."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import pytest

from support.testing import exhaustive, module_at

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "docs" / "site" / "build_site.py"


@pytest.fixture(scope="module")
def site() -> ModuleType:
    return module_at(SCRIPT)


@pytest.fixture(scope="module")
def staged(site: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("staged")
    site.stage(folder)
    return folder


def test_every_page_stands_in_the_navigation(site: ModuleType) -> None:
    named = [page for pages in site.navigation().values() for page in pages]
    assert len(named) == len(set(named))
    pages = {path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").rglob("*.md")} - {"docs/README.md"}
    assert pages <= set(named)
    assert all((ROOT / page).is_file() for page in named)


def test_all_pages_are_staged_with_what_they_link_to(site: ModuleType, staged: Path) -> None:
    for page in (ROOT / "docs").rglob("*.md"):
        assert (staged / page.relative_to(ROOT)).is_file()
    for page in staged.rglob("*.md"):
        for link in site.links(page.read_text()):
            assert (page.parent / link).is_file(), f"{page.relative_to(staged)}: {link}"


def test_a_link_to_a_folder_leads_to_a_list_of_its_files(staged: Path) -> None:
    text = (staged / "hw" / "verilog" / "math" / "index.md").read_text()
    files = sorted(path.name for path in (ROOT / "hw" / "verilog" / "math").iterdir() if path.is_file())
    assert text.startswith("# hw/verilog/math\n")
    assert all(f"- [{name}]({name})" in text for name in files)
    assert "(verilog/math/index.md)" in (staged / "hw" / "README.md").read_text()


def test_links_in_examples_are_no_links(site: ModuleType) -> None:
    assert site.links("[a](a.md#b) `[c](c.md)` [d](https://d) [e](#e)\n```\n[f](f.md)\n```\n[g](../g.v)") == ["a.md", "../g.v"]
    assert site.links('<img src="a.gif" width="480">') == ["a.gif"]


PAGE = '<html><body id="top"><a name="old"></a><img src="a.png"><a href="{}">x</a></body></html>'


@pytest.mark.parametrize("link", ["b.html", "b.html#top", "b.html#old", "#top", "sub", "https://none.invalid/x", "mailto:a@b"])
def test_links_that_lead_somewhere(site: ModuleType, tmp_path: Path, link: str) -> None:
    make_site(tmp_path, link)
    assert list(site.dead_links(tmp_path)) == []


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ("c.html", "no such file"),
        ("b.html#none", "no such place"),
        ("#none", "no such place"),
        ("sub/none.html", "no such file"),
        ("/b.html", "no such file"),
    ],
)
def test_links_that_lead_nowhere_are_found(site: ModuleType, tmp_path: Path, link: str, why: str) -> None:
    make_site(tmp_path, link)
    assert list(site.dead_links(tmp_path)) == [f"a.html: {link}: {why}"]


def make_site(folder: Path, link: str) -> None:
    (folder / "sub").mkdir()
    (folder / "a.png").touch()
    (folder / "sub" / "index.html").write_text("<p>")
    (folder / "b.html").write_text(PAGE.format("a.html"))
    (folder / "a.html").write_text(PAGE.format(link))


def test_the_example_stands_after_the_film_and_its_caption(site: ModuleType) -> None:
    blocks = site.with_example('# a\n\n<img src="b.gif">\n\n*c*\n\nd').split("\n\n")
    assert blocks[3].startswith("## Try it here")
    assert (blocks[2], blocks[-1]) == ("*c*", "d")
    assert site.with_example('<img src="b.gif">\n\nd').split("\n\n")[1].startswith("## Try it here")
    with pytest.raises(ValueError, match=r"^README\.md: has no film"):
        site.with_example("# a\n\nb")


@exhaustive  # `.ci/run` builds the site, and follows its links, with `make docs`
def test_the_whole_site_has_search_and_no_dead_link(site: ModuleType, tmp_path: Path) -> None:
    built = site.build(tmp_path / "docs")
    index = (built / "searchindex.js").read_text()
    assert all(f'"docs/{page.stem}"' in index for page in (ROOT / "docs").glob("*.md"))
    assert (built / "api" / "evcot.html").is_file()
    for guide in (ROOT / "docs" / "guides").glob("*.py"):
        assert f'href="{guide.stem}.ipynb"' in (built / "docs" / "guides" / f"{guide.stem}.html").read_text()
        assert json.loads((built / "docs" / "guides" / f"{guide.stem}.ipynb").read_text())["nbformat"] == 4
    first = (built / "README.html").read_text()
    assert first.index("traffic.gif") < first.index('src="example/report.html"')
    report = (built / "example" / "report.html").read_text()
    assert len(report) < 4_000_000
    assert "highway" in report
    for page in built.rglob("*.html"):
        if built / "api" not in page.parents:
            assert '<script src="http' not in page.read_text(), "nothing is fetched from elsewhere"

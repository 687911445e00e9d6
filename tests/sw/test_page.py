# SPDX-License-Identifier: Apache-2.0
"""A page in a frame, and as a file."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest

from evcot.errors import OutputError
from evcot.page import Page

PAGE = Page('a "drive" & <more>', "<!doctype html>\n<p title=\"x\">µ &amp; 'y'</p>", 480)


class Frames(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[dict[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append({"tag": tag, **dict(attrs)})


def test_a_notebook_gets_one_frame_with_the_whole_page_that_reaches_nothing_else() -> None:
    frames = Frames()
    frames.feed(PAGE._repr_html_())
    (frame,) = frames.found
    assert frame["tag"] == "iframe"
    assert frame["srcdoc"] == PAGE.text
    assert frame["title"] == PAGE.name
    assert frame["sandbox"] == "allow-scripts"
    assert "height: 480px" in str(frame["style"])


def test_without_a_browser_the_page_is_one_sentence_that_says_how_to_see_it() -> None:
    said = "a \"drive\" & <more>, 0.0 MB: a notebook in a browser shows it; save('page.html') writes it for any browser"
    assert repr(PAGE) == f"<Page of {said}>"


def test_a_saved_page_is_the_page_and_never_replaces_a_file(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    PAGE.save(path)
    assert path.read_text(encoding="utf-8") == PAGE.text
    path.write_text("mine")
    with pytest.raises(OutputError, match="exists"):
        PAGE.save(path)
    assert path.read_text() == "mine"
    PAGE.save(path, force=True)
    assert path.read_text(encoding="utf-8") == PAGE.text

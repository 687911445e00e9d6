# SPDX-License-Identifier: Apache-2.0
"""The page in a real browser: it draws, it answers, it comes back, and a phone can show it."""

from __future__ import annotations

import io
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageColor

from evcot_cosim.live.server import Server
from evcot_cosim.live.session import Session

from .stories import SENSOR, EveryTenth, Played, events, wait_until

pytest.importorskip("websockets", reason="websockets is not installed")

HELLO = {"name": "a drive", "engine": "rct", "preset": "plain", "width": SENSOR[0], "height": SENSOR[1], "speed": 1.0}


def started() -> Session:
    """Events at (20, 10), ON and OFF, and a cluster there, for as long as anybody wants."""
    parts = [events(*(10_000 * i + np.arange(0, 10_000, 500)).tolist(), x=20, y=10) for i in range(100_000)]
    session = Session(Played(parts, lambda _: time.sleep(0.01)), EveryTenth())
    session.start()
    return session


@pytest.fixture
def server() -> Iterator[Server]:
    session = started()
    with Server(session, HELLO, port=0) as server:
        yield server
    session.stop()


class Page:
    """The page, and all that its console said."""

    def __init__(self, browser: Any, url: str, **context: Any) -> None:
        self.context = browser.new_context(**context)
        self.page = self.context.new_page()
        self.said: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.goto(url)
        wait_until(lambda: self.page.query_selector("#rows tr") is not None, 20)

    def text(self, selector: str) -> str:
        return str(self.page.inner_text(selector))

    def shows(self, x: float, y: float, colour: str) -> bool:
        """Whether the picture has a colour at a place of the sensor, give or take two pixels of the screen."""
        with Image.open(io.BytesIO(self.page.query_selector("#stage").screenshot())) as image:
            scale = min(image.width / SENSOR[0], image.height / SENSOR[1])
            left = image.width / 2 + (x + 0.5 - SENSOR[0] / 2) * scale
            top = image.height / 2 + (y + 0.5 - SENSOR[1] / 2) * scale
            near = np.asarray(image.convert("RGB"))[round(top) - 2 : round(top) + 3, round(left) - 2 : round(left) + 3]
        return bool((np.abs(near.astype(int) - ImageColor.getrgb(colour)).max(axis=2) < 8).any())


@pytest.fixture
def open_page(browser: Any, server: Server) -> Iterator[Any]:
    pages: list[Page] = []

    def opened(**context: Any) -> Page:
        pages.append(Page(browser, server.url, **context))
        return pages[-1]

    yield opened
    for page in pages:
        page.context.close()
        assert page.said == []


def test_it_draws_events_and_clusters_and_tells_figures(open_page: Any, server: Server) -> None:
    page = open_page(color_scheme="dark")
    assert (page.text("#name"), page.text("#what")) == ("a drive", "rct, plain · 64×48 px")
    wait_until(lambda: page.text("#drawn_ms").endswith("ms"), 20)
    assert page.text("#state") == "live"
    assert page.text("#clusters") == "1"
    assert page.text("#dropped") == "0"
    assert page.text("#slipped_s") == "0.0 s"
    assert page.text("#rows td:nth-child(3)") == "20"
    assert page.shows(40, 40, "#0b0e12")
    assert not page.shows(20, 10, "#0b0e12"), "events"
    assert page.shows(16.5, 10, "#56b4e9"), "the window's edge, 3 pixels and a half left of the centre"


def test_layers_can_be_switched_off(open_page: Any) -> None:
    page = open_page(color_scheme="light")
    assert page.shows(16.5, 10, "#0068a3")
    page.page.uncheck("input[name=boxes]")
    wait_until(lambda: not page.shows(16.5, 10, "#0068a3"))
    assert page.shows(16.5, 10, "#ffffff")


def test_a_pause_holds_the_picture_and_not_the_figures(open_page: Any) -> None:
    page = open_page()
    page.page.click("#pause")
    assert page.text("#pause") == "Resume"
    held = page.page.evaluate("document.querySelector('#stage').toDataURL()")
    before = page.text("#recording_s")
    wait_until(lambda: page.text("#recording_s") != before, 20)
    assert page.page.evaluate("document.querySelector('#stage').toDataURL()") == held
    page.page.click("#pause")
    assert page.text("#pause") == "Pause"


@pytest.mark.parametrize("width", [390, 800, 1280])
def test_no_width_makes_it_scroll_sideways_and_every_control_has_a_name(open_page: Any, width: int) -> None:
    page = open_page(viewport={"width": width, "height": 844}, is_mobile=width < 500, has_touch=width < 500)
    assert page.page.evaluate("document.documentElement.scrollWidth") <= width
    unnamed = """[...document.querySelectorAll("button, select, input")].filter((control) =>
      !control.textContent.trim() && !control.closest("label")?.textContent.trim()).length"""
    assert page.page.evaluate(unnamed) == 0
    canvas = page.page.query_selector("#stage").bounding_box()
    assert canvas["width"] > 0.5 * width
    assert canvas["width"] / canvas["height"] == pytest.approx(SENSOR[0] / SENSOR[1], rel=0.5)


def test_it_comes_back_when_the_server_does(browser: Any) -> None:
    session = started()
    with Server(session, HELLO, port=0) as server:
        page = Page(browser, server.url)
        port = int(server.url.rstrip("/").rsplit(":", 1)[1])
    session.stop()
    page.page.wait_for_selector("#state[data-state=ended]", timeout=20_000)
    page.page.wait_for_timeout(1_500)  # it has tried to connect again since
    assert page.text("#state").startswith("ended")
    assert page.text("#tracks") != "–"
    session = started()
    with Server(session, {**HELLO, "name": "another drive"}, port):
        page.page.wait_for_selector("#state[data-state=live]", timeout=20_000)
        assert page.text("#name") == "another drive"
        page.context.close()
    session.stop()


def test_a_connection_that_breaks_is_no_end_and_is_made_again(browser: Any, server: Server) -> None:
    page = browser.new_page()
    page.add_init_script(
        "const Plain = WebSocket; window.sockets = []; window.states = [];"
        "window.WebSocket = class extends Plain { constructor(...of) { super(...of); window.sockets.push(this); } };"
    )
    page.goto(server.url)
    page.wait_for_selector("#state[data-state=live]", timeout=20_000)
    page.evaluate("""() => {
      const place = document.querySelector('#state');
      new MutationObserver(() => window.states.push(place.textContent)).observe(place, { childList: true });
      window.sockets[0].close();
    }""")
    page.wait_for_function("() => window.sockets.length === 2", timeout=20_000)
    page.wait_for_selector("#state[data-state=live]", timeout=20_000)
    assert page.evaluate("() => window.states")[0] == "no connection, trying again"
    page.close()

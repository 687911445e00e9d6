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

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.tracks.tracking import TrackerOutput
from evcot_cosim.live.player import Begin, Player, Run, Wish
from evcot_cosim.live.server import Server
from evcot_cosim.live.session import Session
from evcot_cosim.live.tracker_thread import Beside
from support.logs import verdicts_of
from support.texts import hard_to_read, texts_of

from .stories import HELLO, SENSOR, Classified, EveryTenth, Played, events, playing, wait_until

pytest.importorskip("websockets", reason="websockets is not installed")


def blinking(parts: int = 100_000) -> Iterator[Events]:
    """Events at (20, 10), ON and OFF: parts of 10 ms, made one at a time."""
    for i in range(parts):
        yield events(*(10_000 * i + np.arange(0, 10_000, 500)).tolist(), x=20, y=10)


def started(hello: dict[str, object] = HELLO) -> Player:
    """A player with one cluster, at events that go on for longer than any test."""
    player = playing(Session(Played(blinking(), lambda _: time.sleep(0.01)), EveryTenth(), wait_s=10.0), hello)
    player.start()
    return player


@pytest.fixture
def server(request: pytest.FixtureRequest) -> Iterator[Server]:
    player = started({**HELLO, **getattr(request, "param", {})})
    with Server(player, port=0) as server:
        yield server
    player.stop()


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
        with Image.open(io.BytesIO(self.page.query_selector("#picture").screenshot())) as image:
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
    assert (page.text("#title"), page.text("#what")) == ("a drive", "rct, plain · 64×48 px")
    wait_until(lambda: page.text("#drawn_ms").endswith("ms"), 20)
    assert page.text("#state") == "live"
    assert page.text("#clusters") == "1"
    assert page.text("#dropped") == "0"
    assert page.text("#slipped_s") == "0.0 s"
    assert page.text("#rows td:nth-child(4)") == "20"
    assert not page.page.is_visible("#rows td:nth-child(2)"), "no classes"
    assert page.shows(40, 40, "#07090c")
    assert not page.shows(20, 10, "#07090c"), "events"
    assert page.shows(16.5, 10, "#ff9b47"), "the window's edge, 3 pixels and a half left of the centre"


DRAWN_TEXTS = """() => {
  const { prototype } = CanvasRenderingContext2D; const { fillText } = prototype; const texts = [];
  prototype.fillText = function (text, ...more) { texts.push(text); return fillText.call(this, text, ...more); };
  document.getElementById("rail").dispatchEvent(new Event("input")); prototype.fillText = fillText; return texts; }"""


class Asked(Classified):
    """A tracker that says the classes that it is told to say."""

    def __init__(self, said: list[int]) -> None:
        super().__init__()
        self._said = said

    def feed(self, some: Events) -> TrackerOutput:
        output = EveryTenth.feed(self, some)
        self._verdicts = verdicts_of(*((int(some.t_us[-1]), 0, self._said.pop()) for _ in self._said[:1]))
        return output


def test_classes_are_in_the_table_and_on_the_boxes(browser: Any) -> None:
    said: list[int] = []
    player = playing(Session(Played(blinking(), lambda _: time.sleep(0.01)), Asked(said), wait_s=10.0))
    player.start()
    try:
        with Server(player, port=0) as server:
            page = Page(browser, server.url)
            assert page.page.is_visible("#tracked th:nth-child(2)")
            for class_ids, label in (([], "–"), ([3], "cup"), ([-1], "?")):
                said += class_ids
                wait_until(lambda label=label: page.text("#rows td:nth-child(2)") == label, 20)  # type: ignore[misc]
                assert page.page.evaluate(DRAWN_TEXTS) == ["0", label][: 1 + len(class_ids)]
            page.context.close()
    finally:
        player.stop()
    assert page.said == []


def test_layers_can_be_switched_off(open_page: Any) -> None:
    page = open_page(color_scheme="light")
    assert page.shows(16.5, 10, "#a84a00")
    page.page.uncheck("input[name=boxes]")
    wait_until(lambda: not page.shows(16.5, 10, "#a84a00"))
    assert page.shows(16.5, 10, "#ffffff")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_is_large_and_has_contrast(open_page: Any, scheme: str) -> None:
    page = open_page(color_scheme=scheme, viewport={"width": 1440, "height": 900})
    assert len(texts_of(page.page)) > 30
    assert hard_to_read(page.page) == []


def test_keys_are_those_of_the_report(open_page: Any) -> None:
    page = open_page(color_scheme="light")
    page.page.keyboard.press("Space")
    assert page.text("#pause") == "Resume"
    page.page.keyboard.press("t")
    assert page.page.evaluate("document.documentElement.dataset.theme") == "light"
    before = page.page.input_value("#rail [name=fade]")
    page.page.keyboard.press("]")
    assert float(page.page.input_value("#rail [name=fade]")) > float(before)


def test_a_pause_holds_the_picture_and_not_the_figures(open_page: Any) -> None:
    page = open_page()
    page.page.click("#pause")
    assert page.text("#pause") == "Resume"
    held = page.page.evaluate("document.querySelector('#picture').toDataURL()")
    before = page.text("#recording_s")
    wait_until(lambda: page.text("#recording_s") != before, 20)
    assert page.page.evaluate("document.querySelector('#picture').toDataURL()") == held
    page.page.click("#pause")
    assert page.text("#pause") == "Pause"


@pytest.mark.parametrize("server", [{"seekable": True}], indirect=True)
@pytest.mark.parametrize("width", [390, 800, 1280])
def test_no_width_makes_it_scroll_sideways_and_every_control_has_a_name(open_page: Any, width: int) -> None:
    page = open_page(viewport={"width": width, "height": 844}, is_mobile=width < 500, has_touch=width < 500)
    assert page.page.evaluate("document.documentElement.scrollWidth") <= width
    unnamed = """[...document.querySelectorAll("button, select, input")].filter((control) =>
      !control.textContent.trim() && !control.ariaLabel && !control.closest("label")?.textContent.trim()).length"""
    assert page.page.evaluate(unnamed) == 0
    canvas = page.page.query_selector("#picture").bounding_box()
    assert canvas["width"] > 0.5 * width
    assert canvas["width"] / canvas["height"] == pytest.approx(SENSOR[0] / SENSOR[1], rel=0.5)


def test_it_comes_back_when_the_server_does(browser: Any) -> None:
    player = started()
    with Server(player, port=0) as server:
        page = Page(browser, server.url)
        port = int(server.url.rstrip("/").rsplit(":", 1)[1])
    player.stop()
    page.page.wait_for_selector("#state[data-state=ended]", timeout=20_000)
    page.page.wait_for_timeout(1_500)  # it has tried to connect again since
    assert page.text("#state").startswith("ended")
    assert page.text("#tracks") != "–"
    player = started({**HELLO, "name": "another drive"})
    with Server(player, port):
        page.page.wait_for_selector("#state[data-state=live]", timeout=20_000)
        assert page.text("#title") == "another drive"
        page.context.close()
    player.stop()


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


class Studio:
    """Sessions as a page wishes them, and what was wished."""

    def __init__(self, parts: int) -> None:
        self.asked: list[Wish] = []
        self._parts = parts

    def prepare(self, wish: Wish) -> Begin:
        if wish.preset == "discs":
            raise ConfigError("preset discs: is not today's")
        self.asked.append(wish)
        source = Seekable(blinking(self._parts), lambda _: time.sleep(0.01))
        beside = [Beside("hardware", "RTL in simulation", Elsewhere())] if wish.hardware else []
        hello = {**HELLO, "engine": wish.engine, "preset": wish.preset, "seekable": True}
        hello["lanes"] = [wish.engine, *(each.name for each in beside)]
        hello["kinds"] = ["model" if wish.engine == "cot_motion" else "software", *(each.name for each in beside)]
        return lambda: Run(Session(source, EveryTenth(), beside=beside), hello)


class Seekable(Played):
    """Says where it is, as a file does."""

    place_s = 1.5
    length_s = 4.0


class Elsewhere(EveryTenth):
    """Its cluster is 20 pixels to the right."""

    def feed(self, some: Events) -> TrackerOutput:
        records, owner = super().feed(some)
        records["x"] += 20
        return records, owner


@pytest.fixture
def studio(request: pytest.FixtureRequest) -> Studio:
    return Studio(getattr(request, "param", 100_000))


@pytest.fixture
def chosen(browser: Any, studio: Studio) -> Iterator[Page]:
    """A page that may choose what is played."""
    player = Player(studio.prepare, Wish("rct", "plain"))
    player.start()
    with Server(player, port=0) as server:
        page = Page(browser, server.url, color_scheme="dark")
        yield page
        page.context.close()
        assert page.said == []
    player.stop()


def test_engine_and_preset_are_chosen_on_the_page(chosen: Page, studio: Studio) -> None:
    page = chosen.page
    assert page.input_value("select[name=engine]") == "rct"
    assert page.input_value("select[name=preset]") == "plain"
    page.select_option("select[name=engine]", "adaptive")
    wait_until(lambda: chosen.text("#what").startswith("adaptive, default preset"), 20)
    assert studio.asked[-1] == Wish("adaptive", None, False, 1.5), "it goes on from where it is"
    page.select_option("select[name=preset]", "auto")
    wait_until(lambda: chosen.text("#what").startswith("adaptive, auto"), 20)
    assert page.locator("select[name=preset] option").all_text_contents() == ["default", "auto"]


def test_hardware_is_shown_beside_software(chosen: Page, studio: Studio) -> None:
    assert not chosen.page.is_visible("#beside")
    assert not chosen.shows(43.5, 10, "#56b4e9")
    chosen.page.check("input[name=hardware]")
    wait_until(lambda: chosen.page.is_visible("#beside") and chosen.text("#beside_clusters") == "1", 20)
    assert studio.asked[-1].hardware
    assert chosen.text("#beside_about") == "RTL in simulation"
    assert chosen.text("#lanes").split() == ["rct", "hardware"]
    wait_until(lambda: chosen.page.locator("#rows tr").count() == 2, 20)
    assert chosen.shows(43.5, 10, "#56b4e9"), "its right edge, 3 pixels and a half from the centre at 40"
    assert chosen.shows(16.5, 10, "#ff9b47"), "the software's left edge"


def test_a_golden_model_has_a_colour_of_its_own(chosen: Page) -> None:
    """A lighter shade of the hardware's, dashed, as in the report; orange is software."""
    border = "(one) => [getComputedStyle(one).borderTopColor, getComputedStyle(one).borderTopStyle]"
    assert chosen.page.locator("#lanes i").first.evaluate(border) == ["rgb(255, 155, 71)", "dashed"]
    chosen.page.select_option("select[name=engine]", "cot_motion")
    wait_until(lambda: chosen.text("#what").startswith("cot_motion"), 20)
    assert chosen.page.locator("#lanes i").first.evaluate(border) == ["rgb(165, 215, 245)", "dashed"]


def test_a_window_of_900_pixels_shows_all_of_it_with_hardware(chosen: Page) -> None:
    chosen.page.set_viewport_size({"width": 1440, "height": 900})
    chosen.page.check("input[name=hardware]")
    wait_until(lambda: chosen.page.is_visible("#beside") and chosen.page.locator("#rows tr").count() == 2, 20)
    assert chosen.page.evaluate("document.documentElement.scrollHeight") == 900
    assert (
        chosen.page.evaluate(
            "(({ scrollHeight, clientHeight }) => scrollHeight - clientHeight)(document.querySelector('#contents'))"
        )
        == 0
    )
    assert chosen.page.query_selector("#picture").bounding_box()["height"] > 600
    chosen.page.evaluate(
        "document.querySelector('#contents').insertAdjacentHTML('beforeend', '<div style=height:900px></div>')"
    )
    assert chosen.page.evaluate("document.documentElement.scrollHeight") == 900, "a long table scrolls by itself"


def test_a_place_is_sought_and_replayed(chosen: Page, studio: Studio) -> None:
    wait_until(lambda: chosen.text("#place") == "1.5 s of 4.0 s", 20)
    chosen.page.fill("input[name=place]", "2.5")
    chosen.page.dispatch_event("input[name=place]", "change")
    wait_until(lambda: studio.asked[-1] == Wish("rct", "plain", False, 2.5), 20)
    chosen.page.click("#replay")
    wait_until(lambda: studio.asked[-1] == Wish("rct", "plain", False, 0.0), 20)


@pytest.mark.parametrize("studio", [300], indirect=True)
def test_at_the_end_of_a_file_it_says_so_and_offers_a_replay(chosen: Page, studio: Studio) -> None:
    chosen.page.wait_for_selector("#state[data-state=ended]", timeout=20_000)
    assert chosen.text("#state") == "ended"
    chosen.page.click("#replay")
    chosen.page.wait_for_selector("#state[data-state=live]", timeout=20_000)
    assert [wish.at_s for wish in studio.asked] == [0.0, 0.0]


def test_what_cannot_be_chosen_is_said(chosen: Page, studio: Studio) -> None:
    chosen.page.select_option("select[name=preset]", "discs")
    wait_until(lambda: chosen.text("#note") == "preset discs: is not today's", 20)
    assert chosen.text("#state") == "live"
    assert len(studio.asked) == 1


def test_a_run_that_is_kept_has_its_choice_shown_and_locked(browser: Any) -> None:
    session = Session(Played([events(*range(0, 10_000, 500), x=20, y=10)] * 1), EveryTenth())
    player = playing(session, fixed="--save keeps one run")
    player.start()
    with Server(player, port=0) as server:
        page = browser.new_page()
        page.goto(server.url)
        wait_until(lambda: page.inner_text("#note") == "--save keeps one run", 20)
        assert page.locator("#choice :enabled").count() == 0
        page.close()
    player.stop()

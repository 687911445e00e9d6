# SPDX-License-Identifier: Apache-2.0
"""The report as a person uses it, in a real browser: every test also checks that nothing was complained of or fetched."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from evcot.events import Events, Recording
from evcot.tracks.compare import compare
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.lockstep.verdict import verdict_of
from evcot_cosim.report import Material, Side, write_report
from evcot_cosim.report.page import render
from evcot_cosim.report.part_pages import write_overview
from support.logs import verdicts_of
from support.testing import module_at
from support.texts import hard_to_read, texts_of

from .conftest import Opened, mismatch_at, summary_of

BLUE, ORANGE = (0, 104, 163), (168, 74, 0)  # hardware, software, in light colours
SIZES = ((1280, 720), (1440, 900), (390, 844))
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


def coloured(pixels: Any, colour: tuple[int, int, int], reach: int = 40) -> int:
    """How many pixels have about a colour."""
    return int((np.abs(pixels - np.array(colour)).max(axis=2) < reach).sum())


def rows(opened: Opened) -> list[list[str]]:
    """The cells of the list of objects."""
    return [text.split("\t") for text in opened.page.locator("#objects tbody tr").all_inner_texts()]


def place_of(opened: Opened, number: int) -> tuple[float, float]:
    """Where the middle of an object is on the page."""
    script = """(number) => { const { stage, objects, clock } = report; const lives = objects.at(clock.now).get(number);
      const box = objects.boxes(lives, clock.now).find(Boolean); const at = stage.canvas.getBoundingClientRect();
      return [at.left + ((box.x - stage.centre.x) * stage.scale + stage.canvas.width / 2) / stage.ratio,
        at.top + ((box.y - stage.centre.y) * stage.scale + stage.canvas.height / 2) / stage.ratio]; }"""
    x, y = opened.ask(script, number)
    return float(x), float(y)


def free_object(opened: Opened) -> int:
    """An object that no smaller box covers in its middle."""
    for number in opened.ask("() => [...report.objects.at(report.clock.now).keys()]"):
        x, y = place_of(opened, number)
        opened.page.mouse.move(x, y)
        if f"object {number}" in opened.page.locator("#read").inner_text().split("\n"):
            return int(number)
    raise AssertionError("every object is covered")


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_picture_play_button_and_timeline_are_on_one_screen(browser: Any, report: Path, width: int, height: int) -> None:
    context = PHONE if width < 500 else {"viewport": {"width": width, "height": height}}
    opened = Opened(browser, report, **context)
    for selector in ("#picture", "#play", "#timeline", "#tabs"):
        box = opened.page.locator(selector).bounding_box()
        assert box is not None
        assert box["y"] >= 0, selector
        assert box["y"] + box["height"] <= height + 0.5, selector
        assert box["x"] + box["width"] <= width + 0.5, selector
    assert opened.ask("() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]") == [width, height]
    assert opened.complaints == []
    opened.context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("width", "height"), SIZES[1:])
def test_every_text_is_large_and_has_contrast(browser: Any, report: Path, width: int, height: int, scheme: str) -> None:
    context = PHONE if width < 500 else {"viewport": {"width": width, "height": height}}
    opened = Opened(browser, report, "#see=1", color_scheme=scheme, **context)
    seen = 0
    for tab in opened.page.locator("[role=tab]").all():
        tab.click()
        seen += len(texts_of(opened.page))
        assert hard_to_read(opened.page) == []
    assert seen > 300
    for menu in ("check-1", "compare", *(["keys"] if width > 500 else [])):
        opened.page.locator(f"[popovertarget={menu}]").click()
        assert hard_to_read(opened.page) == []
        opened.page.keyboard.press("Escape")
    assert opened.complaints == []
    opened.context.close()


def test_it_opens_at_a_merge_with_something_to_see(opened: Opened, material: Material) -> None:
    assert opened.now_us in material.sides[0].log.records["t_us"] - material.span_us[0]
    pixels = opened.drawn()
    assert coloured(pixels, BLUE) > 500
    assert coloured(pixels, ORANGE) > 300
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20  # events in fading colours


def test_it_plays_pauses_and_stops_at_the_end(opened: Opened) -> None:
    before = opened.now_us
    opened.page.get_by_role("button", name="Play").click()
    opened.page.wait_for_function("before => report.clock.now > before + 1000", arg=before)
    opened.page.get_by_role("button", name="Pause").click()
    stood = opened.now_us
    opened.page.wait_for_timeout(100)
    assert opened.now_us == stood
    assert opened.page.locator("#said").inner_text() == f"Paused at {stood / 1e6:.3f} s"
    opened.page.get_by_label("Speed").select_option("4.0")
    opened.page.locator("#speed").evaluate("(one) => one.blur()")
    opened.page.keyboard.press("Space")
    opened.page.wait_for_function("() => !report.clock.playing && report.clock.now === report.clock.duration", timeout=20_000)


def test_going_back_shows_what_playing_there_shows(opened: Opened) -> None:
    opened.ask("() => report.clock.seek(200000)")
    for step in range(1, 11):
        opened.ask("time => report.clock.seek(time)", 200_000 + 5_000 * step)
    played = opened.drawn()
    opened.ask("() => report.clock.seek(500000)")
    opened.ask("() => report.clock.seek(250000)")
    assert (opened.drawn() == played).all()


def test_one_selection_for_picture_list_timeline_card_and_address(opened: Opened) -> None:
    opened.ask("() => report.clock.seek(400000)")
    number = free_object(opened)
    opened.page.mouse.click(*place_of(opened, number))
    assert opened.ask("() => report.selected()") == number
    assert opened.now_us == 400_000, "selecting does not move the cursor"
    assert opened.page.locator("#objects tr[aria-selected=true]").get_attribute("data-number") == str(number)
    assert opened.page.locator("#card .object").inner_text() == f"Object {number}"
    assert opened.page.url.endswith(f"#at=400000&see={number}")
    assert coloured(opened.pixels("#timeline"), (239, 233, 251), 3) > 200, "its row is tinted"
    opened.page.keyboard.press("Escape")
    assert opened.ask("() => report.selected()") == 0
    assert coloured(opened.pixels("#timeline"), (239, 233, 251), 3) < 30
    opened.page.locator("#objects tbody tr").first.click()
    assert opened.ask("() => report.selected()") == int(rows(opened)[0][0])


def test_a_bar_of_the_timeline_selects_and_anywhere_seeks(opened: Opened) -> None:
    bar = """() => { const { timeline, objects } = report; const object = objects.list.find((one) => one.row === 0);
      const at = timeline.canvas.getBoundingClientRect(); const time = (object.birth + object.end) / 2;
      return { number: object.number, time, x: at.left + timeline.x(time), y: at.top + timeline.top + 4 }; }"""
    found = opened.ask(bar)
    opened.page.mouse.click(found["x"], found["y"])
    assert opened.ask("() => report.selected()") == found["number"]
    assert opened.now_us == pytest.approx(found["time"], abs=2_000)
    opened.page.mouse.move(found["x"], 690)
    box = opened.page.locator("#timeline").bounding_box()
    assert box is not None
    opened.page.mouse.move(box["x"] + 300, box["y"] + 30)
    opened.page.mouse.down()
    opened.page.mouse.move(box["x"] + 400, box["y"] + 30, steps=3)
    dragged = opened.now_us
    opened.page.mouse.up()
    assert dragged == pytest.approx(opened.ask("() => report.timeline.time(400)"), abs=2_000)
    assert opened.ask("() => report.selected()") == found["number"], "a drag beside the bars selects nothing else"


def test_the_card_has_the_command_that_shows_the_birth_of_its_track(opened: Opened, material: Material) -> None:
    number, track = opened.ask("() => { const side = report.sides[0]; return [side.object[2], side.ids[2]]; }")
    opened.ask("number => { location.hash = `#see=${number}`; }", number)
    command = opened.page.locator("#card code").inner_text()
    first = opened.ask("(n) => report.sides[0].ids[report.objects.byNumber.get(n).lives[0][0]]", number)
    assert command == f"evcot waves build/cosim/boxes --around birth:{first}"
    assert opened.page.locator("#card canvas").count() >= 2
    moments = opened.page.locator("#card .moments button")
    at_us = int(moments.last.get_attribute("data-at") or -1)
    moments.last.click()
    assert opened.now_us == at_us
    assert track in opened.page.locator("#card .title").inner_text()


def test_every_side_of_an_object_has_its_number(opened: Opened) -> None:
    """What Python paired is what the list says, id by id."""
    opened.page.locator("[data-filter=all]").click()
    shown = {row[0]: row[1:4] for row in rows(opened)}
    for i, name in enumerate(("hardware", "software", "truth")):
        expected: dict[str, list[str]] = {}
        for number, track in opened.ask(f"() => report.sides[{i}].ids.map((id, life) => [report.sides[{i}].object[life], id])"):
            expected.setdefault(str(int(number)), []).append(track)
        assert opened.ask(f"() => report.sides[{i}].name") == name
        for number, cells in shown.items():
            ids = list(dict.fromkeys(expected.get(number, [])))
            assert cells[i] == ("–" if not ids else f"{len(ids)} tracks" if len(ids) > 3 else ", ".join(ids))


def test_the_list_is_filtered_sorted_and_searched(opened: Opened) -> None:
    opened.ask("() => report.clock.seek(400000)")
    now = len(rows(opened))
    assert now == opened.ask("() => report.objects.at(400000).size")
    opened.page.locator("[data-filter=all]").click()
    numbers = [int(row[0]) for row in rows(opened)]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) > now
    opened.page.locator("[data-sort=number]").click()
    assert [int(row[0]) for row in rows(opened)] == numbers[::-1]
    opened.page.locator("[data-sort=hardware]").click()
    first = [row[1].split(",")[0] for row in rows(opened) if row[1] != "–" and "tracks" not in row[1]]
    assert [int(track) for track in first] == sorted(int(track) for track in first)
    opened.page.keyboard.press("/")
    opened.page.keyboard.type("hw 0")
    assert len(rows(opened)) == 1
    assert rows(opened)[0][1].split(", ")[0] == "0"


def test_a_moment_of_the_agreement_is_gone_to_and_selects(opened: Opened) -> None:
    opened.page.keyboard.press("g")
    opened.page.keyboard.press("a")
    assert opened.page.locator("#panel-agreement").is_visible()
    line = opened.page.locator("#merges .place").first
    at_us, number = line.get_attribute("data-at"), line.get_attribute("data-number")
    line.click()
    assert opened.now_us == float(at_us or -1)
    assert opened.ask("() => report.selected()") == int(number or -1)
    assert opened.page.locator("#panel-agreement").is_visible(), "the tab stays"


def test_keys_step_to_every_kind_of_moment(opened: Opened, material: Material) -> None:
    log, begin_us = material.sides[0].log, material.span_us[0]
    opened.page.keyboard.press("2")
    for key, kind in (("m", 2), ("u", None), ("e", -1)):
        opened.ask("() => report.clock.seek(100000)")
        opened.page.keyboard.press(key)
        times_us = material.recording.events.t_us if kind == -1 else log.records["t_us"]
        if kind is not None and kind >= 0:
            lasting = opened.ask("() => report.sides[0].end.filter((_, life) => report.sides[0].ended[life] === 2)")
            times_us = np.array([*lasting.values()] if isinstance(lasting, dict) else lasting) + begin_us
        later = times_us[times_us - begin_us > 100_000] - begin_us
        assert opened.now_us == later.min(), key
        opened.page.keyboard.press(f"Shift+{key.upper()}")
        earlier = times_us[times_us - begin_us < later.min()] - begin_us
        if len(earlier):
            assert opened.now_us == earlier.max(), key
    opened.page.keyboard.press("2")
    opened.ask("() => report.clock.seek(0)")
    opened.page.keyboard.press("d")
    assert opened.now_us > 0
    assert opened.ask("() => report.objects.differs(report.objects.byNumber.get(report.selected()))")
    opened.page.keyboard.press("End")
    opened.page.keyboard.press("m")
    assert opened.page.locator("#said").inner_text() == "No merge after this time."


def test_keys_go_through_objects_and_follow_them(opened: Opened) -> None:
    opened.ask("() => report.clock.seek(400000)")
    opened.page.keyboard.press("j")
    first = opened.ask("() => report.selected()")
    opened.page.keyboard.press("j")
    second = opened.ask("() => report.selected()")
    opened.page.keyboard.press("k")
    assert first == opened.ask("() => report.selected()") != second
    opened.page.keyboard.press("f")
    opened.ask("() => report.clock.seek(410000)")
    assert opened.ask("() => report.stage.zoom") == 2
    opened.page.keyboard.press("z")
    object_ = opened.ask("() => report.objects.byNumber.get(report.selected())")
    assert opened.ask("() => report.axis.from") <= object_["birth"]
    opened.page.keyboard.press("?")
    assert opened.page.locator("#keys").is_visible()


def test_layers_switch_what_is_drawn(opened: Opened) -> None:
    assert coloured(opened.drawn(), BLUE) > 500
    opened.page.keyboard.press("1")
    assert coloured(opened.drawn(), BLUE) < 20
    opened.page.keyboard.press("1")
    assert coloured(opened.drawn(), BLUE) > 500
    for name in ("trails", "numbers", "colours", "on", "off"):
        before = opened.drawn()
        opened.page.locator(f"#rail [name={name}]").click()
        assert (opened.drawn() != before).any(), name


def test_zooming_keeps_what_is_under_the_pointer(opened: Opened) -> None:
    box = opened.page.locator("#picture").bounding_box()
    assert box is not None
    x, y = round(box["x"]) + 250, round(box["y"]) + 200
    before = opened.ask("([x, y]) => report.stage.toSensor(x, y)", [x, y])
    opened.page.mouse.move(x, y)
    opened.page.keyboard.down("Control")
    opened.page.mouse.wheel(0, -400)
    opened.page.keyboard.up("Control")
    opened.page.wait_for_function("() => report.stage.zoom > 2")
    after = opened.ask("([x, y]) => report.stage.toSensor(x, y)", [x, y])
    assert (after["x"], after["y"]) == pytest.approx((before["x"], before["y"]), abs=0.5)
    opened.page.mouse.down()
    opened.page.mouse.move(x + 40, y, steps=3)
    opened.page.mouse.up()
    assert opened.ask("([x, y]) => report.stage.toSensor(x, y).x", [x + 40, y]) == pytest.approx(after["x"], abs=0.5)
    assert opened.ask("() => report.selected()") == 0, "a drag is no click"
    opened.page.keyboard.press("0")
    assert opened.ask("() => report.stage.zoom") == 1


def test_the_timeline_zooms_and_follows(opened: Opened) -> None:
    opened.ask("() => report.clock.seek(100000)")
    for _ in range(4):
        opened.page.get_by_label("Zoom in on the time").click()
    span = opened.ask("() => [report.axis.from, report.axis.to]")
    assert span[0] < 100_000 < span[1]
    assert span[1] - span[0] == pytest.approx(opened.ask("() => report.axis.duration") / 16)
    opened.ask("() => { report.clock.now = report.axis.to - 1; report.clock.play(); }")
    opened.page.wait_for_function("end => report.axis.to > end", arg=span[1])


def test_a_heat_map_is_laid_over_the_picture(opened: Opened) -> None:
    opened.page.locator("#tab-heat").click()
    before = opened.drawn()
    opened.page.locator("[data-heat]").first.click()
    assert (opened.drawn() != before).mean() > 0.5
    opened.page.locator("[data-heat]").first.click()
    assert (opened.drawn() == before).all()


def test_times_follow_the_clock_that_is_asked_for(opened: Opened) -> None:
    opened.page.locator("#tab-timing").click()
    assert opened.page.locator("[data-clocks]").first.inner_text() == "0.02 µs"
    opened.page.locator("#megahertz").fill("50")
    assert opened.page.locator("[data-clocks]").first.inner_text() == "0.04 µs"


def test_panes_are_resized_and_remembered(opened: Opened) -> None:
    box = opened.page.locator("[data-split='--time-height']").bounding_box()
    assert box is not None
    before = opened.page.locator("#timeline").bounding_box()
    opened.page.mouse.move(box["x"] + 300, box["y"] + 3)
    opened.page.mouse.down()
    opened.page.mouse.move(box["x"] + 300, box["y"] - 97, steps=4)
    opened.page.mouse.up()
    after = opened.page.locator("#timeline").bounding_box()
    assert before is not None
    assert after is not None
    assert after["height"] == pytest.approx(before["height"] + 100, abs=2)
    opened.page.reload()
    opened.page.wait_for_selector("html[data-ready]")
    assert opened.page.locator("#timeline").bounding_box() == after


def test_every_control_has_a_name(opened: Opened) -> None:
    nameless = opened.ask(
        "() => [...document.querySelectorAll('button, input, select, canvas, img, a')].filter((one) => "
        "!(one.getAttribute('aria-label') || one.textContent.trim() || one.alt || one.labels?.[0]?.textContent.trim()))"
        ".map((one) => one.outerHTML)"
    )
    assert nameless == []


def test_nothing_jumps_while_it_loads(browser: Any, report: Path) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    page.add_init_script(
        "window.moved = 0; new PerformanceObserver((list) => list.getEntries().forEach((one) => (window.moved += one.value)))"
        ".observe({ type: 'layout-shift', buffered: true });"
    )
    page.goto(f"file://{report}")
    page.wait_for_selector("html[data-ready]")
    page.wait_for_timeout(200)
    assert page.evaluate("() => window.moved") < 0.02
    context.close()


def test_it_follows_the_systems_colours_and_the_button(browser: Any, report: Path) -> None:
    opened = Opened(browser, report, color_scheme="dark")
    assert opened.pixels("body").mean() < 60
    assert opened.drawn().mean() < 60
    opened.page.keyboard.press("t")
    assert opened.drawn().mean() > 200
    opened.page.reload()
    opened.page.wait_for_selector("html[data-ready]")
    assert opened.drawn().mean() > 200, "it is remembered"
    opened.page.keyboard.press("t")
    assert opened.drawn().mean() < 60
    assert opened.complaints == []
    opened.context.close()


def test_on_a_phone_one_taps(browser: Any, report: Path) -> None:
    opened = Opened(browser, report, **PHONE)
    small = opened.ask(
        "() => [...document.querySelectorAll('#transport :is(button, select), #menus button')].filter((one) => "
        "one.offsetParent && one.getBoundingClientRect().height < 40).map((one) => one.outerHTML)"
    )
    assert small == []
    opened.page.locator("#objects tbody tr").first.tap()
    card, table = (opened.page.locator(selector).bounding_box() for selector in ("#card", "#objects"))
    assert card is not None
    assert table is not None
    assert card["y"] < table["y"], "the card is above the list"
    opened.page.locator("[data-act=layers]").tap()
    assert opened.page.locator("#rail").is_visible()
    assert opened.complaints == []
    opened.context.close()


def test_it_prints_light_with_every_tab_and_without_controls(browser: Any, report: Path) -> None:
    opened = Opened(browser, report, color_scheme="dark")
    bright = (
        "() => { dispatchEvent(new Event('beforeprint')); const { data } = report.stage.context.getImageData(0, 0, 99, 99); "
    )
    bright += "dispatchEvent(new Event('afterprint')); return data[4 * 50 * 99]; }"
    assert opened.page.evaluate(bright) > 200
    assert opened.drawn().mean() < 60
    opened.page.emulate_media(media="print")
    assert not opened.page.locator("#rail").is_visible()
    for tab in ("objects", "scores", "agreement", "run"):
        assert opened.page.locator(f"#panel-{tab}").is_visible(), tab
    assert len(opened.page.pdf(format="A4")) > 50_000
    opened.context.close()


def test_an_address_with_a_time_opens_there(browser: Any, report: Path) -> None:
    opened = Opened(browser, report, "#at=123456&see=2")
    assert opened.now_us == 123_456
    assert opened.ask("() => report.selected()") == 2
    opened.context.close()
    opened = Opened(browser, report, "#at=5&see=hardware-0")
    assert opened.ask("() => report.selected() === report.sides[0].object[report.sides[0].ids.indexOf('0')]")
    opened.context.close()
    for wrong in ("#at=x", "#at=5&see=nobody-1", "#see=99999", "#at=1e99"):
        opened = Opened(browser, report, wrong)
        assert opened.complaints == []
        opened.context.close()


def test_a_run_of_nothing_opens_and_says_what_is_missing(browser: Any, tmp_path: Path) -> None:
    from .test_page import empty

    write_report(Material(empty(), summary_of("nothing"), ()), tmp_path / "empty.html")
    opened = Opened(browser, tmp_path / "empty.html")
    for key in ("Space", "m", "e", "1", "j", "f", "z", "/", "End"):
        opened.page.keyboard.press(key)
    assert opened.page.locator("#empty").is_visible()
    steps = opened.page.locator("#what option:enabled").all_inner_texts()
    assert (steps, opened.page.locator("#what").input_value()) == (["event", "update"], "event")
    opened.page.locator("#tab-run").click()
    opened.page.get_by_role("button", name="What to do").click()
    assert "A recording of 50 ms at least" in opened.page.locator("#panel-missing").inner_text()
    assert opened.complaints == []
    opened.context.close()


def test_a_hostile_name_does_nothing(browser: Any, material: Material, tmp_path: Path) -> None:
    from .test_page import HOSTILE

    write_report(Material(material.recording, summary_of(HOSTILE), material.sides), tmp_path / "hostile.html")
    opened = Opened(browser, tmp_path / "hostile.html")
    assert opened.page.locator("h1").inner_text() == HOSTILE
    assert opened.complaints == []
    opened.context.close()


def test_a_film_shows_the_report_in_use(browser: Any, report: Path, tmp_path: Path) -> None:
    module = module_at(Path(__file__).parents[3] / "docs" / "site" / "film_report.py")
    module.film(browser, report, tmp_path / "report.gif")
    with Image.open(tmp_path / "report.gif") as gif:
        assert gif.size == (1200, 750)
        assert gif.n_frames > 40  # type: ignore[attr-defined]
        first = np.asarray(gif.convert("RGB")).astype(int)
        gif.seek(gif.n_frames - 1)  # type: ignore[attr-defined]
        last = np.asarray(gif.convert("RGB")).astype(int)
    changed = np.abs(first - last).max(axis=2) > 40
    assert changed[60:450, 130:700].mean() > 0.3, "the heat map lies over the picture"
    assert changed[120:700, 720:].mean() > 0.05, "another tab is open"


@pytest.mark.parametrize("damage", ["cut", "flipped"])
def test_a_damaged_page_shows_one_sentence_and_nothing_else(browser: Any, report: Path, tmp_path: Path, damage: str) -> None:
    text = report.read_text()
    columns = text.index('id="columns"')
    cut = text[: columns + 10_000]
    (tmp_path / "report.html").write_text(cut if damage == "cut" else f"{cut}{'A' * 40}{text[columns + 10_040 :]}")
    page = browser.new_page()
    page.goto(f"file://{tmp_path / 'report.html'}")
    if damage == "cut":  # there is no script that could say so
        page.wait_for_timeout(200)
        assert not page.locator("#broken").is_visible(), "a page that loads is no broken one"
        page.evaluate("() => document.getAnimations().forEach((one) => one.finish())")
    page.locator("#broken").wait_for()
    says = {"cut": "the file is incomplete, or the browser runs no scripts.", "flipped": "the file is damaged ("}
    assert page.locator("#broken").inner_text().startswith(f"This page cannot be shown: {says[damage]}")
    on_top = "() => document.elementFromPoint(innerWidth / 2, innerHeight - 20).id"
    assert page.evaluate(on_top) == "broken"
    page.close()


def test_an_overview_names_a_page_that_is_not_beside_it(browser: Any, report: Path, tmp_path: Path) -> None:
    (tmp_path / "part-00000.html").write_bytes(report.read_bytes())
    parts = [
        {
            "page": f"part-0000{i}.html",
            "from_us": 10 * i,
            "to_us": 10 * i + 10,
            "events": 5,
            "grade": "good",
            "alive_hardware": 1.0,
        }
        for i in range(2)
    ]
    verdict = {"grade": "good", "headline": "The tracks look sound.", "lines": [], "figures": {}}
    sensor = {"width": 346, "height": 260}
    write_overview(
        summary_of(parts=parts, verdict=verdict, events=10, recording_s=1.0, sensor=sensor), tmp_path / "report.html"
    )
    page = browser.new_page()
    page.clock.install()
    page.goto(f"file://{tmp_path / 'report.html'}")
    page.frame_locator("iframe").locator("html[data-ready]").wait_for()
    page.clock.run_for(6_000)
    assert page.locator("iframe").is_visible()
    page.get_by_role("button", name="Later").click()
    page.wait_for_timeout(300)
    page.clock.run_for(6_000)
    assert page.locator("#lost").inner_text() == (
        "part-00001.html cannot be shown: it must be beside this page, whole, as evcot wrote it."
    )
    assert not page.locator("iframe").is_visible()
    page.get_by_role("button", name="Earlier").click()
    page.frame_locator("iframe").locator("html[data-ready]").wait_for()
    assert not page.locator("#lost").is_visible()
    page.close()


def test_a_mismatch_leads_and_is_where_the_playback_stands(browser: Any, material: Material, tmp_path: Path) -> None:
    sides = (material.sides[0], Side("model", material.sides[0].log))
    write_report(Material(material.recording, mismatch_at(60_000), sides), tmp_path / "m.html")
    opened = Opened(browser, tmp_path / "m.html")
    at_us = material.recording.events.t_us[60_000] - material.span_us[0]
    assert opened.now_us == at_us
    assert opened.page.locator("#panel-mismatch").is_visible()
    opened.page.keyboard.press("Home")
    opened.page.keyboard.press("d")
    assert opened.now_us == at_us
    assert coloured(opened.pixels("#timeline"), (180, 35, 24), 3) > 100, "the end of the run is marked"
    assert opened.complaints == []
    opened.context.close()


def test_software_alone_speaks_of_no_hardware(browser: Any, material: Material, tmp_path: Path) -> None:
    sides = (Side("software", material.sides[1].log),)
    write_report(Material(material.recording, {"name": "alone"}, sides), tmp_path / "alone.html")
    opened = Opened(browser, tmp_path / "alone.html")
    opened.page.locator("#objects tbody tr").first.click()
    text = opened.page.locator("#app").inner_text()
    for word in ("Agreement", "Timing", "Differ", "hardware", "HW", "evcot waves"):
        assert word not in text, word
    assert {row[-1] for row in rows(opened)} == {"tracked"}
    assert opened.complaints == []
    opened.context.close()


@pytest.fixture
def classified(browser: Any, material: Material, tmp_path: Path) -> Iterator[Opened]:
    """The software's tracks alone, of which every second is a cup from 0.3 s on, and none of the classes from 0.5 s on."""
    log = material.sides[1].log
    even = [one for one in np.unique(log.records["track_id"]).tolist() if one % 2 == 0]
    begin_us = int(material.recording.events.t_us[0])
    said = [(begin_us + at_us, one, class_id) for at_us, class_id in ((300_000, 2), (500_000, -1)) for one in even]
    named = replace(log, verdicts=verdicts_of(*said), class_names={2: "cup"})
    write_report(Material(material.recording, {"name": "alone"}, (Side("software", named),)), tmp_path / "alone.html")
    opened = Opened(browser, tmp_path / "alone.html")
    yield opened
    assert opened.complaints == []
    opened.context.close()


DRAWN_TEXTS = """(at) => { const texts = []; const { prototype } = CanvasRenderingContext2D; const { fillText } = prototype;
  prototype.fillText = function (text, ...more) {
    if (this.canvas.id === "picture") texts.push(text);
    return fillText.call(this, text, ...more); };
  report.clock.seek(at); report.draw(); prototype.fillText = fillText; return texts; }"""


def test_a_box_and_its_row_have_the_class_of_the_last_verdict_so_far(classified: Opened) -> None:
    for at_us, label in ((290_000, None), (310_000, "cup"), (510_000, "?")):
        texts = classified.ask(DRAWN_TEXTS, at_us)
        shown = {row[1]: row[2] for row in rows(classified)}
        labels = {label if int(track) % 2 == 0 else None for track in shown}
        assert {text if text != "–" else None for text in shown.values()} == labels
        assert all((text == "–") == (label is None or int(track) % 2 == 1) for track, text in shown.items())
        assert [text for text in texts if not text.isdigit()] == [text for text in shown.values() if text != "–"]


def test_objects_are_found_and_sorted_by_class_and_a_change_is_gone_to(classified: Opened) -> None:
    classified.ask("() => report.clock.seek(310000)")
    classified.page.locator("[data-sort=class]").click()
    labels = [row[2] for row in rows(classified)]
    assert set(labels) == {"cup", "–"}
    assert labels == ["cup"] * labels.count("cup") + ["–"] * labels.count("–")
    classified.page.locator("#find").fill("cup")
    found = rows(classified)
    assert found
    assert all(int(row[1]) % 2 == 0 for row in found)
    classified.page.locator("#objects tbody tr").first.click()
    classified.page.get_by_role("button", name="class ?").first.click()
    assert classified.now_us == 500_000


BRIEF = 2_000  # tracks that end in their neighbour soon
JOINT = 3  # as many has the software
LENGTH_US = 4_000_000


def log_of(engine: str, brief: int, late_us: int = 9_000) -> TrackLog:
    """One track all the time, and beside it so many that merge into it after some time."""
    birth_us = np.linspace(10_000, LENGTH_US - 10_000, brief).astype(np.int64)
    rows = np.zeros(1 + 2 * brief, TRACK)
    rows["track_id"], rows["slot"], rows["other_id"] = 0, 0, -1
    rows["x"], rows["y"], rows["width"], rows["height"], rows["n_ev"] = 30, 30, 12, 12, 8
    for part, kind, after_us in ((slice(1, 1 + brief), Kind.BORN, 0), (slice(1 + brief, None), Kind.MERGED, late_us)):
        rows["kind"][part], rows["t_us"][part] = kind, birth_us + after_us
        rows["track_id"][part], rows["slot"][part] = 1 + np.arange(brief), 1 + np.arange(brief) % 3
        rows["x"][part] = 34
    rows["other_id"][1 + brief :] = 0
    rows = rows[np.argsort(rows["t_us"], kind="stable")]
    return TrackLog(engine, rows, np.zeros(20_000, np.int16))


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Events on a blob, and a hot pixel."""
    random = np.random.default_rng(3)
    n = 20_000
    x, y = (np.clip(random.normal(30, 3, n), 0, 63).astype(np.uint16) for _ in range(2))
    x[::5], y[::5] = 50, 7
    return Recording(Events(np.linspace(0, LENGTH_US, n).astype(np.int64), x, y, np.ones(n, np.uint8)), 64, 48, "busy")


@pytest.fixture(scope="module")
def busy(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a run with thousands of merges that only the hardware has."""
    hardware, software = log_of("cot_array", BRIEF), log_of("rct", JOINT)
    summary = summary_of("busy", agreement=compare(hardware, software, span_us=(0, LENGTH_US)).to_dict())
    summary["verdict"] = verdict_of(recording, {"hardware": hardware, "software": software}, summary).to_dict()
    path = tmp_path_factory.mktemp("busy") / "report.html"
    write_report(Material(recording, summary, (Side("hardware", hardware), Side("software", software))), path)
    return path


def test_of_many_objects_some_are_listed_and_every_one_is_found(browser: Any, busy: Path) -> None:
    opened = Opened(browser, busy)
    opened.page.locator("[data-filter=all]").click()
    assert opened.page.locator("#objects tbody tr").count() == 400
    assert opened.page.locator("#more").inner_text() == "400 of 2,004 are listed; find narrows them."
    opened.page.locator("#find").fill("hw 1999")
    assert opened.page.locator("#objects tbody tr").count() == 1
    assert opened.page.locator("#more").inner_text() == ""
    opened.page.locator("#objects tbody tr").click()
    assert "hardware 1999 merged into object 1 after 9 ms." in opened.page.locator("#card").inner_text()
    opened.page.locator("#tab-agreement").click()
    assert opened.page.locator("#lone .place").count() == 200
    assert "and 1,803 more objects" in opened.page.locator("#lone").inner_text()
    assert opened.complaints == []
    opened.context.close()


def test_of_many_objects_a_frame_is_drawn_in_time(browser: Any, busy: Path) -> None:
    opened = Opened(browser, busy)
    measure = """() => {
      const spent = [];
      report.clock.playing = true;
      for (let i = 0; i < 60; i++) {
        report.clock.now += 1000;
        const at = performance.now();
        report.draw();
        spent.push(performance.now() - at);
      }
      report.clock.playing = false;
      return spent.sort((a, b) => a - b)[30];
    }"""
    spent = opened.ask(measure)
    assert spent < 16.7, "ms"
    opened.context.close()


def test_tracks_that_merge_at_their_birth_are_counted_only(recording: Recording) -> None:
    hardware = log_of("cot_array", BRIEF, late_us=1_000)
    text = render(Material(recording, {"name": "busy"}, (Side("hardware", hardware),)))
    assert "2,000 hardware tracks merged in the moment of their birth: counted, not listed." in text
    assert '"ids":["0"]' in text


def test_the_hot_pixel_is_named_and_does_not_flatten_the_map(busy: Path) -> None:
    text = busy.read_text()
    assert "<td>50, 7</td>" in text
    assert '<td class="number">4,000</td><td class="number">20.0 %</td>' in text

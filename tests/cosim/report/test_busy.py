# SPDX-License-Identifier: Apache-2.0
"""A busy run, and a software tracker's run, in a real browser: what is too much to be drawn is counted, and words fit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.tracks.compare import compare
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.lockstep.verdict import verdict_of
from evcot_cosim.report import Material, Side, write_report

from .conftest import Opened, summary_of

BRIEF = 2_000  # tracks that end in their neighbour at once
JOINT = 3  # of them the software has, too
LONE = BRIEF - JOINT
LENGTH_US = 4_000_000
PHONE = {"viewport": {"width": 390, "height": 844}, "is_mobile": True, "has_touch": True}


def log_of(engine: str, brief: int) -> TrackLog:
    """One track all the time, and beside it so many that merge into it after a millisecond."""
    birth_us = np.linspace(10_000, LENGTH_US - 10_000, brief).astype(np.int64)
    rows = np.zeros(1 + 2 * brief, TRACK)
    rows["track_id"], rows["slot"], rows["other_id"] = 0, 0, -1
    rows["x"], rows["y"], rows["width"], rows["height"], rows["n_ev"] = 30, 30, 12, 12, 8
    for part, kind, late_us in ((slice(1, 1 + brief), Kind.BORN, 0), (slice(1 + brief, None), Kind.MERGED, 1_000)):
        rows["kind"][part], rows["t_us"][part] = kind, birth_us + late_us
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


@pytest.fixture(scope="module")
def alone(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a software tracker's log."""
    path = tmp_path_factory.mktemp("alone") / "report.html"
    write_report(Material(recording, {"name": "alone"}, (Side("software", log_of("rct", JOINT)),)), path)
    return path


@pytest.fixture
def opened(browser: Any, busy: Path) -> Iterator[Opened]:
    page = Opened(browser, busy)
    yield page
    assert page.complaints == []
    page.context.close()


def test_the_verdict_stands_above_the_picture_and_says_what_to_do(opened: Opened) -> None:
    verdict, picture = (opened.page.locator(selector).bounding_box() for selector in ("#verdict", "#stage"))
    assert verdict is not None
    assert picture is not None
    assert verdict["y"] + verdict["height"] <= picture["y"]
    text = opened.page.locator("#verdict").inner_text()
    assert "2,001 tracks, about 1.5 alive at a time (1,334 per object alive)" in text
    assert "parts of one object start tracks of their own" in text
    assert opened.page.locator("#verdict").get_attribute("class") in ("fair", "poor")


def test_marks_at_fast_playback_are_few_and_fade(opened: Opened) -> None:
    marks = opened.ask("() => report.sides[0].marks(1e6, 2.4e6)")
    assert 1 < len(marks) <= 6
    assert [mark["fresh"] for mark in marks] == sorted((mark["fresh"] for mark in marks), reverse=True)
    assert [bool(mark["text"]) for mark in marks] == [True] + [False] * (len(marks) - 1)
    assert max(mark["at"] for mark in marks) == opened.ask("() => Math.max(...report.sides[0].end.filter((at) => at <= 2.4e6))")


def test_merges_that_cannot_be_told_apart_are_counted_until_one_zooms_in(opened: Opened) -> None:
    counted = "() => { const drawn = []; const context = document.querySelector('#lives').getContext('2d'); "
    counted += "const fillText = context.fillText.bind(context); context.fillText = (text, ...at) => { drawn.push(text); "
    counted += "fillText(text, ...at); }; window.drawn = drawn; }"
    opened.ask(counted)
    opened.page.get_by_label("Show the whole time").click()
    opened.page.wait_for_function("() => window.drawn.length")
    assert "2,000 merges; zoom in to see each" in opened.ask("() => window.drawn")
    opened.ask("() => { window.drawn.length = 0; report.axis.zoomAt(100, 2e6); }")
    opened.page.get_by_label("Zoom in on the time").click()
    opened.page.wait_for_function("() => window.drawn.length")
    assert not [text for text in opened.ask("() => window.drawn") if "merges" in text]


def test_a_list_of_thousands_is_one_tab_stop_and_few_rows(opened: Opened) -> None:
    box = opened.page.locator("[data-list=merges] .places")
    assert opened.page.locator("[data-list=merges] h3").inner_text() == f"Merges without a partner {LONE:,}"
    assert 5 < box.locator("a").count() < 30
    assert box.evaluate("(one) => one.querySelectorAll('a[tabindex=\"-1\"]').length === one.querySelectorAll('a').length")
    every = "document.querySelectorAll('a, button, input, select, summary, [tabindex]')"
    assert opened.ask(f"() => [...{every}].filter((one) => one.tabIndex >= 0).length") < 60
    box.evaluate("(one) => (one.scrollTop = 26 * 1000)")
    opened.page.wait_for_function("() => document.querySelector('[data-row=\"1001\"]')")
    assert box.locator("[data-row='0']").count() == 0


def test_the_list_is_walked_by_keys_and_enter_goes_there(opened: Opened) -> None:
    before = opened.now_us
    box = opened.page.locator("[data-list=merges] .places")
    box.focus()
    opened.page.keyboard.press("End")
    assert box.evaluate("(one) => one.getAttribute('aria-activedescendant')") == f"merges-row-{LONE - 1}"
    assert opened.now_us == before  # choosing is not going
    opened.page.keyboard.press("ArrowUp")
    opened.page.keyboard.press("Enter")
    opened.page.wait_for_function("() => report.selection()?.side.name === 'hardware'")
    merges_us = opened.ask("() => [...report.sides[0].end].sort((a, b) => a - b)")
    assert opened.now_us == merges_us[BRIEF - 3]  # the last is a joint one


def test_the_histogram_counts_every_place_and_leads_to_them(opened: Opened) -> None:
    sums = opened.ask(
        "() => report.lists.find((one) => one.name === 'merges').when.map(([, counts]) => counts.reduce((a, b) => a + b))"
    )
    assert sums == [LONE]
    canvas = opened.page.locator("[data-list=merges] canvas")
    box = canvas.bounding_box()
    assert box is not None
    canvas.click(position={"x": box["width"] / 2, "y": 20})
    at_us = opened.ask(
        "() => { const one = report.lists.find((list) => list.name === 'merges'); return one.rows[one.active].at; }"
    )
    assert at_us == pytest.approx(LENGTH_US / 2, rel=0.02)


def test_no_text_stands_on_another(opened: Opened) -> None:
    opened.ask("() => report.clock.seek(2000500)")
    taken = opened.ask("() => report.stage.taken")
    assert taken
    for i, (left, top, right, bottom) in enumerate(taken):
        for l2, t2, r2, b2 in taken[:i]:
            assert not (left < r2 and l2 < right and top < b2 and t2 < bottom)


def test_nothing_lies_over_the_picture_which_has_most_of_the_width(browser: Any, busy: Path) -> None:
    opened = Opened(browser, busy, viewport={"width": 1440, "height": 900})
    over = opened.page.locator("#stage").evaluate(
        "(one) => { const box = one.getBoundingClientRect(); const all = [...document.querySelectorAll('button')]; "
        "return all.filter((other) => { "
        "const b = other.getBoundingClientRect(); return b.left < box.right && box.left < b.right && b.top < box.bottom && "
        "box.top < b.bottom; }).length; }"
    )
    assert over == 0
    box = opened.page.locator("#stage").bounding_box()
    assert box is not None
    assert box["width"] > 0.65 * 1440
    opened.context.close()


def test_a_software_run_does_not_speak_of_hardware(browser: Any, alone: Path) -> None:
    opened = Opened(browser, alone)
    text = opened.page.locator("body").inner_text()
    for word in ("Agreement", "CM update", "difference", "N_ev", "hardware"):
        assert word not in text, word
    assert opened.page.locator("[data-step=update]").inner_text() == "move"
    assert opened.page.locator("#verdict tr").count() == 3
    assert opened.complaints == []
    opened.context.close()


def test_on_a_phone_one_taps(browser: Any, busy: Path) -> None:
    words = "(one) => getComputedStyle(one, '::before').content"
    for context, said in (({}, "Move over the picture"), (PHONE, "Tap the picture")):
        opened = Opened(browser, busy, **context)
        assert said in opened.page.locator("#hover").evaluate(words)
        wide = opened.ask("() => [document.documentElement.scrollWidth, innerWidth]")
        assert wide[0] <= wide[1]
        opened.context.close()


def test_the_colours_button_says_what_it_is(opened: Opened) -> None:
    button = opened.page.locator("#theme")
    said = []
    for _ in range(4):
        said.append(button.inner_text())
        button.click()
    assert said == ["Colours: as the system", "Colours: light", "Colours: dark", "Colours: as the system"]


def test_n_ev_is_of_the_hardware_alone(opened: Opened) -> None:
    readout = opened.page.locator("figure:has(#nev) .readout").inner_text()
    assert "hardware" in readout
    assert "software" not in readout
    assert "software" in opened.page.locator("figure:has(#size) .readout").inner_text()


def test_the_hot_pixel_is_named_and_does_not_flatten_the_map(busy: Path) -> None:
    text = busy.read_text()
    assert "Hot: pixel (50, 7) has" in text
    assert "4,000, 20.0 % of them" in text

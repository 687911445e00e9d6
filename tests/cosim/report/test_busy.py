# SPDX-License-Identifier: Apache-2.0
"""A busy run in a real browser: thousands of objects are listed in part, found, and drawn in time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.tracks.compare import compare
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.lockstep.verdict import verdict_of
from evcot_cosim.report import Material, Side, write_report
from evcot_cosim.report.page import render

from .conftest import Opened, summary_of

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

# SPDX-License-Identifier: Apache-2.0
"""A small run of the box experiment to report of, made without hardware; and a browser to read it in."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from evcot.hardware.golden import track as track_model
from evcot.scenes import simulate_scene
from evcot.trackers.presets import fit, for_sensor
from evcot.trackers.rct.tracker import track as track_software
from evcot.tracks.compare import compare
from evcot.tracks.log import TrackLog
from evcot_cosim.lockstep.truth import scene_truth
from evcot_cosim.report import Material, Side, Truth, write_report

WINDOW = {"width": 1440, "height": 900}


def summary_of(name: str = "boxes", **more: Any) -> dict[str, Any]:
    """What summary.json has that a report shows."""
    return {
        "name": name, "exact": True, "records": 1_234, "command": "evcot cosim boxes", "seed": None, "slots": 8,
        "hardware": "cot_array", "cycles": 100_500, "cycles_per_event": 1.005, "events_per_s": 5e6, "realtime_factor": 20.0,
        "versions": {"evcot": "0", "python": "3"}, "filters": [],
        "latency_clocks": {"median": 2, "p99": 3, "max": 9, "histogram": [[2, 900], [3, 90], [9, 1]]}, **more,
    }  # fmt: skip


def mismatch_at(event_index: int, **more: Any) -> dict[str, Any]:
    """The same of a run that ended there: its owner differed, or what is given."""
    found = {"tick": 9, "field": "owner", "hardware": 1, "model": 2, "seed": 7, "config": {"module": "cot_array"}}
    return summary_of(exact=False, mismatch={"event_index": event_index, **found, **more})


def material_of(duration_us: int, **more: Any) -> Material:
    """The box experiment so long, through the golden model and the software tracker."""
    scene = simulate_scene("boxes", 1, {"duration_us": duration_us})
    recording = scene.recording
    config = fit(for_sensor(recording.width), recording.width, recording.height)
    model = track_model(recording, config.hardware)
    hardware, software = TrackLog("cot_array", model.records, model.owner), track_software(recording, config.rct)
    span_us = int(recording.events.t_us[0]), int(recording.events.t_us[-1])
    agreement = compare(hardware, software, radius_px=config.rct.radius_px, span_us=span_us)
    summary = summary_of(agreement=agreement.to_dict(), config=config.to_dict(), **more)
    truth: Truth = scene_truth(scene.truth, (recording.width, recording.height))
    return Material(recording, summary, (Side("hardware", hardware, "build/cosim/boxes"), Side("software", software)), truth)


@pytest.fixture(scope="session")
def material() -> Material:
    """0.6 s of the box experiment; two boxes meet in it."""
    found = material_of(600_000)
    assert len(found.sides[0].log.of_kind(2)) > 3  # type: ignore[arg-type]
    return found


@pytest.fixture(scope="session")
def report(material: Material, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of it."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(material, path)
    return path


class Opened:
    """A page, and everything that it complained about or asked the network for."""

    def __init__(self, browser: Any, path: Path, hash: str = "", **context: Any) -> None:
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self.context = browser.new_context(**{"viewport": WINDOW, "color_scheme": "light", **context})
        self.page = self.context.new_page()
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(f"file://{path}{hash}")
        self.page.wait_for_selector("html[data-ready]", timeout=30_000)

    def ask(self, script: str, argument: Any = None) -> Any:
        """The value of JavaScript, after two frames: what was called for is drawn."""
        value = self.page.evaluate(script, argument)
        self.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return value

    @property
    def now_us(self) -> float:
        """The time that the page shows."""
        return float(self.ask("() => report.clock.now"))

    def pixels(self, selector: str) -> NDArray[np.int64]:
        """(height, width, 3) of an element as it stands on the screen."""
        return _rgb(self.page.locator(selector).screenshot())

    def drawn(self) -> NDArray[np.int64]:
        """(height, width, 3) of the playback's canvas."""
        self.ask("() => null")
        return _rgb(base64.b64decode(self.page.evaluate("() => report.stage.canvas.toDataURL()").partition(",")[2]))


def _rgb(png: bytes) -> NDArray[np.int64]:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(np.int64)


@pytest.fixture
def opened(browser: Any, report: Path) -> Iterator[Opened]:
    """The report in a window of its own; it must not have complained, nor asked the network for anything."""
    page = Opened(browser, report)
    yield page
    assert page.complaints == []
    assert [url for url in page.asked if not url.startswith(("file:", "data:", "blob:"))] == []
    page.context.close()

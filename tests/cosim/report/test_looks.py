# SPDX-License-Identifier: Apache-2.0
"""The main states look as they did: screenshots, made so coarse that fonts and smoothing do not matter, against kept ones.

After a wanted change: EVCOT_BASELINE=1 pytest tests/cosim/report/test_looks.py, and look at what it wrote.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from evcot_cosim.report import Material, Side, write_report

from .conftest import Opened, mismatch_at

BASELINE = Path(__file__).with_name("baseline")
CELL = 20  # pixels of the screen to one that is compared
MEAN = 3.0  # of 255: how far apart all of it may be
CELLS_APART = 0.02  # share of it that may be further apart than FAR
FAR = 40.0


@dataclass(frozen=True)
class State:
    """What is done before the screenshot, and the window."""

    act: Callable[[Opened], None] = lambda opened: None
    context: dict[str, Any] = field(default_factory=dict)
    mismatch: bool = False


def dark(**more: Any) -> dict[str, Any]:
    return {"color_scheme": "dark", **more}


def clicked(selector: str) -> Callable[[Opened], None]:
    return lambda opened: opened.page.locator(selector).first.click()


def selected(opened: Opened) -> None:
    opened.ask("() => { location.hash = '#at=400000&see=1'; }")


def zoomed(opened: Opened) -> None:
    opened.ask("() => { report.stage.zoomAt(4, 450, 450); report.clock.invalidate(); }")
    for _ in range(3):
        opened.page.get_by_label("Zoom in on the time").click()


def printed(opened: Opened) -> None:
    opened.page.emulate_media(media="print")


STATES = {
    "opened": State(),
    "dark": State(selected, context=dark()),
    "selected": State(selected),
    "zoomed": State(zoomed, dark()),
    "scores": State(clicked("#tab-scores")),
    "heat": State(clicked("#tab-heat")),
    "help": State(lambda opened: opened.page.keyboard.press("?")),
    "phone": State(context=dark(viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)),
    "print": State(printed, dark()),
    "mismatch": State(mismatch=True),
}


@pytest.fixture(scope="module")
def pages(report: Path, material: Material, tmp_path_factory: pytest.TempPathFactory) -> dict[bool, Path]:
    """The report of a run, and of one that a mismatch ended."""
    path = tmp_path_factory.mktemp("mismatch") / "report.html"
    sides = (material.sides[0], Side("model", material.sides[0].log))
    write_report(Material(material.recording, mismatch_at(60_000), sides, material.truth), path)
    return {False: report, True: path}


def coarse(png: bytes) -> Image.Image:
    image = Image.open(io.BytesIO(png)).convert("RGB")
    return image.resize((image.width // CELL, image.height // CELL), Image.Resampling.BOX)


def difference(now: Image.Image, kept: Image.Image) -> tuple[float, float]:
    """Mean over all, and share of cells that are far apart."""
    apart = np.abs(np.asarray(now, float) - np.asarray(kept, float)).max(axis=2)
    return float(apart.mean()), float((apart > FAR).mean())


@pytest.mark.parametrize("name", STATES)
def test_a_state_looks_as_it_did(name: str, browser: Any, pages: dict[bool, Path]) -> None:
    state = STATES[name]
    opened = Opened(browser, pages[state.mismatch], **state.context)
    state.act(opened)
    opened.ask("() => null")
    now = coarse(opened.page.screenshot(animations="disabled"))
    assert opened.complaints == []
    opened.context.close()
    path = BASELINE / f"{name}.png"
    if os.environ.get("EVCOT_BASELINE"):
        now.save(path)
    kept = Image.open(path).convert("RGB")
    assert now.size == kept.size
    mean, share = difference(now, kept)
    assert mean < MEAN, f"{name}: {mean:.1f} of 255 apart"
    assert share < CELLS_APART, f"{name}: {share:.1%} of the cells are far apart"


def test_kept_states_differ_from_each_other() -> None:
    images = {name: Image.open(BASELINE / f"{name}.png").convert("RGB") for name in ("opened", "selected", "heat", "mismatch")}
    for name, one in images.items():
        for other, two in images.items():
            mean, share = difference(one, two)
            assert (name == other) == (mean < MEAN and share < CELLS_APART), (name, other)

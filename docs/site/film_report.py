# SPDX-License-Identifier: Apache-2.0
"""Films a report in use: python docs/site/film_report.py RUN/report.html docs/images/report.gif"""

from __future__ import annotations

import io
import shutil
import sys
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw
from playwright.sync_api import Browser, Page, ViewportSize, sync_playwright

__all__ = ["film"]

_SIZE: ViewportSize = {"width": 1200, "height": 750}
_FRAME_MS = 125
_PLAYED_US = 25_000  # of the recording in a frame
_COLOURS = 96
_POINTER = ((0, 0), (0, 17), (4, 13), (7, 19), (10, 18), (7, 12), (12, 12))

_MIDDLE = """(number) => { const { stage, objects, clock } = report; const canvas = stage.canvas.getBoundingClientRect();
  const box = objects.boxes(objects.at(clock.now).get(number), clock.now).find(Boolean);
  return [canvas.left + ((box.x - stage.centre.x) * stage.scale + stage.canvas.width / 2) / stage.ratio,
    canvas.top + ((box.y - stage.centre.y) * stage.scale + stage.canvas.height / 2) / stage.ratio]; }"""
_LARGEST = """() => { const { objects, clock } = report; const area = (one) => one ? one.halfWidth * one.halfHeight : 0;
  return [...objects.at(clock.now)].map(([number, lives]) => [number, area(objects.boxes(lives, clock.now).find(Boolean))])
    .sort((a, b) => b[1] - a[1])[0][0]; }"""


class _Camera:
    """Pictures of a page, each with the pointer where the mouse is."""

    def __init__(self, page: Page) -> None:
        self.page, self.pictures = page, list[Image.Image]()
        self.x, self.y = _SIZE["width"] / 2, _SIZE["height"] / 2

    def shoot(self, count: int = 1) -> None:
        for _ in range(count):
            picture = Image.open(io.BytesIO(self.page.screenshot())).convert("RGB")
            outline = [(self.x + x, self.y + y) for x, y in _POINTER]
            ImageDraw.Draw(picture).polygon(outline, fill="black", outline="white")
            self.pictures.append(picture)

    def move(self, x: float, y: float, steps: int = 4) -> None:
        from_x, from_y = self.x, self.y
        for step in range(1, steps + 1):
            self.x, self.y = (a + (b - a) * step / steps for a, b in ((from_x, x), (from_y, y)))
            self.page.mouse.move(self.x, self.y)
            self.shoot()

    def click(self, selector: str) -> None:
        box: Any = self.page.locator(selector).bounding_box()
        self.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.page.mouse.click(self.x, self.y)
        self.shoot(5)

    def play(self, frames: int) -> None:
        for _ in range(frames):
            self.page.evaluate("(us) => report.clock.seek(report.clock.now + us)", _PLAYED_US)
            self.shoot()


def film(browser: Browser, report: Path, target: Path) -> None:
    """Write a GIF in which a report is played, an object is selected, the cursor is dragged and tabs are opened."""
    page = browser.new_page(viewport=_SIZE, color_scheme="light")
    page.goto(f"file://{report.resolve()}#at=0")
    page.wait_for_selector("html[data-ready]")
    page.evaluate("() => report.clock.seek(0.15 * report.clock.duration)")
    camera = _Camera(page)
    camera.shoot(3)
    camera.play(16)
    camera.move(*page.evaluate(_MIDDLE, page.evaluate(_LARGEST)))
    page.mouse.click(camera.x, camera.y)
    camera.shoot(6)
    camera.play(10)
    timeline: Any = page.locator("#timeline").bounding_box()
    camera.move(timeline["x"] + 0.5 * timeline["width"], timeline["y"] + 40)
    page.mouse.down()
    camera.move(timeline["x"] + 0.8 * timeline["width"], timeline["y"] + 40, steps=10)
    page.mouse.up()
    for tab in ("scores", "agreement", "heat"):
        if page.locator(f"#tab-{tab}").count():
            camera.click(f"#tab-{tab}")
    camera.click("[data-heat] >> nth=0")
    page.close()
    palette = _beside(camera.pictures[0], camera.pictures[-1]).quantize(_COLOURS)
    first, *others = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in camera.pictures]
    first.save(target, save_all=True, append_images=others, duration=_FRAME_MS, loop=0, optimize=True)


def _beside(left: Image.Image, right: Image.Image) -> Image.Image:
    both = Image.new("RGB", (left.width + right.width, left.height))
    both.paste(left)
    both.paste(right, (left.width, 0))
    return both


if __name__ == "__main__":
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        film(chromium, Path(sys.argv[1]), Path(sys.argv[2]))
        chromium.close()

# SPDX-License-Identifier: Apache-2.0
"""A frame of a film: enlarged events, with trails, boxes and ids drawn over them, and the time in a corner."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ...tracks.boxes import box_corners
from .colours import GROUND, INK, RGB
from .states import Follower

__all__ = ["compose", "size_of"]

_FONT_PX = 13
_MARGIN_PX = 6


def size_of(sensor: tuple[int, int], width_px: int) -> tuple[int, int, int]:
    """(scale, width, height) of a picture at least `width_px` wide; sides are even, as required by video codecs."""
    enlarged = max(1, -(-width_px // sensor[0]))
    width, height = (side * enlarged + side * enlarged % 2 for side in sensor)
    return enlarged, width, height


def compose(
    events: NDArray[np.uint8], enlarged: int, size: tuple[int, int], followers: Sequence[Follower], picture: int, caption: str
) -> Image.Image:
    """Compose a picture: the sensor's image, (height, width, 3), enlarged, with the followers' tracks drawn over it."""
    large = events.repeat(enlarged, 0).repeat(enlarged, 1)
    height, width = large.shape[:2]
    if (width, height) != size:
        large = np.pad(large, ((0, size[1] - height), (0, size[0] - width), (0, 0)), mode="edge")
    image = Image.fromarray(large)
    draw = ImageDraw.Draw(image)
    for place, follower in enumerate(followers):
        _draw_side(draw, follower, picture, enlarged, place)
    _write(draw, (_MARGIN_PX, size[1] - _MARGIN_PX), caption, INK, "ls")
    if len(followers) > 1:
        for row, follower in enumerate(followers):
            _write(
                draw, (size[0] - _MARGIN_PX, _MARGIN_PX + row * (_FONT_PX + 4)), follower.side.name, follower.side.colour, "rt"
            )
    return image


def _draw_side(draw: ImageDraw.ImageDraw, follower: Follower, picture: int, enlarged: int, place: int) -> None:
    states, trails = follower.at(picture)
    pen = min(enlarged, 2)
    for trail in trails.values():
        _trail(draw, trail, enlarged, follower.side.colour)
    # A pixel's middle is half a pixel from the edge of the picture.
    boxes = (box_corners(states) + 0.5) * enlarged
    for track_id, angle, corners in zip(states["track_id"].tolist(), states["angle"].tolist(), boxes, strict=True):
        (left, top), (right, bottom) = corners.min(axis=0).tolist(), (corners.max(axis=0) - 1).tolist()
        if angle:
            draw.polygon([tuple(corner) for corner in corners.tolist()], outline=follower.side.colour, width=pen)
        else:
            draw.rectangle((left, top, max(left, right), max(top, bottom)), outline=follower.side.colour, width=pen)
        # Ids of the second side are drawn below the box, so that they do not cover those of the first.
        above, below = max(top - 2, _FONT_PX), min(bottom + 2 + _FONT_PX, draw.im.size[1] - 2)
        _write(draw, (max(left, 2), below if place % 2 else above), str(track_id), follower.side.colour, "ls")


def _trail(draw: ImageDraw.ImageDraw, trail: deque[tuple[float, float]], enlarged: int, colour: RGB) -> None:
    if len(trail) > 1:
        draw.line([((x + 0.5) * enlarged, (y + 0.5) * enlarged) for x, y in trail], fill=colour, width=1)


def _write(draw: ImageDraw.ImageDraw, at: tuple[float, float], text: str, colour: RGB, anchor: str) -> None:
    draw.text(at, text, fill=colour, font=_font(), anchor=anchor, stroke_width=2, stroke_fill=GROUND)


@cache
def _font() -> ImageFont.FreeTypeFont:
    """The font bundled with Matplotlib, so that the result is the same on every machine."""
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans-Bold.ttf"), _FONT_PX)

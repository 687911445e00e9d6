# SPDX-License-Identifier: Apache-2.0
"""A frame of a film: events that fade, with trails, boxes and ids drawn over them, and the time in a corner."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ..._numba_private import njit
from ...events import Events, check_pixels
from ...recordings.formats.source import Sensor
from ...tracks.log import TrackLog
from ...tracks.record import box_corners
from ...tracks.timeline import sample, track_labels
from . import FADE_CONSTANTS

__all__ = [
    "EVENTS",
    "GROUND",
    "INK",
    "RGB",
    "SIDES",
    "Follower",
    "Side",
    "Surface",
    "compose",
    "hexadecimal",
    "palette",
    "shades",
    "side_of",
    "size_of",
]


RGB = tuple[int, int, int]

GROUND: RGB = (11, 14, 18)
EVENTS: tuple[RGB, RGB] = ((224, 139, 189), (47, 199, 154))  # OFF, ON
INK: RGB = (230, 233, 237)
SIDES: tuple[RGB, ...] = ((86, 180, 233), (255, 155, 71), (240, 228, 66), (255, 255, 255))

_EVENT_SHADES, _LINE_SHADES = 96, 12


def hexadecimal(rgb: RGB) -> str:
    """The colour as "#rrggbb"."""
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def shades(rgb: RGB, cover: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(n, 3): a colour blended with the background by the opacities `cover`, (n,)."""
    return np.round(cover[:, np.newaxis] * rgb + (1 - cover[:, np.newaxis]) * GROUND).astype(np.uint8)


def palette() -> NDArray[np.uint8]:
    """(256, 3): the colours of a picture, for formats with a palette."""
    events = [shades(rgb, np.linspace(0, 1, _EVENT_SHADES)) for rgb in EVENTS]
    lines = [shades(rgb, np.linspace(1, 0, _LINE_SHADES, endpoint=False)) for rgb in (*SIDES, INK)]
    rows = np.concatenate([*events, *lines])
    return np.concatenate([rows, np.tile(np.array([GROUND], np.uint8), (256 - len(rows), 1))])


_LEVELS = 256
_NEVER = np.iinfo(np.int64).min // 2


class Surface:
    """The time surface of a sensor; see the module.

    Args:
        decay_us: time constant with which events fade.
    """

    def __init__(self, sensor: Sensor, decay_us: float) -> None:
        width, height = sensor
        check_pixels(width, height)
        self._decay_us = decay_us
        self._t_us = np.full((height, width), _NEVER, np.int64)
        self._p = np.zeros((height, width), np.uint8)
        cover = np.exp(-FADE_CONSTANTS * np.arange(_LEVELS + 1) / _LEVELS)
        cover[-1] = 0
        self._table = np.array([shades(rgb, cover) for rgb in EVENTS])

    def add(self, events: Events) -> None:
        """Add events, in order of time."""
        _add(events.t_us, events.x, events.y, events.p, self._t_us, self._p)

    def picture(self, now_us: int) -> NDArray[np.uint8]:
        """(height, width, 3): the image at a time."""
        image = np.empty((*self._t_us.shape, 3), np.uint8)
        _paint(self._t_us, self._p, now_us, _LEVELS / (FADE_CONSTANTS * self._decay_us), self._table, image)
        return image


@njit(cache=True, nogil=True)
def _add(t_us, x, y, p, latest_us, latest_p):  # type: ignore[no-untyped-def]
    """Store each event as the latest of its pixel."""
    for i in range(len(t_us)):
        latest_us[y[i], x[i]] = t_us[i]
        latest_p[y[i], x[i]] = p[i]


@njit(cache=True, nogil=True)
def _paint(latest_us, latest_p, now_us, scale, table, image):  # type: ignore[no-untyped-def]
    """Colours by polarity and age."""
    faded = np.float64(table.shape[1] - 1)
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            level = min((now_us - latest_us[row, column]) * scale, faded)
            for channel in range(3):
                image[row, column, channel] = table[latest_p[row, column], np.int64(level), channel]


_TRAIL_PICTURES = 300


@dataclass(frozen=True)
class Side:
    """A track log with its display name and colour."""

    name: str
    log: TrackLog
    colour: RGB


def side_of(place: int, name: str, log: TrackLog) -> Side:
    """The side for the log at index `place` of several."""
    return Side(name, log, SIDES[place % len(SIDES)])


class Follower:
    """The visible tracks of a side, picture by picture.

    Args:
        times_us: (n,) times of the pictures, ascending.
    """

    def __init__(self, side: Side, times_us: NDArray[np.int64]) -> None:
        self.side = side
        self._states = sample(side.log, times_us)
        self._begin = np.searchsorted(self._states["sample"], np.arange(len(times_us) + 1))
        self._labels = track_labels(side.log, self._states["track_id"], times_us[self._states["sample"]])
        self._trails: dict[int, deque[tuple[float, float]]] = {}

    def at(self, picture: int) -> tuple[NDArray[np.void], list[str], dict[int, deque[tuple[float, float]]]]:
        """(states of dtype `timeline.SAMPLE`, label of each, track id -> past positions); to be called picture by picture."""
        here = slice(self._begin[picture], self._begin[picture + 1])
        states = self._states[here]
        trails = {}
        for track_id, x, y in zip(states["track_id"].tolist(), states["x"].tolist(), states["y"].tolist(), strict=True):
            trail = self._trails.get(track_id)
            trails[track_id] = deque(maxlen=_TRAIL_PICTURES) if trail is None else trail
            trails[track_id].append((x, y))
        self._trails = trails
        return states, self._labels[here], trails


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
    states, labels, trails = follower.at(picture)
    pen = min(enlarged, 2)
    for trail in trails.values():
        _trail(draw, trail, enlarged, follower.side.colour)
    # A pixel's middle is half a pixel from the edge of the picture.
    boxes = (box_corners(states) + 0.5) * enlarged
    for label, angle, corners in zip(labels, states["angle"].tolist(), boxes, strict=True):
        (left, top), (right, bottom) = corners.min(axis=0).tolist(), (corners.max(axis=0) - 1).tolist()
        if angle:
            draw.polygon([tuple(corner) for corner in corners.tolist()], outline=follower.side.colour, width=pen)
        else:
            draw.rectangle((left, top, max(left, right), max(top, bottom)), outline=follower.side.colour, width=pen)
        # Labels of the second side are drawn below the box, so that they do not cover those of the first.
        above, below = max(top - 2, _FONT_PX), min(bottom + 2 + _FONT_PX, draw.im.size[1] - 2)
        inside = min(left, draw.im.size[0] - 2 - draw.textlength(label, _font()))
        _write(draw, (max(inside, 2), below if place % 2 else above), label, follower.side.colour, "ls")


def _trail(draw: ImageDraw.ImageDraw, trail: deque[tuple[float, float]], enlarged: int, colour: RGB) -> None:
    if len(trail) > 1:
        draw.line([((x + 0.5) * enlarged, (y + 0.5) * enlarged) for x, y in trail], fill=colour, width=1)


def _write(draw: ImageDraw.ImageDraw, at: tuple[float, float], text: str, colour: RGB, anchor: str) -> None:
    draw.text(at, text, fill=colour, font=_font(), anchor=anchor, stroke_width=2, stroke_fill=GROUND)


@cache
def _font() -> ImageFont.FreeTypeFont:
    """The font bundled with Matplotlib, so that the result is the same on every machine."""
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans-Bold.ttf"), _FONT_PX)

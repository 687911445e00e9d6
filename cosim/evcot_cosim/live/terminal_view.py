# SPDX-License-Identifier: Apache-2.0
"""Renderer of events and clusters as terminal characters, two pixels each."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rich.color import Color
from rich.segment import Segment
from rich.style import Style

from evcot.recordings.formats.source import Sensor
from evcot.tracks.boxes import upright_sides

from .frame import Frame
from .visible_clusters import Clusters

__all__ = ["Glance"]

_EMPTY, _OFF, _ON, _BOX = range(4)
_COLOURS = ("#10151b", "#cc79a7", "#009e73", "#f0e442")  # Okabe and Ito's palette
_HALF = "▀"


class Glance:
    """Draws the frames of a sensor into a grid of characters, as large as fits."""

    def __init__(self, sensor: Sensor) -> None:
        self._sensor = sensor
        parsed = [Color.parse(colour) for colour in _COLOURS]
        self._styles = [[Style(color=top, bgcolor=bottom) for bottom in parsed] for top in parsed]

    def lines(self, frame: Frame | None, columns: int, rows: int) -> list[list[Segment]]:
        """Rows of segments, at most `columns` wide and `rows` high."""
        width, height = self._sensor
        scale = max(width / columns, height / (2 * rows))
        shape = max(1, int(height / scale / 2)) * 2, max(1, int(width / scale))
        field = np.zeros(shape, np.uint8)
        if frame is not None:
            seen = ~frame.filtered
            cells = (
                np.minimum((frame.y[seen] / scale).astype(np.int64), shape[0] - 1),
                np.minimum((frame.x[seen] / scale).astype(np.int64), shape[1] - 1),
            )
            field[cells] = np.where(frame.on[seen], _ON, _OFF)
            _draw_boxes(field, frame.clusters, scale)
        return [self._line(field[row], field[row + 1]) for row in range(0, shape[0], 2)]

    def _line(self, top: NDArray[np.uint8], bottom: NDArray[np.uint8]) -> list[Segment]:
        """One row of characters; neighbours of the same style form one segment."""
        look = top.astype(np.int64) * len(_COLOURS) + bottom
        cuts = [0, *(np.flatnonzero(np.diff(look)) + 1).tolist(), len(look)]
        return [Segment(_HALF * (end - begin), self._styles[top[begin]][bottom[begin]]) for begin, end in pairwise(cuts)]


def _draw_boxes(field: NDArray[np.uint8], clusters: Clusters, scale: float) -> None:
    rows, columns = field.shape
    for state, width, height in zip(clusters.states, *upright_sides(clusters.states), strict=True):
        left, right = (int((state["x"] + side * width / 2) / scale) for side in (-1, 1))
        top, bottom = (int((state["y"] + side * height / 2) / scale) for side in (-1, 1))
        across, down = slice(max(left, 0), max(right + 1, 0)), slice(max(top, 0), max(bottom + 1, 0))
        for row in (top, bottom):
            if 0 <= row < rows:
                field[row, across] = _BOX
        for column in (left, right):
            if 0 <= column < columns:
                field[down, column] = _BOX

# SPDX-License-Identifier: Apache-2.0
"""Common to all pictures over time: the axis, the number of tracks alive, the ends of lives, and merges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..tracks.log import Kind
from ..tracks.timeline import OPEN
from .style import INK

__all__ = ["END_MARKERS", "Point", "TimeAxis", "draw_alive", "draw_merges"]

Point = tuple[float, float]

# How a life ended (`timeline.LIFE`) -> the marker at its end.
END_MARKERS: dict[int, str] = {int(Kind.LOST): "|", int(Kind.MERGED): "D", OPEN: ">"}


@dataclass(frozen=True)
class TimeAxis:
    """A recording's times as positions on an axis, in seconds, or in milliseconds below two seconds.

    Attributes:
        zero_us: time at position 0.
        length_us: how much time is shown.
    """

    zero_us: int
    length_us: int

    @property
    def unit(self) -> str:
        """Name of the unit."""
        return "s" if self._long else "ms"

    def __call__(self, t_us: NDArray[np.int64]) -> NDArray[np.float64]:
        """Positions of times."""
        return np.asarray((t_us - self.zero_us) / (1e6 if self._long else 1e3), np.float64)

    @property
    def _long(self) -> bool:
        return self.length_us >= 2_000_000


def draw_alive(
    ax: Axes, at: NDArray[np.float64], sides: Iterable[tuple[NDArray[np.int64], dict[str, Any]]], label: str
) -> None:
    """Steps of how many tracks are alive at each position, one line for each (counts, look)."""
    most = 1
    for counts, look in sides:
        most = max(most, int(counts.max()))
        ax.step(at, counts, where="post", **look)
    ax.set_ylim(0, 1.12 * most)
    ax.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    ax.set_ylabel(label)


def draw_merges(ax: Axes, joins: Sequence[tuple[Point, Point]], width: float) -> None:
    """A line from each merged life to its survivor."""
    ax.add_collection(LineCollection(joins, colors=INK, linewidths=width))

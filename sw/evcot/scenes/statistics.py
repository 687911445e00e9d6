# SPDX-License-Identifier: Apache-2.0
"""Statistics of the events of a recording, to compare simulated with real ones.

    python -m evcot.scenes.statistics real.aedat4 simulated.aedat4

prints one column per recording.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import EvcotError
from ..events import Recording
from ..recordings.files import read_recording

__all__ = ["Statistics", "main", "statistics", "table"]

PIXEL_QUANTILES = (0.25, 0.5, 0.75, 0.9, 0.99)
INTERVAL_QUANTILES = (0.01, 0.1, 0.25, 0.5, 0.75, 0.9)
HOT_FACTOR = 10.0  # a pixel is hot from this many times the 99.9th percentile of all pixels


@dataclass(frozen=True, eq=False)
class Statistics:
    """Statistics of one recording.

    Attributes:
        events_per_s: of all pixels together.
        on_share: share of ON events.
        hot: (n, 3) int64, x, y and events per second of pixels far above all others; excluded from the following fields.
        pixel_hz: (width * height - n,) events per second of each pixel.
        intervals_us: (m,) times from an event of a pixel to its next.
        silent_share: share of pixels without events.
    """

    events_per_s: float
    on_share: float
    hot: NDArray[np.int64]
    pixel_hz: NDArray[np.float64]
    intervals_us: NDArray[np.int64]

    @property
    def silent_share(self) -> float:
        return float(np.mean(self.pixel_hz == 0)) if len(self.pixel_hz) else 0.0


def statistics(recording: Recording) -> Statistics:
    """Statistics of a recording; rates are 0 unless it has two events at different times."""
    events, width = recording.events, recording.width
    seconds = recording.duration_us * 1e-6
    pixel = events.y.astype(np.int64) * width + events.x
    counts = np.bincount(pixel, minlength=width * recording.height)
    rates = counts / seconds if seconds else np.zeros(len(counts))
    hot = np.flatnonzero(rates > HOT_FACTOR * max(float(np.quantile(rates, 0.999)), 1.0))
    order = np.argsort(pixel, kind="stable")
    gaps, same = np.diff(events.t_us[order]), np.diff(pixel[order]) == 0
    return Statistics(
        len(events) / seconds if seconds else 0.0,
        float(events.p.mean()) if len(events) else 0.0,
        np.stack((hot % width, hot // width, np.rint(rates[hot]).astype(np.int64)), axis=1),
        np.delete(rates, hot),
        gaps[same & ~np.isin(pixel[order][1:], hot)],
    )


def table(names: Sequence[str], columns: Sequence[Statistics]) -> list[list[str]]:
    """Rows of text, beginning with the heading."""

    def row(title: str, cells: Sequence[str]) -> list[str]:
        return [title, *cells]

    def quantile(values: NDArray[Any], part: float) -> float:
        return float(np.quantile(values, part)) if len(values) else 0.0

    rows = [
        row("", names),
        row("events/s", [f"{one.events_per_s:,.0f}" for one in columns]),
        row("ON share", [f"{one.on_share:.3f}" for one in columns]),
        row("hot pixels (x, y: Hz)", ["; ".join(f"{x}, {y}: {hz}" for x, y, hz in one.hot[:3].tolist()) for one in columns]),
        row("silent pixels", [f"{one.silent_share:.3f}" for one in columns]),
    ]
    rows += [
        row(f"pixel rate, {part:.0%} quantile, Hz", [f"{quantile(one.pixel_hz, part):.2f}" for one in columns])
        for part in PIXEL_QUANTILES
    ]
    rows += [
        row(f"interval, {part:.0%} quantile, ms", [f"{quantile(one.intervals_us, part) / 1000:.2f}" for one in columns])
        for part in INTERVAL_QUANTILES
    ]
    return rows


def main(arguments: Sequence[str]) -> int:
    """Print the table of the recordings named; returns the exit code."""
    if not arguments:
        print("usage: python -m evcot.scenes.statistics RECORDING ...", file=sys.stderr)
        return 2
    try:
        rows = table([Path(path).stem for path in arguments], [statistics(read_recording(path)) for path in arguments])
    except EvcotError as error:
        print(f"statistics: {error}", file=sys.stderr)
        return 2
    widths = [max(len(line[i]) for line in rows) for i in range(len(rows[0]))]
    for title, *cells in rows:
        print(title.ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=True)), sep="  ")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

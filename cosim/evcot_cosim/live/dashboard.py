# SPDX-License-Identifier: Apache-2.0
"""The live view in a terminal: a small picture, figures, and the oldest clusters."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.color import Color
from rich.console import Console, ConsoleOptions, Group, RenderableType
from rich.layout import Layout
from rich.live import Live
from rich.panel import Panel
from rich.segment import Segment
from rich.style import Style
from rich.table import Table
from rich.text import Text

from evcot.recordings.formats.source import Sensor
from evcot.tracks.record import upright_sides

from .messages import Frame, FrameMaker
from .player import Player, Run
from .session import Session
from .visible_clusters import Clusters

__all__ = ["rows_of", "show"]


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


_PICTURES_HZ = 15
_SIDE_COLUMNS = 44
_CLUSTERS_MAX = 20


class _Picture:
    """The newest frame, scaled to its place in the terminal."""

    def __init__(self, glance: Glance) -> None:
        self._glance = glance
        self.frame: Frame | None = None

    def __rich_console__(self, _console: Console, options: ConsoleOptions) -> Iterator[Segment]:
        for line in self._glance.lines(self.frame, options.max_width, options.height or options.max_height):
            yield from line
            yield Segment.line()


def show(player: Player, url: str | None, console: Console, going_on: Callable[[], bool]) -> None:
    """Display what is played for as long as that goes on; KeyboardInterrupt is left to the caller."""
    layout = Layout()
    layout.split_row(Layout(name="picture"), Layout(name="side", size=_SIDE_COLUMNS))
    with Live(layout, console=console, screen=True, auto_refresh=False) as live:
        while going_on():
            _show_run(player, player.run, layout, live, url, going_on)


def _show_run(player: Player, run: Run, layout: Layout, live: Live, url: str | None, going_on: Callable[[], bool]) -> None:
    """Display one session until another takes its place."""
    session = run.session
    inbox = session.subscribe()
    maker, picture = FrameMaker(session.source.sensor), _Picture(Glance(session.source.sensor))
    drawn_here = url is None  # with a page, its drawing is what is measured
    layout["picture"].update(Panel(picture, title=session.source.name, title_align="left"))
    try:
        while going_on() and player.run is run:
            taken = inbox.take(1 / _PICTURES_HZ)
            clusters = session.clusters
            if taken and taken.items:
                picture.frame = maker.make(taken.items, clusters)
            layout["side"].update(_side(session, clusters, inbox.lost, url))
            live.refresh()
            if drawn_here and taken and taken.items and picture.frame is not None:
                session.drawn.add(time.perf_counter() - picture.frame.arrived_s)
            time.sleep(1 / _PICTURES_HZ)
    finally:
        session.unsubscribe(inbox)


def _side(session: Session, clusters: Clusters, undrawn: int, url: str | None) -> RenderableType:
    figures = session.figures()
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim")
    grid.add_column(justify="right")
    for name, value in rows_of(figures):
        alarming = name in ("dropped", "left out", "playback delay") and value != "0"
        grid.add_row(name, Text(value, style="bold red" if alarming else "bold"))
    grid.add_row("not drawn", f"{undrawn:,}")
    table = Table(box=None, padding=(0, 1))
    classes = ["class"] if len(session.labels) > 2 else []
    for name in ("id", *classes, "age", "x", "y", "size", "px/s"):
        table.add_column(name, justify="right", header_style="dim")
    rows = zip(clusters.birth_us.tolist(), clusters.label.tolist(), clusters.states, strict=True)
    oldest = sorted(rows, key=lambda each: each[0])
    for birth_us, label, state in oldest[:_CLUSTERS_MAX]:
        age_s = max(int(state["t_us"]) - birth_us, 0) / 1e6
        size, speed = f"{state['width']:.0f}x{state['height']:.0f}", f"{math.hypot(state['vx'], state['vy']):.0f}"
        numbers = f"{age_s:.1f} s", f"{state['x']:.0f}", f"{state['y']:.0f}", size, speed
        table.add_row(str(state["track_id"]), *([session.labels[label]] if classes else []), *numbers)
    page = Text(f"page: {url}\n" if url else "page: --web shows one\n", style="dim")
    return Group(Panel(Group(grid, page), title="figures"), Panel(table, title="clusters, oldest first"))


def rows_of(figures: dict[str, Any]) -> list[tuple[str, str]]:
    """Figures of a session as text, (label, value)."""
    rows = [
        ("events", f"{figures['events']:,}"),
        ("rate", f"{figures['events_per_s'] / 1e6:.3f} M events/s"),
        ("time tracked", f"{figures['recording_s']:.1f} s"),
        ("clusters now", f"{figures['clusters']:,}"),
        ("tracks", f"{figures['tracks']:,}, {figures['merged']:,} merged, {figures['lost']:,} lost"),
        ("event to tracked", _milliseconds(figures["tracked_ms"])),
        ("event to drawn", _milliseconds(figures["drawn_ms"])),
        ("dropped", f"{figures['dropped']:,}"),
    ]
    if figures["left_out"]:
        rows.append(("left out", f"{figures['left_out']:,}"))
    if figures["slipped_s"]:
        rows.append(("playback delay", f"{figures['slipped_s']:.1f} s"))
    for beside in figures["beside"]:
        dropped = f", {beside['dropped']:,} dropped" if beside["dropped"] else ""
        rows.append((beside["name"], f"{beside['clusters']:,} now, {beside['tracks']:,} tracks{dropped}"))
        rows.append(("", beside["about"]))
    if figures["saved"] is not None:
        rows.append(("saved", f"{figures['saved']:,}"))
    return rows


def _milliseconds(quantiles: dict[str, float | None]) -> str:
    p50, p99 = quantiles["p50"], quantiles["p99"]
    return "no viewer" if p50 is None or p99 is None else f"{p50:.1f} ms, p99 {p99:.1f}"

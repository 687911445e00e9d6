# SPDX-License-Identifier: Apache-2.0
"""Figures for publications: tracks over events, positions over time, number of tracks alive, and lifetimes.

A figure is a stack of panels, with sizes in millimetres. Colours distinguish tracks of one log, else logs.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ..errors import ConfigError
from ..events import Events, check_pixels
from ..recordings.formats.source import Sensor
from ..tracks.log import Kind, TrackLog
from ..tracks.timeline import alive, lifetimes, sample, track_labels
from .panels import END_MARKERS, TimeAxis, draw_alive, draw_merges
from .style import COLUMN_MM, DASHES, KINDS, PALETTE, RULES, save

__all__ = [
    "Log",
    "Material",
    "NotebookFigure",
    "alive_panel",
    "density",
    "figure_of",
    "lives_panel",
    "place_panel",
    "plot",
    "tracks_panel",
]

_SAMPLES = 2_000  # number of sample times in a window


@dataclass(frozen=True)
class Log:
    """A track log and its display name."""

    name: str
    log: TrackLog


@dataclass(frozen=True)
class Material:
    """Events and logs in a window of time.

    Attributes:
        counts: (height, width) events per pixel.
        logs: one or more.
        from_us, to_us: start and end of the window, in the recording's time.
        zero_us: origin of the time axis.
    """

    counts: NDArray[np.int64]
    logs: tuple[Log, ...]
    from_us: int
    to_us: int
    zero_us: int

    @cached_property
    def times_us(self) -> NDArray[np.int64]:
        """Sample times, evenly spaced over the window."""
        return np.unique(np.linspace(self.from_us, max(self.to_us, self.from_us + 1), _SAMPLES).astype(np.int64))

    @cached_property
    def axis(self) -> TimeAxis:
        """Times as positions on the axis."""
        return TimeAxis(self.zero_us, self.to_us - self.from_us)

    def paths(self, log: Log) -> dict[int, NDArray[np.void]]:
        """Track id -> states in the window in order of time, of dtype `timeline.SAMPLE`; tracks in order of birth."""
        states = sample(log.log, self.times_us)
        states = states[np.argsort(states["track_id"], kind="stable")]
        ids, begin = np.unique(states["track_id"], return_index=True)
        return dict(zip(ids.tolist(), np.split(states, begin[1:]), strict=False)) if len(ids) else {}

    def lives(self, log: Log) -> NDArray[np.void]:
        """The lives that overlap the window, of dtype `timeline.LIFE`, in order of birth."""
        lives = lifetimes(log.log, self.to_us)
        touching: NDArray[np.void] = lives[(lives["birth_us"] <= self.to_us) & (lives["end_us"] >= self.from_us)]
        return touching

    def alive(self, log: Log) -> NDArray[np.int64]:
        """Number of visible tracks at each of `times_us`."""
        return alive(log.log, self.times_us)


def density(blocks: Iterable[Events], sensor: Sensor) -> tuple[NDArray[np.int64], int, int]:
    """(height, width) events per pixel, and the times of the first and the last event; (0, 0) without events."""
    width, height = sensor
    check_pixels(width, height)
    counts = np.zeros(width * height, np.int64)
    first_us: int | None = None
    last_us = 0
    for block in blocks:
        if len(block):
            counts += np.bincount(block.y.astype(np.int64) * width + block.x, minlength=width * height)
            first_us = int(block.t_us[0]) if first_us is None else first_us
            last_us = int(block.t_us[-1])
    return counts.reshape(height, width), first_us or 0, last_us


_DARKEST = 0.45  # of the pixel with the most events; paths must stand out
_WIDER = 0.9  # points
_LABELS_MAX = 24  # with more tracks, no labels are drawn
_ROW_LABELS_MAX = 40


def _styled(material: Material) -> Iterator[tuple[Log, NDArray[np.void], dict[str, Any]]]:
    """All lives as (log, life, line style). Earlier logs have wider lines, so that later ones do not hide them."""
    several = len(material.logs) > 1
    for place, log in enumerate(material.logs):
        width = 1.0 + _WIDER * (len(material.logs) - 1 - place)
        lives = material.lives(log)
        of_track = {track_id: i for i, track_id in enumerate(dict.fromkeys(lives["track_id"].tolist()))}
        for life in lives:
            colour = PALETTE[(place if several else of_track[int(life["track_id"])]) % len(PALETTE)]
            yield log, life, {"color": colour, "linestyle": DASHES[place % len(DASHES)], "linewidth": width}


def _lines(ax: Axes, material: Material, curve: tuple[str, str], name_at_end: bool) -> None:
    """Draw a line per life of a track through two fields of its states; "t" is the time."""
    paths = {log.name: material.paths(log) for log in material.logs}
    few = sum(map(len, paths.values())) <= _LABELS_MAX
    for log, life, look in _styled(material):
        states = paths[log.name].get(int(life["track_id"]))
        if states is None:
            continue
        times_us = material.times_us[states["sample"]]
        states = states[(times_us >= life["birth_us"]) & (times_us <= life["end_us"])]
        if not len(states):
            continue
        across, up = (material.axis(material.times_us[states["sample"]]) if field == "t" else states[field] for field in curve)
        ax.plot(across, up, color="white", linewidth=look["linewidth"] + 1, alpha=0.7, zorder=1.5)
        ax.plot(across, up, **look)
        if few and name_at_end:
            label = track_labels(log.log, states["track_id"][-1:], material.times_us[states["sample"][-1:]])[0]
            ax.annotate(
                label, (across[-1], up[-1]), (2, 2), textcoords="offset points", color=look["color"],
                fontsize=6, weight="bold", annotation_clip=True, path_effects=[withStroke(linewidth=1.5, foreground="white")],
            )  # fmt: skip


def tracks_panel(ax: Axes, material: Material) -> None:
    """Draw the events in grey, and the paths of the tracks, each labelled at its end."""
    height, width = material.counts.shape
    full = max(float(np.quantile(some, 0.98)) if len(some := material.counts[material.counts > 0]) else 1.0, 1.0)
    grey = 1 - _DARKEST * np.minimum(np.log1p(material.counts) / np.log1p(full), 1)
    ax.imshow(
        grey,
        cmap="gray",
        vmin=0,
        vmax=1,
        extent=(-0.5, width - 0.5, height - 0.5, -0.5),
        interpolation="nearest",
        aspect="equal",
    )
    _lines(ax, material, ("x", "y"), name_at_end=True)
    ax.set_xlim(-0.5, width - 0.5)
    ax.set_ylim(height - 0.5, -0.5)
    for spine in ax.spines.values():
        spine.set_visible(True)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(6, integer=True))
    ax.set_xlabel("x (px)")
    ax.set_ylabel("y (px)")


def place_panel(ax: Axes, material: Material, field: str) -> None:
    """Draw x or y of every track over time; the y axis points down, as on the sensor."""
    _lines(ax, material, ("t", field), name_at_end=field == "x")
    height, width = material.counts.shape
    ax.set_ylim((-0.5, width - 0.5) if field == "x" else (height - 0.5, -0.5))
    ax.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    ax.set_ylabel(f"{field} (px)")
    _time(ax, material)


def alive_panel(ax: Axes, material: Material) -> None:
    """Draw the number of visible tracks over time."""
    looks = [
        {"color": PALETTE[place % len(PALETTE)], "linestyle": DASHES[place % len(DASHES)]}
        for place in range(len(material.logs))
    ]
    counts = zip(map(material.alive, material.logs), looks, strict=True)
    draw_alive(ax, material.axis(material.times_us), counts, "tracks alive")
    _time(ax, material)


def lives_panel(ax: Axes, material: Material) -> None:
    """Draw every track from birth to end, one log above the other; a merge is linked to its survivor."""
    lives = {log.name: material.lives(log) for log in material.logs}
    tracks = dict.fromkeys((name, track_id) for name, some in lives.items() for track_id in some["track_id"].tolist())
    rows = {track: row for row, track in enumerate(tracks)}  # one that was lost and found again stays in its row
    for log, life, look in _styled(material):
        _life(ax, material, life, rows[log.name, int(life["track_id"])], look["color"])
    joins = [
        (
            (at := float(material.axis(life["end_us"])), rows[name, int(life["track_id"])]),
            (at, rows[name, int(life["other_id"])]),
        )
        for name, some in lives.items()
        for life in some[some["ended"] == Kind.MERGED]
        if (name, int(life["other_id"])) in rows
    ]
    draw_merges(ax, joins, 0.5)
    ax.set_ylim(max(len(rows), 1) - 0.3, -0.7)
    every = -(-len(rows) // _ROW_LABELS_MAX) or 1
    named = [(row, str(track_id)) for (_, track_id), row in rows.items() if row % every == 0]
    ax.set_yticks([row for row, _ in named], [text for _, text in named])
    ax.tick_params(axis="y", length=0)
    ax.set_ylabel("track id")
    _time(ax, material)


def _life(ax: Axes, material: Material, life: NDArray[np.void], row: int, colour: str) -> None:
    begin, end = (float(material.axis(life[name])) for name in ("birth_us", "end_us"))
    ax.hlines(row, begin, end, color=colour, linewidth=2.0)
    marker = END_MARKERS[int(life["ended"])]
    ax.plot(end, row, marker, color=colour, markersize=5 if marker == "|" else 3, clip_on=True)


def _time(ax: Axes, material: Material) -> None:
    begin, end = material.axis(np.array([material.from_us, material.to_us]))
    margin = 0.015 * max(end - begin, 1e-9)
    ax.set_xlim(begin - margin, end + margin)
    ax.set_xlabel(f"time ({material.axis.unit})")


_MM_PER_INCH = 25.4
_SIDE_MM = (20.0, 1000.0)
_DPI = (50.0, 1200.0)
_LEGEND_MM = 5.0
_ROW_MM = 2.6  # height of a row in the panel of lives


class NotebookFigure(Figure):
    """A figure that a notebook shows without Matplotlib's own set-up for notebooks."""

    def _repr_png_(self) -> bytes:
        """The figure as a PNG."""
        file = io.BytesIO()
        self.savefig(file, format="png")
        return file.getvalue()


@dataclass(frozen=True)
class _Panel:
    """A panel's drawing function, and its height at a given width, in mm."""

    draw: Callable[[Axes, Material], None]
    height_mm: Callable[[Material, float], float]


def _scene_mm(material: Material, width_mm: float) -> float:
    height, width = material.counts.shape
    return float((width_mm - 12) * height / width + 9)


def _lives_mm(material: Material, _width_mm: float) -> float:
    return min(12 + _ROW_MM * sum(len(material.lives(log)) for log in material.logs), 110)


_TRACKS = (_Panel(tracks_panel, _scene_mm),)
_PLACES = (
    _Panel(lambda ax, material: place_panel(ax, material, "x"), lambda *_: 32),
    _Panel(lambda ax, material: place_panel(ax, material, "y"), lambda *_: 32),
)
_ALIVE = (_Panel(alive_panel, lambda *_: 28),)
_LIVES = (_Panel(lives_panel, _lives_mm),)
_KINDS = dict(zip(KINDS, (_TRACKS, _PLACES, _ALIVE, _LIVES), strict=True))


def plot(
    material: Material, path: Path | str, kinds: Sequence[str] = ("tracks",), *, width_mm: float = COLUMN_MM[1],
    height_mm: float | None = None, dpi: float = 300, force: bool = False,
) -> None:  # fmt: skip
    """Draw a figure and write it; the path's suffix is .png, .svg or .pdf. Equal material gives identical files.

    Args:
        kinds, width_mm, height_mm: as of `figure_of`.
        dpi: resolution of a PNG, and of the image of events in the other formats.
        force: replace an existing file.

    Raises:
        ConfigError: an unknown kind or suffix, or an invalid size.
        OutputError: the file exists, or cannot be written.
    """
    figure = figure_of(material, kinds, width_mm=width_mm, height_mm=height_mm, dpi=dpi)
    with matplotlib.rc_context(RULES):
        save(figure, Path(path), dpi, force=force)


def figure_of(
    material: Material, kinds: Sequence[str] = ("tracks",), *, width_mm: float = COLUMN_MM[1],
    height_mm: float | None = None, dpi: float = 300,
) -> NotebookFigure:  # fmt: skip
    """Draw a figure.

    Args:
        kinds: panels, from top to bottom, of `KINDS`.
        width_mm, height_mm: size; by default the height required by the panels.
        dpi: resolution.

    Raises:
        ConfigError: an unknown kind, or an invalid size.
    """
    unknown = next((kind for kind in kinds if kind not in _KINDS), None)
    if unknown is not None or not kinds:
        raise ConfigError(f"--kind {unknown or ''}: must be one or more of {', '.join(KINDS)}")
    panels = [panel for kind in kinds for panel in _KINDS[kind]]
    heights = [panel.height_mm(material, width_mm) for panel in panels]
    legend_mm = _LEGEND_MM if len(material.logs) > 1 else 0.0
    whole_mm = sum(heights) + legend_mm if height_mm is None else height_mm
    for name, value, (low, high) in (("--width", width_mm, _SIDE_MM), ("--height", whole_mm, _SIDE_MM), ("--dpi", dpi, _DPI)):
        if not low <= value <= high:
            raise ConfigError(f"{name} {value:g}: must be from {low:g} to {high:g}")
    with matplotlib.rc_context(RULES):
        size = width_mm / _MM_PER_INCH, whole_mm / _MM_PER_INCH
        layout = ConstrainedLayoutEngine(w_pad=0.02, h_pad=0.02)
        figure = NotebookFigure(figsize=size, dpi=dpi, facecolor="white", layout=layout)
        FigureCanvasAgg(figure)
        axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
        for ax, panel in zip(axes, panels, strict=True):
            panel.draw(ax, material)
        if legend_mm:
            figure.legend(handles=_legend(material), loc="outside upper center", ncols=len(material.logs), handlelength=2.5)
    return figure


def _legend(material: Material) -> list[Line2D]:
    return [
        Line2D([], [], color=PALETTE[i % len(PALETTE)], linestyle=DASHES[i % len(DASHES)], label=log.name)
        for i, log in enumerate(material.logs)
    ]

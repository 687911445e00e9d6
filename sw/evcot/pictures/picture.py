# SPDX-License-Identifier: Apache-2.0
"""One picture of a run: the scene with both trackers' paths and boxes, clusters over time, lives and merges."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..errors import ConfigError
from ..events import Events, Recording
from ..outputs import written_aside
from ..tracks.log import TrackLog
from ..tracks.timeline import alive, lifetimes
from .panels import END_MARKERS, EVENT_COLOURS, NOTHING, Clock, Side, count_panel, lives_panel, moment_panel, scene_panel
from .plots import Log, Material, density, figure_of
from .style import INK

if TYPE_CHECKING:
    from .plots import NotebookFigure

__all__ = ["SIZE_PX", "draw", "log_figure", "log_html"]


SIZE_PX = (1950, 1095)  # width, height of every picture

_DPI = 150
_LEFT = 0.048  # margin, as a fraction of the width
_CLOCK_SAMPLES = 2_000
_MOMENTS = 4
_TRACKS_MAX = 40  # maximum per engine; the longest are drawn
_ENGINES: tuple[tuple[str, str, float, Literal["solid", "dashed"]], ...] = (
    ("hardware", "#0072B2", 2.4, "solid"),
    ("software", "#D55E00", 1.0, "dashed"),
)

_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.8,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def draw(
    recording: Recording, hardware: TrackLog, software: TrackLog, path: Path | str, title: str, *, force: bool = False
) -> None:
    """Draw a run as a PNG of `SIZE_PX`.

    Left: all events by polarity and the paths of both trackers; below it a few numbered moments, each with the events just
    before it and both trackers' boxes. Right: the number of clusters alive, and every track from birth to end, with merges
    linked to the survivor.
    If there are too many tracks, only the longest are drawn, and the picture states this.

    Args:
        recording: the recording that both tracked.
        hardware, software: the logs; either may be empty.
        path: the file; it appears under its name only when it is complete.
        title: title at the top.

    Raises:
        OutputError: the file cannot be written.
    """
    clock = _clock(recording, hardware, software)
    sides = [
        _side(name, colour, width, dashes, log, int(clock.times_us[-1]))
        for (name, colour, width, dashes), log in zip(_ENGINES, (hardware, software), strict=True)
    ]
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(SIZE_PX[0] / _DPI, SIZE_PX[1] / _DPI), dpi=_DPI, facecolor="white")
        FigureCanvasAgg(figure)
        columns = figure.add_gridspec(1, 2, width_ratios=(1.1, 1), left=_LEFT, right=0.985, top=0.865, bottom=0.07, wspace=0.18)
        left = columns[0].subgridspec(3, 1, height_ratios=(1, 0.36, 0.01), hspace=0.42)
        scene = figure.add_subplot(left[0], anchor="N")
        over_time = columns[1].subgridspec(2, 1, height_ratios=(1, 2.8), hspace=0.16)
        count = figure.add_subplot(over_time[0])
        lives = figure.add_subplot(over_time[1], sharex=count)
        scene.set_title("(a) paths; below, boxes at four moments")
        count.set_title("(b) clusters alive", pad=14)
        lives.set_title("(c) lifetimes and merges")
        scene_panel(scene, recording, sides, clock)
        count_panel(count, sides, clock)
        lives_panel(lives, sides, clock)
        beneath = left[1].subgridspec(1, _MOMENTS, wspace=0.06)
        for moment in range(len(clock.moments_us)):
            moment_panel(figure.add_subplot(beneath[moment], anchor="N"), recording, sides, clock, moment)
        scene.legend(
            handles=_legend(sides),
            ncols=5,
            columnspacing=1.2,
            handlelength=2,
            loc="lower left",
            bbox_to_anchor=(_LEFT - 0.01, 0.015),
            bbox_transform=figure.transFigure,
        )
        figure.text(_LEFT, 0.965, title, fontsize=13, weight="bold", va="center", color=INK)
        figure.text(_LEFT, 0.928, _subtitle(recording, sides), va="center", color=INK)
        with written_aside(Path(path), force=force) as file:
            figure.savefig(file, format="png")


def _clock(recording: Recording, *logs: TrackLog) -> Clock:
    """The recording's time axis, and moments spread over the part in which most engines have visible tracks."""
    t_us = recording.events.t_us
    begin_us, end_us = (int(t_us[0]), int(t_us[-1])) if len(t_us) else (0, 0)
    times_us = np.unique(np.linspace(begin_us, max(end_us, begin_us + 1), _CLOCK_SAMPLES).astype(np.int64))
    seeing = np.sum([alive(log, times_us) > 0 for log in logs], axis=0)
    busy_us = times_us[seeing == seeing.max()]
    at = (np.arange(_MOMENTS) + 0.5) / _MOMENTS * len(busy_us)
    return Clock(times_us, np.unique(busy_us[at.astype(np.int64)]) if seeing.max() else np.empty(0, np.int64))


def _side(name: str, colour: str, width: float, dashes: Literal["solid", "dashed"], log: TrackLog, end_us: int) -> Side:
    lives = lifetimes(log, end_us)
    longest = np.argsort(lives["birth_us"] - lives["end_us"], kind="stable")[:_TRACKS_MAX]
    return Side(name, colour, width, dashes, log, lives[np.sort(longest)], len(lives))


def _legend(sides: list[Side]) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = []
    for side in sides:
        handles.append(Line2D([], [], color=side.colour, linewidth=side.width, label=f"{side.name} ({side.log.engine})"))
        handles.append(Patch(facecolor="none", edgecolor=side.colour, linestyle=side.dashes, label=f"{side.name} box"))
    handles += [Patch(color=colour, label=f"{name} events") for name, colour in zip(("OFF", "ON"), EVENT_COLOURS, strict=True)]
    handles += [
        Line2D([], [], color=INK, linestyle="", marker=marker, label=label)
        for marker, label in zip(END_MARKERS.values(), ("lost", "merged into", "still alive"), strict=True)
    ]
    return handles


def _subtitle(recording: Recording, sides: list[Side]) -> str:
    parts = [f"{recording.name}: {len(recording.events):,} events in {recording.duration_us * 1e-6:.3g} s"]
    parts.append(f"{recording.width} × {recording.height} px")
    if not any(side.tracks for side in sides):
        parts.append(NOTHING)
    parts += [f"the {len(s.lives)} longest of {s.tracks} {s.name} tracks drawn" for s in sides if len(s.lives) < s.tracks]
    return "   ·   ".join(parts)


_WIDTH_MM, _NOTEBOOK_DPI = 150.0, 110.0  # 650 px, which a notebook's column holds
_LONGEST_ASPECT = 4  # of the sensor that is drawn without a recording
_SIDE_MAX_PX = 4_096  # of its sides: more is outside every event camera


def log_figure(log: TrackLog, recording: Recording | None, panels: Sequence[str]) -> NotebookFigure:
    """See `TrackLog.plot`."""
    if recording is None:
        recording = _empty_sensor(log)
    elif len(log.owner) > len(recording.events):
        rule = f"must be the recording of the log, of {len(log.owner):,} events at least"
        raise ConfigError(f"plot: {recording.name} has {len(recording.events):,} events: {rule}")
    counts, _, _ = density([recording.events], (recording.width, recording.height))
    times_us = np.concatenate((recording.events.t_us, log.records["t_us"]))
    from_us, to_us = (int(times_us.min()), int(times_us.max())) if len(times_us) else (0, 0)
    material = Material(counts, (Log(log.engine, log),), from_us, to_us, from_us)
    return figure_of(material, panels, width_mm=_WIDTH_MM, dpi=_NOTEBOOK_DPI)


def log_html(log: TrackLog) -> str:
    """The log in a line, and its tracks as a picture."""
    picture = base64.b64encode(log_figure(log, None, ("tracks",))._repr_png_()).decode()
    return f'<div>{html.escape(repr(log))}</div><img alt="paths of the tracks" src="data:image/png;base64,{picture}">'


def _empty_sensor(log: TrackLog) -> Recording:
    """A recording without events, on a sensor that is as large as the tracks need."""
    records = log.records
    reaches = (records[axis] + records[side] / 2 for axis, side in (("x", "width"), ("y", "height")))
    width, height = (min(max(math.ceil(np.max(reach, initial=0.0)) + 1, 1), _SIDE_MAX_PX) for reach in reaches)
    width, height = max(width, height // _LONGEST_ASPECT), max(height, width // _LONGEST_ASPECT)
    return Recording(Events.empty(), width, height, log.engine)

# SPDX-License-Identifier: Apache-2.0
"""A picture of tracks and alarms over the field of normal motion and the zones."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from ..outputs import written_aside
from ..pictures.style import INK
from ..tracks.log import Kind, TrackLog
from .alarm import Anomaly
from .field import NormalMotion
from .zones import Zones

__all__ = ["draw_alarms"]

_DPI = 110
_WIDTH_IN = 8.0
_TRACK, _ALARMED, _FIELD, _ZONE = "#0072B2", "#D55E00", "#BBBBBB", "#CC79A7"
_LEAST_SUPPORT = 0.25
_LABELS_MAX = 60
_LABEL_SHARE = 0.7  # of the width; beyond it, labels are drawn to the left of their point


def draw_alarms(
    log: TrackLog,
    alarms: NDArray[np.void],
    path: Path | str,
    title: str,
    sensor: tuple[int, int],
    normal: NormalMotion | None = None,
    zones: Zones | None = None,
    *,
    force: bool = False,
) -> None:
    """Draw a PNG: arrows of the normal direction, zones, the paths of all tracks, highlighted for those with an alarm, and each
    alarm with its kind, its track's id and its time. If there are too many alarms, only the first are labelled.

    Raises:
        OutputError: the file cannot be written.
    """
    width, height = sensor
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": 8, "axes.edgecolor": INK}):
        figure = Figure(figsize=(_WIDTH_IN, _WIDTH_IN * height / width + 0.8), dpi=_DPI, layout="constrained")
        FigureCanvasAgg(figure)
        ax = figure.add_subplot()
        if normal is not None:
            _draw_field(ax, normal)
        for zone in (zones or Zones()).zones:
            ax.add_patch(Polygon(zone.corners, facecolor=_ZONE, edgecolor=_ZONE, alpha=0.25))
            ax.annotate(zone.name, zone.corners[0], color=_ZONE)
        for line in (zones or Zones()).lines:
            ax.plot(*zip(line.begin, line.end, strict=True), color=_ZONE)
            ax.annotate(line.name, line.begin, color=_ZONE)
        alarmed = np.unique(alarms["track_id"])
        _draw_ways(ax, log, alarmed, False)
        _draw_ways(ax, log, alarmed, True)
        ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), aspect="equal", xlabel="x (px)", ylabel="y (px)")
        _label(ax, alarms)
        ax.set_title(title, loc="left", fontweight="bold", color=INK)
        with written_aside(Path(path), force=force) as file:
            figure.savefig(file, format="png")


def _draw_field(ax: Axes, normal: NormalMotion) -> None:
    field = normal.smoothed()
    row, column = np.nonzero(field.support >= _LEAST_SUPPORT)
    x, y = ((index + 0.5) * normal.config.cell_px - 0.5 for index in (column, row))
    ax.quiver(
        x, y, field.x[row, column], field.y[row, column], angles="xy", pivot="mid", color=_FIELD, scale=40, width=0.002
    )  # fmt: skip


def _draw_ways(ax: Axes, log: TrackLog, alarmed: NDArray[np.int64], wanted: bool) -> None:
    records = log.records[log.records["kind"] <= Kind.MOVED]
    records = records[np.isin(records["track_id"], alarmed) == wanted]
    records = records[np.argsort(records["track_id"], kind="stable")]
    cuts = np.flatnonzero(np.diff(records["track_id"])) + 1
    ways = [np.column_stack((way["x"], way["y"])) for way in np.split(records, cuts)]
    ax.add_collection(LineCollection(ways, colors=_ALARMED if wanted else _TRACK, linewidths=1.4 if wanted else 0.7))


def _label(ax: Axes, alarms: NDArray[np.void]) -> None:
    ax.plot(alarms["x"], alarms["y"], "o", color=_ALARMED, markersize=4, markeredgecolor="white", markeredgewidth=0.6)
    for alarm in alarms[:_LABELS_MAX]:
        kind = Anomaly(int(alarm["kind"])).name.lower().replace("_", " ")
        text = f"{kind}, {alarm['track_id']}, {alarm['t_us'] * 1e-6:.2f} s"
        right = alarm["x"] < _LABEL_SHARE * ax.get_xlim()[1]  # where there is room for the text
        place, side = ((4, 3), "left") if right else ((-4, 3), "right")
        ax.annotate(text, (alarm["x"], alarm["y"]), place, textcoords="offset points", ha=side, color=INK, fontsize=7)

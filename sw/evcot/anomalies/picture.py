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
from ..tracks.log import Kind
from ..tracks.log_files import RecordRuns
from .alarm import Anomaly
from .field import NormalMotion
from .monitor import Verdict
from .zones import Zones

__all__ = ["draw_alarms"]

_DPI = 110
_WIDTH_IN = 8.0
_TRACK, _ALARMED, _FIELD, _ZONE = "#0072B2", "#D55E00", "#BBBBBB", "#CC79A7"
_LEAST_SUPPORT = 0.25
_LABELS_MAX = 60
_WAYS_MAX = 4_000
_PLACE = np.dtype([("track_id", "<i8"), ("x", "<f4"), ("y", "<f4")])
_LABEL_SHARE = 0.7  # of the width; beyond it, labels are drawn to the left of their point


def draw_alarms(
    log: RecordRuns,
    verdict: Verdict,
    path: Path | str,
    title: str,
    sensor: tuple[int, int],
    normal: NormalMotion | None = None,
    zones: Zones | None = None,
    *,
    force: bool = False,
) -> None:
    """Draw a PNG: arrows of the normal direction, zones, the paths of all tracks, highlighted for those with an alarm, and each
    alarm with its kind, its track's id and its time. Of too many alarms only the first are labelled, of too many tracks an even
    choice is drawn, and the title says so.

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
        alarmed = np.unique(verdict.alarms["track_id"])
        every = [-(-count // _WAYS_MAX) for count in (verdict.tracks, len(alarmed))]
        for wanted in (False, True):
            _draw_ways(ax, log, alarmed, wanted, max(every[wanted], 1))
        ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), aspect="equal", xlabel="x (px)", ylabel="y (px)")
        _label(ax, verdict.alarms)
        if every[False] > 1:
            title += f", a {every[False]}th of the tracks"
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


def _draw_ways(ax: Axes, log: RecordRuns, alarmed: NDArray[np.int64], wanted: bool, every: int) -> None:
    """Draw the paths of the tracks with, or without, an alarm; of ids those that `every` divides."""
    parts = [np.empty(0, _PLACE)]
    for records in log.record_runs():
        chosen = records[(records["kind"] <= Kind.MOVED) & (records["track_id"] % every == 0)]
        chosen = chosen[np.isin(chosen["track_id"], alarmed) == wanted]
        chosen = chosen[np.argsort(chosen["track_id"], kind="stable")]
        parts.append(chosen[_farther(chosen)][["track_id", "x", "y"]].astype(_PLACE))
    places = np.concatenate(parts)
    places = places[np.argsort(places["track_id"], kind="stable")]
    cuts = np.flatnonzero(np.diff(places["track_id"])) + 1
    ways = [np.column_stack((way["x"], way["y"])) for way in np.split(places, cuts)]
    ax.add_collection(LineCollection(ways, colors=_ALARMED if wanted else _TRACK, linewidths=1.4 if wanted else 0.7))


def _farther(records: NDArray[np.void]) -> NDArray[np.bool_]:
    """Of records by track, those that are in another pixel than the one before, and each track's first and last."""
    changes = np.zeros(len(records) + 1, np.bool_)
    changes[[0, -1]] = True
    changes[1:-1] = np.diff(records["track_id"]) != 0
    moved = np.zeros(len(records), np.bool_)
    for axis in "xy":
        moved[1:] |= np.diff(np.round(records[axis])) != 0
    return changes[:-1] | changes[1:] | moved


def _label(ax: Axes, alarms: NDArray[np.void]) -> None:
    ax.plot(alarms["x"], alarms["y"], "o", color=_ALARMED, markersize=4, markeredgecolor="white", markeredgewidth=0.6)
    for alarm in alarms[:_LABELS_MAX]:
        kind = Anomaly(int(alarm["kind"])).name.lower().replace("_", " ")
        text = f"{kind}, {alarm['track_id']}, {alarm['t_us'] * 1e-6:.2f} s"
        right = alarm["x"] < _LABEL_SHARE * ax.get_xlim()[1]  # where there is room for the text
        place, side = ((4, 3), "left") if right else ((-4, 3), "right")
        ax.annotate(text, (alarm["x"], alarm["y"]), place, textcoords="offset points", ha=side, color=INK, fontsize=7)

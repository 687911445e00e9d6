# SPDX-License-Identifier: Apache-2.0
"""The panels of `picture.draw`: the scene, single moments of it, clusters over time, and lives with their merges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import blended_transform_factory
from numpy.typing import NDArray

from ..events import Events, Recording
from ..tracks.log import Kind, TrackLog
from ..tracks.record import box_corners
from ..tracks.timeline import OPEN, alive, sample
from .style import INK

__all__ = [
    "END_MARKERS",
    "EVENT_COLOURS",
    "NOTHING",
    "Clock",
    "Point",
    "Side",
    "TimeAxis",
    "count_panel",
    "draw_alive",
    "draw_merges",
    "lives_panel",
    "moment_panel",
    "scene_panel",
]


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


# Okabe and Ito's palette, suitable for colour-blind readers; the engines also differ in line width and dashes.
EVENT_COLOURS = ("#CC79A7", "#009E73")  # OFF, ON
NOTHING = "no cluster became visible"

_BINS_MAX = 1024  # maximum bins per side of the scene: larger sensors are drawn more coarsely
_MOMENT_FRACTION = 0.004  # of the recording: events this long before a moment are highlighted
_LABELLED_MAX = 30  # maximum number of rows with a track id as label
_NUMBER: dict[str, Any] = {"fontsize": 7.5, "weight": "bold", "color": INK}
_GAP_ROWS = 0.8  # between the engines' lives
_HEIGHT_PT = 300  # approximate height of the panel of lives, for the thickness of rows


@dataclass(frozen=True)
class Side:
    """One engine's data and line style."""

    name: str
    colour: str
    width: float  # of its lines; those of the first engine are wider, so that the second's do not hide them
    dashes: Literal["solid", "dashed"]  # of its boxes
    log: TrackLog
    lives: NDArray[np.void]  # of dtype `timeline.LIFE`: the lives that are drawn, in order of birth
    tracks: int  # number of all tracks


@dataclass(frozen=True)
class Clock:
    """The time axis shared by all panels."""

    times_us: NDArray[np.int64]  # evenly over the recording
    moments_us: NDArray[np.int64]  # at which boxes are drawn

    @cached_property
    def axis(self) -> TimeAxis:
        """Times as positions on the axis."""
        return TimeAxis(int(self.times_us[0]), int(self.times_us[-1] - self.times_us[0]))


def scene_panel(ax: Axes, recording: Recording, sides: Sequence[Side], clock: Clock) -> None:
    """Draw all events by polarity, and both trackers' paths, in sensor coordinates with the origin at the top left."""
    _draw_events(ax, recording, np.ones(len(recording.events), np.bool_), 0.5)
    for side in sides:
        _draw_paths(ax, side, clock)
    ax.xaxis.set_major_locator(MaxNLocator(7, integer=True))
    ax.yaxis.set_major_locator(MaxNLocator(7, integer=True))
    ax.set_xlabel("x (px)")
    ax.set_ylabel("y (px)")


def moment_panel(ax: Axes, recording: Recording, sides: Sequence[Side], clock: Clock, moment: int) -> None:
    """Draw the events just before a numbered moment, and both trackers' boxes at it."""
    at_us = int(clock.moments_us[moment])
    before_us = max(int(_MOMENT_FRACTION * (clock.times_us[-1] - clock.times_us[0])), 1)
    first, end = (int(i) for i in np.searchsorted(recording.events.t_us, (at_us - before_us, at_us + 1)))
    recent = np.zeros(len(recording.events), np.bool_)
    recent[first:end] = True
    _draw_events(ax, recording, recent, 1.0)
    for side in sides:
        _draw_boxes(ax, side, np.array([at_us]))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.set_title(f"{moment + 1}", loc="left", pad=2, **_NUMBER)
    position = float(clock.axis(np.array([at_us]))[0])
    ax.set_title(f"{position:.3g} {clock.axis.unit}", loc="right", pad=2, fontsize=7.5, weight="normal", color=INK)


def _draw_events(ax: Axes, recording: Recording, chosen: NDArray[np.bool_], strength: float) -> None:
    image, bin_px = _event_image(recording, chosen, strength)
    right, bottom = image.shape[1] * bin_px - 0.5, image.shape[0] * bin_px - 0.5
    ax.imshow(image, extent=(-0.5, right, bottom, -0.5), interpolation="nearest", aspect="equal")
    ax.set_xlim(-0.5, recording.width - 0.5)
    ax.set_ylim(recording.height - 0.5, -0.5)
    for spine in ax.spines.values():
        spine.set_visible(True)


def _event_image(recording: Recording, chosen: NDArray[np.bool_], strength: float) -> tuple[NDArray[np.float64], int]:
    """(rows, columns, 3) image of the chosen events and the side of a cell in pixels; the hue is a mix of the polarities."""
    bin_px = -(-max(recording.width, recording.height) // _BINS_MAX)
    shape = (-(-recording.height // bin_px), -(-recording.width // bin_px))
    events = recording.events
    off, on = (_counts(events, chosen & (events.p == polarity), bin_px, shape) for polarity in (0, 1))
    total = on + off
    image = np.ones((*shape, 3))
    if not total.any():
        return image, bin_px
    share = (on / np.maximum(total, 1))[..., None]
    hue = (1 - share) * to_rgb(EVENT_COLOURS[0]) + share * to_rgb(EVENT_COLOURS[1])
    full = max(float(np.quantile(total[total > 0], 0.95)), 1.0)
    cover = strength * np.minimum(np.log1p(total) / np.log1p(full), 1.0)[..., None]
    return image * (1 - cover) + hue * cover, bin_px


def _counts(events: Events, chosen: NDArray[np.bool_], bin_px: int, shape: tuple[int, int]) -> NDArray[np.int64]:
    cell = (events.y[chosen].astype(np.int64) // bin_px) * shape[1] + events.x[chosen] // bin_px
    return np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)


def _draw_paths(ax: Axes, side: Side, clock: Clock) -> None:
    states = _states(side, clock.times_us)
    paths = []
    for life in side.lives:
        here = clock.times_us[states["sample"]]
        path = states[(states["track_id"] == life["track_id"]) & (here >= life["birth_us"]) & (here <= life["end_us"])]
        if len(path):
            paths.append(np.column_stack((path["x"], path["y"])))
    ax.add_collection(LineCollection(paths, colors="white", linewidths=side.width + 1.2, alpha=0.6))
    ax.add_collection(LineCollection(paths, colors=side.colour, linewidths=side.width))


def _states(side: Side, times_us: NDArray[np.int64]) -> NDArray[np.void]:
    """States of the tracks that are drawn, of dtype `timeline.SAMPLE`."""
    states = sample(side.log, times_us)
    drawn: NDArray[np.void] = states[np.isin(states["track_id"], side.lives["track_id"])]
    return drawn


def _draw_boxes(ax: Axes, side: Side, times_us: NDArray[np.int64]) -> None:
    boxes = [Polygon(corners) for corners in box_corners(_states(side, times_us))]
    ax.add_collection(
        PatchCollection(boxes, facecolor="none", edgecolor=side.colour, linewidth=1.4, linestyle=side.dashes, zorder=3)
    )


def count_panel(ax: Axes, sides: Sequence[Side], clock: Clock) -> None:
    """Draw the number of visible clusters over time."""
    counts = ((alive(side.log, clock.times_us), {"color": side.colour, "linewidth": side.width}) for side in sides)
    draw_alive(ax, clock.axis(clock.times_us), counts, "clusters alive")
    ax.tick_params(labelbottom=False)
    _mark_moments(ax, clock)
    top = blended_transform_factory(ax.transData, ax.transAxes)
    for i, position in enumerate(clock.axis(clock.moments_us)):
        ax.text(position, 1.02, str(i + 1), transform=top, ha="center", va="bottom", **_NUMBER)


def _mark_moments(ax: Axes, clock: Clock) -> None:
    for position in clock.axis(clock.moments_us):
        ax.axvline(position, color=INK, linewidth=0.6, linestyle=":", zorder=0)


def lives_panel(ax: Axes, sides: Sequence[Side], clock: Clock) -> None:
    """Draw every track from birth to end, one engine above the other; a merge is linked to its survivor."""
    beside = blended_transform_factory(ax.transAxes, ax.transData)
    begin, end = clock.axis(clock.times_us[[0, -1]])
    # An engine with few tracks gets extra room, so that its name fits.
    least = max(1.0, 0.25 * max(len(side.lives) for side in sides))
    n_rows = sum(max(len(side.lives), least) for side in sides)
    label_every = int(np.ceil(n_rows / _LABELLED_MAX))
    ticks: list[tuple[float, str, str]] = []
    top = 0.0
    for side in sides:
        bottom = top + max(len(side.lives), least)
        rows = top + 0.5 + np.arange(len(side.lives), dtype=np.float64)
        if len(side.lives):
            _draw_lives(ax, side, clock, rows, n_rows)
            ticks += [(rows[i], str(side.lives["track_id"][i]), side.colour) for i in range(0, len(rows), label_every)]
        else:
            ax.text((begin + end) / 2, (top + bottom) / 2, NOTHING, ha="center", va="center", color=side.colour, style="italic")
        ax.text(
            -0.078, (top + bottom) / 2, f"{side.name} track id",
            transform=beside, rotation=90, ha="right", va="center", color=side.colour,
        )  # fmt: skip
        if side is not sides[-1]:
            ax.axhline(bottom + _GAP_ROWS / 2, color=INK, linewidth=0.8)
        top = bottom + _GAP_ROWS
    ax.set_ylim(top - _GAP_ROWS, 0)
    ax.set_yticks([tick[0] for tick in ticks], [tick[1] for tick in ticks], fontsize=7.5)
    for label, tick in zip(ax.get_yticklabels(), ticks, strict=True):
        label.set_color(tick[2])
    ax.tick_params(axis="y", length=0)
    margin = 0.015 * (end - begin)
    ax.set_xlim(begin - margin, end + margin)
    ax.set_xlabel(f"time since the first event ({clock.axis.unit})")
    _mark_moments(ax, clock)


def _draw_lives(ax: Axes, side: Side, clock: Clock, rows: NDArray[np.float64], n_rows: float) -> None:
    lives = side.lives
    begin, end = clock.axis(lives["birth_us"]), clock.axis(lives["end_us"])
    thickness = float(np.clip(0.6 * _HEIGHT_PT / n_rows, 1.2, 7))
    ax.hlines(rows, begin, end, color=side.colour, linewidth=thickness, alpha=0.55, capstyle="butt")
    marker = float(np.clip(thickness, 3, 6))
    row_of = dict(zip(lives["track_id"].tolist(), rows.tolist(), strict=True))
    for ended, symbol in END_MARKERS.items():
        here = lives["ended"] == ended
        ax.plot(
            end[here], rows[here], symbol, color=side.colour, markersize=marker * (1.6 if symbol == "|" else 1), clip_on=False
        )
    joins = [
        ((position, row), (position, row_of[int(life["other_id"])]))
        for life, position, row in zip(lives, end, rows, strict=True)
        if life["ended"] == Kind.MERGED and int(life["other_id"]) in row_of
    ]
    draw_merges(ax, joins, 0.8)

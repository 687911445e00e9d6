# SPDX-License-Identifier: Apache-2.0
"""A reference path of the one object in a recording, made offline from the whole recording; it shares nothing with trackers.

1. Events that stand alone are left out: an event stays if its neighbourhood in space and time holds enough others.
2. Of all paths over a coarse grid, the one through the most events is found by dynamic programming over the whole recording,
   backwards and forwards, at most `_STEP_CELLS` a step.
3. Around that path, in a window of time that reaches as far ahead as back, the median of the events is the centre, and their
   percentiles tell the extent; both are smoothed over time, again as far ahead as back.

A second estimate, which uses neither grid nor path but a robust local line through the events over time, tells the error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, gaussian_filter1d, label, median_filter, uniform_filter

from evcot.events import Events, Recording
from evcot.metrics.truth import OBJECT, GroundTruth

__all__ = ["REFERENCE", "Reference", "Scale", "reference"]

REFERENCE = np.dtype(
    [
        ("t_us", "<i8"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("events", "<i8"),
        ("state", "u1"),
    ]
)
ABSENT, SILENT, SEEN = 0, 1, 2

_CELL_PX = 2
_BIN_US = 10_000  # of the neighbourhood in time
_STEP_CELLS = 6
_BEND = 0.15  # what a step of one cell costs, in the data's logarithm, times its square
_INNER = 10, 90  # percentiles between which an object's extent is measured; the rest is taken to be as dense
_CORE = 4.0  # median distances from the centre within which events belong to the object
_LEAP, _LEAP_STEPS = 0.2, 11  # of the size, from the median over so many instants
_ROUNDS = 6  # of the robust line


@dataclass(frozen=True)
class Scale:
    """What must be known of the object.

    Attributes:
        size_px: its rough size.
        window_us: half of the window of time in which its place is measured.
        neighbours: how many events the neighbourhood of an event needs, for it to stay.
        seen_events: how many events in a window make it seen.
        border_px: how near the edge an object is that is about to leave.
    """

    size_px: float
    window_us: int
    neighbours: float
    seen_events: int = 10
    border_px: float = 10.0


@dataclass(frozen=True, eq=False)
class Reference:
    """The path, (n,) of dtype `REFERENCE`, and the distance between both estimates where the object is seen.

    `state` is 2 where the object is seen, 1 where it sends too few events to be measured (its place is interpolated then, and
    it need not be found), 0 where it has left the sensor.
    """

    path: NDArray[np.void]
    difference_px: NDArray[np.float64]

    @property
    def error(self) -> str:
        """Median and 95th percentile of the difference."""
        median, most = np.percentile(self.difference_px, (50, 95))
        return f"two independent estimates differ by {median:.1f} px (median), {most:.1f} px (95 %)"

    def truth(self) -> GroundTruth:
        """The path as ground truth."""
        path = self.path
        there = path["state"] != ABSENT
        objects = np.zeros(int(there.sum()), OBJECT)
        objects["frame"] = np.flatnonzero(there)
        for name in ("x", "y", "width", "height"):
            objects[name] = path[name][there]
        seconds = path["t_us"] * 1e-6
        objects["vx"], objects["vy"] = (np.gradient(path[axis], seconds)[there] for axis in "xy")
        objects["counted"] = path["state"][there] == SEEN
        return GroundTruth(path["t_us"].copy(), objects, ("0",))


def reference(recording: Recording, scale: Scale, step_us: int) -> Reference:
    """The path every `step_us`."""
    events = _not_alone(recording, scale)
    times_us = np.arange(recording.events.t_us[0], recording.events.t_us[-1], step_us)
    rough = _rough_path(events, recording, times_us, scale)
    path = _refined(events, times_us, rough, scale)
    _mark_gaps(path, recording, scale, step_us)
    second = _local_lines(events, times_us, rough, scale)
    seen = (path["state"] == SEEN) & np.isfinite(second[:, 0])
    difference = np.hypot(path["x"] - second[:, 0], path["y"] - second[:, 1])[seen]
    return Reference(path, difference)


def _not_alone(recording: Recording, scale: Scale) -> Events:
    """Events whose neighbourhood, three cells of `size_px` / 3 a side and three bins of time, holds enough events."""
    events = recording.events
    side = max(scale.size_px / 3, 1.0)
    bins = (
        ((events.t_us - events.t_us[0]) // _BIN_US).astype(np.int64),
        (events.y / side).astype(np.int64),
        (events.x / side).astype(np.int64),
    )
    counts = np.zeros([int(axis.max()) + 1 for axis in bins], np.float32)
    np.add.at(counts, bins, 1)
    around = uniform_filter(counts, 3, mode="constant") * 27
    return events.where(around[bins] >= scale.neighbours)


def _rough_path(events: Events, recording: Recording, times_us: NDArray[np.int64], scale: Scale) -> NDArray[np.float64]:
    """(n, 2) x, y of the path through the most events."""
    shape = -(-recording.height // _CELL_PX), -(-recording.width // _CELL_PX)
    step_us = int(times_us[1] - times_us[0])
    frame = np.clip((events.t_us - times_us[0] + step_us // 2) // step_us, 0, len(times_us) - 1)
    counts = np.zeros((len(times_us), *shape), np.float32)
    np.add.at(counts, (frame, events.y // _CELL_PX, events.x // _CELL_PX), 1)
    sigma = scale.size_px / 2 / _CELL_PX
    data = np.log1p(gaussian_filter(counts, (0, sigma, sigma), mode="constant") * sigma**2)
    best, froms = data[0], []
    for own in data[1:]:
        best, back_y = _best_step(best, 0)
        best, back_x = _best_step(best, 1)
        froms.append((back_y, back_x))
        best = best + own
    y, x = np.unravel_index(int(best.argmax()), shape)
    path = [(x, y)]
    for back_y, back_x in reversed(froms):
        x = x + int(back_x[y, x])
        y = y + int(back_y[y, x])
        path.append((x, y))
    return (np.array(path[::-1], np.float64) + 0.5) * _CELL_PX - 0.5


def _best_step(score: NDArray[np.float32], axis: int) -> tuple[NDArray[np.float32], NDArray[np.int8]]:
    """For each cell the best score to come from along an axis, less what the step costs, and how many cells away it is."""
    best, back = np.full(score.shape, -np.inf, np.float32), np.zeros(score.shape, np.int8)
    size = score.shape[axis]
    for step in range(-_STEP_CELLS, _STEP_CELLS + 1):
        to = [slice(None)] * 2
        of = [slice(None)] * 2
        to[axis], of[axis] = slice(max(-step, 0), size - max(step, 0)), slice(max(step, 0), size - max(-step, 0))
        offered = np.full(score.shape, -np.inf, np.float32)
        offered[tuple(to)] = score[tuple(of)] - _BEND * step**2
        better = offered > best
        best[better], back[better] = offered[better], step
    return best, back


def _near(events: Events, at_us: int, place: NDArray[np.float64], scale: Scale, windows: float = 1.0) -> slice | NDArray[Any]:
    """Indices of the events around a time and a place."""
    reach_us = round(windows * scale.window_us)
    begin, end = np.searchsorted(events.t_us, (at_us - reach_us, at_us + reach_us))
    far = np.hypot(events.x[begin:end] - place[0], events.y[begin:end] - place[1])
    return begin + np.flatnonzero(far <= 1.5 * scale.size_px)


def _refined(events: Events, times_us: NDArray[np.int64], rough: NDArray[np.float64], scale: Scale) -> NDArray[np.void]:
    """Median and extent of the events around the rough path; interpolated where there are too few."""
    path = np.zeros(len(times_us), REFERENCE)
    path["t_us"] = times_us
    for row, place in zip(path, rough, strict=True):
        for _ in range(2):  # the second time around the first's centre
            near = _near(events, int(row["t_us"]), place, scale)
            if len(near) < scale.seen_events:
                break
            place = np.array([np.median(events.x[near]), np.median(events.y[near])])
            far = np.hypot(events.x[near] - place[0], events.y[near] - place[1])
            near = near[far <= _CORE * max(float(np.median(far)), 1.0)]
        row["events"] = len(near)
        if len(near) >= scale.seen_events:
            row["x"], row["y"] = place
            row["width"], row["height"] = (
                np.ptp(np.percentile(axis[near], _INNER)) * 100 / np.ptp(_INNER) + 1 for axis in (events.x, events.y)
            )
    seen = path["events"] >= scale.seen_events
    for axis in ("x", "y"):  # what leaps is noise in a moment of few events
        whole = np.interp(times_us, times_us[seen], path[axis][seen])
        seen &= np.abs(whole - median_filter(whole, _LEAP_STEPS, mode="nearest")) <= _LEAP * scale.size_px
    path["state"] = np.where(seen, SEEN, SILENT)
    steps = max(scale.window_us / float(times_us[1] - times_us[0]), 1.0)
    for name, smooth in (("x", 0.5), ("y", 0.5), ("width", 2.0), ("height", 2.0)):
        whole = np.interp(times_us, times_us[seen], path[name][seen])
        path[name] = gaussian_filter1d(whole, smooth * steps, mode="nearest")
    return path


def _mark_gaps(path: NDArray[np.void], recording: Recording, scale: Scale, step_us: int) -> None:
    """A silent stretch that begins or ends at the sensor's edge is one in which the object is not there."""
    x, y = path["x"], path["y"]
    border = np.minimum.reduce((x, y, recording.width - 1 - x, recording.height - 1 - y)) < scale.border_px
    runs, count = label(path["state"] == SILENT)
    for run in range(1, count + 1):
        own = np.flatnonzero(runs == run)
        before, after = max(own[0] - 1, 0), min(own[-1] + 1, len(path) - 1)
        if border[before] or border[after] or len(own) * step_us > 1_000_000:
            path["state"][own] = ABSENT


def _local_lines(events: Events, times_us: NDArray[np.int64], rough: NDArray[np.float64], scale: Scale) -> NDArray[np.float64]:
    """(n, 2) x, y: at each time a straight motion fitted to the events around it, far ones weighted down (Tukey's biweight)."""
    found = np.full((len(times_us), 2), np.nan)
    for row, (at_us, place) in enumerate(zip(times_us.tolist(), rough, strict=True)):
        near = _near(events, at_us, place, scale, 1.5)
        if len(near) < scale.seen_events:
            continue
        late = (events.t_us[near] - at_us) / (1.5 * scale.window_us)
        base = (1 - np.abs(late) ** 3) ** 3  # as in LOESS
        points = np.stack((events.x[near], events.y[near]), axis=1).astype(np.float64)
        design = np.stack((np.ones(len(late)), late), axis=1)
        weight = base
        for _ in range(_ROUNDS):
            root = np.sqrt(weight)[:, None]
            line, *_ = np.linalg.lstsq(design * root, points * root, rcond=None)
            far = np.hypot(*(points - design @ line).T)
            spread = max(float(np.median(far)), 0.5)
            weight = base * np.clip(1 - (far / (4 * spread)) ** 2, 0, None) ** 2
        found[row] = line[0]
    return found

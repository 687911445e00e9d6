# SPDX-License-Identifier: Apache-2.0
"""Tracking error and lag on the box experiment, whose positions and velocities are known exactly.

Every few milliseconds tracks and moving boxes are matched as CLEAR does it. A track is on a box while its centre lies within
half the box's diagonal of the box's centre. The lag is how far it lies behind, along the box's motion: a track that is ahead
has one below 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evcot.metrics.frames import line_up
from evcot.metrics.mot import clear
from evcot.metrics.rule import load_rule
from evcot.metrics.sampling import positions
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.scenes.truth import Box, Scene
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.timeline import expiring, sample

_ON_THE_BOX = 1e-6  # similarity: not 0, at which CLEAR would keep a pair that has parted

__all__ = ["Following", "follow", "moving_boxes"]


@dataclass(frozen=True, eq=False)
class Following:
    """Results of `follow`.

    Attributes:
        error_px, lag_px, lag_ms: (n,) one per pair of a moving box and its track, at each instant.
        objects: boxes that moved on the sensor, summed over the instants.
        switches, fragments: as in `metrics.clear.Clear`.
        born, merged: tracks that became visible, and those that others absorbed.
        lost: lifetimes that ended on a box while it moved.
    """

    error_px: NDArray[np.float64]
    lag_px: NDArray[np.float64]
    lag_ms: NDArray[np.float64]
    objects: int
    switches: int
    fragments: int
    born: int
    merged: int
    lost: int


def moving_boxes(scene: Scene) -> GroundTruth:
    """The scene's truth; boxes that rest or are off the sensor do not count."""
    samples = scene.truth.samples
    instants_us, frame = np.unique(samples["t_us"], return_inverse=True)
    objects = np.zeros(len(samples), OBJECT)
    objects["frame"], objects["object"] = frame, samples["object_id"]
    for name in ("x", "y", "width", "height", "vx", "vy"):
        objects[name] = samples[name]
    objects["counted"] = samples["visible"] & ((samples["vx"] != 0) | (samples["vy"] != 0))
    return GroundTruth(instants_us, objects, tuple(map(str, range(len(scene.truth.boxes)))))


def follow(log: TrackLog, scene: Scene, lifetime_us: int) -> Following:
    """Compare tracks, which end after `lifetime_us` without events, with the boxes of a scene."""
    truth, boxes = moving_boxes(scene), scene.truth.boxes
    rule = load_rule("scene")
    states = expiring(log, rule.max_age_us)
    frames, objects, outputs = line_up(sample(states, truth.instants_us), truth, rule)
    followed = clear(frames, _ON_THE_BOX)
    matches = followed.matches
    times_us = truth.instants_us[matches.frame]
    x, y = positions(states, np.unique(outputs["track_id"])[matches.track], times_us[:, None])
    dx, dy, vx, vy = _relative(boxes, np.unique(objects["object"])[matches.truth], times_us, x[:, 0], y[:, 0])
    speed = np.hypot(vx, vy)
    lag_px = -(dx * vx + dy * vy) / speed
    return Following(
        error_px=np.hypot(dx, dy),
        lag_px=lag_px,
        lag_ms=1000 * lag_px / speed,
        objects=int(frames.truth_lengths.sum()),
        switches=followed.idsw,
        fragments=followed.frag,
        born=len(log.of_kind(Kind.BORN)),
        merged=len(log.of_kind(Kind.MERGED)),
        lost=_lost_on_the_way(log, scene, lifetime_us),
    )


def _relative(
    boxes: tuple[Box, ...], box: NDArray[np.int64], t_us: NDArray[np.int64], x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], ...]:
    """Of (n,) places at (n,) times: the way to them from the box of that number, and its velocity, each (n,)."""
    found = np.empty((4, len(t_us)))
    for i, one in enumerate(boxes):
        own = box == i
        centre_x, centre_y = one.centre(t_us[own])
        found[:, own] = x[own] - centre_x, y[own] - centre_y, *one.velocity(t_us[own])
    return tuple(found)


def _lost_on_the_way(log: TrackLog, scene: Scene, lifetime_us: int) -> int:
    """Number of LOST records of tracks that ended on a box which was on the sensor and moving since their last event."""
    lost = log.of_kind(Kind.LOST)
    on_the_way = np.zeros(len(lost), bool)
    for box in scene.truth.boxes:
        x, y = box.centre(lost["t_us"])
        near = np.hypot(lost["x"] - x, lost["y"] - y) <= np.hypot(box.width, box.height) / 2
        seen = (x >= 0) & (x < scene.recording.width) & (y >= 0) & (y < scene.recording.height)
        moved = [np.hypot(*box.velocity(t_us)) > 0 for t_us in (lost["t_us"] - lifetime_us, lost["t_us"])]
        on_the_way |= near & seen & moved[0] & moved[1]
    return int(on_the_way.sum())

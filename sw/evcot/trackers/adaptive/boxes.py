# SPDX-License-Identifier: Apache-2.0
"""The box of an object: a Kalman filter for each axis, and whether two boxes are parts of one object.

Boxes are (2, 2) tables: centre and half side by axis.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from .layout import Rules, World

__all__ = ["are_one", "are_parts", "correct", "overlap", "predict", "together"]

Table = NDArray[Any]

_WITHIN = 0.7  # share of the smaller box that lies in the larger


@step
def mostly_within(a: Table, b: Table) -> bool:
    """Whether most of the smaller box lies in the larger, along both axes."""
    for axis in range(2):
        shared = a[axis, 1] + b[axis, 1] - abs(a[axis, 0] - b[axis, 0])
        if shared < 2.0 * _WITHIN * min(a[axis, 1], b[axis, 1]):
            return False
    return True


@step
def overlap(a: Table, b: Table, axis: int) -> float:
    """The length along an axis that two boxes share; negative for the gap between them."""
    return float(min(a[axis, 0] + a[axis, 1], b[axis, 0] + b[axis, 1]) - max(a[axis, 0] - a[axis, 1], b[axis, 0] - b[axis, 1]))


@step
def together(a: Table, b: Table, axis: int) -> float:
    """The length along an axis of both boxes together."""
    return float(max(a[axis, 0] + a[axis, 1], b[axis, 0] + b[axis, 1]) - min(a[axis, 0] - a[axis, 1], b[axis, 0] - b[axis, 1]))


# Kalman filter of one axis of a box: centre, velocity, half side, growth; corrected by the number of events beyond a side.
#
# A side is defined by a share `quantile` of the object's events lying beyond it. With n of N events beyond, the side is off by
# (n / N - quantile) / f, where f is the density of events at the side, with variance quantile (1 - quantile) / (N f^2). This
# holds for any N, whereas the sample quantile of few events would lie too far inside.


@step
def predict(s: Table, p: Table, dt: float, velocity_walk: float, growth_walk: float) -> None:
    """Predict one axis' state (4,) and covariance (4, 4) by dt seconds: velocity and growth are random walks."""
    s[0] += dt * s[1]
    s[2] += dt * s[3]
    for k in range(4):
        p[0, k] += dt * p[1, k]
        p[2, k] += dt * p[3, k]
    for k in range(4):
        p[k, 0] += dt * p[k, 1]
        p[k, 2] += dt * p[k, 3]
    for at, walk in ((0, velocity_walk), (2, growth_walk)):
        q = walk * walk * dt
        p[at, at] += q * dt * dt / 3.0
        p[at, at + 1] += q * dt / 2.0
        p[at + 1, at] += q * dt / 2.0
        p[at + 1, at + 1] += q


@step
def correct(s: Table, p: Table, sign: float, off_px: float, variance: float) -> None:
    """Update with a measurement of the side centre + sign * half that is `off_px` above the estimate."""
    row = (p[0, 0] + sign * p[2, 0], p[0, 1] + sign * p[2, 1], p[0, 2] + sign * p[2, 2], p[0, 3] + sign * p[2, 3])
    total = row[0] + sign * row[2] + variance
    for i in range(4):
        gain = row[i] / total
        s[i] += gain * off_px
        for k in range(4):
            p[i, k] -= gain * row[k]


_TOGETHER = 2.0  # half sides travelled with one box in the other, after which they are one whatever their velocities
_NEW = 1.0  # half sides travelled, up to which an object is new
_FAR = 3.0  # half sides travelled, from which an object has come far
_ENTERING_GAP = 1.0  # between two that enter, as a part of the longest half side
_BESIDE = 0.1  # of the larger one's whole sides: the gap between it and such a part
_THIN = 0.4  # thickness of an edge, as a part of its length
_THIN_GAPS = 2.5  # factor of the gap beside an edge
_FLAT = 0.8  # thickness by width of bands that are edges of one object, however far apart
_SMALL = 0.6  # of the larger one's mean side, up to which an object close to it may be a part of it, wherever it lies
_ABREAST = 0.6  # share of the wider box that is covered by the other


@step
def are_parts(a: Table, b: Table, gap: float, elongation: float) -> bool:
    """Whether the places of two boxes, (2, 2) centre and half side by axis, allow them to be parts of one object: one mostly
    inside the other; or one behind the other, of similar width, with a gap that is small for the length of the whole."""
    if mostly_within(a, b):
        return True
    for axis in range(2):
        across = 1 - axis
        if overlap(a, b, across) >= 2.0 * _ABREAST * max(a[across, 1], b[across, 1]):
            length, width = together(a, b, axis), together(a, b, across)
            # Edges of one object are thin and far apart, objects that follow one another are not.
            thin = min(a[axis, 1], b[axis, 1]) < _THIN * 0.5 * width
            most = (_THIN_GAPS if thin else 1.0) * gap * (elongation * width - length)
            if -overlap(a, b, axis) <= most:
                return True
            flat = max(a[axis, 1] / a[across, 1], b[axis, 1] / b[across, 1]) < _FLAT
            if flat and overlap(a, b, across) >= 0.8 * width and length <= elongation * width:
                return True
    return False


@step
def _gap(a: Table, b: Table, axis: int) -> float:
    """The gap between two objects along an axis; negative where they overlap."""
    return float(abs(a[axis, 0] - b[axis, 0]) - a[axis, 2] - b[axis, 2])


@step
def _is_body(s: Table) -> bool:
    """Whether an object is more than an edge: its sides are of similar length."""
    return bool(min(s[0, 2], s[1, 2]) >= _THIN * max(s[0, 2], s[1, 2]))


@step
def are_one(rules: Rules, world: World, i: int, k: int) -> bool:
    """Whether two objects are one: by position and with equal motion; or both entering over the same edge, side by side."""
    a, b = world.state[i], world.state[k]
    one, other = world.objects[i], world.objects[k]
    if one.edge >= 0 and one.edge == other.edge and max(one.travel, other.travel) < _NEW:
        gap, most = -1e9, 0.0
        for axis in range(2):
            gap = max(gap, abs(a[axis, 0] - b[axis, 0]) - a[axis, 2] - b[axis, 2])
            most = max(most, a[axis, 2], b[axis, 2])
        if gap <= _ENTERING_GAP * most:
            return True
    if mostly_within(a[:, ::2], b[:, ::2]):
        one.inside, other.inside = k, i
        if min(one.within, other.within) > _TOGETHER:
            return True
    return _may_be_parts(rules, world, i, k) and _move_together(rules, world, i, k)


@step
def _move_together(rules: Rules, world: World, i: int, k: int) -> bool:
    """Whether two objects have equal velocities, as far as these are known."""
    a, b = world.state[i], world.state[k]
    one, other = world.objects[i], world.objects[k]
    fast = max(np.hypot(a[0, 1], a[1, 1]), np.hypot(b[0, 1], b[1, 1]))
    unsure = 0.0
    for axis in range(2):
        unsure += world.cov[i, axis, 1, 1] + world.cov[k, axis, 1, 1]
    # Two that have come far alone must be known to move together; of others it need only be possible.
    known = min(one.travel, other.travel) >= _FAR and one.track_id >= 0 and other.track_id >= 0
    most = fast - np.sqrt(unsure) if known else fast + np.sqrt(unsure)
    return bool(np.hypot(a[0, 1] - b[0, 1], a[1, 1] - b[1, 1]) <= rules.merge_velocity * most)


@step
def _may_be_parts(rules: Rules, world: World, i: int, k: int) -> bool:
    """Whether two objects may be one by their places: a small one close to another, or parts as in `are_parts`."""
    a, b = world.state[i], world.state[k]
    one, other = world.objects[i], world.objects[k]
    half_a, half_b = a[0, 2] + a[1, 2], b[0, 2] + b[1, 2]
    larger = max(half_a, half_b)
    apart = max(_gap(a, b, 0), _gap(a, b, 1))
    if min(half_a, half_b) < _SMALL * larger and apart < _BESIDE * larger:
        return True
    # What has moved by itself, and is no edge, is no part of something beyond its gate.
    if apart > max(one.gate, other.gate) and one.track_id >= 0 and other.track_id >= 0 and _is_body(a) and _is_body(b):
        return False
    return are_parts(a[:, ::2], b[:, ::2], rules.gap, rules.elongation)

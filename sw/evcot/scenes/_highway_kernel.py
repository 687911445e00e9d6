# SPDX-License-Identifier: Apache-2.0
"""Kernels: the vehicles of a road at one time, and their projection into the picture."""

from __future__ import annotations

import numpy as np

from .._numba_private import njit
from .shapes import COLUMNS, INTENSITY, KIND, OBJECT, QUADRANGLE, X, Y

__all__ = ["MARGIN_PX", "meet", "motion_at", "project", "project_each"]

_LEAST_M = 2.0  # minimum distance for projection
MARGIN_PX = 4.0  # distance outside the sensor at which a vehicle is created


@njit(cache=True, nogil=True)
def motion_at(stretches, changes, across_m, t_s):  # type: ignore[no-untyped-def]
    """(n, 4) of each vehicle: place across and along in m, speeds in m/s, from `traffic.Stretch` and `traffic.LaneChange`."""
    now = np.empty((len(across_m), 4))
    for i in range(len(across_m)):
        current = 0
        for j in range(1, stretches.shape[1]):
            if stretches[i, j, 0] <= t_s:
                current = j
        begin_s, along_m, speed_m_s, acceleration = stretches[i, current]
        elapsed_s = t_s - begin_s
        now[i, 0], now[i, 2] = across_m[i], 0.0
        for j in range(changes.shape[1]):
            begin_s, lasts_s, by_m = changes[i, j]
            part = min(max((t_s - begin_s) / lasts_s, 0.0), 1.0)
            now[i, 0] += by_m * part**2 * (3 - 2 * part)
            now[i, 2] += by_m * 6 * part * (1 - part) / lasts_s
        now[i, 1] = along_m + elapsed_s * (speed_m_s + elapsed_s * acceleration / 2)
        now[i, 3] = speed_m_s + elapsed_s * acceleration
    return now


@njit(cache=True, nogil=True)
def meet(times_s, motions, half_m, length_m, gap_m):  # type: ignore[no-untyped-def]
    """Whether the first vehicle is, at any of some times, nearer to another than `gap_m` along the road, and a tenth of it
    across. `motions`: the arguments of `motion_at` but the time."""
    stretches, changes, across_m = motions
    for t_s in times_s:
        now = motion_at(stretches, changes, across_m, t_s)
        for i in range(1, len(now)):
            beside = abs(now[i, 0] - now[0, 0]) < half_m[i] + half_m[0] + gap_m / 10
            behind = now[i, 1] + length_m[i] + gap_m < now[0, 1]
            ahead = now[0, 1] + length_m[0] + gap_m < now[i, 1]
            if beside and not behind and not ahead:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def project(now_m, size_m, corners_m, focal, vanishing, camera_m, road_m, sensor, first_face):  # type: ignore[no-untyped-def]
    """The vehicles in the picture, the farthest first.

    Args:
        now_m: (n, 4) of each vehicle: place across and along in m, speeds in m/s.
        size_m: (n, 2) its height and length.
        corners_m: (n, faces, 4, 3) across, up and along, of the corners of its faces.
        focal, vanishing, camera_m, road_m: focal length in pixels, vanishing point (x, y), height of the camera, nearest and
            farthest place of the road.
        sensor: (width, height).
        first_face: the faces from this one on are those of its box.

    Returns:
        (m,) the vehicles; (m, faces, 4) x and y of the corners; (m, 6) x, y, width, height, vx, vy of the boxes.
    """
    faces = corners_m.shape[1]
    order, near = _from_far_to_near(now_m, size_m, camera_m, road_m)
    seen = np.empty(near, np.int64)
    x, y = np.empty((near, faces, 4)), np.empty((near, faces, 4))
    boxes = np.empty((near, 6))
    low, high, box_low, box_high = np.empty(2), np.empty(2), np.empty(2), np.empty(2)
    speed_low, speed_high, m = np.empty(2), np.empty(2), 0
    for vehicle in order[:near]:
        across_m, along_m, across_m_s, along_m_s = now_m[vehicle]
        for axis in range(2):
            low[axis] = box_low[axis] = np.inf
            high[axis] = box_high[axis] = -np.inf
            speed_low[axis] = speed_high[axis] = 0.0
        for face in range(faces):
            for corner in range(4):
                across, up, along = corners_m[vehicle, face, corner]
                along += along_m
                scale, recedes = focal / along, along_m_s / along
                places = (scale * (across + across_m), scale * (camera_m - up))
                speeds = (scale * across_m_s - recedes * places[0], -recedes * places[1])
                x[m, face, corner], y[m, face, corner] = places[0] + vanishing[0], places[1] + vanishing[1]
                for axis in range(2):
                    place = places[axis] + vanishing[axis]
                    low[axis], high[axis] = min(low[axis], place), max(high[axis], place)
                    if face >= first_face and place < box_low[axis]:
                        box_low[axis], speed_low[axis] = place, speeds[axis]
                    if face >= first_face and place > box_high[axis]:
                        box_high[axis], speed_high[axis] = place, speeds[axis]
        if min(high[0], high[1]) > -MARGIN_PX and low[0] < sensor[0] + MARGIN_PX and low[1] < sensor[1] + MARGIN_PX:
            seen[m] = vehicle
            for axis in range(2):
                boxes[m, axis], boxes[m, 2 + axis] = (box_low[axis] + box_high[axis]) / 2, box_high[axis] - box_low[axis]
                boxes[m, 4 + axis] = (speed_low[axis] + speed_high[axis]) / 2
            m += 1
    return seen[:m], x[:m], y[:m], boxes[:m]


@njit(cache=True, nogil=True)
def _from_far_to_near(now_m, size_m, camera_m, road_m):  # type: ignore[no-untyped-def]
    """The vehicles on the visible part of the road, the farthest first, in the first places of an array; and how many."""
    order, near = np.empty(len(now_m), np.int64), 0
    for vehicle in range(len(now_m)):
        along_m = now_m[vehicle, 1]
        near_m = road_m[0] * (1 - size_m[vehicle, 0] / camera_m) - size_m[vehicle, 1]
        if max(near_m, _LEAST_M) < along_m < road_m[1]:
            at = near
            while at > 0 and now_m[order[at - 1], 1] < along_m:
                order[at] = order[at - 1]
                at -= 1
            order[at] = vehicle
            near += 1
    return order, near


@njit(cache=True, nogil=True)
def project_each(  # type: ignore[no-untyped-def]
    times_s, motions, size_m, corners_m, intensity, focal, vanishing, camera_m, road_m, sensor, first_face
):
    """`project` at each of some times, one after the other: the end of each time in the others, the vehicles, their shapes (see
    `shapes`), and the boxes.

    Args:
        motions: the arguments of `motion_at` but the time; for the others see `project`.
        intensity: (n, faces).
    """
    stretches, changes, across_m = motions
    faces = corners_m.shape[1]
    ends, n = np.empty(len(times_s), np.int64), 0
    most = 16 * len(times_s)
    seen, boxes, shapes = np.empty(most, np.int64), np.empty((most, 6)), np.empty((most, faces, COLUMNS))
    for i in range(len(times_s)):
        now_m = motion_at(stretches, changes, across_m, times_s[i])
        its, x, y, its_boxes = project(now_m, size_m, corners_m, focal, vanishing, camera_m, road_m, sensor, first_face)
        past = n + len(its)
        while past > len(seen):
            seen, boxes, shapes = np.concatenate((seen, seen)), np.concatenate((boxes, boxes)), np.concatenate((shapes, shapes))
        for k in range(len(its)):
            seen[n + k] = its[k]
            for column in range(6):
                boxes[n + k, column] = its_boxes[k, column]
            for face in range(faces):
                shape = shapes[n + k, face]
                shape[KIND], shape[OBJECT], shape[INTENSITY] = QUADRANGLE, its[k], intensity[its[k], face]
                for corner in range(4):
                    shape[X + corner], shape[Y + corner] = x[k, face, corner], y[k, face, corner]
        ends[i] = n = past
    return ends, seen[:n], shapes[:n].reshape(-1, COLUMNS), boxes[:n]

# SPDX-License-Identifier: Apache-2.0
"""Objects that cannot be seen: a scene may draw one whose contrast makes next to no events; it need not be found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from field.member import Member

__all__ = ["without_faint"]

_LEAST_HZ = 250.0  # of an object's own events, over its life; noise on its area is taken off


def without_faint(member: Member) -> Member:
    """The member, in which objects that send fewer events are not counted (nor are tracks on them false)."""
    events, truth = member.recording.events, member.truth
    shape = member.recording.height, member.recording.width
    step_us = int(truth.instants_us[1] - truth.instants_us[0])
    bounds = np.searchsorted(events.t_us, [truth.instants_us - step_us // 2, truth.instants_us + step_us // 2])
    rows = np.searchsorted(truth.objects["frame"], np.arange(len(truth.instants_us) + 1))
    own, areas, times = np.zeros((3, len(truth.ids)))
    free = np.zeros(2)  # events and pixels where nothing is
    for begin, end, first, last in zip(*bounds, rows[:-1], rows[1:], strict=True):
        counts = np.zeros(shape, np.int32)
        np.add.at(counts, (events.y[begin:end], events.x[begin:end]), 1)
        boxes = [_pixels(one, shape) for one in truth.objects[first:last]]
        cover = np.zeros(shape, np.int8)
        for box in boxes:
            cover[box] += 1
        free += counts[cover == 0].sum(), (cover == 0).sum()
        for one, box in zip(truth.objects[first:last], boxes, strict=True):
            alone = cover[box] == 1
            if one["counted"] and alone.any():
                number = one["object"]
                own[number] += counts[box][alone].sum()
                areas[number] += alone.sum()
                times[number] += step_us * 1e-6
    rate_hz = (own - areas * free[0] / max(free[1], 1)) / np.maximum(times, 1e-9)
    faint = (times > 0) & (rate_hz < _LEAST_HZ)
    objects = truth.objects.copy()
    objects["counted"] &= ~faint[objects["object"]]
    return replace(member, truth=replace(truth, objects=objects))


def _pixels(one: np.void, shape: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns of an object's box."""
    spans = []
    for axis, side, size in (("y", "height", shape[0]), ("x", "width", shape[1])):
        low, high = round(one[axis] - one[side] / 2), round(one[axis] + one[side] / 2) + 1
        spans.append(slice(min(max(low, 0), size), min(max(high, 0), size)))
    return spans[0], spans[1]

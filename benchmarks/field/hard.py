# SPDX-License-Identifier: Apache-2.0
"""Recordings without any object, and objects that cannot be seen: every track of them is false, or need not be found."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from evcot.events import Events, Recording
from field.member import Entry, Member, nothing_there, scene_rule
from field.transforms import merged, poisson_noise

__all__ = ["FAMILY", "entries", "without_faint"]


FAMILY = "nothing there"
_SENSOR, _SMALL = (346, 260), (128, 128)
_LAMP_RADIUS_PX, _LAMP_HZ, _LAMP_JITTER_US = 14.0, 100.0, 600.0
_HOT_PIXELS = 12

Make = Callable[[tuple[int, int], int, np.random.Generator], Events]


def _noise(sensor: tuple[int, int], end_us: int, random: np.random.Generator) -> Events:
    return poisson_noise(sensor, (0, end_us), 5.0, random)


def _hot(sensor: tuple[int, int], end_us: int, random: np.random.Generator) -> Events:
    """Pixels that send from 50 to 10,000 events a second, with 0.2 Hz of noise of all pixels."""
    streams = [poisson_noise(sensor, (0, end_us), 0.2, random)]
    for hz in np.exp(random.uniform(np.log(50.0), np.log(10_000.0), _HOT_PIXELS)):
        t_us = np.arange(random.uniform(0, 1e6 / hz), end_us, 1e6 / hz).astype(np.int64)
        x, y = (np.full(len(t_us), random.integers(side), np.uint16) for side in sensor)
        streams.append(Events(t_us, x, y, np.full(len(t_us), random.integers(2), np.uint8)))
    return merged(*streams)


def _lamp(sensor: tuple[int, int], end_us: int, random: np.random.Generator) -> Events:
    """Each pixel of a quarter of a disc in the corner sends ON events as the lamp brightens and OFF events as it fades."""
    y, x = np.mgrid[: sensor[1], : sensor[0]]
    lit = np.argwhere(np.hypot(x, y) < _LAMP_RADIUS_PX)
    halves = round(end_us * 2e-6 * _LAMP_HZ)
    times = random.poisson(1.2, (halves, len(lit)))
    half, pixel = (np.repeat(index.ravel(), times.ravel()) for index in np.indices(times.shape))
    t_us = (half + 0.5) * 1e6 / (2 * _LAMP_HZ) + random.normal(0, _LAMP_JITTER_US, len(half))
    order = np.argsort(t_us, kind="stable")
    order = order[(t_us[order] >= 0) & (t_us[order] < end_us)]
    own = lit[pixel[order]].astype(np.uint16)
    flicker = Events(t_us[order].astype(np.int64), own[:, 1], own[:, 0], (half[order] % 2 == 0).astype(np.uint8))
    return merged(flicker, poisson_noise(sensor, (0, end_us), 0.2, random))


_MEMBERS: dict[str, tuple[Make, tuple[int, int], int]] = {
    "5 Hz a pixel, 60 s": (_noise, _SENSOR, 60),
    "5 Hz a pixel, 128x128": (_noise, _SMALL, 60),
    "hot pixels": (_hot, _SENSOR, 20),
    "lamp at 100 Hz": (_lamp, _SENSOR, 20),
}


def entries(seed: int, quick: bool) -> Iterator[Entry]:
    """One family; quick: a few seconds of each."""
    for number, (name, (make, sensor, seconds)) in enumerate(_MEMBERS.items()):
        yield Entry(
            FAMILY, name, FAMILY, _builder(name, make, sensor, min(seconds, 4) if quick else seconds, (seed, 4, number))
        )


def _builder(name: str, make: Make, sensor: tuple[int, int], seconds: int, seed: tuple[int, ...]) -> Callable[[], Member]:
    def build() -> Member:
        end_us = seconds * 1_000_000
        recording = Recording(make(sensor, end_us, np.random.default_rng(seed)), *sensor, name)
        return Member(FAMILY, name, recording, nothing_there(0, end_us), scene_rule(recording), "there is nothing")

    return build


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

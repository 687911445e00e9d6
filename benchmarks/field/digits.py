# SPDX-License-Identifier: Apache-2.0
"""Digits that a camera saw (N-MNIST), each carried along a known path: real sensor events with exact truth.

A sample is 0.3 s in which the camera made three saccades and came back to where it began; it is repeated, so that an object
keeps its shape. Its events, and with them the digit, move within the sample by about 3 px to either side. The truth does not
follow that: the box holds the digit over the whole saccade (the 2nd to 98th percentile of the sample's events), and its centre
is exactly the path. Digits that meet lie one on the other, as if they were transparent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.metrics.truth import OBJECT, GroundTruth
from field.member import TRUTH_STEP_US, Absent, Entry, Member, scene_rule
from field.paths import Bouncing
from field.transforms import merged, poisson_noise
from shared import SHARED

__all__ = ["SOURCE", "digits", "entries"]

SOURCE = "N-MNIST"
_FILE = "nmnist_800.npz"
_SENSOR = 346, 260
_EXTENT = 2, 98  # percentiles
_COUNTS = {"apart": (1, 3, 5), "crossing": (2, 4, 6)}
_SPEED_PX_S = 20.0, 140.0
_NOISE_HZ = 0.05, 1.0
_SECONDS = 4.0


def entries(seed: int, quick: bool) -> Iterator[Entry]:
    """Two families: each digit in its own row, and all over the sensor."""
    for ways, counts in _COUNTS.items():
        for number, count in enumerate(counts[: 1 if quick else None]):
            yield Entry(f"digits, {ways}", f"{count} digits", SOURCE, _builder(ways, count, (seed, 2, number)))


def _builder(ways: str, count: int, seed: tuple[int, ...]) -> Callable[[], Member]:
    return lambda: digits(ways, count, seed)


def digits(ways: str, count: int, seed: tuple[int, ...]) -> Member:
    """So many digits, "apart" or "crossing"."""
    random = np.random.default_rng((*seed, count))
    samples = [_sample(int(number)) for number in random.choice(800, count, replace=False)]
    boxes = [np.percentile(np.stack((one.x, one.y)), _EXTENT, axis=1) for one in samples]  # (low and high, x and y)
    size_px = np.array([high - low + 1 for low, high in boxes])
    paths = Bouncing(_SENSOR, size_px, random.uniform(*_SPEED_PX_S, count), ways == "crossing", random)
    end_us = round(_SECONDS * 1e6)
    streams = [
        _carried(one, box.mean(axis=0), paths, number, end_us)
        for number, (one, box) in enumerate(zip(samples, boxes, strict=True))
    ]
    noise = poisson_noise(_SENSOR, (0, end_us), random.uniform(*_NOISE_HZ), random)
    recording = Recording(merged(*streams, noise), *_SENSOR, f"{count} digits {ways}")
    instants_us = np.arange(0, end_us, TRUTH_STEP_US)
    objects = np.zeros((len(instants_us), count), OBJECT)
    objects["frame"], objects["object"] = np.arange(len(instants_us))[:, None], np.arange(count)
    for number in range(count):
        own = objects[:, number]
        (own["x"], own["y"]), (own["vx"], own["vy"]) = paths.at(instants_us, number)
        own["width"], own["height"] = size_px[number]
    objects["counted"] = True
    truth = GroundTruth(instants_us, objects.ravel(), tuple(map(str, range(count))))
    how = "exact path; the box is the digit's extent over its saccade of about 3 px to either side"
    return Member(f"digits, {ways}", f"{count} digits", recording, truth, scene_rule(recording), how)


@lru_cache(maxsize=1)
def _samples() -> dict[str, NDArray[Any]]:
    path = SHARED / _FILE
    if not path.is_file():
        raise Absent(f"{_FILE} is not in {SHARED}")
    with np.load(path) as samples:
        return dict(samples)


def _sample(number: int) -> Events:
    """One sample; times from 0."""
    samples = _samples()
    begin, end = samples["first"][number : number + 2]
    t_us, x, y, p = (samples[name][begin:end] for name in ("t_us", "x", "y", "p"))
    order = np.argsort(t_us, kind="stable")
    return Events(
        *(column[order].astype(kind) for column, kind in ((t_us, np.int64), (x, np.uint16), (y, np.uint16), (p, np.uint8)))
    )


def _carried(sample: Events, middle: NDArray[np.float64], paths: Bouncing, number: int, end_us: int) -> Events:
    """A sample repeated until `end_us`, its middle on the path."""
    period_us = int(sample.t_us[-1]) + 1
    times = -(-end_us // period_us)
    t_us = (sample.t_us + period_us * np.arange(times)[:, None]).ravel()
    (path_x, path_y), _ = paths.at(t_us, number)
    x = np.rint(path_x + np.tile(sample.x, times) - middle[0])
    y = np.rint(path_y + np.tile(sample.y, times) - middle[1])
    inside = (x >= 0) & (x < _SENSOR[0]) & (y >= 0) & (y < _SENSOR[1]) & (t_us < end_us)
    p = np.tile(sample.p, times)
    return Events(t_us[inside], x[inside].astype(np.uint16), y[inside].astype(np.uint16), p[inside])

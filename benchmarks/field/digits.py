# SPDX-License-Identifier: Apache-2.0
"""Digits that a camera saw (N-MNIST), each carried along a known path: real sensor events with exact truth.

A sample is 0.3 s in which the camera made three saccades and came back to where it began; it is repeated, so that an object
keeps its shape. In the image every digit runs through the same loop meanwhile, a triangle about 6 px wide and 5 px high: the
median, over all samples, of where the events of each 10 ms lie in their sample. The truth follows it: the centre is the path
plus the digit's place in the loop; the box holds the digit as it would be without saccades (the 2nd to 98th percentile of the
sample's events, each moved back). Paths keep a digit's whole loop on the sensor. Digits that meet lie one on the other, as if
they were transparent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.metrics.truth import OBJECT, GroundTruth
from field.member import TRUTH_STEP_US, Absent, Entry, Member, scene_rule
from field.second import Bouncing
from field.transforms import merged, poisson_noise
from shared import SHARED

__all__ = ["FILE", "SOURCE", "digit_labels", "digits", "entries"]

SOURCE = "N-MNIST"
FILE = "nmnist_800.npz"
_SENSOR = 346, 260
_EXTENT = 2, 98  # percentiles
_BIN_US, _BINS = 10_000, 30  # the last bin takes the few events after 0.3 s as well
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


def digits(ways: str, count: int, seed: tuple[int, ...], numbers: Sequence[int] | None = None) -> Member:
    """So many digits, "apart", "crossing" or "still" (apart, no path); of these samples, or else of random ones."""
    random = np.random.default_rng((*seed, count))
    chosen = random.choice(800, count, replace=False) if numbers is None else numbers
    samples = [_sample(int(number)) for number in chosen]
    swept = [_extent(np.stack((one.x, one.y))) for one in samples]
    still = [_extent(np.stack((one.x, one.y)) - _loop(one.t_us)) for one in samples]
    speed_px_s = random.uniform(*_SPEED_PX_S, count) * (ways != "still")
    paths = Bouncing(_SENSOR, np.stack([size_px for _, size_px in swept]), speed_px_s, ways == "crossing", random)
    end_us = round(_SECONDS * 1e6)
    streams = [
        _carried(one, middle, paths, number, end_us)
        for number, (one, (middle, _)) in enumerate(zip(samples, swept, strict=True))
    ]
    noise = poisson_noise(_SENSOR, (0, end_us), random.uniform(*_NOISE_HZ), random)
    recording = Recording(merged(*streams, noise), *_SENSOR, f"{count} digits {ways}")
    instants_us = np.arange(0, end_us, TRUTH_STEP_US)
    objects = np.zeros((len(instants_us), count), OBJECT)
    objects["frame"], objects["object"] = np.arange(len(instants_us))[:, None], np.arange(count)
    for number in range(count):
        own = objects[:, number]
        place, speed = _in_the_loop(samples[number], instants_us)
        centre, velocity = paths.at(instants_us, number)
        (middle, size_px), (of_path, _) = still[number], swept[number]
        own["x"], own["y"] = centre + place + (middle - of_path)[:, None]
        own["vx"], own["vy"] = velocity + speed
        own["width"], own["height"] = size_px
    objects["counted"] = True
    truth = GroundTruth(instants_us, objects.ravel(), tuple(map(str, range(count))))
    how = "exact path, plus the digit's place in the saccades' loop, the same for all samples; the box is its extent"
    return Member(f"digits, {ways}", f"{count} digits", recording, truth, scene_rule(recording), how)


@lru_cache(maxsize=1)
def _samples() -> dict[str, NDArray[Any]]:
    path = SHARED / FILE
    if not path.is_file():
        raise Absent(f"{FILE} is not in {SHARED}")
    with np.load(path) as samples:
        return dict(samples)


def digit_labels() -> NDArray[np.int64]:
    """The digit of each sample, (800,)."""
    return np.asarray(_samples()["label"], np.int64)


def _sample(number: int) -> Events:
    """One sample; times from 0."""
    samples = _samples()
    begin, end = samples["first"][number : number + 2]
    t_us, x, y, p = (samples[name][begin:end] for name in ("t_us", "x", "y", "p"))
    order = np.argsort(t_us, kind="stable")
    return Events(
        *(column[order].astype(kind) for column, kind in ((t_us, np.int64), (x, np.uint16), (y, np.uint16), (p, np.uint8)))
    )


@lru_cache(maxsize=1)
def _saccades() -> NDArray[np.float64]:
    """Where a digit is, (2, n) px from its middle, at 5, 15, 25 … ms of its sample; rows x and y."""
    samples = _samples()
    of = np.repeat(np.arange(len(samples["first"]) - 1), np.diff(samples["first"]))
    bins = np.minimum(samples["t_us"] // _BIN_US, _BINS - 1)
    loop = np.empty((2, _BINS))
    for row, axis in enumerate("xy"):
        off = samples[axis] - (np.bincount(of, samples[axis]) / np.bincount(of))[of]
        loop[row] = [np.median(off[bins == one]) for one in range(_BINS)]
    return loop


def _loop(t_us: NDArray[np.int64]) -> NDArray[np.float64]:
    """Where a digit is at times of its sample, (2, n) px from its middle."""
    at = (np.arange(_BINS) + 0.5) * _BIN_US
    return np.stack([np.interp(t_us, at, row) for row in _saccades()])


def _extent(places: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Middle, and width and height, of what holds most of (2, n) places."""
    low, high = np.percentile(places, _EXTENT, axis=1)
    return (low + high) / 2, high - low + 1


def _in_the_loop(sample: Events, t_us: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where the digit of a repeated sample is, (2, n) px from its path, and its velocity there beside that of the path."""
    period_us = _period_us(sample)
    step_us = _BIN_US // 2
    back, on, ahead = (_loop((t_us + shift) % period_us) for shift in (-step_us, 0, step_us))
    return on, (ahead - back) / (2 * step_us * 1e-6)


def _period_us(sample: Events) -> int:
    return int(sample.t_us[-1]) + 1


def _carried(sample: Events, middle: NDArray[np.float64], paths: Bouncing, number: int, end_us: int) -> Events:
    """A sample repeated until `end_us`, its middle on the path."""
    period_us = _period_us(sample)
    times = -(-end_us // period_us)
    t_us = (sample.t_us + period_us * np.arange(times)[:, None]).ravel()
    (path_x, path_y), _ = paths.at(t_us, number)
    x = np.tile(sample.x, times) + np.rint(path_x - middle[0])  # one whole shift for all pixels: rows must not coincide
    y = np.tile(sample.y, times) + np.rint(path_y - middle[1])
    inside = (x >= 0) & (x < _SENSOR[0]) & (y >= 0) & (y < _SENSOR[1]) & (t_us < end_us)
    p = np.tile(sample.p, times)
    return Events(t_us[inside], x[inside].astype(np.uint16), y[inside].astype(np.uint16), p[inside])

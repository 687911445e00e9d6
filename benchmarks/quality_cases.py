# SPDX-License-Identifier: Apache-2.0
"""What the engines are compared on: groups of recordings with their truth, and the kind of preset that fits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cot_quality import Case, between, simulated
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import load_rule, read_truth
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.recordings.files import read_recording
from shared import SHARED

__all__ = ["CONTOURS", "FILMED", "TRAFFIC", "groups", "traffic_cases", "traffic_is_here"]

TRAFFIC = "traffic_outbound"
FILMED, CONTOURS = "discs", "contours"  # in names of groups, followed by their ways

_HIGHWAY_SEEDS, _DISC_SEEDS, _BOX_SEEDS = (
    (21, 22, 23),
    (4, 5, 6, 7, 8, 9),
    (1, 2, 3),
)  # docs/evaluation.md: what was tuned on what
_DISC_SECONDS = 10
_TRUTH_STEP_US = 20_000

# Four discs, 60 events of their contours per millisecond each, and 5 % noise.
_SENSOR = 346, 260
_DISCS, _RADIUS_PX, _SPEED_PX_S, _SPREAD = 4, 10.0, 150.0, 0.5
_EVENTS_PER_MS, _NOISE = 60.0, 0.05
_NOISE_HZ = 1e3 * _DISCS * _EVENTS_PER_MS * _NOISE / (1 - _NOISE) / (_SENSOR[0] * _SENSOR[1])
_THRESHOLD = 0.056  # with which the camera sends so many events


def traffic_is_here() -> bool:
    """Whether the real recording is at hand."""
    return (SHARED / f"{TRAFFIC}.aedat4").is_file()


def groups(quick: bool = False) -> Iterator[list[Case]]:
    """Cases of one name, whose scores are averaged; one group after the other, since they are large."""
    if traffic_is_here():
        yield from ([case] for case in traffic_cases())
    few = 1 if quick else None
    yield [simulated("highway", "traffic", "highway", {}, seed) for seed in _HIGHWAY_SEEDS[:few]]
    for ways in ("separate", "crossing"):
        yield [filmed(ways, seed) for seed in _DISC_SEEDS[:few]]
        yield [contours(ways, seed) for seed in _DISC_SEEDS[:few]]
    yield [simulated("boxes", "discs", "boxes", {}, seed) for seed in _BOX_SEEDS[:few]]


def traffic_cases() -> Iterator[Case]:
    """The real motorway without its hot pixel, whole and by halves."""
    rule, recording = load_rule("traffic"), read_recording(SHARED / f"{TRAFFIC}.aedat4")
    begin_us, end_us = recording.events.t_us[[0, -1]].tolist()
    middle_us = (begin_us + end_us) // 2 + 1
    hot = learn_hot_pixels(recording.events, (recording.width, recording.height))
    recording, _ = apply(recording, FilterConfig(hot_pixels=hot))
    whole = Case(TRAFFIC, "traffic", recording, read_truth(SHARED / f"{TRAFFIC}_gt.csv", rule), rule)
    yield replace(whole, name=f"{TRAFFIC}, first half", truth=between(whole.truth, begin_us, middle_us))
    yield replace(whole, name=f"{TRAFFIC}, second half", truth=between(whole.truth, middle_us, end_us))
    yield whole


def filmed(ways: str, seed: int) -> Case:
    """Discs as a camera sees them, the nearer ones in front of the others."""
    settings: dict[str, object] = {
        "count": _DISCS,
        "radius_px": _RADIUS_PX,
        "speed_px_s": _SPEED_PX_S,
        "speed_spread": _SPREAD,
        "ways": ways,
        "duration_us": _DISC_SECONDS * 1_000_000,
        "on_threshold": _THRESHOLD,
        "off_threshold": _THRESHOLD,
        "noise_hz": _NOISE_HZ,
    }
    return simulated(f"{FILMED}, {ways}", "discs", "discs", settings, seed)


def contours(ways: str, seed: int) -> Case:
    """Discs whose contours send events at random, all round and all the time, whatever is in front of what."""
    random = np.random.default_rng(seed)
    paths, end_us = _Paths(ways, random), _DISC_SECONDS * 1_000_000
    count = round(_DISCS * _EVENTS_PER_MS * end_us * 1e-3 / (1 - _NOISE))
    t_us = np.sort(random.integers(0, end_us, count))
    disc, angle = random.integers(0, _DISCS, count), random.uniform(0, 2 * np.pi, count)
    place = paths.at(t_us, disc)[0] + _RADIUS_PX * np.stack((np.cos(angle), np.sin(angle)))
    noise = random.random(count) < _NOISE
    most = np.array(_SENSOR)[:, None] - 1
    place[:, noise] = random.uniform(0, 1, (2, np.count_nonzero(noise))) * most
    x, y = np.clip(np.rint(place), 0, most).astype(np.uint16)
    events = Events(t_us, x, y, random.integers(0, 2, count, dtype=np.uint8))
    truth = paths.truth(np.arange(0, end_us, _TRUTH_STEP_US))
    return Case(f"{CONTOURS}, {ways}", "discs", Recording(events, *_SENSOR, CONTOURS), truth, load_rule("scene"))


class _Paths:
    """Four discs that bounce off the walls: all over the sensor, or each along its own row."""

    def __init__(self, ways: str, random: np.random.Generator) -> None:
        speed = _SPEED_PX_S * (1 + _SPREAD * random.uniform(-1, 1, _DISCS))
        angle = random.uniform(0, 2 * np.pi, _DISCS)
        self._room = np.array(_SENSOR)[:, None] - 1 - 2 * _RADIUS_PX
        self._start = random.uniform(0, 1, (2, _DISCS)) * self._room
        if ways == "separate":
            angle = np.where(angle > np.pi, np.pi, 0.0)
            self._start[1] = (np.arange(_DISCS) + 0.5) * _SENSOR[1] / _DISCS - _RADIUS_PX
        self._speed = speed * np.stack((np.cos(angle), np.sin(angle)))

    def at(self, t_us: NDArray[np.int64], disc: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centres and velocities, (2, n)."""
        way = (self._start[:, disc] + self._speed[:, disc] * (t_us * 1e-6)) % (2 * self._room)
        back = way > self._room
        return _RADIUS_PX + np.where(back, 2 * self._room - way, way), np.where(back, -1, 1) * self._speed[:, disc]

    def truth(self, instants_us: NDArray[np.int64]) -> GroundTruth:
        """Every disc at every instant."""
        objects = np.zeros(len(instants_us) * _DISCS, OBJECT)
        objects["frame"], objects["object"] = np.divmod(np.arange(len(objects)), _DISCS)
        (x, y), (vx, vy) = self.at(instants_us[objects["frame"]], objects["object"])
        objects["x"], objects["y"], objects["vx"], objects["vy"] = x, y, vx, vy
        objects["width"] = objects["height"] = 2 * _RADIUS_PX
        objects["counted"] = True
        return GroundTruth(instants_us, objects, tuple(map(str, range(_DISCS))))

# SPDX-License-Identifier: Apache-2.0
"""Engines side by side, each with its own preset for the kind of scene, else its first, and the filters that the preset wants.

On real traffic, whole and by halves, the simulated motorway, four discs that keep to lanes or cross and bounce, and the box
experiment; Figures are means over draws in which a tenth of the events is lost, seeds (11, 0) to
(11, 4). `python benchmarks/quality.py` prints the table of docs/evaluation.md; `python benchmarks/quality.py cot_motion` the
rows of one engine.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cot_quality import Case, between, simulated
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import Scores, evaluate, load_rule, read_truth
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.recordings.files import read_recording
from evcot.trackers.engines import ENGINES
from evcot.tracks.log import TrackLog
from evcot.tracks.tracking import log_of
from field.draws import LOST
from field.transforms import without
from measure import Goal, Result, heading, line
from shared import SHARED

__all__ = [
    "CONTOURS",
    "FILMED",
    "TRAFFIC",
    "Quality",
    "follow",
    "groups",
    "measure",
    "quality",
    "traffic_cases",
    "traffic_is_here",
]


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


_ABSENT = f"{TRAFFIC}.aedat4 is not here: its rows are left out"
_ENGINES = ("cot_motion", "rct", "mean-shift", "frames", "cot_array")
DRAWS = 5
_PER_MINUTE = (FILMED, CONTOURS)
_MEANS = ("hota", "deta", "assa", "idf1", "mota")


@dataclass(frozen=True)
class Quality:
    """Means over the draws of the recordings of a group; None where there is nothing to measure.

    Attributes:
        switches: in all recordings of a draw; of discs, per minute.
        velocity_percent: error of the velocity, as a part of the objects' median speed.
    """

    hota: float
    deta: float
    assa: float
    idf1: float
    mota: float
    switches: float
    position_px: float | None
    velocity_percent: float | None
    latency_ms: float | None


def follow(case: Case, engine: str) -> TrackLog:
    """The log of an engine with its preset for this kind of scene, if it has one."""
    chosen, recording = ENGINES[engine], case.recording
    preset = case.preset if case.preset in chosen.presets else next(iter(chosen.presets))
    filters = chosen.filters.get(preset, FilterConfig())
    tracker = chosen.start(chosen.presets[preset], filters, (recording.width, recording.height))
    return log_of(engine, tracker, [recording.events])


def quality(group: list[Case], engine: str) -> Quality:
    """How well an engine follows what a group of recordings shows: means over the draws of each."""
    drawn = [_draw(case, draw) for case in group for draw in range(DRAWS)]
    scores = [evaluate(follow(case, engine), case.truth, case.rule) for case in drawn]
    minutes = sum(float(np.ptp(case.truth.instants_us)) for case in group) / 60e6
    switches = sum(one.idsw for one in scores) / DRAWS
    hota, deta, assa, idf1, mota = (float(np.mean([getattr(one, name) for one in scores])) for name in _MEANS)
    return Quality(
        hota,
        deta,
        assa,
        idf1,
        mota,
        switches=switches / minutes if group[0].name.startswith(_PER_MINUTE) else switches,
        position_px=_mean([one.position_error_px_median for one in scores]),
        velocity_percent=_mean([_velocity_percent(case, one) for case, one in zip(drawn, scores, strict=True)]),
        latency_ms=_mean([one.latency_ms for one in scores]),
    )


def _draw(case: Case, draw: int) -> Case:
    """Without a tenth of the events, as in the field of tests."""
    events = without(case.recording.events, LOST, (11, draw))
    return replace(case, recording=replace(case.recording, events=events))


def _velocity_percent(case: Case, scores: Scores) -> float | None:
    """Of the median speed of what moves."""
    speed = np.hypot(case.truth.objects["vx"], case.truth.objects["vy"])
    moving = speed[case.truth.objects["counted"] & (speed > 0)]
    if scores.velocity_error_median is None or not len(moving):
        return None
    return 100 * scores.velocity_error_median / float(np.median(moving))


def _mean(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """quality_<group>_<engine>_<figure>: HOTA of each engine, and what has a goal."""
    if not traffic_is_here():
        print(_ABSENT)
    for group in groups(quick):
        name = group[0].name
        for engine in _ENGINES:
            found = quality(group, engine)
            title = f"quality_{name.replace(', ', '_').replace(' ', '_')}_{engine}"
            how = f"preset {group[0].preset}, {len(group)} recordings"
            if name == TRAFFIC and engine == "rct":
                yield from _of_traffic(title, found, how)
                continue
            yield Result(f"{title}_hota", found.hota, "HOTA", how=how)
            if name.startswith(_PER_MINUTE) and engine == "rct":
                yield from _of_discs(title, found, how, 2 if "crossing" in name else 0)


def _of_traffic(title: str, found: Quality, how: str) -> Iterator[Result]:
    yield Result(f"{title}_hota", found.hota, "HOTA", 0.85, "goal", goal=Goal(1), how=how)
    yield Result(f"{title}_idf1", found.idf1, "IDF1", 0.95, "goal", goal=Goal(1), how=how)
    yield _at_most(f"{title}_switches", found.switches, 1, "", how)


def _of_discs(title: str, found: Quality, how: str, switches: float) -> Iterator[Result]:
    yield _at_most(f"{title}_switches", found.switches, switches, "/min", how)
    if found.position_px is not None and found.velocity_percent is not None:
        yield _at_most(f"{title}_position", found.position_px, 1, "px", how)
        yield _at_most(f"{title}_velocity", found.velocity_percent, 5, "%", how)


def _at_most(name: str, value: float, most: float, unit: str, how: str) -> Result:
    """A goal that may be zero: the value itself is held against it."""
    return Result(name, value, unit, ratio=value, goal=Goal(most, at_most=True), how=how)


# field of `Quality` -> (heading, format)
_COLUMNS = {
    "hota": ("HOTA", ".3f"),
    "deta": ("DetA", ".3f"),
    "assa": ("AssA", ".3f"),
    "idf1": ("IDF1", ".3f"),
    "mota": ("MOTA", ".3f"),
    "switches": ("switches", ".3g"),
    "position_px": ("position, px", ".2f"),
    "velocity_percent": ("velocity, %", ".1f"),
    "latency_ms": ("latency, ms", ".1f"),
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("engines", nargs="*", metavar="ENGINE", help=f"some of {', '.join(_ENGINES)} (default: all)")
    parser.add_argument("--quick", action="store_true", help="one simulated recording of each kind")
    options = parser.parse_args()
    if unknown := set(options.engines) - set(_ENGINES):
        parser.error(f"{', '.join(sorted(unknown))}: must be some of {', '.join(_ENGINES)}")
    heading("", "engine", *(title for title, _ in _COLUMNS.values()))
    for group in groups(options.quick):
        for engine in options.engines or _ENGINES:
            found = quality(group, engine)
            values = [(getattr(found, field), form) for field, (_, form) in _COLUMNS.items()]
            line([group[0].name, engine, *("" if value is None else format(value, form) for value, form in values)])
    if not traffic_is_here():
        print(f"\n{_ABSENT}")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Engines side by side, each with its own preset for the kind of scene, else its first, and the filters that the preset wants.

On real traffic, whole and by halves, the simulated motorway, four discs that keep to lanes or cross and bounce, and the box
experiment; `quality_cases` has the seeds. Figures are means over draws in which a tenth of the events is lost, seeds (11, 0) to
(11, 4). `python benchmarks/quality.py` prints the table of docs/evaluation.md; `python benchmarks/quality.py cot_motion` the
rows of one engine.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cot_quality import Case
from evcot.filters.config import FilterConfig
from evcot.metrics import Scores, evaluate
from evcot.trackers.engines import ENGINES
from evcot.tracks.log import TrackLog
from evcot.tracks.tracking import log_of
from field.draws import LOST
from field.transforms import without
from measure import Goal, Result
from quality_cases import CONTOURS, FILMED, TRAFFIC, groups, traffic_is_here

__all__ = ["Quality", "follow", "measure", "quality"]

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
    _print_line(["", "engine", *(heading for heading, _ in _COLUMNS.values())])
    _print_line(["---"] * (2 + len(_COLUMNS)))
    for group in groups(options.quick):
        for engine in options.engines or _ENGINES:
            found = quality(group, engine)
            values = [(getattr(found, field), form) for field, (_, form) in _COLUMNS.items()]
            _print_line([group[0].name, engine, *("" if value is None else format(value, form) for value, form in values)])
    if not traffic_is_here():
        print(f"\n{_ABSENT}")


def _print_line(cells: list[str]) -> None:
    print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Abnormal events on simulated highways: how many of the planted are found, how soon, and how many alarms are false.

Normal motion is learned from one seed without anomalies; the others have two of each kind in 45 s. With the truth in
the tracker's place, which tests the rules alone, and with two trackers. `TUNED` are the seeds on which the rules were chosen,
`FRESH` those on which nothing was. Scenes are kept in build/anomalies, as they take minutes.

    python benchmarks/anomalies.py [tuned] [truth auto rct]
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import evcot
from evcot.anomalies import anomalies, learn
from evcot.anomalies.score import AlarmScores, score_alarms, truth_log
from evcot.events import Events, Recording
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.scenes.registry import simulate_scene
from evcot.scenes.truth import Label, Truth
from evcot.trackers.rct import tracker as rct
from evcot.trackers.rct.config import FILTERS, PRESETS
from evcot.tracks.log import TrackLog
from measure import Goal, Result

__all__ = ["measure"]

NORMAL_SEED = 100
TUNED = (99, *range(101, 105), *range(107, 110), *range(111, 114), *range(115, 123))
FRESH = (201, 202, 203, 204, 205, 206)
FOUND, FALSE_A_MINUTE = 0.95, 1.0  # the goals
NORMAL_S, SECONDS = 60, 45
EACH = 2
SENSOR = (346, 260)
KINDS = ("wrong_way", "stopping", "crossing", "loitering", "speeding")
FOLDER = Path(__file__).parents[1] / "build" / "anomalies"

Engine = Callable[[Recording, Truth], TrackLog]


def _rct(recording: Recording, _truth: Truth) -> TrackLog:
    return rct.track(apply(recording, FILTERS["traffic"])[0], PRESETS["traffic"])


ENGINES: dict[str, Engine] = {
    "truth": lambda _recording, truth: truth_log(truth),
    "adaptive": lambda recording, _truth: evcot.track(recording, "adaptive"),
    "rct": _rct,
}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """anomalies_<engine>_found as a share, and _false a minute, on the fresh seeds; quick: on two of them."""
    for name in ENGINES:
        scores = _scores(name, FRESH[:2] if quick else FRESH)
        _, found, planted, false = _totals(scores)
        minutes = sum(score.minutes for score in scores)
        least, most = (None, None) if name == "rct" else (Goal(1), Goal(1, at_most=True))  # one tracker must reach them
        yield Result(f"anomalies_{name}_found", found / planted, "share", FOUND, "goal", goal=least)
        rate = sum(false.values()) / minutes
        yield Result(f"anomalies_{name}_false", rate, "1/minute", FALSE_A_MINUTE, "goal", goal=most)


def main() -> None:
    """Simulate what is not there yet, score, print."""
    names = sys.argv[1:]
    seeds = TUNED if "tuned" in names else FRESH
    for name in [name for name in names if name != "tuned"] or ENGINES:
        _print(name, _scores(name, seeds), seeds)


def _scores(name: str, seeds: Sequence[int]) -> list[AlarmScores]:
    normal = learn([_tracked(name, NORMAL_SEED)[0]], SENSOR)
    logs = (_tracked(name, seed) for seed in seeds)
    return [score_alarms(anomalies(log, None, normal).alarms, truth, SECONDS * 10**6) for log, truth in logs]


def _tracked(engine: str, seed: int) -> tuple[TrackLog, Truth]:
    recording, truth = _scene(seed)
    keep = np.ones(len(recording.events), bool)
    for x, y in learn_hot_pixels(recording.events, SENSOR):
        keep &= (recording.events.x != x) | (recording.events.y != y)
    return ENGINES[engine](replace(recording, events=recording.events.where(keep)), truth), truth


def _scene(seed: int) -> tuple[Recording, Truth]:
    path = FOLDER / f"{seed}.npz"
    if not path.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        normal = seed == NORMAL_SEED
        overrides = {"story": 0, "vehicles_per_s": 1.2, "truth_step_us": 10_000}
        overrides |= {"duration_us": (NORMAL_S if normal else SECONDS) * 10**6} | ({} if normal else dict.fromkeys(KINDS, EACH))
        scene = simulate_scene("highway", seed, overrides)
        events, truth = scene.recording.events, scene.truth
        labels = np.array([tuple(map(str, label)) for label in truth.labels], np.str_).reshape(-1, 4)
        np.savez(path, t=events.t_us, x=events.x, y=events.y, p=events.p, truth=truth.samples, labels=labels)
    with np.load(path) as stored:
        labels_of = tuple(Label(int(i), str(kind), int(begin), int(end)) for i, kind, begin, end in stored["labels"])
        events = Events(stored["t"], stored["x"], stored["y"], stored["p"])
        return Recording(events, *SENSOR, "highway"), replace(Truth(stored["truth"]), labels=labels_of)


def _totals(scores: Sequence[AlarmScores]) -> tuple[dict[str, tuple[int, int]], int, int, dict[str, int]]:
    """(found, planted) by kind, both in all, and false alarms by kind."""
    of_kind = {kind: (sum(s.found[kind] for s in scores), sum(s.planted[kind] for s in scores)) for kind in KINDS}
    false: dict[str, int] = {}
    for score in scores:
        for kind, count in score.false_alarms.items():
            false[kind] = false.get(kind, 0) + count
    found, planted = map(sum, zip(*of_kind.values(), strict=True))
    return of_kind, found, planted, false


def _print(name: str, scores: Sequence[AlarmScores], seeds: Sequence[int]) -> None:
    of_kind, found, planted, false = _totals(scores)
    minutes = sum(score.minutes for score in scores)
    print(f"{name}: {minutes:g} minutes, seeds {', '.join(map(str, seeds))}")
    print(f"  {'kind':10} {'found':>7} {'median s to alarm':>18}")
    for kind, (hits, of) in of_kind.items():
        waits = [wait for score in scores for wait in score.seconds_to_alarm[kind]]
        print(f"  {kind:10} {hits:3}/{of:<3} {np.median(waits) if waits else np.nan:18.1f}")
    told = ", ".join(f"{count} {kind}" for kind, count in sorted(false.items())) or "none"
    rate = sum(false.values()) / minutes
    print(f"  all        {found:3}/{planted:<3} {found / planted:.1%}; false alarms {rate:.2f} a minute: {told}")
    missed = [f"{seed} {label.kind} {label.object_id}" for seed, s in zip(seeds, scores, strict=True) for label in s.missed]
    print(f"  missed     {', '.join(missed) or 'none'}")


if __name__ == "__main__":
    main()

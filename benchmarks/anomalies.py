# SPDX-License-Identifier: Apache-2.0
"""Abnormal events on simulated highways: how many of the planted are found, how soon, and how many alarms are false.

Normal motion is learned from one seed without anomalies; the others have two of each kind in 45 s. Twice: with the truth in the
tracker's place, which tests the rules alone, and with real tracks. Scenes are kept in build/anomalies, as they take minutes.

    python benchmarks/anomalies.py [truth kalman rct]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from evcot.anomalies import anomalies, learn
from evcot.anomalies.score import AlarmScores, score_alarms, truth_log
from evcot.events import Events, Recording
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.kalman import tracker as kalman
from evcot.kalman.config import KalmanConfig
from evcot.rct import tracker as rct
from evcot.rct.presets import PRESETS
from evcot.scenes.registry import simulate_scene
from evcot.scenes.truth import Label, Truth
from evcot.tracklog import TrackLog

NORMAL_SEED, SEEDS = 100, (101, 102, 103, 104)
NORMAL_S, SECONDS = 60, 45
EACH = 2
SENSOR = (346, 260)
KINDS = ("wrong_way", "stopping", "crossing", "loitering", "speeding")
FOLDER = Path(__file__).parents[1] / "build" / "anomalies"

# People are slow and make few events: births may take longer than for cars, and silences too.
KALMAN = KalmanConfig(birth_us=30_000, birth_pixels=16, coast_us=250_000, packet_us=4_000)

Engine = Callable[[Recording, np.ndarray, Truth], TrackLog]
ENGINES: dict[str, Engine] = {
    "truth": lambda _recording, _keep, truth: truth_log(truth),
    "kalman": lambda recording, keep, _truth: kalman.track(recording, KALMAN, keep),
    "rct": lambda recording, keep, _truth: rct.track(recording, PRESETS["traffic"], keep),
}


def main() -> None:
    """Simulate what is not there yet, score, print."""
    for name in sys.argv[1:] or ENGINES:
        normal = learn([_tracked(name, NORMAL_SEED)[0]], SENSOR)
        scores = []
        for seed in SEEDS:
            log, truth = _tracked(name, seed)
            scores.append(score_alarms(anomalies(log, None, normal).alarms, truth, SECONDS * 10**6))
        _print(name, scores)


def _tracked(engine: str, seed: int) -> tuple[TrackLog, Truth]:
    recording, truth = _scene(seed)
    keep = np.ones(len(recording.events), bool)
    for x, y in learn_hot_pixels(recording.events, SENSOR):
        keep &= (recording.events.x != x) | (recording.events.y != y)
    return ENGINES[engine](recording, keep, truth), truth


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


def _print(name: str, scores: list[AlarmScores]) -> None:
    minutes = sum(score.minutes for score in scores)
    print(f"{name}: {minutes:g} minutes, seeds {', '.join(map(str, SEEDS))}")
    print(f"  {'kind':10} {'found':>7} {'median s to alarm':>18}")
    for kind in KINDS:
        found, planted = (sum(getattr(score, part)[kind] for score in scores) for part in ("found", "planted"))
        waits = [wait for score in scores for wait in score.seconds_to_alarm[kind]]
        print(f"  {kind:10} {found:3}/{planted:<3} {np.median(waits) if waits else np.nan:18.1f}")
    found, planted = (sum(sum(getattr(score, part).values()) for score in scores) for part in ("found", "planted"))
    false: dict[str, int] = {}
    for score in scores:
        for kind, count in score.false_alarms.items():
            false[kind] = false.get(kind, 0) + count
    told = ", ".join(f"{count} {kind}" for kind, count in sorted(false.items())) or "none"
    rate = sum(false.values()) / minutes
    print(f"  all        {found:3}/{planted:<3} {found / planted:.1%}; false alarms {rate:.2f} a minute: {told}")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Search for registers of cot_motion on many families of the field at once, by random steps from the best so far.

python benchmarks/motion_search.py --seed 1 --minutes 40      # prints every better setting, and what differs from the preset

Filters and slots are those of the preset. A merit is a mean over families,
with weights, of 0.7 HOTA of centres + 0.3 HOTA of boxes; where nothing is there, of 1 - 0.25 per track. A setting that is worse
than the one it came from on a part of the recordings is dropped at once.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter, defaultdict
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hardware.config import MotionConfig
from evcot.hardware.motion.contract import MOTION_RANGES
from evcot.metrics import evaluate
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import MOTION
from evcot.tracks.log import Kind, TrackLog
from field import Absent, entries
from field.member import Member

assert isinstance(MOTION.hardware, MotionConfig)
_HARDWARE, _REGISTERS = MOTION.hardware, MOTION.hardware.registers
_CHOSEN_ON = (1, 2)  # seed sets
_WEIGHTS = {
    "traffic, space": 0.7, "traffic, time": 0.7, "traffic, loss": 0.6, "traffic, crowd": 0.6, "motorway": 1.2,
    "second simulator, road": 1.0, "second simulator, shapes": 0.7, "boxes": 0.7, "digits": 1.0, "nothing": 0.6, "discs": 1.2,
    "insects": 0.5, "shake": 0.6, "pendulum, recorded": 0.5, "hand": 0.7,
}  # fmt: skip
_FIXED = ("step_log2", "speed_max")  # chosen by the scene, or a limit
_DRAWN_ONCE = ("traffic", "hand", "pendulum, recorded")  # all but the same in every seed set
_MOST = 4  # recordings of a family and seed set
_POOL = 8
_CHECKS = {1 / 6: 0.025, 1 / 3: 0.012, 1 / 2: 0.006, 2 / 3: 0.006}  # share of the recordings -> how much worse it may be there

Registers = dict[str, int]


class Case(NamedTuple):
    """A recording, and its family's name in `_WEIGHTS`."""

    family: str
    member: Member


def main() -> None:
    """Search."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="of the search (default 1)")
    parser.add_argument("--minutes", type=float, default=40.0, help="how long (default 40)")
    options = parser.parse_args()
    print(f"seed {options.seed}")
    rng, end_s = np.random.default_rng(options.seed), time.monotonic() + 60 * options.minutes
    cases = _cases()
    order = rng.permutation(len(cases))
    start = {name: int(getattr(_REGISTERS, name)) for name in MOTION_RANGES if name not in _FIXED}
    scores = [_score(start, case) for case in cases]
    pool = [(_merit(cases, scores, order), start, scores)]
    print(f"{len(cases)} recordings; the preset: {pool[0][0]:.4f}", flush=True)
    tried = 0
    while time.monotonic() < end_s:
        _, parent, of_parent = pool[int(rng.integers(len(pool)))]
        registers = _stepped(parent, rng)
        tried += 1
        try:
            found = _scores(registers, cases, order, of_parent)
        except ConfigError:
            continue  # values that contradict each other
        if found is None:
            continue
        pool.append((_merit(cases, found, order), registers, found))
        best = pool[-1][0] > pool[0][0]
        pool = sorted(pool, key=lambda entry: -entry[0])[:_POOL]
        if best:
            changed = {name: value for name, value in registers.items() if value != start[name]}
            print(f"{tried} tried, {pool[0][0]:.4f}: {changed}", flush=True)
    print(f"{tried} tried")


def _cases() -> list[Case]:
    found: list[Case] = []
    for seed_set in _CHOSEN_ON:
        counts: Counter[str] = Counter()
        for entry in entries(seed_set, quick=False):
            family = next((name for name in _WEIGHTS if entry.family.startswith(name)), None)
            if family is None or counts[family] == _MOST or (seed_set != _CHOSEN_ON[0] and family.startswith(_DRAWN_ONCE)):
                continue
            try:
                member = entry.build()
            except Absent:
                continue
            counts[family] += 1
            found.append(Case(family, member))
    return found


def _stepped(registers: Registers, rng: np.random.Generator) -> Registers:
    """One to four registers changed: those of few values by one or two, others by a third or so."""
    changed = dict(registers)
    for name in rng.choice(list(registers), size=int(rng.integers(1, 5)), replace=False):
        low, high, _ = MOTION_RANGES[name]
        value = changed[name]
        if high - low <= 15:
            value += int(rng.choice([-2, -1, 1, 2]))
        else:
            other = round(value * float(np.exp(rng.normal(0, 0.35))))
            value = other if other != value else value + int(rng.choice([-1, 1]))
        changed[name] = int(min(max(value, low), high))
    return changed


def _scores(registers: Registers, cases: list[Case], order: NDArray[np.int64], of_parent: list[float]) -> list[float] | None:
    """The score on every recording; None if it is worse than its parent's on a part of them."""
    found = [0.0] * len(cases)
    checks = {round(share * len(cases)): least for share, least in _CHECKS.items()}
    for done, at in enumerate(order.tolist(), 1):
        found[at] = _score(registers, cases[at])
        if done in checks:
            part = order[:done]
            if _merit(cases, found, part) < _merit(cases, of_parent, part) - checks[done]:
                return None
    return found


def _merit(cases: list[Case], scores: list[float], part: NDArray[np.int64]) -> float:
    families = defaultdict(list)
    for at in part.tolist():
        families[cases[at].family].append(scores[at])
    return float(np.average([np.mean(values) for values in families.values()], weights=[_WEIGHTS[name] for name in families]))


def _score(registers: Registers, case: Case) -> float:
    member, recording = case.member, case.member.recording
    config = replace(MOTION, hardware=replace(_HARDWARE, registers=replace(_REGISTERS, **registers)))
    tracker = ENGINES["cot_motion"].start(config, config.filters, (recording.width, recording.height))
    records = np.concatenate([tracker.feed(recording.events)[0], tracker.finish()])
    if member.empty:
        return max(0.0, 1.0 - 0.25 * np.count_nonzero(records["kind"] == Kind.BORN))
    log = TrackLog("search", records, np.empty(0, np.int16))
    centres = evaluate(log, member.truth, member.rule).hota or 0.0
    boxes = evaluate(log, member.truth, replace(member.rule, similarity="iou")).hota or 0.0
    return 0.7 * centres + 0.3 * boxes


if __name__ == "__main__":
    main()

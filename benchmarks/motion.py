# SPDX-License-Identifier: Apache-2.0
"""cot_motion beside cot_array: one configuration, the golden model, the goals of docs/motion.md.

python benchmarks/motion.py             # every row; a few minutes
python benchmarks/motion.py traffic     # rows that begin so
python benchmarks/motion.py --alone     # without cot_array
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

import quality_cases
from evcot.metrics import evaluate
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import PRESETS
from evcot.tracks.log import Kind, TrackLog
from field import Absent, entries
from field.member import Member

_CHOSEN_ON, _UNSEEN = 1, 5  # seed sets of the field
_DISC_SEEDS = {"chosen on": (11, 12), "unseen": (4, 5, 6, 7, 8, 9)}
_TRAFFIC = {"as recorded", "upside down", "half the size", "backwards"}
_COLUMNS = ("HOTA", "IoU", "switches/min", "BORN")

Row = tuple[str, str, list[Callable[[], Member]]]  # name, today's preset beside it, members


def main() -> int:
    """Print the table."""
    alone = "--alone" in sys.argv
    begins = tuple(word for word in sys.argv[1:] if word != "--alone") or ("",)
    titles = ("motion",) if alone else ("motion", "today")
    print("| | " + " | ".join(f"{title}, {column}" for title in titles for column in _COLUMNS) + " |")
    print("|---" * (1 + len(titles) * len(_COLUMNS)) + "|")
    for name, today, builders in _rows():
        if not name.startswith(begins):
            continue
        try:
            presets = ("motion",) if alone else ("motion", today)
            cells = np.array([_scores(presets, build()) for build in builders]).mean(axis=0)
        except Absent as reason:
            print(f"{name}: left out: {reason}", file=sys.stderr)
            continue
        shown = [f"{value:.3f}" if i % 4 < 2 else f"{value:.1f}" for i, value in enumerate(cells)]
        print(f"| {name} | " + " | ".join(shown).replace("nan", "") + " |", flush=True)
    return 0


def _rows() -> Iterator[Row]:
    for entry in entries(_CHOSEN_ON, False):
        if entry.family.startswith("traffic") and entry.name in _TRAFFIC:
            yield f"traffic, {entry.name}", "traffic", [entry.build]
    for label, seeds in _DISC_SEEDS.items():
        for ways in ("crossing", "separate"):
            for make in (quality_cases.filmed, quality_cases.contours):
                yield f"discs {ways}, {make.__name__}, {label}", "discs", [_case(make, ways, seed) for seed in seeds]
    for seed_set, label in ((_CHOSEN_ON, "chosen on"), (_UNSEEN, "unseen")):
        found = [entry.build for entry in entries(seed_set, False) if entry.family == "motorway, simulated"]
        yield f"motorways, simulated, {label}", "traffic", found
    for entry in entries(_UNSEEN, True):
        if entry.family == "nothing there":
            yield f"nothing there, {entry.name}", "traffic", [entry.build]


def _case(make: Callable[[str, int], quality_cases.Case], ways: str, seed: int) -> Callable[[], Member]:
    def build() -> Member:
        case = make(ways, seed)
        return Member("discs", case.name, case.recording, case.truth, case.rule, "exact")

    return build


def _scores(presets: Sequence[str], member: Member) -> list[float]:
    """For each preset HOTA of centres and of boxes, switches a minute, and records BORN; NaN where there is no truth."""
    return [score for preset in presets for score in _score(preset, member)]


def _score(preset: str, member: Member) -> tuple[float, ...]:
    run: RunConfig = PRESETS[preset]
    recording = member.recording
    tracker = ENGINES[run.hardware.module].start(run, run.filters, (recording.width, recording.height))
    records = np.concatenate([tracker.feed(recording.events)[0], tracker.finish()])
    born = float(np.count_nonzero(records["kind"] == Kind.BORN))
    if member.empty:
        return np.nan, np.nan, np.nan, born
    log = TrackLog(preset, records, np.empty(0, np.int16))
    centre = evaluate(log, member.truth, member.rule)
    boxes = evaluate(log, member.truth, replace(member.rule, similarity="iou"))
    minutes = float(member.truth.instants_us[-1] - member.truth.instants_us[0]) / 6e7
    return centre.hota or 0.0, boxes.hota or 0.0, centre.idsw / minutes, born


if __name__ == "__main__":
    sys.exit(main())

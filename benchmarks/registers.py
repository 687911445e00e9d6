# SPDX-License-Identifier: Apache-2.0
"""The hardware with registers by what is seen in the recording, on every family of the field: docs/auto.md's table.

python benchmarks/registers.py                  # seed set 1, on which the rules were chosen; 10 minutes
python benchmarks/registers.py --seed-set 41    # another; recordings that do not depend on it are left out

The golden model, whole recordings: `auto-paper` (the array without motion), the preset `motion`, and `auto`. Rows are means
over the members of a family.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evcot.metrics import evaluate
from evcot.trackers.auto.estimates import estimate
from evcot.trackers.auto_registers import AUTO, AUTO_PAPER, auto_config
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import PRESETS
from evcot.tracks.log import Kind, TrackLog
from field import members
from field.member import Member

_CHOSEN_ON = 1
_FIXED = ("traffic, space", "traffic, time", "traffic, crowd", "pendulum, recorded", "hand, recorded")
_MOTION = "motion"
_COLUMNS = ("HOTA", "IoU", "IDF1", "BORN")


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed-set", type=int, default=_CHOSEN_ON, help="of everything drawn in the field (default 1)")
    seed_set = parser.parse_args().seed_set
    contenders = (AUTO_PAPER, _MOTION, AUTO)
    print("| family | " + " | ".join(f"{name}: {column}" for name in contenders for column in _COLUMNS) + " |")
    print("|---" * (1 + len(contenders) * len(_COLUMNS)) + "|")
    means = []
    for family, scores in _families(seed_set):
        mean = np.mean(scores, axis=0)
        means.append(mean)
        _print(family, mean)
    _print("**mean of those with objects**", np.nanmean([mean for mean in means if not np.isnan(mean[0, 0])], axis=0))
    return 0


def _families(seed_set: int) -> Iterator[tuple[str, list[list[tuple[float, ...]]]]]:
    name, scores = "", []
    for member in members(seed_set):
        if seed_set != _CHOSEN_ON and member.family in _FIXED:
            continue
        if member.family != name and scores:
            yield name, scores
            scores = []
        name = member.family
        scores.append([_score(config, member) for config in _configs(member)])
    if scores:
        yield name, scores


def _configs(member: Member) -> tuple[RunConfig, ...]:
    recording = member.recording
    seen = estimate([recording.events], (recording.width, recording.height))
    return auto_config(seen, AUTO_PAPER), PRESETS[_MOTION], auto_config(seen)


def _score(config: RunConfig, member: Member) -> tuple[float, ...]:
    """HOTA of centres and of boxes, IDF1, and records BORN; NaN where there is no truth."""
    recording = member.recording
    tracker = ENGINES["cot"].start(config, config.filters, (recording.width, recording.height))
    records = np.concatenate([tracker.feed(recording.events)[0], tracker.finish()])
    born = float(np.count_nonzero(records["kind"] == Kind.BORN))
    if member.empty:
        return np.nan, np.nan, np.nan, born
    log = TrackLog(config.name, records, np.empty(0, np.int16))
    centre = evaluate(log, member.truth, member.rule)
    boxes = evaluate(log, member.truth, replace(member.rule, similarity="iou"))
    return centre.hota or 0.0, boxes.hota or 0.0, centre.idf1 or 0.0, born


def _print(name: str, mean: NDArray[np.float64]) -> None:
    cells = [
        f"{value:.0f}" if column == "BORN" else f"{value:.3f}"
        for row in mean
        for column, value in zip(_COLUMNS, row, strict=True)
    ]
    print(f"| {name} | " + " | ".join(cells).replace("nan", "") + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())

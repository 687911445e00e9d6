# SPDX-License-Identifier: Apache-2.0
"""The hardware with registers by what is seen in the recording, on every family of the field: docs/adaptive.md's table.

python benchmarks/registers.py                  # seed set 1, on which the rules were chosen; 15 minutes
python benchmarks/registers.py --seed-set 41    # another; recordings that do not depend on it are left out

The golden model, whole recordings. Rows are means over the members of a family. `by hand` is that of three presets of
cot_array (the one for the sensor, `traffic`, `discs`) which is best on the family, hot pixels masked. The others are of
cot_motion: `motion` is the preset; `auto` holds the filters that the noise of the whole recording asks for, `follows` measures
it while the recording goes on: the default of `evcot track`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.metrics import evaluate
from evcot.trackers.adaptive.estimates import estimate
from evcot.trackers.auto import auto_config
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import AUTO, FOLLOWING, PRESETS, for_sensor
from evcot.tracks.log import Kind, TrackLog
from field import members
from field.member import Member

CHOSEN_ON = 1
FIXED = ("traffic, space", "traffic, time", "traffic, crowd", "pendulum, recorded", "hand, recorded")
_BY_HAND = ("for the sensor", "traffic", "discs")
_FOLLOWS = "follows"
_REGISTERS = ("motion", AUTO, _FOLLOWS)
_COLUMNS = ("HOTA", "IoU", "IDF1", "BORN")

Scores = dict[str, NDArray[np.float64]]  # columns, by the name of the settings


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed-set", type=int, default=CHOSEN_ON, help="of everything drawn in the field (default 1)")
    titles = ("by hand", *_REGISTERS)
    print("| family | best by hand | " + " | ".join(f"{title}: {column}" for title in titles for column in _COLUMNS) + " |")
    print("|---" * (2 + len(titles) * len(_COLUMNS)) + "|")
    rows = []
    for family, members_scores in _families(parser.parse_args().seed_set):
        mean = {name: np.mean([scores[name] for scores in members_scores], axis=0) for name in members_scores[0]}
        best = max(_BY_HAND, key=lambda name: mean[name][0] if mean[name][0] >= 0 else -mean[name][-1])
        row = np.array([mean[best], *(mean[name] for name in _REGISTERS)])
        _print(family, best, row)
        if row[0, 0] >= 0:
            rows.append(row)
    _print("**mean of those with objects**", "", np.mean(rows, axis=0))
    return 0


def _families(seed_set: int) -> Iterator[tuple[str, list[Scores]]]:
    name, found = "", []
    for member in members(seed_set):
        if seed_set != CHOSEN_ON and member.family in FIXED:
            continue
        if member.family != name and found:
            yield name, found
            found = []
        name = member.family
        found.append({settings: _score(config, member) for settings, config in _configs(member).items()})
    if found:
        yield name, found


def _configs(member: Member) -> dict[str, RunConfig]:
    recording = member.recording
    sensor = recording.width, recording.height
    seen = estimate([recording.events], sensor)
    hot = learn_hot_pixels(recording.events, sensor)
    by_hand = {name: for_sensor(sensor[0]) if name == _BY_HAND[0] else PRESETS[name] for name in _BY_HAND}
    masked = {name: replace(run, filters=replace(run.filters, hot_pixels=hot)) for name, run in by_hand.items()}
    return {**masked, "motion": PRESETS["motion"], AUTO: auto_config(seen), _FOLLOWS: FOLLOWING}


def _score(config: RunConfig, member: Member) -> NDArray[np.float64]:
    """HOTA of centres and of boxes, IDF1, and records BORN; NaN where there is no truth."""
    recording = member.recording
    tracker = ENGINES[config.hardware.module].start(config, config.filters, (recording.width, recording.height))
    records = np.concatenate([tracker.feed(recording.events)[0], tracker.finish()])
    born = float(np.count_nonzero(records["kind"] == Kind.BORN))
    if member.empty:
        return np.array([np.nan, np.nan, np.nan, born])
    log = TrackLog(config.name, records, np.empty(0, np.int16))
    centre = evaluate(log, member.truth, member.rule)
    boxes = evaluate(log, member.truth, replace(member.rule, similarity="iou"))
    return np.array([centre.hota or 0.0, boxes.hota or 0.0, centre.idf1 or 0.0, born])


def _print(name: str, best: str, row: NDArray[np.float64]) -> None:
    cells = [
        f"{value:.0f}" if column == "BORN" else f"{value:.3f}"
        for scores in row
        for column, value in zip(_COLUMNS, scores, strict=True)
    ]
    print(f"| {name} | {best} | " + " | ".join(cells).replace("nan", "") + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())

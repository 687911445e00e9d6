# SPDX-License-Identifier: Apache-2.0
"""Where `adaptive` loses on members of the field: which instants of objects are missed, and what is there instead.

python benchmarks/losses.py                                             # recorded and simulated roads: a mean for each family
python benchmarks/losses.py --families hand pendulum --seed-set 2

An object is found where a track follows it with a similarity of at least 0.5, as for CLEAR. Shares are of all instants of
objects. "Reported at birth" is what HOTA would gain if all that becomes visible were reported from its birth on.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.metrics.frames import Frames, Matches, line_up
from evcot.metrics.mot import clear, hota
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.tracker import AdaptiveTracker
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.log_parts import sampled
from field import Absent, Member, entries

__all__ = ["COLUMNS", "Boxes", "instead", "losses", "main", "when"]

_FOUND = 0.5
_ROADS = "traffic", "motorway", "second simulator, road"
_WHEN = "before", "between", "after", "never"  # of the first and the last instant at which the object is found
_INSTEAD = "box over several", "box beside", "not reported", "nothing"
_GAINS = "centres exact", "no false track", "reported at birth"  # of HOTA
COLUMNS = ("HOTA", *_WHEN, *_INSTEAD, *_GAINS)

Boxes = NDArray[np.float64]  # (k, 4): centre x, y; half width, half height


def when(matches: Matches, frame: int, of: int) -> str:
    """When an object, missed in a frame, is missed."""
    found = matches.frame[matches.truth == of]
    if not len(found):
        return "never"
    return "before" if frame < found.min() else "after" if frame > found.max() else "between"


def instead(missed: Boxes, objects: Boxes, reported: Boxes, others: Boxes) -> str:
    """What is there instead of an object, `missed` (4,); `others` are boxes that the tracker has, but does not report."""
    over = _hold(reported, missed[None])[:, 0]
    if (over & (_hold(reported, objects).sum(axis=1) > 1)).any():
        return "box over several"
    if (over | _hold(missed[None], reported)[0]).any():
        return "box beside"
    if (_hold(others, missed[None])[:, 0] | _hold(missed[None], others)[0]).any():
        return "not reported"
    return "nothing"


def losses(member: Member) -> list[float]:
    """The figures of `COLUMNS`."""
    log, early, tentative = _followed(member)
    frames, counted, outputs = _lined_up(log, member)
    matches = clear(frames, _FOUND).matches
    found = set(zip(matches.frame.tolist(), matches.truth.tolist(), strict=True))
    counts: Counter[str] = Counter()
    for frame, numbers in enumerate(frames.truth):
        own, objects = counted[counted["frame"] == frame], member.truth.objects[member.truth.objects["frame"] == frame]
        reported = _boxes(outputs[outputs["sample"] == frame])
        for at, number in enumerate(numbers.tolist()):
            if (frame, number) not in found:
                counts[when(matches, frame, number)] += 1
                counts[instead(_boxes(own)[at], _boxes(objects), reported, tentative[frame])] += 1
    score, total = hota(frames).hota, max(len(counted), 1)
    changes = _exact(frames, matches), _true(frames, matches), _lined_up(early, member)[0]
    gains = [hota(changed).hota - score for changed in changes]
    return [score, *(counts[name] / total for name in (*_WHEN, *_INSTEAD)), *gains]


def _lined_up(log: TrackLog, member: Member) -> tuple[Frames, NDArray[np.void], NDArray[np.void]]:
    return line_up(sampled(log.record_runs(), member.truth.instants_us, member.rule.max_age_us), member.truth, member.rule)


def _followed(member: Member) -> tuple[TrackLog, TrackLog, list[Boxes]]:
    """The log; the log if what becomes visible were reported at once; and at each instant the boxes that are not reported."""
    recording = member.recording
    tracker = AdaptiveTracker(AdaptiveConfig(), recording.width, recording.height)
    world = tracker._world
    parts, tentative, done = [np.empty(0, TRACK)], [], 0
    early: list[tuple[int, int, NDArray[np.void]]] = []  # slot, born_us, record
    names: dict[tuple[int, int], int] = {}  # (slot, born_us) -> track id
    for t_us, end in zip(
        member.truth.instants_us, np.searchsorted(recording.events.t_us, member.truth.instants_us, "right"), strict=True
    ):
        parts.append(tracker.feed(recording.events[done:end])[0])
        done = int(end)
        here = world.objects["alive"] & (world.objects["away"] < 0)
        for slot in np.flatnonzero(here).tolist():
            born_us, track_id = int(world.objects["born_us"][slot]), int(world.objects["track_id"][slot])
            if track_id >= 0:
                names[slot, born_us] = track_id
            else:
                early.append((slot, born_us, _record(world.state[slot], int(t_us))))
        state = world.state[here & (world.objects["track_id"] < 0)]
        tentative.append(np.stack([state[:, 0, 0], state[:, 1, 0], state[:, 0, 2], state[:, 1, 2]], axis=1))
    parts += [tracker.feed(recording.events[done:])[0], tracker.finish()]
    records = np.concatenate(parts)
    for slot, born_us, record in early:
        if (slot, born_us) in names:
            record["track_id"] = names[slot, born_us]
            parts.append(record)
    whole = np.concatenate(parts)
    nobody = np.empty(0, np.int16)
    whole = whole[np.argsort(whole["t_us"], kind="stable")]
    return TrackLog("adaptive", records, nobody), TrackLog("adaptive", whole, nobody), tentative


def _record(state: NDArray[np.float64], t_us: int) -> NDArray[np.void]:
    """What would be reported of an object, (1,) of dtype `TRACK`."""
    record = np.zeros(1, TRACK)
    record["t_us"], record["kind"], record["other_id"] = t_us, int(Kind.MOVED), -1
    record["x"], record["y"] = state[0, 0], state[1, 0]
    record["width"], record["height"] = 2 * state[0, 2], 2 * state[1, 2]
    return record


def _boxes(rows: NDArray[np.void]) -> Boxes:
    return np.stack([rows["x"], rows["y"], rows["width"] / 2, rows["height"] / 2], axis=1).astype(np.float64)


def _hold(boxes: Boxes, places: Boxes) -> NDArray[np.bool_]:
    """(boxes, places): whether a box holds a centre."""
    off = np.abs(boxes[:, None, :2] - places[None, :, :2])
    held: NDArray[np.bool_] = np.all(off <= boxes[:, None, 2:], axis=2)
    return held


def _pairs(frames: Frames, matches: Matches) -> Iterator[tuple[int, NDArray[np.int64], NDArray[np.int64]]]:
    """By frame: rows and columns of what was found."""
    for frame, (truth, tracks) in enumerate(zip(frames.truth, frames.tracks, strict=True)):
        own = matches.frame == frame
        rows = [int(np.flatnonzero(truth == number)[0]) for number in matches.truth[own]]
        columns = [int(np.flatnonzero(tracks == number)[0]) for number in matches.track[own]]
        yield frame, np.array(rows, np.int64), np.array(columns, np.int64)


def _exact(frames: Frames, matches: Matches) -> Frames:
    similarity = [one.copy() for one in frames.similarity]
    for frame, rows, columns in _pairs(frames, matches):
        similarity[frame][rows, columns] = 1.0
    return replace(frames, similarity=tuple(similarity))


def _true(frames: Frames, matches: Matches) -> Frames:
    kept = [
        (frames.tracks[frame][columns], frames.similarity[frame][:, columns]) for frame, _, columns in _pairs(frames, matches)
    ]
    return replace(frames, tracks=tuple(tracks for tracks, _ in kept), similarity=tuple(one for _, one in kept))


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--families", nargs="+", metavar="WORD", default=_ROADS, help="families whose name begins so")
    parser.add_argument("--seed-set", type=int, default=1, help="of everything drawn in the field (default 1)")
    options = parser.parse_args()
    every: defaultdict[str, list[Any]] = defaultdict(list)
    for entry in entries(options.seed_set, quick=False):
        if not entry.family.startswith(tuple(options.families)):
            continue
        try:
            every[entry.family].append(losses(entry.build()))
        except Absent as reason:
            print(f"{entry.family}, {entry.name}: left out: {reason}", file=sys.stderr)
    print(f"| family | {' | '.join(COLUMNS)} |")
    print("|---" * (len(COLUMNS) + 1) + "|")
    for family, rows in every.items():
        print(f"| {family} | {' | '.join(f'{value:.3f}' for value in np.mean(rows, axis=0))} |")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""A tracker that does not see every part: its log is of the whole stream."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events
from evcot.scenes.registry import simulate_scene
from evcot.trackers.rct.presets import PRESETS
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import DROPPED, TRACK, Kind
from evcot.tracks.tracking import FilteredTracker, TrackerOutput
from evcot_cosim.live.gaps import GapTracker

from .stories import EveryTenth, random_events, record


def test_without_gaps_it_is_the_tracker() -> None:
    some = random_events(95, 1)
    records, owner = GapTracker(EveryTenth()).feed(some)
    wanted, wanted_owner = EveryTenth().feed(some)
    assert np.array_equal(records, wanted)
    assert np.array_equal(owner, wanted_owner)


def test_records_number_what_the_tracker_has_not_seen_too() -> None:
    tracker = GapTracker(EveryTenth())
    records = [tracker.feed(random_events(15, 1))[0]]  # 0, 10 -> 0, 10
    assert tracker.skip(100).tolist() == [DROPPED] * 100
    records.append(tracker.feed(random_events(10, 2))[0])  # 20 -> 120
    assert tracker.skip(0).tolist() == []
    tracker.skip(7)
    records += [tracker.feed(random_events(10, 3))[0], tracker.finish()]  # 30 -> 137; at the end -> 142
    assert np.concatenate(records)["event_index"].tolist() == [0, 10, 120, 137, 142]


class Late:
    """A tracker whose next call returns records of the given events."""

    def __init__(self, *event_indices: list[int]) -> None:
        self._event_indices = iter(event_indices)

    def _records(self) -> NDArray[np.void]:
        return np.concatenate([np.empty(0, TRACK), *(record(Kind.MOVED, 0, i, 1) for i in next(self._event_indices))])

    def feed(self, some: Events) -> TrackerOutput:
        return self._records(), np.zeros(len(some), np.int16)

    def finish(self) -> NDArray[np.void]:
        return self._records()

    @property
    def settled(self) -> int:
        return 0


def test_records_that_come_late_are_numbered_by_where_their_event_was() -> None:
    tracker = GapTracker(Late([], [3], [4, 5, 7], [10], [15]))
    five = random_events(5, 1)
    got = [tracker.feed(five)[0]]
    tracker.skip(100)
    got.append(tracker.feed(five)[0])  # from before the gap
    tracker.skip(1_000)
    got.append(tracker.feed(five)[0])  # from before both, the first after the first, and one more
    got += [tracker.feed(five[:0])[0], tracker.finish()]
    assert [rows["event_index"].tolist() for rows in got] == [[], [3], [4, 105, 107], [1_110], [1_115]]


class Mute:
    """A tracker that tells nothing, of whatever it is fed."""

    settled = 0

    def feed(self, some: Events) -> TrackerOutput:
        self.settled += len(some)
        return np.empty(0, TRACK), np.zeros(len(some), np.int16)

    def finish(self) -> NDArray[np.void]:
        return np.empty(0, TRACK)


def test_gaps_are_let_go_though_the_tracker_tells_nothing() -> None:
    tracker, five = GapTracker(Mute()), random_events(5, 1)
    for _ in range(1_000):
        tracker.feed(five)
        tracker.skip(2)
        tracker.skip(1)
    assert len(tracker._gaps) == 2
    assert tracker.settled == 5 * 1_000 + 3 * 999


@pytest.mark.parametrize("seed", range(3))
def test_a_real_tracker_numbers_as_one_behind_a_filter_does(seed: int) -> None:
    """Its records come later than the events that caused them: packets end after them."""
    recording = simulate_scene("discs", 5, {"duration_us": 100_000}).recording
    events, random = recording.events, np.random.default_rng(seed)
    cuts = np.sort(random.integers(len(events), size=40))
    runs = [events[a:b] for a, b in zip([0, *cuts], [*cuts, len(events)], strict=True)]
    seen = random.random(len(runs)) < 0.7
    config = PRESETS["plain"]

    def software() -> RctTracker:
        return RctTracker(config, recording.width, recording.height)

    gap = GapTracker(software())
    kept = FilteredTracker(lambda run: next(keeps), software())
    keeps = iter([np.full(len(run), see) for run, see in zip(runs, seen, strict=True)])
    wanted = [kept.feed(run) for run in runs]
    got = [gap.feed(run) if see else (None, gap.skip(len(run))) for run, see in zip(runs, seen, strict=True)]
    assert np.array_equal(np.concatenate([o for _, o in got]), np.concatenate([o for _, o in wanted]))
    all_got = np.concatenate([*(records for records, _ in got if records is not None), gap.finish()])
    all_wanted = np.concatenate([*(records for records, _ in wanted), kept.finish()])
    assert len(all_got) > 50
    assert np.array_equal(all_got, all_wanted)

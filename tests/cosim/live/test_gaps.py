# SPDX-License-Identifier: Apache-2.0
"""A tracker that does not see every part: its log is of the whole stream."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.contract import DROPPED
from evcot.rct.presets import PRESETS
from evcot.rct.tracker import RctTracker
from evcot.scenes.registry import simulate_scene
from evcot.tracking import KeptTracker
from evcot_cosim.live.gaps import GapTracker

from .stories import EveryTenth, random_events


def test_without_gaps_it_is_the_tracker() -> None:
    some = random_events(95, 1)
    records, owner = GapTracker(EveryTenth()).feed(some)
    wanted, wanted_owner = EveryTenth().feed(some)
    assert np.array_equal(records, wanted)
    assert np.array_equal(owner, wanted_owner)


def test_records_number_what_the_tracker_has_not_seen_too() -> None:
    tracker = GapTracker(EveryTenth())
    told = [tracker.feed(random_events(15, 1))[0]]  # 0, 10 -> 0, 10
    assert tracker.skip(100).tolist() == [DROPPED] * 100
    told.append(tracker.feed(random_events(10, 2))[0])  # 20 -> 120
    assert tracker.skip(0).tolist() == []
    tracker.skip(7)
    told += [tracker.feed(random_events(10, 3))[0], tracker.finish()]  # 30 -> 137; at the end -> 142
    assert np.concatenate(told)["event_index"].tolist() == [0, 10, 120, 137, 142]


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
    kept = KeptTracker(lambda run: next(keeps), software())
    keeps = iter([np.full(len(run), see) for run, see in zip(runs, seen, strict=True)])
    wanted = [kept.feed(run) for run in runs]
    got = [gap.feed(run) if see else (None, gap.skip(len(run))) for run, see in zip(runs, seen, strict=True)]
    assert np.array_equal(np.concatenate([o for _, o in got]), np.concatenate([o for _, o in wanted]))
    all_got = np.concatenate([*(records for records, _ in got if records is not None), gap.finish()])
    all_wanted = np.concatenate([*(records for records, _ in wanted), kept.finish()])
    assert len(all_got) > 50
    assert np.array_equal(all_got, all_wanted)

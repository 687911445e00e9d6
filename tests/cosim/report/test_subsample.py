# SPDX-License-Identifier: Apache-2.0
"""What a report leaves out of a long run, it leaves out evenly; births and ends stay."""

from __future__ import annotations

import numpy as np

from evcot.tracks.log import Kind
from evcot.tracks.timeline import LIFE
from evcot_cosim.report.subsample import longest_lives, thinned_events, thinned_records


def test_few_events_all_stay() -> None:
    assert thinned_events(5, 9).tolist() == [0, 1, 2, 3, 4]
    assert thinned_events(0, 9).tolist() == []


def test_of_many_events_one_in_each_stretch_stays() -> None:
    kept = thinned_events(100_000, 1_000)
    assert len(kept) == 1_000
    assert (np.diff(kept) > 0).all()
    assert (kept // 100).tolist() == list(range(1_000))
    assert len(np.unique(kept % 100)) > 50  # no comb
    assert thinned_events(100_000, 1_000).tolist() == kept.tolist()


def test_no_room_keeps_nothing() -> None:
    assert thinned_events(100, 0).tolist() == []


def test_births_and_ends_stay_whatever_the_room() -> None:
    kind = np.array([Kind.BORN, *[Kind.MOVED] * 97, Kind.MERGED, Kind.LOST], np.uint8)
    kept = thinned_records(kind, 13)
    assert kept[[0, 98, 99]].all()
    assert kept.sum() == 13
    assert thinned_records(kind, 2).sum() == 3
    assert thinned_records(kind, 100).all()


def test_the_longest_lives_stay_in_order_of_birth() -> None:
    lives = np.zeros(4, LIFE)
    lives["track_id"], lives["birth_us"], lives["end_us"] = range(4), [0, 10, 20, 30], [5, 500, 21, 300]
    assert lives[longest_lives(lives, 2)]["track_id"].tolist() == [1, 3]
    assert lives[longest_lives(lives, 4)]["track_id"].tolist() == [0, 1, 2, 3]

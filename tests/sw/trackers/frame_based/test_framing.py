# SPDX-License-Identifier: Apache-2.0
"""Frames on a time grid, packets by count or by time, independent of how the stream is split into runs."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.trackers.frame_based.framing import Framing


def ends(framing: Framing, *runs: list[int]) -> list[int]:
    """Where frames end, counted from the first event of all."""
    found, before = [], 0
    for run in runs:
        found += (before + framing.cut(np.array(run, np.int64))).tolist()
        before += len(run)
    return found


def test_frames_count_from_the_first_event_and_silent_ones_are_none() -> None:
    t_us = [1005, 1014, 1016, 1024, 1025, 1059, 1064, 1065]
    assert ends(Framing(10), t_us) == [2, 4, 5, 7]


def test_a_packet_ends_after_so_many_events() -> None:
    assert ends(Framing(100, 3), [0, 1, 2, 3, 4, 5, 6]) == [3, 6]


def test_or_before_the_event_that_comes_too_late_for_it() -> None:
    # The second packet counts its time from its own first event.
    assert ends(Framing(10, 3), [0, 9, 10, 19, 20, 21, 22]) == [2, 4, 7]


def test_events_of_one_time_are_one_frame_but_may_be_many_packets() -> None:
    assert ends(Framing(1), [7, 7, 7, 7, 8]) == [4]
    assert ends(Framing(1, 2), [7, 7, 7, 7, 8]) == [2, 4]


def test_nothing_ends_without_events() -> None:
    assert ends(Framing(10), [], [3], []) == []


@pytest.mark.parametrize("events", [None, 1, 4, 1_000])
def test_where_the_stream_is_cut_changes_nothing(events: int | None) -> None:
    random = np.random.default_rng(1)
    t_us = 10**15 + np.cumsum(random.integers(0, 9, 500) * (random.random(500) < 0.7))
    whole = ends(Framing(20, events), t_us.tolist())
    assert len(whole) > 10
    for size in (1, 3, 77):
        assert ends(Framing(20, events), *(t_us[i : i + size].tolist() for i in range(0, 500, size))) == whole

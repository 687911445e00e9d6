# SPDX-License-Identifier: Apache-2.0
"""EVT 2 and EVT 3, word by word: every event has the time that its own words give."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.formats.evt import decode_evt2, decode_evt3


def evt2_high(mark: int) -> int:
    return 8 << 28 | mark


def evt2_event(p: int, low: int, x: int, y: int) -> int:
    return p << 28 | low << 22 | x << 11 | y


def evt3_high(mark: int) -> int:
    return 8 << 12 | mark


def evt3_low(low: int) -> int:
    return 6 << 12 | low


def evt3_row(y: int) -> int:
    return y


def evt3_event(p: int, x: int) -> int:
    return 2 << 12 | p << 11 | x


def evt3_base(p: int, x: int) -> int:
    return 3 << 12 | p << 11 | x


def evt3_vector12(bits: int) -> int:
    return 4 << 12 | bits


def evt3_vector8(bits: int) -> int:
    return 5 << 12 | bits


def rows(events: object) -> list[tuple[int, ...]]:
    return list(zip(*(getattr(events, name).tolist() for name in ("t_us", "x", "y", "p")), strict=True))


def evt2(*words: int, t0_us: int = 0) -> tuple[list[tuple[int, ...]], int]:
    events, untimed = decode_evt2(np.array(words, np.uint32), t0_us)
    return rows(events), untimed


def evt3(*words: int, t0_us: int = 0) -> tuple[list[tuple[int, ...]], int]:
    events, untimed = decode_evt3(np.array(words, np.uint16), t0_us)
    return rows(events), untimed


def test_evt2_adds_an_event_s_six_bits_to_the_mark() -> None:
    events, untimed = evt2(evt2_high(3), evt2_event(1, 5, 639, 479), evt2_event(0, 63, 0, 2047), t0_us=1000)
    assert events == [(1000 + 3 * 64 + 5, 639, 479, 1), (1000 + 3 * 64 + 63, 0, 2047, 0)]
    assert untimed == 0


def test_evt2_time_goes_on_where_the_mark_wraps_around() -> None:
    last = (1 << 28) - 1
    events, _ = evt2(evt2_high(last), evt2_event(0, 63, 1, 1), evt2_high(0), evt2_event(0, 0, 1, 1))
    assert [event[0] for event in events] == [(1 << 34) - 1, 1 << 34]


def test_evt2_time_that_runs_back_is_left_for_the_recording_to_refuse() -> None:
    events, _ = evt2(evt2_high(10), evt2_event(0, 0, 1, 1), evt2_high(9), evt2_event(0, 0, 1, 1))
    assert [event[0] for event in events] == [640, 576]


def test_evt2_events_before_the_first_mark_are_counted_and_left_out() -> None:
    events, untimed = evt2(evt2_event(0, 1, 1, 1), evt2_event(1, 2, 2, 2), evt2_high(0), evt2_event(1, 3, 3, 3))
    assert events == [(3, 3, 3, 1)]
    assert untimed == 2


@pytest.mark.parametrize("kind", [10, 14, 15])
def test_evt2_words_of_other_kinds_are_passed_over(kind: int) -> None:
    events, untimed = evt2(evt2_high(1), kind << 28 | 12345, evt2_event(1, 0, 7, 8))
    assert (events, untimed) == ([(64, 7, 8, 1)], 0)


def test_evt3_single_events_share_row_and_time() -> None:
    events, untimed = evt3(evt3_high(2), evt3_low(7), evt3_row(719), evt3_event(1, 1279), evt3_event(0, 0), t0_us=50)
    assert events == [(50 + 2 * 4096 + 7, 1279, 719, 1), (50 + 2 * 4096 + 7, 0, 719, 0)]
    assert untimed == 0


def test_evt3_vectors_move_their_base_on() -> None:
    events, _ = evt3(
        evt3_high(0), evt3_low(1), evt3_row(4), evt3_base(1, 100), evt3_vector12(0x801), evt3_vector12(0), evt3_vector8(0x80)
    )
    assert events == [(1, 100, 4, 1), (1, 111, 4, 1), (1, 100 + 24 + 7, 4, 1)]


def test_evt3_a_single_event_leaves_the_vector_s_base_and_polarity_alone() -> None:
    events, _ = evt3(evt3_high(0), evt3_row(4), evt3_base(1, 100), evt3_event(0, 7), evt3_vector8(1))
    assert events == [(0, 7, 4, 0), (0, 100, 4, 1)]


def test_evt3_a_time_mark_that_runs_ahead_moves_no_event() -> None:
    """A camera's periodic mark may show a later time than the events after it: they keep their own."""
    events, _ = evt3(evt3_high(1), evt3_low(799), evt3_row(0), evt3_event(1, 1), evt3_low(811), evt3_low(800), evt3_event(1, 2))
    assert [event[0] for event in events] == [4096 + 799, 4096 + 800]


def test_evt3_a_new_upper_part_starts_from_zero_below_and_a_repeated_one_changes_nothing() -> None:
    events, _ = evt3(
        *(evt3_row(0), evt3_high(1), evt3_low(9)),
        *(evt3_high(1), evt3_event(0, 1)),
        *(evt3_high(2), evt3_event(0, 2)),
        *(evt3_low(3), evt3_event(0, 3)),
    )
    assert [event[0] for event in events] == [4096 + 9, 8192, 8192 + 3]


def test_evt3_time_goes_on_where_the_mark_wraps_around() -> None:
    words = [evt3_row(0)]
    for mark in (0, 2000, 4000, 0, 2000, 4000, 4095, 1):
        words += [evt3_high(mark), evt3_event(0, 1)]
    events, _ = evt3(*words)
    assert [event[0] >> 12 for event in events] == [0, 2000, 4000, 4096, 6096, 8096, 8191, 8193]


def test_evt3_events_before_time_row_or_base_are_counted_and_left_out() -> None:
    events, untimed = evt3(evt3_row(5), evt3_event(1, 1), evt3_high(0), evt3_vector12(0b111), evt3_event(1, 2))
    assert events == [(0, 2, 5, 1)]
    assert untimed == 4
    assert evt3(evt3_high(0), evt3_event(1, 1), evt3_row(5), evt3_event(1, 2)) == ([(0, 2, 5, 1)], 1)


@pytest.mark.parametrize("kind", [1, 7, 10, 14, 15])
def test_evt3_words_of_other_kinds_are_passed_over(kind: int) -> None:
    events, untimed = evt3(evt3_high(1), evt3_row(3), kind << 12 | 1234, evt3_event(1, 9))
    assert (events, untimed) == ([(4096, 9, 3, 1)], 0)

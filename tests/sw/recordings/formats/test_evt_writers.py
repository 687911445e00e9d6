# SPDX-License-Identifier: Apache-2.0
"""EVT words written for a few events, by hand; and the limits of times and addresses."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.formats.evt_writers import Evt2Sink, Evt3Sink
from support.refusals import refused

Row = tuple[int, int, int, int]  # t_us, x, y, p


def events_of(rows: list[Row]) -> Events:
    t_us, x, y, p = np.array(rows, np.int64).reshape(-1, 4).T
    return Events(t_us.copy(), x.astype(np.uint16), y.astype(np.uint16), p.astype(np.uint8))


def written(sink: type[Evt2Sink | Evt3Sink], *runs: list[Row]) -> tuple[str, NDArray[Any]]:
    """The header, and the words."""
    file = io.BytesIO()
    target = sink(file, (320, 240))
    for rows in runs:
        target.write(events_of(rows))
    target.close()
    header, end, words = file.getvalue().partition(b"% end\n")
    return (header + end).decode(), np.frombuffer(words, "<u4" if sink is Evt2Sink else "<u2")


def test_evt2_has_a_time_mark_every_64_us() -> None:
    header, words = written(Evt2Sink, [(70, 3, 5, 1), (127, 2047, 1, 0)], [(127, 4, 6, 1), (128, 0, 2047, 0)])
    assert header == "% evt 2.0\n% format EVT2;height=240;width=320\n% geometry 320x240\n% end\n"
    mark, on = 8 << 28, 1 << 28
    events = [on | 6 << 22 | 3 << 11 | 5, 63 << 22 | 2047 << 11 | 1, on | 63 << 22 | 4 << 11 | 6, 2047]
    assert words.tolist() == [mark | 1, *events[:3], mark | 2, events[3]]


HIGH, LOW, Y, X, BASE, TWELVE, EIGHT, ON = (8 << 12, 6 << 12, 0, 2 << 12, 3 << 12, 4 << 12, 5 << 12, 1 << 11)


def test_evt3_writes_what_has_changed() -> None:
    rows = [(5, 3, 2, 1), (5, 2, 2, 1), (5, 9, 2, 0), (5, 9, 4, 0), (6, 9, 4, 0), (4096, 9, 4, 0), (4096, 8, 4, 0)]
    marks = HIGH, LOW | 5, Y | 2
    expected = [*marks, X | ON | 3, X | ON | 2, X | 9, Y | 4, X | 9, LOW | 6, X | 9, HIGH | 1, LOW, X | 9, X | 8]
    assert written(Evt3Sink, rows)[1].tolist() == expected
    assert written(Evt3Sink, rows[:3], rows[3:])[1].tolist() == expected


def row_of(*xs: int, t_us: int = 0, y: int = 0, p: int = 1) -> list[Row]:
    return [(t_us, x, y, p) for x in xs]


@pytest.mark.parametrize(
    ("xs", "words"),
    [
        ((32, 33, 34, 35), [X | ON | x for x in (32, 33, 34, 35)]),  # a vector needs four words, too
        ((32, 33, 34, 35, 36), [BASE | ON | 32, TWELVE | 0b11111, TWELVE, EIGHT]),
        ((64, 75, 76, 87, 88, 95), [BASE | ON | 64, TWELVE | 1 << 11 | 1, TWELVE | 1 << 11 | 1, EIGHT | 1 << 7 | 1]),
        ((28, 29, 30, 31, 32), [X | ON | x for x in (28, 29, 30, 31, 32)]),  # over the end of 32 pixels
        ((0, 1, 2, 3, 3, 4), [X | ON | x for x in (0, 1, 2, 3, 3, 4)]),  # not to the right
        ((0, 2, 4, 6, 8, 7), [BASE | ON, TWELVE | 0b101010101, TWELVE, EIGHT, X | ON | 7]),
    ],
)
def test_evt3_writes_five_events_or_more_of_a_row_as_a_vector(xs: tuple[int, ...], words: list[int]) -> None:
    assert written(Evt3Sink, row_of(*xs))[1].tolist() == [HIGH, LOW, Y, *words]


@pytest.mark.parametrize("other", [{"t_us": 1}, {"y": 1}, {"p": 0}])
def test_a_vector_has_one_time_row_and_polarity(other: dict[str, int]) -> None:
    words = written(Evt3Sink, row_of(0, 1, 2, 3) + row_of(4, 5, 6, **other))[1]
    assert not any(word >> 12 in (3, 4, 5) for word in words.tolist())


@pytest.mark.parametrize(("pause", "marks"), [(2047, [1 + 2047]), (2048, [2048, 2049]), (5000, [2048, 4095, 5001])])
def test_evt3_marks_rise_by_less_than_half_their_range(pause: int, marks: list[int]) -> None:
    words = written(Evt3Sink, [(4096, 0, 0, 1), (4096 * (1 + pause), 0, 0, 1)])[1].tolist()
    first, then = [HIGH | 1, LOW, Y, X | ON], [HIGH | mark & 4095 for mark in marks]
    assert words == [*first, *then, LOW, X | ON]


@pytest.mark.parametrize(
    ("sink", "first_us", "t0_us"),
    [
        (Evt2Sink, (1 << 33) - 1, 0),
        (Evt2Sink, 1 << 33, 1 << 33),
        (Evt3Sink, (1 << 24) - 1, 0),
        (Evt3Sink, (1 << 24) + 5, 1 << 24),
        (Evt3Sink, 1 << 25, 1 << 25),
    ],
)
def test_an_offset_of_times_is_in_the_header(sink: type[Evt2Sink | Evt3Sink], first_us: int, t0_us: int) -> None:
    header, words = written(sink, [(first_us, 0, 0, 0)])
    assert (f"% t0 {t0_us}\n" in header) == (t0_us > 0)
    assert ("t0" in header) == (t0_us > 0)
    assert int(words[0]) & 4095 == (first_us - t0_us >> (6 if sink is Evt2Sink else 12)) & 4095


def test_times_and_addresses_end_where_their_words_do() -> None:
    written(Evt2Sink, [(5, 0, 0, 0), ((1 << 34) - 1, 0, 0, 0)])
    written(Evt3Sink, [(5, 0, 0, 0), (5 + 1, 2047, 2047, 0)])
    last = 1 << 34
    with refused(RecordingError, f"event 1: t = {last}: must be below {last}: EVT 2.0 lasts for 2^34 us from 0 us on"):
        written(Evt2Sink, [(5, 0, 0, 0), (last, 0, 0, 0)])
    with refused(
        RecordingError,
        f"event 1: t = {(1 << 44) + 6}: must follow the event before within 2^44 us (203 days) in EVT 3.0",
    ):
        written(Evt3Sink, [(5, 0, 0, 0)], [((1 << 44) + 6, 0, 0, 0)])
    for sink, number in ((Evt2Sink, 2), (Evt3Sink, 3)):
        for axis, place in (("x", (2048, 0)), ("y", (0, 2048))):
            with refused(RecordingError, f"event 2: {axis} = 2048: must be below 2048 in EVT {number}.0"):
                written(sink, [(0, 0, 0, 0), (0, 2047, 2047, 0)], [(0, *place, 0)])
        with refused(RecordingError, "event 0: t = -1: must not be negative"):
            written(sink, [(-1, 0, 0, 0)])
        with refused(RecordingError, f"event 0: t = {1 << 62}: must be below 2^62 at the start"):
            written(sink, [(1 << 62, 0, 0, 0)])
        written(sink, [((1 << 62) - 1, 0, 0, 0)])


def test_a_file_without_events_is_a_header() -> None:
    assert written(Evt3Sink, [])[0].endswith("% geometry 320x240\n% end\n")

# SPDX-License-Identifier: Apache-2.0
"""EVT 2.0, EVT 2.1, EVT 3.0 and DAT, word by word: every event has the time encoded in its words."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from evcot.recordings.formats.prophesee import FORMATS
from evcot.recordings.formats.source import BLOCK_EVENTS
from evcot.recordings.formats.words import WordFile

from .reference_evt import (
    FILES,
    Row,
    dat_event,
    evt2_event,
    evt2_high,
    evt3_base,
    evt3_event,
    evt3_high,
    evt3_low,
    evt3_row,
    evt3_vector8,
    evt3_vector12,
    evt21_event,
    evt21_high,
    reference,
    write,
)

Decode = Callable[..., tuple[list[Row], int]]


def opened(path: Path, piece_words: int | None = None) -> WordFile:
    source = next(each for each in FORMATS if each.matches(path.read_bytes()[:1024], path)).open(path)
    assert isinstance(source, WordFile)
    if piece_words is not None:
        source._piece_words = piece_words
    return source


def rows(source: WordFile, from_us: int | None = None) -> list[Row]:
    found: list[Row] = []
    for block in source.blocks(from_us):
        found += zip(*(getattr(block, name).tolist() for name in ("t_us", "x", "y", "p")), strict=True)
    return found


@pytest.fixture
def decoded(tmp_path: Path) -> Decode:
    """(kind, words...) -> the events, and how many were left out."""

    def decode(kind: str, *words: int, header: bytes | None = None) -> tuple[list[Row], int]:
        with closing(opened(write(tmp_path / "events", kind, words, header))) as source:
            return rows(source), sum(source.left_out.values())

    return decode


def test_evt2_adds_an_event_s_six_bits_to_the_mark(decoded: Decode) -> None:
    words = (evt2_high(3), evt2_event(1, 5, 639, 479), evt2_event(0, 63, 0, 2047))
    found, lost = decoded("evt2", *words, header=b"% evt 2.0\n% t0 1000\n% end\n")
    assert found == [(1000 + 3 * 64 + 5, 639, 479, 1), (1000 + 3 * 64 + 63, 0, 2047, 0)]
    assert lost == 0


def test_evt2_time_goes_on_where_the_mark_wraps_around(decoded: Decode) -> None:
    last = (1 << 28) - 1
    found, _ = decoded("evt2", evt2_high(last), evt2_event(0, 63, 1, 1), evt2_high(0), evt2_event(0, 0, 1, 1))
    assert [event[0] for event in found] == [(1 << 34) - 1, 1 << 34]


def test_evt2_time_that_runs_back_is_left_for_the_recording_to_refuse(decoded: Decode) -> None:
    found, _ = decoded("evt2", evt2_high(10), evt2_event(0, 0, 1, 1), evt2_high(9), evt2_event(0, 0, 1, 1))
    assert [event[0] for event in found] == [640, 576]


def test_evt2_events_before_the_first_mark_are_counted_and_left_out(decoded: Decode) -> None:
    words = (evt2_event(0, 1, 1, 1), evt2_event(1, 2, 2, 2), evt2_high(0), evt2_event(1, 3, 3, 3))
    assert decoded("evt2", *words) == ([(3, 3, 3, 1)], 2)


@pytest.mark.parametrize(("kind", "lost"), [(10, 0), (14, 0), (15, 0), (2, 1), (7, 1), (9, 1), (11, 1), (13, 1)])
def test_evt2_words_of_other_kinds_are_passed_over_and_reserved_ones_counted(decoded: Decode, kind: int, lost: int) -> None:
    assert decoded("evt2", evt2_high(1), kind << 28 | 12345, evt2_event(1, 0, 7, 8)) == ([(64, 7, 8, 1)], lost)
    words = (evt21_high(1), kind << 60 | 12345 << 20, evt21_event(1, 0, 7, 8, 1))
    assert decoded("evt21", *words) == ([(64, 7, 8, 1)], lost)


@pytest.mark.parametrize("kind", ["evt21", "evt21-legacy"])
def test_evt21_gives_one_event_per_set_bit_from_left_to_right(decoded: Decode, kind: str) -> None:
    words = (evt21_high(3), evt21_event(1, 5, 64, 9, 1 << 31 | 0b101), evt21_event(0, 6, 0, 2047, 0))
    assert decoded(kind, *words) == ([(197, 64, 9, 1), (197, 66, 9, 1), (197, 95, 9, 1)], 0)


@pytest.mark.parametrize("kind", ["evt21", "evt21-legacy"])
def test_evt21_order_is_what_the_time_marks_show_where_the_header_leaves_it_out(decoded: Decode, kind: str) -> None:
    words = (evt21_high(3), evt21_event(1, 5, 64, 9, 0x80000001), evt21_event(0, 5, 0, 8, 0x80000000), evt21_high(4))
    expected = [(197, 64, 9, 1), (197, 95, 9, 1), (197, 31, 8, 0)]
    assert decoded(kind, *words, header=b"% evt 2.1\n% end\n") == (expected, 0)


def test_evt21_events_before_the_first_mark_are_counted_one_by_one(decoded: Decode) -> None:
    assert decoded("evt21", evt21_event(0, 1, 0, 1, 0b1101), evt21_high(0), evt21_event(1, 3, 3, 3, 1)) == ([(3, 3, 3, 1)], 3)


def test_evt3_single_events_share_row_and_time(decoded: Decode) -> None:
    words = (evt3_high(2), evt3_low(7), evt3_row(719), evt3_event(1, 1279), evt3_event(0, 0))
    found, lost = decoded("evt3", *words, header=b"% evt 3.0\n% t0 50\n% end\n")
    assert (found, lost) == ([(50 + 2 * 4096 + 7, 1279, 719, 1), (50 + 2 * 4096 + 7, 0, 719, 0)], 0)


def test_evt3_vectors_move_their_base_on(decoded: Decode) -> None:
    words = (evt3_high(0), evt3_low(1), evt3_row(4), evt3_base(1, 100))
    vectors = (evt3_vector12(0x801), evt3_vector12(0), evt3_vector8(0x80))
    found, _ = decoded("evt3", *words, *vectors)
    assert found == [(1, 100, 4, 1), (1, 111, 4, 1), (1, 100 + 24 + 7, 4, 1)]


def test_evt3_a_vector_of_eight_has_no_ninth_event(decoded: Decode) -> None:
    found, _ = decoded("evt3", evt3_high(0), evt3_row(4), evt3_base(1, 100), evt3_vector8(0xF01))
    assert found == [(0, 100, 4, 1)]


def test_evt3_a_base_that_vectors_move_on_for_ever_never_comes_back_inside(decoded: Decode) -> None:
    found, _ = decoded("evt3", evt3_high(0), evt3_row(4), evt3_base(1, 2040), *[evt3_vector12(1)] * 20_000)
    assert [event[1] for event in found[:3]] == [2040, 2052, 2064]
    assert min(event[1] for event in found[1:]) > 2047


def test_evt3_a_single_event_leaves_the_vector_s_base_and_polarity_alone(decoded: Decode) -> None:
    found, _ = decoded("evt3", evt3_high(0), evt3_row(4), evt3_base(1, 100), evt3_event(0, 7), evt3_vector8(1))
    assert found == [(0, 7, 4, 0), (0, 100, 4, 1)]


def test_evt3_a_time_mark_that_runs_ahead_moves_no_event(decoded: Decode) -> None:
    """A camera's periodic mark may show a later time than the events after it: they keep their own."""
    words = (evt3_high(1), evt3_low(799), evt3_row(0), evt3_event(1, 1), evt3_low(811), evt3_low(800), evt3_event(1, 2))
    found, _ = decoded("evt3", *words)
    assert [event[0] for event in found] == [4096 + 799, 4096 + 800]


def test_evt3_a_new_upper_part_starts_from_zero_below_and_a_repeated_one_changes_nothing(decoded: Decode) -> None:
    found, _ = decoded(
        "evt3",
        *(evt3_row(0), evt3_high(1), evt3_low(9)),
        *(evt3_high(1), evt3_event(0, 1)),
        *(evt3_high(2), evt3_event(0, 2)),
        *(evt3_low(3), evt3_event(0, 3)),
    )
    assert [event[0] for event in found] == [4096 + 9, 8192, 8192 + 3]


def test_evt3_time_goes_on_where_the_mark_wraps_around(decoded: Decode) -> None:
    words = [evt3_row(0)]
    for mark in (0, 2000, 4000, 0, 2000, 4000, 4095, 1):
        words += [evt3_high(mark), evt3_event(0, 1)]
    found, _ = decoded("evt3", *words)
    assert [event[0] >> 12 for event in found] == [0, 2000, 4000, 4096, 6096, 8096, 8191, 8193]


def test_evt3_events_before_time_row_or_base_are_counted_and_left_out(decoded: Decode) -> None:
    words = (evt3_row(5), evt3_event(1, 1), evt3_high(0), evt3_vector12(0b111), evt3_event(1, 2))
    assert decoded("evt3", *words) == ([(0, 2, 5, 1)], 4)
    assert decoded("evt3", evt3_high(0), evt3_event(1, 1), evt3_row(5), evt3_event(1, 2)) == ([(0, 2, 5, 1)], 1)


@pytest.mark.parametrize(("kind", "lost"), [(7, 0), (10, 0), (14, 0), (15, 0), (9, 1), (11, 1), (12, 1), (13, 1)])
def test_evt3_words_of_other_kinds_are_passed_over_and_reserved_ones_counted(decoded: Decode, kind: int, lost: int) -> None:
    assert decoded("evt3", evt3_high(1), evt3_row(3), kind << 12 | 1234, evt3_event(1, 9)) == ([(4096, 9, 3, 1)], lost)


def test_evt3_a_row_of_other_events_is_no_row_for_these(decoded: Decode) -> None:
    words = (evt3_high(1), evt3_row(3), 1 << 12 | 4, evt3_event(1, 9), evt3_row(5), evt3_event(0, 8))
    assert decoded("evt3", *words) == ([(4096, 8, 5, 0)], 2)


def test_dat_has_a_time_in_every_word_and_goes_on_where_it_wraps_around(decoded: Decode) -> None:
    words = [dat_event((1 << 32) - 1, 16383, 16383, 1), dat_event(3, 0, 1, 0)]
    assert decoded("dat2", *words) == ([((1 << 32) - 1, 16383, 16383, 1), ((1 << 32) + 3, 0, 1, 0)], 0)
    words = [dat_event(8, 511, 255, 1, version=1), dat_event(7, 0, 1, 0, version=1)]
    assert decoded("dat1", *words) == ([(8, 511, 255, 1), (7, 0, 1, 0)], 0)


def random_words(kind: str, count: int, seed: int) -> list[int]:
    """Words of every kind in any order, time marks that rise, repeat, fall and wrap among them."""
    random = np.random.default_rng(seed)
    mark = int(random.integers(1 << 28))
    words = []
    for raw in random.integers(0, 1 << 63, count, dtype=np.uint64).tolist():
        share = random.random()
        mark += int(random.choice([0, 1, 2, 700, 1 << 20, -1 if share < 0.5 else 1]))
        if kind.startswith("dat"):
            words.append(raw >> 32 << 32 | mark * 997 % (1 << 32))
        elif kind == "evt3":
            word = raw % (1 << 16)
            words.append(evt3_high(mark % 4096) if share < 0.1 else word % (1 << 15) if share < 0.9 else word)
        elif kind == "evt2":
            word = raw % (1 << 32)
            words.append(evt2_high(mark % (1 << 28)) if share < 0.1 else word % (1 << 29) if share < 0.9 else word)
        else:
            sparse = raw & int(random.integers(1 << 62)) & int(random.integers(1 << 62))
            dense = sparse if random.random() < 0.9 else raw
            other = dense | int(random.integers(16)) << 60 if share > 0.9 else dense % (1 << 61)
            words.append(evt21_high(mark % (1 << 28)) if share < 0.1 else other)
    return words


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize("seed", range(4))
def test_random_words_mean_what_the_tables_say_wherever_the_pieces_are_cut(tmp_path: Path, kind: str, seed: int) -> None:
    words = random_words(kind, 3000, seed)
    expected = reference(kind, words)
    assert len(expected.rows) > 1000
    path = write(tmp_path / "events", kind, words)
    for piece_words in (1, 2, 7, 1000, 1 << 18):
        with closing(opened(path, piece_words)) as source:
            assert rows(source) == expected.rows
            assert sum(source.left_out.values()) == expected.untimed + expected.strange


@pytest.mark.parametrize("kind", [kind for kind in FILES if kind.startswith("evt")])
@pytest.mark.parametrize("seed", range(4))
def test_from_any_time_on_random_words_mean_the_same(tmp_path: Path, kind: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    mark_bits = 12 if kind == "evt3" else 28
    words, mark = [], 0
    for word in random_words(kind, 2000, seed):
        if word >> {"evt2": 28, "evt3": 12}.get(kind, 60) == 8:
            mark += int(random.choice([0, 1, 5, 900]))
            word = {"evt2": evt2_high, "evt3": evt3_high}.get(kind, evt21_high)(mark % (1 << mark_bits))
        words.append(word)
    low_bits = 12 if kind == "evt3" else 6
    with closing(opened(write(tmp_path / "events", kind, words), 100)) as source:
        full = rows(source)
        assert full == reference(kind, words).rows
        for from_us in [*random.integers(0, mark << low_bits, 40).tolist(), 0, mark << low_bits]:
            part = rows(source, from_us)
            rest = full[: len(full) - len(part)]
            assert rest + part == full
            assert all(event[0] < from_us for event in rest)
            assert len(part) < len(full) or from_us < full[0][0] + (1 << low_bits)


@pytest.mark.parametrize(
    ("kind", "start", "word", "most"),
    [
        ("evt21", [evt21_high(0)], evt21_event(0, 0, 0, 0, 0xFFFFFFFF), 32),
        ("evt3", [evt3_high(0), evt3_row(1), evt3_base(1, 7)], evt3_vector12(0xFFF), 12),
    ],
)
def test_a_block_is_given_whenever_one_is_full(tmp_path: Path, kind: str, start: list[int], word: int, most: int) -> None:
    with closing(opened(write(tmp_path / "events", kind, start + [word] * 60_000))) as source:
        counts = [len(block) for block in source.blocks()]
    assert sum(counts) == most * 60_000
    assert max(counts) <= BLOCK_EVENTS + most
    assert len(counts) == -(-sum(counts) // BLOCK_EVENTS)

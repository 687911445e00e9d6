# SPDX-License-Identifier: Apache-2.0
"""evt2_decoder.v, evt21_decoder.v, evt3_decoder.v: stories, real recordings, random and damaged words, clocks.

The software decoders of the same formats are the reference.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.events import Events
from evcot.recordings.files import read_recording, write_events
from evcot.recordings.formats.evt2 import evt2_layout, evt21_layout
from evcot.recordings.formats.evt3 import evt3_layout
from evcot.recordings.formats.words import Layout, WordArray
from shared import SHARED
from support.evt import (
    STREAMS,
    axis_beats,
    compare_with_software,
    corrupted,
    decode_in_hardware,
    event_rows,
    evt2_words,
    evt_device,
    payload,
    random_events,
)
from support.stream_device import StreamDevice, random_stalls

Sized = tuple[int, int, int, int, int, int]  # DATA_W, T_W, X_W, Y_W, WIDTH, HEIGHT
NAMES = ("DATA_W", "T_W", "X_W", "Y_W", "WIDTH", "HEIGHT")


@dataclass(frozen=True)
class Format:
    """A format, its decoder in RTL and its decoder in software."""

    top: str
    layout: Layout
    word: type[np.unsignedinteger[Any]]
    encode: Callable[[Events, Path], WordArray]
    gap_us: int  # of random events; beyond it the format cannot tell the time
    orders: tuple[dict[str, int], ...]  # in which a source may send a word
    shapes: tuple[Sized, Sized, Sized]  # the last one for the stories
    refused: tuple[tuple[dict[str, int], str], ...]
    fixture: Path | None

    def device(self, shape: Sized) -> StreamDevice:
        given = dict(zip(NAMES, shape, strict=True))
        return evt_device(self.top, given.pop("WIDTH"), given.pop("HEIGHT"), **given)

    def sent(self, words: WordArray, order: dict[str, int]) -> WordArray:
        """The words with their bytes as a source sends them that sets these inputs right."""
        if order.get("swap_halves"):
            words = words.view(np.uint32).reshape(-1, 2)[:, ::-1]
        if order.get("swap_bytes"):
            words = (words.view(np.uint32) if self.word is np.uint64 else words).byteswap()
        return np.ascontiguousarray(words).view(self.word).ravel()


def written_as_evt3(events: Events, folder: Path) -> WordArray:
    """Events from time 0 on as evcot writes them."""
    write_events(folder / "events.raw", (2048, 2048), [events], "evt3", force=True)
    return payload(folder / "events.raw", np.uint16)


BYTES = ({"swap_bytes": 0}, {"swap_bytes": 1})
HALVES = tuple({"swap_bytes": order & 1, "swap_halves": order >> 1} for order in range(4))
WIDTH_64 = ({"T_W": 65}, "T_W_must_be_35_to_64")
EVT2 = Format(
    "evt2_decoder", evt2_layout(0), np.uint32, lambda events, _: evt2_words(events, vectors=False), 1 << 32, BYTES,
    ((64, 35, 10, 9, 640, 480), (16, 64, 11, 11, 2048, 2048), (32, 48, 5, 4, 20, 10)),
    (
        WIDTH_64,
        ({"T_W": 34}, "HIGH_W_must_exceed_MARK_W"),
        ({"DATA_W": 128}, "DATA_W_must_be_16_32_or_64"),
        ({"X_W": 12}, "X_W_must_be_1_to_11"),
        ({"X_W": 10, "WIDTH": 1025}, "WIDTH_must_be_1_to_2_to_the_X_W"),
        ({"HEIGHT": 0}, "HEIGHT_must_be_1_to_2_to_the_Y_W"),
        ({"COUNT_W": 7}, "COUNT_W_must_be_8_to_64"),
    ),
    SHARED / "fixture_evt2_640x480.raw",
)  # fmt: skip
EVT21 = Format(
    "evt21_decoder", evt21_layout(0, upper_first=False), np.uint64, lambda events, _: evt2_words(events, vectors=True), 1 << 32,
    HALVES, ((32, 35, 9, 8, 304, 240), (64, 64, 11, 11, 2048, 2048), (32, 48, 5, 4, 20, 10)),
    (WIDTH_64, ({"DATA_W": 16}, "DATA_W_must_be_at_least_half_of_WORD_W")), None,
)  # fmt: skip
EVT3 = Format(
    "evt3_decoder", evt3_layout(0), np.uint16, written_as_evt3, 1 << 24, BYTES,
    ((64, 25, 11, 10, 1280, 720), (16, 64, 11, 11, 2048, 2048), (64, 48, 6, 4, 50, 10)),
    (
        ({"T_W": 65}, "T_W_must_be_25_to_64"),
        ({"T_W": 24}, "HIGH_W_must_exceed_MARK_W"),
        ({"DATA_W": 8}, "DATA_W_must_be_16_32_or_64"),
    ),
    SHARED / "fixture_evt3_1280x720.raw",
)  # fmt: skip
FORMATS = (EVT2, EVT21, EVT3)
EACH = [pytest.param(one, shape, id=f"{one.top}, {shape[0]}") for one in FORMATS for shape in one.shapes]


class TestEvt2:
    @staticmethod
    def mark(value: int) -> int:
        return 8 << 28 | value

    @staticmethod
    def event(t_low: int, x: int, y: int, p: int) -> int:
        return p << 28 | t_low << 22 | x << 11 | y

    @pytest.fixture(scope="class")
    @classmethod
    def small(cls) -> StreamDevice:
        return EVT2.device(EVT2.shapes[2])

    @staticmethod
    def decoded(device: StreamDevice, words: list[int]) -> tuple[list[list[int]], dict[str, int]]:
        return decode_in_hardware(device, np.array(words, np.uint32))

    def test_an_event_has_the_time_of_the_last_mark_and_its_own(self, small: StreamDevice) -> None:
        mark, event = self.mark, self.event
        words = [mark(2), event(5, 3, 4, 1), event(6, 19, 9, 0), mark(3), event(0, 0, 0, 1)]
        assert self.decoded(small, words) == ([[133, 3, 4, 1], [134, 19, 9, 0], [192, 0, 0, 1]], {"n_events": 3})

    def test_events_before_the_first_mark_are_left_out(self, small: StreamDevice) -> None:
        one = self.event(1, 1, 1, 1)
        assert self.decoded(small, [one] * 3 + [self.mark(0), one]) == ([[1, 1, 1, 1]], {"n_events": 1, "n_untimed": 3})

    def test_events_beyond_the_sensor_are_left_out(self, small: StreamDevice) -> None:
        places = [(20, 3, 0), (3, 10, 0), (2047, 2047, 0), (19, 9, 1)]
        words = [self.mark(0), *(self.event(0, *place) for place in places)]
        assert self.decoded(small, words) == ([[0, 19, 9, 1]], {"n_events": 1, "n_outside": 3})

    def test_reserved_words_are_counted_and_triggers_and_vendors_words_are_not(self, small: StreamDevice) -> None:
        words = [self.mark(1), *(kind << 28 for kind in range(2, 16) if kind != 8), self.event(0, 1, 1, 1)]
        assert self.decoded(small, words) == ([[64, 1, 1, 1]], {"n_events": 1, "n_reserved": 10})

    def test_a_mark_that_falls_by_more_than_half_of_its_range_begins_a_turn(self, small: StreamDevice) -> None:
        top, half, mark, one = (1 << 28) - 1, 1 << 27, self.mark, self.event(0, 1, 1, 1)
        words = [mark(top), one, mark(top - half), one, mark(top), mark(top - half - 1), one]
        times = [row[0] for row in self.decoded(small, words)[0]]
        assert times == [top << 6, top - half << 6, (1 << 28) + top - half - 1 << 6]

    def test_reset_forgets_the_time(self, small: StreamDevice) -> None:
        self.decoded(small, [self.mark(5), self.event(0, 1, 1, 1)])
        assert self.decoded(small, [self.event(0, 1, 1, 1)]) == ([], {"n_untimed": 1})

    def test_a_word_that_keep_cuts_is_skipped(self, small: StreamDevice) -> None:
        small.reset()
        words = [self.mark(1), *(self.event(0, x, 1, 1) for x in (1, 2, 3))]
        beats = [[word, keep, keep == 15 and word == words[3]] for word, keep in zip(words, (15, 7, 0, 15), strict=True)]
        assert small.run({"s_axis_t": beats}).words["m_"].tolist() == [[64, 3, 1, 1]]
        assert (small.sim.io.n_cut, small.sim.io.n_events) == (1, 1)

    def test_an_event_comes_6_clocks_after_its_word_which_is_taken_every_clock(self, small: StreamDevice) -> None:
        words = evt2_words(random_events(np.random.default_rng(1), 10_000, 20, 10, 1000), vectors=False)
        small.reset()
        run = small.run({"s_axis_t": axis_beats(words, 32)})
        assert set(np.diff(run.accepted["s_axis_t"])) == {1}
        assert set(run.given["m_"] - run.accepted["s_axis_t"][words >> 28 <= 1]) == {6}


class TestEvt21:
    @staticmethod
    def mark(value: int) -> int:
        return (8 << 28 | value) << 32

    @staticmethod
    def vector(t_low: int, x: int, y: int, p: int, mask: int) -> int:
        return (p << 28 | t_low << 22 | x << 11 | y) << 32 | mask

    @pytest.fixture(scope="class")
    @classmethod
    def small(cls) -> StreamDevice:
        return EVT21.device(EVT21.shapes[2])

    @staticmethod
    def decoded(device: StreamDevice, words: list[int]) -> tuple[list[list[int]], dict[str, int]]:
        return decode_in_hardware(device, np.array(words, np.uint64))

    def test_a_set_bit_is_an_event_the_lowest_to_the_left(self, small: StreamDevice) -> None:
        mark, vector = self.mark, self.vector
        words = [
            mark(2), vector(5, 3, 4, 1, 0b1011), vector(6, 0, 9, 0, 1), vector(6, 0, 9, 0, 0), mark(3), vector(0, 19, 0, 1, 1),
        ]  # fmt: skip
        events = [[133, 3, 4, 1], [133, 4, 4, 1], [133, 6, 4, 1], [134, 0, 9, 0], [192, 19, 0, 1]]
        assert self.decoded(small, words) == (events, {"n_events": 5})

    def test_every_bit_counts_that_is_before_a_mark_or_beyond_the_sensor(self, small: StreamDevice) -> None:
        places = [(18, 1, 1, 0xF000_000F), (1, 10, 1, 0b11), (2047, 1, 1, 1)]
        words = [self.vector(0, 1, 1, 1, 7), self.mark(0), *(self.vector(0, *place) for place in places)]
        events = [[0, 18, 1, 1], [0, 19, 1, 1]]
        assert self.decoded(small, words) == (events, {"n_events": 2, "n_untimed": 3, "n_outside": 9})

    def test_words_of_reserved_types_are_counted_once(self, small: StreamDevice) -> None:
        reserved = [(kind << 28) << 32 | 0xFFFF_FFFF for kind in range(2, 16) if kind != 8]
        words = [self.mark(1), *reserved, self.vector(0, 1, 1, 1, 1)]
        assert self.decoded(small, words) == ([[64, 1, 1, 1]], {"n_events": 1, "n_reserved": 10})

    def test_packets_that_end_within_a_word(self, small: StreamDevice) -> None:
        head, tail = self.mark(1) >> 32, self.vector(0, 1, 1, 1, 1) >> 32
        beats = [[0, 15, 0], [head, 15, 1], [9, 15, 1], [1, 15, 0], [tail, 15, 1], [2, 15, 0], [tail, 7, 1], [4, 15, 0],
                 [tail, 15, 1]]  # fmt: skip
        small.reset()
        assert small.run({"s_axis_t": beats}).words["m_"].tolist() == [[64, 1, 1, 1], [64, 3, 1, 1]]
        assert small.sim.io.n_cut == 2

    def test_an_event_every_clock_6_clocks_after_its_word(self) -> None:
        masks = np.random.default_rng(1).integers(1, 1 << 32, 2_000, np.uint64)
        words = np.concatenate([np.array([self.mark(1)], np.uint64), np.uint64(self.vector(0, 100, 100, 1, 0)) | masks])
        run = EVT21.device(EVT21.shapes[1]).run({"s_axis_t": axis_beats(words, 64)})
        assert run.given["m_"][0] - run.accepted["s_axis_t"][1] == 6
        assert set(np.diff(run.given["m_"])) == {1}

    def test_marks_and_vectors_without_events_take_one_clock(self) -> None:
        words = np.array([self.mark(1), self.vector(0, 1, 1, 1, 0), 10 << 60] * 100, np.uint64)
        run = EVT21.device(EVT21.shapes[1]).run({"s_axis_t": axis_beats(words, 64)})
        assert set(np.diff(run.accepted["s_axis_t"])) == {1}


def row(y: int) -> int:
    return y


def event(x: int, p: int) -> int:
    return 2 << 12 | p << 11 | x


def base(x: int, p: int) -> int:
    return 3 << 12 | p << 11 | x


def vector_12(mask: int) -> int:
    return 4 << 12 | mask


def vector_8(mask: int) -> int:
    return 5 << 12 | mask


def low(value: int) -> int:
    return 6 << 12 | value


def high(value: int) -> int:
    return 8 << 12 | value


class TestEvt3:
    @pytest.fixture(scope="class")
    @classmethod
    def small(cls) -> StreamDevice:
        return EVT3.device(EVT3.shapes[2])

    @staticmethod
    def decoded(device: StreamDevice, words: list[int]) -> tuple[list[list[int]], dict[str, int]]:
        return decode_in_hardware(device, np.array(words, np.uint16))

    def test_words_change_one_part_of_the_next_event_each(self, small: StreamDevice) -> None:
        words = [high(1), low(2), row(3), event(4, 1), event(5, 0), row(9), event(5, 1), low(7), event(49, 0)]
        events = [[4098, 4, 3, 1], [4098, 5, 3, 0], [4098, 5, 9, 1], [4103, 49, 9, 0]]
        assert self.decoded(small, words) == (events, {"n_events": 4})

    def test_vectors_move_the_base_on(self, small: StreamDevice) -> None:
        vectors = [vector_12(0b1000_0000_0001), vector_8(0x81), vector_12(1), event(1, 0), vector_8(2)]
        columns = [(8, 1), (19, 1), (20, 1), (27, 1), (28, 1), (1, 0), (41, 1)]
        words = [high(0), row(3), base(8, 1), *vectors]
        assert self.decoded(small, words) == ([[0, x, 3, p] for x, p in columns], {"n_events": 7})

    def test_only_the_8_bits_of_a_vector_of_8_are_pixels(self, small: StreamDevice) -> None:
        assert self.decoded(small, [high(0), row(3), base(0, 1), vector_8(0xF01)])[0] == [[0, 0, 3, 1]]

    def test_a_new_mark_starts_from_zero_below_and_one_repeated_does_not(self, small: StreamDevice) -> None:
        words = [row(1), low(5), high(1), event(1, 0), low(6), high(1), event(2, 0), high(2), event(3, 0)]
        assert [event[0] for event in self.decoded(small, words)[0]] == [4096, 4102, 8192]

    def test_a_mark_that_falls_by_more_than_half_of_its_range_begins_a_turn(self, small: StreamDevice) -> None:
        words = [row(1), high(4095), event(1, 0), high(2047), event(1, 0), high(4095), high(2046), low(1), event(1, 0)]
        assert [event[0] for event in self.decoded(small, words)[0]] == [4095 << 12, 2047 << 12, (4096 + 2046) << 12 | 1]

    @pytest.mark.parametrize("missing", [high(0), row(1), base(1, 1)])
    def test_events_wait_for_time_row_and_base(self, small: StreamDevice, missing: int) -> None:
        parts = [part for part in (high(0), row(1), base(1, 1)) if part != missing]
        events = [vector_12(0b11)] if missing == base(1, 1) else [vector_8(0b10), event(3, 0)]
        assert self.decoded(small, parts + events) == ([], {"n_untimed": 2})

    def test_after_a_row_of_another_kind_there_is_no_row(self, small: StreamDevice) -> None:
        words = [high(0), row(1), base(1, 1), 1 << 12 | 2, event(1, 1), vector_8(1), row(2), event(1, 1)]
        assert self.decoded(small, words) == ([[0, 1, 2, 1]], {"n_events": 1, "n_untimed": 2, "n_reserved": 1})

    def test_vectors_beyond_the_sensor_never_come_back(self, small: StreamDevice) -> None:
        words = [high(0), row(1), base(40, 1), *[vector_12(0xFFF)] * 1000]
        assert self.decoded(small, words)[1] == {"n_events": 10, "n_outside": 11_990}

    def test_reserved_words_are_counted_and_triggers_and_vendors_words_are_not(self, small: StreamDevice) -> None:
        words = [high(0), row(1), *(kind << 12 for kind in (7, 9, 10, 11, 12, 13, 14, 15)), event(1, 1)]
        assert self.decoded(small, words) == ([[0, 1, 1, 1]], {"n_events": 1, "n_reserved": 4})

    def test_reset_forgets_all_parts(self, small: StreamDevice) -> None:
        self.decoded(small, [high(3), low(9), row(1), base(1, 1)])
        assert self.decoded(small, [event(1, 1)])[1] == {"n_untimed": 1}
        assert self.decoded(small, [high(0), event(1, 1), row(1), vector_8(1)])[1] == {"n_untimed": 2}

    def test_an_event_comes_6_clocks_after_its_word_which_is_taken_every_clock(self) -> None:
        words = np.array([high(0), *[row(1), low(2), event(3, 1), event(4, 0)] * 500], np.uint16)
        run = EVT3.device(EVT3.shapes[1]).run({"s_axis_t": axis_beats(words, 16)})
        assert set(np.diff(run.accepted["s_axis_t"])) == {1}
        assert set(run.given["m_"] - run.accepted["s_axis_t"][words >> 12 == 2]) == {6}

    def test_a_vector_takes_as_many_clocks_as_it_has_events(self) -> None:
        words = np.array([high(0), row(1), base(0, 1), *[vector_12(0xFFF)] * 50], np.uint16)
        run = EVT3.device(EVT3.shapes[0]).run({"s_axis_t": axis_beats(words, 64)})
        assert set(np.diff(run.given["m_"])) == {1}


@pytest.mark.parametrize("one", [EVT2, EVT3], ids=lambda one: one.top)
def test_a_real_recording_is_decoded_event_for_event(one: Format) -> None:
    if not one.fixture or not one.fixture.exists():
        pytest.skip(f"{one.fixture} is not there")
    words = payload(one.fixture, one.word)
    data_w, t_w, *_ = shape = one.shapes[0]
    device = one.device(shape)
    decoded, clocks = compare_with_software(device, one.layout, words)
    assert np.array_equal(decoded.events, event_rows(read_recording(one.fixture).events, t_w))
    print(f"{len(decoded.events)} events of {len(words)} words in {clocks} clocks: {len(decoded.events) / clocks:.3f} a clock")
    assert one is EVT3 or clocks <= len(words) + 8
    rng = np.random.default_rng(data_w)
    device.stalls = random_stalls(rng, STREAMS)
    device.set(swap_bytes=1)
    compare_with_software(device, one.layout, words, axis_beats(words.byteswap(), data_w, rng))


@pytest.mark.parametrize(("one", "shape"), EACH)
def test_random_events_come_out_as_they_were_encoded(one: Format, shape: Sized, tmp_path: Path) -> None:
    """About 400,000 events a shape, times that turn, any order of bytes and halves, any stalls; nothing is left out."""
    data_w, t_w, *_, width, height = shape
    device = one.device(shape)
    for run, order in enumerate(one.orders):
        rng = np.random.default_rng([31, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        device.set(**order)
        events = random_events(rng, 400_000 // len(one.orders), width, height, one.gap_us)
        words = one.encode(events, tmp_path)
        decoded, clocks = compare_with_software(device, one.layout, words, axis_beats(one.sent(words, order), data_w, rng))
        assert np.array_equal(decoded.events, event_rows(events, t_w))
        assert events.t_us[-1] > 4 * one.gap_us
        print(f"{one.top}: {len(events)} events of {len(words)} words in {clocks} clocks")


@pytest.mark.parametrize(("one", "shape"), EACH)
def test_damaged_words_are_decoded_as_the_software_does(one: Format, shape: Sized, tmp_path: Path) -> None:
    """Over 100,000 words a shape: few damaged, many, all noise."""
    data_w, *_, width, height = shape
    device = one.device(shape)
    for run, chance in enumerate((0.001, 0.1, 1)):
        rng = np.random.default_rng([32, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        words = corrupted(one.encode(random_events(rng, 100_000, width, height, one.gap_us), tmp_path), rng, min(chance, 0.1))
        if chance == 1:
            words = rng.integers(0, np.iinfo(one.word).max, 20_000 if one is EVT21 else 100_000, one.word, endpoint=True)
        decoded, _ = compare_with_software(device, one.layout, words, axis_beats(words, data_w, rng))
        assert decoded.counters["n_reserved"] > 0
        assert decoded.counters["n_outside"] > 0 or width == 2048

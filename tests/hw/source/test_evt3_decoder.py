# SPDX-License-Identifier: Apache-2.0
"""evt3_decoder.v: stories, a real recording, random and damaged words against the software decoder, clocks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events
from evcot.recordings.files import read_recording, write_events
from evcot.recordings.formats.evt3 import evt3_layout
from evcot.recordings.formats.words import WordArray
from shared import SHARED
from support.evt import (
    STREAMS,
    axis_beats,
    compare_with_software,
    corrupted,
    decode_in_hardware,
    event_rows,
    evt_device,
    payload,
    random_events,
)
from support.stream_device import StreamDevice, random_stalls
from support.testing import lint

TOP = "evt3_decoder"
LAYOUT = evt3_layout(0)
FIXTURE = SHARED / "fixture_evt3_1280x720.raw"

# data_w, t_w, x_w, y_w, width, height
SHAPES = [
    (64, 25, 11, 10, 1280, 720),
    (16, 64, 11, 11, 2048, 2048),
    (64, 48, 6, 4, 50, 10),
]


def device_of(data_w: int, t_w: int, x_w: int, y_w: int, width: int, height: int) -> StreamDevice:
    return evt_device(TOP, width, height, DATA_W=data_w, T_W=t_w, X_W=x_w, Y_W=y_w)


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


def decode_words(device: StreamDevice, words: list[int]) -> tuple[list[list[int]], dict[str, int]]:
    return decode_in_hardware(device, np.array(words, np.uint16))


def encoded(events: Events, folder: Path) -> WordArray:
    """Events from time 0 on as evcot writes them."""
    write_events(folder / "events.raw", (2048, 2048), [events], "evt3", force=True)
    return payload(folder / "events.raw", np.uint16)


@pytest.fixture(scope="module")
def small() -> StreamDevice:
    return device_of(*SHAPES[2])


@pytest.mark.parametrize("shape", [*SHAPES, (32, 48, 1, 1, 1, 2)])
def test_lints_clean(shape: tuple[int, ...]) -> None:
    parameters = dict(zip(("DATA_W", "T_W", "X_W", "Y_W", "WIDTH", "HEIGHT"), shape, strict=True))
    assert lint(TOP, **parameters) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"T_W": 65}, "T_W_must_be_25_to_64"),
        ({"T_W": 24}, "HIGH_W_must_exceed_MARK_W"),
        ({"DATA_W": 8}, "DATA_W_must_be_16_32_or_64"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


class TestStories:
    def test_words_change_one_part_of_the_next_event_each(self, small: StreamDevice) -> None:
        words = [high(1), low(2), row(3), event(4, 1), event(5, 0), row(9), event(5, 1), low(7), event(49, 0)]
        events = [[4098, 4, 3, 1], [4098, 5, 3, 0], [4098, 5, 9, 1], [4103, 49, 9, 0]]
        assert decode_words(small, words) == (events, {"n_events": 4})

    def test_vectors_move_the_base_on(self, small: StreamDevice) -> None:
        words = [
            high(0),
            row(3),
            base(8, 1),
            vector_12(0b1000_0000_0001),
            vector_8(0x81),
            vector_12(1),
            event(1, 0),
            vector_8(2),
        ]
        columns = [(8, 1), (19, 1), (20, 1), (27, 1), (28, 1), (1, 0), (41, 1)]
        assert decode_words(small, words) == ([[0, x, 3, p] for x, p in columns], {"n_events": 7})

    def test_only_the_8_bits_of_a_vector_of_8_are_pixels(self, small: StreamDevice) -> None:
        assert decode_words(small, [high(0), row(3), base(0, 1), vector_8(0xF01)])[0] == [[0, 0, 3, 1]]

    def test_a_new_mark_starts_from_zero_below_and_one_repeated_does_not(self, small: StreamDevice) -> None:
        words = [row(1), low(5), high(1), event(1, 0), low(6), high(1), event(2, 0), high(2), event(3, 0)]
        assert [event[0] for event in decode_words(small, words)[0]] == [4096, 4102, 8192]

    def test_a_mark_that_falls_by_more_than_half_of_its_range_begins_a_turn(self, small: StreamDevice) -> None:
        words = [row(1), high(4095), event(1, 0), high(2047), event(1, 0), high(4095), high(2046), low(1), event(1, 0)]
        assert [event[0] for event in decode_words(small, words)[0]] == [4095 << 12, 2047 << 12, (4096 + 2046) << 12 | 1]

    @pytest.mark.parametrize("missing", [high(0), row(1), base(1, 1)])
    def test_events_wait_for_time_row_and_base(self, small: StreamDevice, missing: int) -> None:
        parts = [high(0), row(1), base(1, 1)]
        events = [vector_12(0b11)] if missing == base(1, 1) else [vector_8(0b10), event(3, 0)]
        words = [part for part in parts if part != missing] + events
        assert decode_words(small, words) == ([], {"n_untimed": 2})

    def test_after_a_row_of_another_kind_there_is_no_row(self, small: StreamDevice) -> None:
        words = [high(0), row(1), base(1, 1), 1 << 12 | 2, event(1, 1), vector_8(1), row(2), event(1, 1)]
        assert decode_words(small, words) == ([[0, 1, 2, 1]], {"n_events": 1, "n_untimed": 2, "n_reserved": 1})

    def test_vectors_beyond_the_sensor_never_come_back(self, small: StreamDevice) -> None:
        words = [high(0), row(1), base(40, 1), *[vector_12(0xFFF)] * 1000]
        assert decode_words(small, words)[1] == {"n_events": 10, "n_outside": 11_990}

    def test_reserved_words_are_counted_and_triggers_and_vendors_words_are_not(self, small: StreamDevice) -> None:
        words = [high(0), row(1), *(kind << 12 for kind in (7, 9, 10, 11, 12, 13, 14, 15)), event(1, 1)]
        assert decode_words(small, words) == ([[0, 1, 1, 1]], {"n_events": 1, "n_reserved": 4})

    def test_reset_forgets_all_parts(self, small: StreamDevice) -> None:
        words = [high(3), low(9), row(1), base(1, 1)]
        decode_words(small, words)
        assert decode_words(small, [event(1, 1)])[1] == {"n_untimed": 1}
        assert decode_words(small, [high(0), event(1, 1), row(1), vector_8(1)])[1] == {"n_untimed": 2}


@pytest.mark.skipif(not FIXTURE.exists(), reason=f"{FIXTURE} is not there")
@pytest.mark.parametrize("shape", SHAPES[:2])
def test_a_real_recording_is_decoded_event_for_event(shape: tuple[int, int, int, int, int, int]) -> None:
    words = payload(FIXTURE, np.uint16)
    data_w, t_w, *_ = shape
    device = device_of(*shape)
    decoded, clocks = compare_with_software(device, LAYOUT, words)
    assert np.array_equal(decoded.events, event_rows(read_recording(FIXTURE).events, t_w))
    print(f"{len(decoded.events)} events of {len(words)} words in {clocks} clocks: {len(decoded.events) / clocks:.3f} a clock")
    rng = np.random.default_rng(data_w)
    device.stalls = random_stalls(rng, STREAMS)
    device.set(swap_bytes=1)
    compare_with_software(device, LAYOUT, words, axis_beats(words.byteswap(), data_w, rng))


@pytest.mark.parametrize("shape", SHAPES)
def test_random_events_come_out_as_they_were_encoded(shape: tuple[int, int, int, int, int, int], tmp_path: Path) -> None:
    """Over 1 M events in all, times that turn, any byte order, any stalls; nothing is left out."""
    data_w, t_w, *_, width, height = shape
    device = device_of(*shape)
    for run in range(2):
        rng = np.random.default_rng([31, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        device.set(swap_bytes=run)
        events = random_events(rng, 200_000, width, height, 1 << 24)
        words = encoded(events, tmp_path)
        decoded, _ = compare_with_software(device, LAYOUT, words, axis_beats(words.byteswap() if run else words, data_w, rng))
        assert np.array_equal(decoded.events, event_rows(events, t_w))
        assert events.t_us[-1] > 1 << 26


@pytest.mark.parametrize("shape", SHAPES)
def test_damaged_words_are_decoded_as_the_software_does(shape: tuple[int, int, int, int, int, int], tmp_path: Path) -> None:
    """Over 300,000 words a shape: few damaged, many, all noise."""
    data_w, *_, width, height = shape
    device = device_of(*shape)
    for run, chance in enumerate((0.001, 0.1, 1)):
        rng = np.random.default_rng([32, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        words = encoded(random_events(rng, 100_000, width, height, 1 << 24), tmp_path)
        words = rng.integers(0, 1 << 16, 100_000, np.uint16) if chance == 1 else corrupted(words, rng, chance)
        decoded, _ = compare_with_software(device, LAYOUT, words, axis_beats(words, data_w, rng))
        assert decoded.counters["n_reserved"] > 0
        assert decoded.counters["n_outside"] > 0 or width == 2048


class TestClocks:
    """What the header claims."""

    def test_an_event_comes_6_clocks_after_its_word_which_is_taken_every_clock(self) -> None:
        words = np.array([high(0), *[row(1), low(2), event(3, 1), event(4, 0)] * 500], np.uint16)
        run = device_of(*SHAPES[1]).run({"s_axis_t": axis_beats(words, 16)})
        assert set(np.diff(run.accepted["s_axis_t"])) == {1}
        assert set(run.given["m_"] - run.accepted["s_axis_t"][words >> 12 == 2]) == {6}

    def test_a_vector_takes_as_many_clocks_as_it_has_events(self) -> None:
        words = np.array([high(0), row(1), base(0, 1), *[vector_12(0xFFF)] * 50], np.uint16)
        run = device_of(*SHAPES[0]).run({"s_axis_t": axis_beats(words, 64)})
        assert set(np.diff(run.given["m_"])) == {1}

# SPDX-License-Identifier: Apache-2.0
"""evt21_decoder.v: a story, random events of a test's own encoder, damaged words against the software decoder, clocks."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.recordings.formats.evt2 import evt21_layout
from evcot.recordings.formats.words import WordArray
from support.evt import (
    STREAMS,
    axis_beats,
    compare_with_software,
    corrupted,
    decode_in_hardware,
    event_rows,
    evt2_words,
    evt_device,
    random_events,
)
from support.stream_device import StreamDevice, random_stalls
from support.testing import lint

TOP = "evt21_decoder"
LAYOUT = evt21_layout(0, upper_first=False)

# data_w, t_w, x_w, y_w, width, height
SHAPES = [
    (32, 35, 9, 8, 304, 240),
    (64, 64, 11, 11, 2048, 2048),
    (32, 48, 5, 4, 20, 10),
]


def device_of(data_w: int, t_w: int, x_w: int, y_w: int, width: int, height: int) -> StreamDevice:
    return evt_device(TOP, width, height, DATA_W=data_w, T_W=t_w, X_W=x_w, Y_W=y_w)


def mark(value: int) -> int:
    return (8 << 28 | value) << 32


def vector(t_low: int, x: int, y: int, p: int, mask: int) -> int:
    return (p << 28 | t_low << 22 | x << 11 | y) << 32 | mask


def decode_words(device: StreamDevice, words: list[int]) -> tuple[list[list[int]], dict[str, int]]:
    return decode_in_hardware(device, np.array(words, np.uint64))


def reordered(words: WordArray, swap_bytes: int, swap_halves: int) -> WordArray:
    """The words with their bytes as a source sends them that sets these inputs right."""
    halves = words.view(np.uint32).reshape(-1, 2)
    halves = halves[:, ::-1] if swap_halves else halves
    return np.ascontiguousarray(halves.byteswap() if swap_bytes else halves).view(np.uint64).ravel()


@pytest.fixture(scope="module")
def small() -> StreamDevice:
    return device_of(*SHAPES[2])


@pytest.mark.parametrize("shape", [*SHAPES, (64, 48, 1, 1, 1, 2)])
def test_lints_clean(shape: tuple[int, ...]) -> None:
    parameters = dict(zip(("DATA_W", "T_W", "X_W", "Y_W", "WIDTH", "HEIGHT"), shape, strict=True))
    assert lint(TOP, **parameters) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [({"T_W": 65}, "T_W_must_be_35_to_64"), ({"DATA_W": 16}, "DATA_W_must_be_at_least_half_of_WORD_W")],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


class TestStories:
    def test_a_set_bit_is_an_event_the_lowest_to_the_left(self, small: StreamDevice) -> None:
        words = [
            mark(2),
            vector(5, 3, 4, 1, 0b1011),
            vector(6, 0, 9, 0, 1),
            vector(6, 0, 9, 0, 0),
            mark(3),
            vector(0, 19, 0, 1, 1),
        ]
        events = [[133, 3, 4, 1], [133, 4, 4, 1], [133, 6, 4, 1], [134, 0, 9, 0], [192, 19, 0, 1]]
        assert decode_words(small, words) == (events, {"n_events": 5})

    def test_every_bit_counts_that_is_before_a_mark_or_beyond_the_sensor(self, small: StreamDevice) -> None:
        words = [
            vector(0, 1, 1, 1, 7),
            mark(0),
            vector(0, 18, 1, 1, 0xF000_000F),
            vector(0, 1, 10, 1, 0b11),
            vector(0, 2047, 1, 1, 1),
        ]
        events = [[0, 18, 1, 1], [0, 19, 1, 1]]
        assert decode_words(small, words) == (events, {"n_events": 2, "n_untimed": 3, "n_outside": 9})

    def test_words_of_reserved_types_are_counted_once(self, small: StreamDevice) -> None:
        words = [mark(1), *((kind << 28) << 32 | 0xFFFF_FFFF for kind in range(2, 16) if kind != 8), vector(0, 1, 1, 1, 1)]
        assert decode_words(small, words) == ([[64, 1, 1, 1]], {"n_events": 1, "n_reserved": 10})

    def test_packets_that_end_within_a_word(self) -> None:
        device = device_of(*SHAPES[2])
        head, tail = mark(1) >> 32, vector(0, 1, 1, 1, 1) >> 32
        beats = [
            [0, 15, 0],
            [head, 15, 1],
            [9, 15, 1],
            [1, 15, 0],
            [tail, 15, 1],
            [2, 15, 0],
            [tail, 7, 1],
            [4, 15, 0],
            [tail, 15, 1],
        ]
        device.reset()
        assert device.run({"s_axis_t": beats}).words["m_"].tolist() == [[64, 1, 1, 1], [64, 3, 1, 1]]
        assert device.sim.io.n_cut == 2


@pytest.mark.parametrize("shape", SHAPES)
def test_random_events_come_out_as_they_were_encoded(shape: tuple[int, int, int, int, int, int]) -> None:
    """Over 1 M events in all, times that turn, any order of bytes and halves, any stalls; nothing is left out."""
    data_w, t_w, *_, width, height = shape
    device = device_of(*shape)
    for order in range(4):
        rng = np.random.default_rng([21, data_w, order])
        swaps = {"swap_bytes": order & 1, "swap_halves": order >> 1}
        device.stalls = random_stalls(rng, STREAMS)
        device.set(**swaps)
        events = random_events(rng, 100_000, width, height, 1 << 32)
        words = evt2_words(events, vectors=True)
        decoded, clocks = compare_with_software(device, LAYOUT, words, axis_beats(reordered(words, **swaps), data_w, rng))
        assert np.array_equal(decoded.events, event_rows(events, t_w))
        assert events.t_us[-1] > 1 << 34
        print(f"{len(events)} events of {len(words)} words in {clocks} clocks")


@pytest.mark.parametrize("shape", SHAPES)
def test_damaged_words_are_decoded_as_the_software_does(shape: tuple[int, int, int, int, int, int]) -> None:
    """Over 100,000 words a shape: few damaged, many, all noise."""
    data_w, *_, width, height = shape
    device = device_of(*shape)
    for run, chance in enumerate((0.001, 0.1, 1)):
        rng = np.random.default_rng([22, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        words = evt2_words(random_events(rng, 100_000, width, height, 1 << 33), vectors=True)
        words = rng.integers(0, 1 << 64, 20_000, np.uint64) if chance == 1 else corrupted(words, rng, chance)
        decoded, _ = compare_with_software(device, LAYOUT, words, axis_beats(words, data_w, rng))
        assert decoded.counters["n_reserved"] > 0
        assert decoded.counters["n_outside"] > 0 or width == 2048


class TestClocks:
    """What the header claims."""

    def test_an_event_every_clock_6_clocks_after_its_word(self) -> None:
        rng = np.random.default_rng(1)
        masks = rng.integers(1, 1 << 32, 2_000, np.uint64)
        words = np.concatenate([np.array([mark(1)], np.uint64), np.uint64(vector(0, 100, 100, 1, 0)) | masks])
        run = device_of(*SHAPES[1]).run({"s_axis_t": axis_beats(words, 64)})
        assert run.given["m_"][0] - run.accepted["s_axis_t"][1] == 6
        assert set(np.diff(run.given["m_"])) == {1}

    def test_marks_and_vectors_without_events_take_one_clock(self) -> None:
        words = np.array([mark(1), vector(0, 1, 1, 1, 0), 10 << 60] * 100, np.uint64)
        run = device_of(*SHAPES[1]).run({"s_axis_t": axis_beats(words, 64)})
        assert set(np.diff(run.accepted["s_axis_t"])) == {1}

# SPDX-License-Identifier: Apache-2.0
"""evt2_decoder.v: a story, a real recording, random and damaged words against the software decoder, clocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.recordings.files import read_recording
from evcot.recordings.formats.evt2 import evt2_layout
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
from support.testing import lint

TOP = "evt2_decoder"
FIXTURE = SHARED / "fixture_evt2_640x480.raw"

# data_w, t_w, x_w, y_w, width, height
SHAPES = [
    (64, 35, 10, 9, 640, 480),
    (16, 64, 11, 11, 2048, 2048),
    (32, 48, 5, 4, 20, 10),
]


def device_of(data_w: int, t_w: int, x_w: int, y_w: int, width: int, height: int) -> StreamDevice:
    return evt_device(TOP, width, height, DATA_W=data_w, T_W=t_w, X_W=x_w, Y_W=y_w)


def mark(value: int) -> int:
    return 8 << 28 | value


def event(t_low: int, x: int, y: int, p: int) -> int:
    return p << 28 | t_low << 22 | x << 11 | y


def decode_words(device: StreamDevice, words: list[int]) -> tuple[list[list[int]], dict[str, int]]:
    return decode_in_hardware(device, np.array(words, np.uint32))


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
        ({"T_W": 65}, "T_W_must_be_35_to_64"),
        ({"T_W": 34}, "HIGH_W_must_exceed_MARK_W"),
        ({"DATA_W": 128}, "DATA_W_must_be_16_32_or_64"),
        ({"X_W": 12}, "X_W_must_be_1_to_11"),
        ({"X_W": 10, "WIDTH": 1025}, "WIDTH_must_be_1_to_2_to_the_X_W"),
        ({"HEIGHT": 0}, "HEIGHT_must_be_1_to_2_to_the_Y_W"),
        ({"COUNT_W": 7}, "COUNT_W_must_be_8_to_64"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


class TestStories:
    def test_an_event_has_the_time_of_the_last_mark_and_its_own(self, small: StreamDevice) -> None:
        words = [mark(2), event(5, 3, 4, 1), event(6, 19, 9, 0), mark(3), event(0, 0, 0, 1)]
        assert decode_words(small, words) == ([[133, 3, 4, 1], [134, 19, 9, 0], [192, 0, 0, 1]], {"n_events": 3})

    def test_events_before_the_first_mark_are_left_out(self, small: StreamDevice) -> None:
        assert decode_words(small, [event(1, 1, 1, 1)] * 3 + [mark(0), event(1, 1, 1, 1)]) == (
            [[1, 1, 1, 1]],
            {"n_events": 1, "n_untimed": 3},
        )

    def test_events_beyond_the_sensor_are_left_out(self, small: StreamDevice) -> None:
        words = [mark(0), event(0, 20, 3, 0), event(0, 3, 10, 0), event(0, 2047, 2047, 0), event(0, 19, 9, 1)]
        assert decode_words(small, words) == ([[0, 19, 9, 1]], {"n_events": 1, "n_outside": 3})

    def test_reserved_words_are_counted_and_triggers_and_vendors_words_are_not(self, small: StreamDevice) -> None:
        words = [mark(1), *(kind << 28 for kind in range(2, 16) if kind != 8), event(0, 1, 1, 1)]
        assert decode_words(small, words) == ([[64, 1, 1, 1]], {"n_events": 1, "n_reserved": 10})

    def test_a_mark_that_falls_by_more_than_half_of_its_range_begins_a_turn(self, small: StreamDevice) -> None:
        top, half = (1 << 28) - 1, 1 << 27
        words = [
            mark(top),
            event(0, 1, 1, 1),
            mark(top - half),
            event(0, 2, 1, 1),
            mark(top),
            mark(top - half - 1),
            event(0, 3, 1, 1),
        ]
        times = [row[0] for row in decode_words(small, words)[0]]
        assert times == [top << 6, top - half << 6, (1 << 28) + top - half - 1 << 6]

    def test_reset_forgets_the_time(self, small: StreamDevice) -> None:
        decode_words(small, [mark(5), event(0, 1, 1, 1)])
        assert decode_words(small, [event(0, 1, 1, 1)]) == ([], {"n_untimed": 1})

    def test_a_word_that_keep_cuts_is_skipped(self, small: StreamDevice) -> None:
        small.reset()
        beats = [
            [mark(1), 0b1111, 0],
            [event(0, 1, 1, 1), 0b0111, 0],
            [event(0, 2, 1, 1), 0, 0],
            [event(0, 3, 1, 1), 0b1111, 1],
        ]
        assert small.run({"s_axis_t": beats}).words["m_"].tolist() == [[64, 3, 1, 1]]
        assert (small.sim.io.n_cut, small.sim.io.n_events) == (1, 1)


def big_endian(words: NDArray[np.uint32]) -> NDArray[np.uint32]:
    return words.byteswap()


@pytest.mark.skipif(not FIXTURE.exists(), reason=f"{FIXTURE} is not there")
def test_a_real_recording_is_decoded_event_for_event() -> None:
    words = payload(FIXTURE, np.uint32)
    data_w, t_w, *_ = SHAPES[0]
    device = device_of(*SHAPES[0])
    decoded, clocks = compare_with_software(device, evt2_layout(0), words)
    assert np.array_equal(decoded.events, event_rows(read_recording(FIXTURE).events, t_w))
    print(f"{len(decoded.events)} events of {len(words)} words in {clocks} clocks: {len(decoded.events) / clocks:.3f} a clock")
    assert clocks <= len(words) + 8
    rng = np.random.default_rng(data_w)
    device.stalls = random_stalls(rng, STREAMS)
    device.set(swap_bytes=1)
    compare_with_software(device, evt2_layout(0), words, axis_beats(big_endian(words), data_w, rng))


@pytest.mark.parametrize("shape", SHAPES)
def test_random_events_come_out_as_they_were_encoded(shape: tuple[int, int, int, int, int, int]) -> None:
    """Over 1 M events in all, times that turn, any byte order, any stalls; nothing is left out."""
    data_w, t_w, *_, width, height = shape
    device = device_of(*shape)
    for run in range(2):
        rng = np.random.default_rng([2, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        device.set(swap_bytes=run)
        events = random_events(rng, 200_000, width, height, 1 << 32)
        words = evt2_words(events, vectors=False)
        decoded, _ = compare_with_software(
            device, evt2_layout(0), words, axis_beats(big_endian(words) if run else words, data_w, rng)
        )
        assert np.array_equal(decoded.events, event_rows(events, t_w))
        assert events.t_us[-1] > 1 << 34


@pytest.mark.parametrize("shape", SHAPES)
def test_damaged_words_are_decoded_as_the_software_does(shape: tuple[int, int, int, int, int, int]) -> None:
    """300,000 words a shape: few damaged, many, all noise."""
    data_w, *_, width, height = shape
    device = device_of(*shape)
    for run, chance in enumerate((0.001, 0.1, 1)):
        rng = np.random.default_rng([3, data_w, run])
        device.stalls = random_stalls(rng, STREAMS)
        words = evt2_words(random_events(rng, 100_000, width, height, 1 << 33), vectors=False)
        words = rng.integers(0, 1 << 32, 100_000, np.uint32) if chance == 1 else corrupted(words, rng, chance)
        decoded, _ = compare_with_software(device, evt2_layout(0), words, axis_beats(words, data_w, rng))
        assert decoded.counters["n_reserved"] > 0
        assert decoded.counters["n_outside"] > 0 or width == 2048


def test_clocks(small: StreamDevice) -> None:
    """An event comes out 6 clocks after its word; a word is taken every clock, marks included."""
    words = evt2_words(random_events(np.random.default_rng(1), 10_000, 20, 10, 1000), vectors=False)
    small.reset()
    run = small.run({"s_axis_t": axis_beats(words, 32)})
    assert set(np.diff(run.accepted["s_axis_t"])) == {1}
    is_event = words >> 28 <= 1
    assert set(run.given["m_"] - run.accepted["s_axis_t"][is_event]) == {6}

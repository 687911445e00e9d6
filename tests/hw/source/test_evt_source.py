# SPDX-License-Identifier: Apache-2.0
"""evt_source.v: each of Prophesee's formats behind the same ports; what is left out is counted, whatever the reason."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from evcot.events import Events
from evcot.recordings.files import write_events
from evcot.recordings.formats.evt2 import evt2_layout, evt21_layout
from evcot.recordings.formats.evt3 import evt3_layout
from evcot.recordings.formats.words import Layout, WordArray
from support.evt import STREAMS, axis_beats, corrupted, decode, evt2_words, evt_device, payload, random_events
from support.stream_device import Bundle, StreamDevice, check_reset, random_stalls

TOP = "evt_source"
WIDTH, HEIGHT = 20, 10


def evt3_words(events: Events, folder: Path) -> WordArray:
    write_events(folder / "a.raw", (WIDTH, HEIGHT), [events], "evt3", force=True)
    return payload(folder / "a.raw", np.uint16)


def legacy(words: WordArray) -> WordArray:
    """The upper half of each word of EVT 2.1 first."""
    return np.ascontiguousarray(words.view(np.uint32).reshape(-1, 2)[:, ::-1]).view(np.uint64).ravel()


class Format(NamedTuple):
    """A format by its number: how events become its words, and what the software makes of them."""

    number: int
    encode: Callable[[Events, Path], WordArray]
    layout: Layout


FORMATS = {
    "2.0": Format(3, lambda events, _: evt2_words(events, vectors=False), evt2_layout(0)),
    "2.1": Format(4, lambda events, _: evt2_words(events, vectors=True), evt21_layout(0, upper_first=False)),
    "3.0": Format(5, evt3_words, evt3_layout(0)),
}


@pytest.mark.parametrize("name", FORMATS)
def test_events_come_out_and_all_else_is_counted(name: str, tmp_path: Path) -> None:
    """In any order of bytes, whole and damaged words, and words of which a part is missing."""
    number, encode, layout = FORMATS[name]
    device = evt_device(TOP, WIDTH, HEIGHT, FORMAT=number, X_W=5, Y_W=4)
    for order, damage in enumerate((0, 0.02, 0.02, 0)):
        rng = np.random.default_rng([83, number, order])
        words = corrupted(encode(random_events(rng, 20_000, WIDTH, HEIGHT, 1 << 20), tmp_path), rng, damage)
        expected = decode(layout, words, WIDTH, HEIGHT)
        swap_bytes, swap_halves = order & 1, order >> 1
        sent = legacy(words) if swap_halves and name == "2.1" else words
        if swap_bytes:
            sent = sent.view(f"<u{min(4, sent.itemsize)}").byteswap().view(sent.dtype)
        beats = axis_beats(sent, 64, rng)
        cut = np.array([[0, 0x01, 1]], np.uint64)
        device.stalls = random_stalls(rng, STREAMS)
        device.set(swap_bytes=swap_bytes, swap_halves=swap_halves)
        device.reset()
        result = device.run({"s_axis_t": np.concatenate([beats, cut])}).words["m_"]
        assert np.array_equal(result, expected.events)
        left_out = sum(count for counter, count in expected.counters.items() if counter != "n_events")
        assert device.sim.io.n_skipped == left_out + 1
        assert (left_out > 100) == bool(damage)


EVENT_VECTOR_TOP = "event_vector"
FIELDS = ("t", "x", "y", "p", "mask", "known")
# bits, width, height, x_w, y_w
SHAPES = [(32, 100, 60, 7, 6), (12, 2048, 2048, 11, 11), (1, 1280, 720, 11, 10)]


def device_of(bits: int, width: int, height: int, x_w: int, y_w: int) -> StreamDevice:
    parameters = {"L": bits, "WIDTH": width, "HEIGHT": height, "X_W": x_w, "Y_W": y_w}
    inputs, outputs = [Bundle("s_", FIELDS)], [Bundle("m_", FIELDS[:4])]
    return StreamDevice(EVENT_VECTOR_TOP, parameters, inputs=inputs, outputs=outputs, has_idle=True)


def test_reset_amid_vectors_leaves_nothing() -> None:
    check_reset(device_of(*SHAPES[0]), {"s_": [[0, 0, 0, 0, 0b1011, 1]] * 30})


@pytest.mark.parametrize("shape", SHAPES)
def test_random_vectors(shape: tuple[int, int, int, int, int]) -> None:
    bits, width, height, *_ = shape
    device = device_of(*shape)
    for run in range(3):
        rng = np.random.default_rng([51, bits, run])
        n = 10_000
        t = rng.integers(0, 1 << 48, n)
        x, y = rng.integers(0, min(2049, width + 20), n), rng.integers(0, min(2048, height + 5), n)
        mask = rng.integers(0, 1 << bits, n) & rng.integers(0, 1 << bits, n)
        vectors = np.stack([t, x, y, rng.integers(0, 2, n), mask, rng.random(n) < 0.9], axis=1).astype(np.uint64)
        events = [
            ([t, x + bit, y, p], known)
            for t, x, y, p, mask, known in vectors.tolist()
            for bit in range(bits)
            if mask >> bit & 1
        ]
        inside = [event for event, known in events if known and event[1] < width and event[2] < height]
        untimed = sum(not known for _, known in events)
        device.reset()
        device.stalls = random_stalls(rng, ("s_", "m_"))
        assert device.run({"s_": vectors}).words["m_"].tolist() == inside
        io = device.sim.io
        assert (io.n_events, io.n_untimed, io.n_outside) == (len(inside), untimed, len(events) - len(inside) - untimed)
        assert untimed > 100


def test_clocks() -> None:
    """4 clocks to the first event, then one every clock; those left out and empty vectors take a clock each."""
    device = device_of(*SHAPES[0])
    run = device.run({"s_": [[0, 0, 0, 0, 0xFFFF_FFFF, 1]] * 20})
    assert run.given["m_"].tolist() == list(range(4, 4 + 640))
    run = device.run({"s_": [[0, 90, 0, 0, 0xFFF, 1], [0, 0, 0, 0, 0, 1]] * 20})
    assert set(np.diff(run.accepted["s_"][1::2])) == {12 + 1}

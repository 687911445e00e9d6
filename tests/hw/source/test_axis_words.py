# SPDX-License-Identifier: Apache-2.0
"""axis_words.v: beats of any width as words, against a reading of the bytes one by one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from support.stream_device import Bundle, StreamDevice, check_reset, random_stalls

TOP = "axis_words"
# data_w, word_w
SHAPES = [(16, 16), (64, 16), (64, 32), (32, 64), (16, 32)]


def device_of(data_w: int, word_w: int) -> StreamDevice:
    inputs, outputs = [Bundle("s_axis_t", ("data", "keep", "last"))], [Bundle("m_", ("word",))]
    return StreamDevice(TOP, {"DATA_W": data_w, "WORD_W": word_w}, inputs=inputs, outputs=outputs, has_idle=True)


@pytest.mark.parametrize("shape", SHAPES)
def test_reset_amid_beats_leaves_nothing(shape: tuple[int, int]) -> None:
    data_w, _ = shape
    beat = [0, (1 << data_w // 8) - 1, 0]
    check_reset(device_of(*shape), {"s_axis_t": [beat] * 60})


def by_the_rule(beats: NDArray[np.uint64], data_w: int, word_w: int) -> tuple[list[int], int]:
    """The words, and how many are cut: lane by lane where a beat has whole words, else half by half up to tlast."""
    words, cut = [], 0
    width = min(data_w, word_w)
    all_kept = (1 << width // 8) - 1
    lower: int | None = None
    for data, keep, last in beats.tolist():
        for lane in range(data_w // width):
            value, kept = data >> lane * width & ((1 << width) - 1), keep >> lane * width // 8 & all_kept
            if kept not in (0, all_kept):
                cut, lower = cut + 1, None
            elif kept and width == word_w:
                words.append(value)
            elif kept and lower is None:
                lower = value
            elif kept and lower is not None:
                words.append(value << width | lower)
                lower = None
        if last and lower is not None:
            cut, lower = cut + 1, None
    return words, cut


def swapped(word: int, word_w: int) -> int:
    """The bytes of a word, or of each half of 64 bits, the other way round."""
    unit = min(word_w, 32) // 8
    given = word.to_bytes(word_w // 8, "little")
    return int.from_bytes(b"".join(given[at : at + unit][::-1] for at in range(0, len(given), unit)), "little")


@pytest.mark.parametrize("shape", SHAPES)
def test_any_bytes_kept_and_any_packets(shape: tuple[int, int]) -> None:
    """80,000 beats a shape, each lane whole, missing or cut, a packet's end anywhere."""
    data_w, word_w = shape
    width = min(shape)
    device = device_of(*shape)
    for run in range(4):
        rng = np.random.default_rng([41, data_w, word_w, run])
        device.reset()
        device.stalls = random_stalls(rng, ("s_axis_t", "m_"))
        n, lanes = 20_000, data_w // width
        kinds = rng.choice(3, (n, lanes), p=[0.7, 0.2, 0.1])
        kept = np.choose(kinds, [(1 << width // 8) - 1, 0, rng.integers(0, 1 << width // 8, (n, lanes))])
        keep = (kept << np.arange(lanes) * (width // 8)).sum(axis=1)
        data = rng.integers(0, (1 << data_w) - 1, n, np.uint64, endpoint=True)
        beats = np.stack([data, keep.astype(np.uint64), rng.integers(0, 2, n).astype(np.uint64)], axis=1)
        beats[-1, 2] = 1
        words, cut = by_the_rule(beats, data_w, word_w)
        device.set(swap_bytes=run % 2)
        if run % 2:
            words = [swapped(word, word_w) for word in words]
        assert device.run({"s_axis_t": beats}).words["m_"][:, 0].tolist() == words
        assert device.sim.io.n_cut == cut
        assert cut > 100


def test_idle_tells_of_half_a_word() -> None:
    device = device_of(32, 64)
    assert device.sim.io.idle == 1
    device.run({"s_axis_t": [[1, 15, 0]]}, clocks=3)
    assert (device.sim.io.idle, device.sim.io.m_valid) == (0, 0)
    device.run({"s_axis_t": [[0, 0, 1]]}, clocks=3)
    assert (device.sim.io.idle, device.sim.io.n_cut) == (1, 1)


def test_clocks() -> None:
    """A word every clock, two clocks after its beat."""
    device = device_of(64, 16)
    beats = [[0x0004_0003_0002_0001, 0xFF, 0]] * 100
    run = device.run({"s_axis_t": beats})
    assert run.words["m_"][:, 0].tolist() == [1, 2, 3, 4] * 100
    assert run.given["m_"].tolist() == list(range(2, 402))
    assert run.accepted["s_axis_t"].tolist() == list(range(0, 400, 4))

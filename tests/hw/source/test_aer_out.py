# SPDX-License-Identifier: Apache-2.0
"""aer_out.v with a chip whose times are its own: every word taken once, the protocol kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.base import HardwareError, reset
from evcot_cosim.rtl.build import load
from support.aer_device import AerDevice, Chip
from support.stream_device import random_pattern
from support.testing import broken_copy

TOP = "aer_out"

# x_w, y_w, slot_w, setup, sync
SHAPES = [(8, 7, 3, 1, 2), (1, 1, 1, 5, 4), (11, 10, 6, 2, 3)]


def device_of(x_w: int, y_w: int, slot_w: int, setup: int, sync: int, verilog: Path | None = None) -> AerDevice:
    parameters = {"X_W": x_w, "Y_W": y_w, "SLOT_W": slot_w, "SETUP": setup, "SYNC": sync}
    return AerDevice(TOP, parameters, verilog=verilog)


def random_words(rng: np.random.Generator, n: int, shape: tuple[int, int, int, int, int]) -> NDArray[np.int64]:
    x_w, y_w, slot_w, *_ = shape
    return rng.integers(0, [4, 1 << slot_w, 1 << x_w, 1 << y_w, 2], (n, 5))


def packed(words: NDArray[np.int64], shape: tuple[int, int, int, int, int]) -> NDArray[np.int64]:
    """{kind, slot, y, x, p}."""
    x_w, y_w, slot_w, *_ = shape
    kind, slot, x, y, p = words.T
    return ((kind << slot_w | slot) << y_w | y) << x_w + 1 | x << 1 | p


def check(
    device: AerDevice,
    words: NDArray[np.int64],
    shape: tuple[int, int, int, int, int],
    chip: Chip,
    seed: int,
    pattern: NDArray[np.uint8] | None = None,
) -> float:
    """Sends the words and returns the clocks a word; the chip must have taken each of them, in order."""
    run = device.run(words, chip, seed, pattern)
    assert np.array_equal(run.out.astype(np.int64), packed(words, shape)), "words lost or changed"
    assert device.sim.io.idle == 1
    return run.clocks / len(words)


@pytest.mark.parametrize("active_low", [0, 1])
def test_nothing_is_taken_after_a_reset_while_an_acknowledge_stands(active_low: int) -> None:
    sim = load("aer_out", {})
    sim.io.active_low, sim.io.aer_ack = active_low, 1 - active_low
    reset(sim, clocks=1)
    for _ in range(10):
        assert sim.io.s_ready == 0
        sim.clock.tick()
    sim.io.aer_ack = active_low
    for _ in range(4):
        sim.clock.tick()
    assert sim.io.s_ready == 1


@pytest.mark.parametrize("active_low", [0, 1])
def test_one_handshake_clock_by_clock(active_low: int) -> None:
    device = device_of(*SHAPES[0])
    device.reset(active_low=active_low)
    sim, io = device.sim, device.sim.io
    on, off = 1 - active_low, active_low
    assert (io.aer_req, io.s_ready, io.idle) == (off, 0, 0)  # not before the acknowledge is seen to be gone
    for _ in range(3):
        sim.clock.tick()
    assert (io.aer_req, io.s_ready, io.idle) == (off, 1, 1)
    io.s_valid, io.s_kind, io.s_slot, io.s_x, io.s_y, io.s_p = 1, 2, 5, 200, 100, 1
    sim.clock.tick()
    io.s_valid = 0
    assert (io.aer_req, io.aer_data, io.s_ready) == (off, 2 << 19 | 5 << 16 | 100 << 9 | 200 << 1 | 1, 0)
    for _ in range(10):
        sim.clock.tick()
        assert io.aer_req == on
    io.aer_ack = on
    for _ in range(2):
        sim.clock.tick()
        assert io.aer_req == on
    for _ in range(10):
        sim.clock.tick()
        assert (io.aer_req, io.s_ready) == (off, 0)
    io.aer_ack = off
    for _ in range(2):
        sim.clock.tick()
        assert io.s_ready == 0
    sim.clock.tick()
    assert io.s_ready == 1


@pytest.mark.parametrize("shape", SHAPES)
def test_every_word_is_taken_once_whenever_the_chip_moves(shape: tuple[int, int, int, int, int]) -> None:
    """300,000 words in all."""
    device, setup = device_of(*shape), shape[3]
    for k, chip in enumerate(
        [Chip(setup=setup), Chip(react=1500, window=300, setup=setup), Chip(react=20_000, window=100, setup=setup)]
    ):
        for active_low in (0, 1):
            rng = np.random.default_rng([111, shape[0], k, active_low])
            device.reset(active_low=active_low)
            words = random_words(rng, 20_000, shape)
            clocks = check(device, words, shape, chip, k, random_pattern(rng, 0.1) if active_low else None)
            print(f"{shape} {chip}: {clocks:.2f} clocks a word")


@pytest.mark.parametrize("shape", SHAPES)
def test_clocks(shape: tuple[int, int, int, int, int]) -> None:
    """A chip that answers at once gets a word in SETUP + 2 * SYNC + 3 clocks."""
    *_, setup, sync = shape
    run = device_of(*shape).run(random_words(np.random.default_rng(1), 10_000, shape), Chip(setup=setup), 1)
    assert setup + 2 * sync + 3 <= run.clocks / 10_000 < setup + 2 * sync + 3.02


TWINS = {
    "requests for one clock": ("if (acknowledge) begin", "begin", "took its signal back"),
    "does not wait until the acknowledge is gone": (
        "if (!acknowledge) state <= READY",
        "state <= READY",
        "requested while|took its signal back",
    ),
    "requests at once": ("settled == LAST_SETTLED[7:0]", "1'b1", "stood long enough"),
    "changes the word while it is on offer": (
        "REQUEST: if (acknowledge) begin",
        "REQUEST: if (!acknowledge) aer_data[0] <= s_p; else begin",
        "withdrew",
    ),
    "forgets a word": ("if (s_valid) begin", "if (s_valid && s_p) begin", "words lost or changed"),
}


@pytest.mark.parametrize("twin", TWINS)
def test_a_broken_twin_is_seen(twin: str, tmp_path: Path) -> None:
    right, wrong, seen = TWINS[twin]
    shape = SHAPES[2]
    device = device_of(*shape, verilog=broken_copy(tmp_path, f"{TOP}.v", right, wrong))
    device.reset(active_low=0)
    words = random_words(np.random.default_rng(7), 2_000, shape)
    with pytest.raises((HardwareError, AssertionError), match=seen):
        check(device, words, shape, Chip(react=4_000, window=300, setup=shape[3]), 3)

# SPDX-License-Identifier: Apache-2.0
"""aer_in.v with a chip whose times are its own: nothing lost, the protocol kept, every event stamped when it came."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.base import HardwareError, reset
from support.aer_device import STEPS_PER_CLOCK, AerDevice, Chip
from support.stream_device import random_pattern
from support.testing import broken_copy

TOP = "aer_in"

# x_w, y_w, width, height, sync
SHAPES = [(8, 7, 200, 100, 2), (1, 1, 2, 1, 3), (11, 10, 1280, 720, 2)]
CHIPS = {
    "at once": Chip(),
    "at once, wires in doubt": Chip(window=300),
    "slow": Chip(gap=20_000, react=5_000, skew=700, setup=400, window=100),
    "quick but late wires": Chip(gap=100, react=1500, skew=2_000, window=200),
}


class Words(NamedTuple):
    """What a chip sends, (n, 2) data and row, the events (x, y, p) that it means, and which word each is."""

    words: NDArray[np.int64]
    events: NDArray[np.int64]
    at: NDArray[np.int64]
    n_outside: int
    n_rowless: int


def device_of(x_w: int, y_w: int, width: int, height: int, sync: int, verilog: Path | None = None) -> AerDevice:
    parameters = {"X_W": x_w, "Y_W": y_w, "WIDTH": width, "HEIGHT": height, "SYNC": sync}
    return AerDevice(TOP, parameters, verilog=verilog)


def plain(rng: np.random.Generator, n: int, shape: tuple[int, int, int, int, int]) -> Words:
    x_w, y_w, width, height, _ = shape
    x, y, p = rng.integers(0, 1 << x_w, n), rng.integers(0, 1 << y_w, n), rng.integers(0, 2, n)
    inside = (x < width) & (y < height)
    words = np.stack([y << x_w + 1 | x << 1 | p, rng.integers(0, 2, n)], axis=1)  # the row wire means nothing here
    return Words(words, np.stack([x, y, p], axis=1)[inside], np.flatnonzero(inside), n - int(inside.sum()), 0)


def serial(rng: np.random.Generator, n: int, shape: tuple[int, int, int, int, int]) -> Words:
    """Three columns first, which have no row, then rows of columns; the unused high wires are noise."""
    x_w, y_w, width, height, _ = shape
    is_row = rng.random(n) < 0.3
    is_row[:3] = False
    x, p, noise = rng.integers(0, 1 << x_w, n), rng.integers(0, 2, n), rng.integers(0, 1 << x_w + y_w + 1, n)
    y = rng.integers(0, 1 << y_w, n)
    first = np.maximum.accumulate(np.where(is_row, np.arange(n), -1))
    row = np.where(first < 0, height, y[first])
    data = np.where(is_row, noise >> y_w << y_w | y, noise >> x_w + 1 << x_w + 1 | x << 1 | p)
    inside = ~is_row & (x < width) & (row < height)
    n_rowless = int(is_row.argmax())
    n_outside = int((~is_row).sum() - inside.sum()) - n_rowless
    words = np.stack([data, is_row], axis=1).astype(np.int64)
    return Words(words, np.stack([x, row, p], axis=1)[inside], np.flatnonzero(inside), n_outside, n_rowless)


def check(device: AerDevice, sent: Words, chip: Chip, seed: int, pattern: NDArray[np.uint8] | None = None) -> float:
    """Sends the words and returns the clocks a word; every event must be there, in order, stamped when its request came."""
    run = device.run(sent.words, chip, seed, pattern)
    assert np.array_equal(run.out[:, 1:].astype(np.int64), sent.events), "events lost or changed"
    sync = int(device.model.parameters["SYNC"])
    late = run.out[:, 0].astype(np.int64) * STEPS_PER_CLOCK - run.request_at[sent.at]
    assert late.min() >= sync * STEPS_PER_CLOCK - chip.window, "stamped too early"
    assert late.max() <= (sync + 1) * STEPS_PER_CLOCK + chip.window, "stamped too late"
    io = device.sim.io
    assert (io.n_events, io.n_outside, io.n_rowless) == (len(sent.events), sent.n_outside, sent.n_rowless)
    assert io.idle == 1
    return run.clocks / len(sent.words)


@pytest.mark.parametrize("active_low", [0, 1])
def test_a_reset_invents_no_request_and_takes_one_that_stands(active_low: int) -> None:
    """The synchronizer has the line as it is: what its reset leaves in it means a request in one of the two polarities."""
    device = device_of(*SHAPES[0])
    for line, expected in ((active_low, 0), (1 - active_low, 1)):
        device.sim.io.aer_req, device.sim.io.m_ready = line, 1
        device.reset(active_low=active_low, word_serial=0)
        device.sim.io.aer_req = line
        for _ in range(20):
            device.sim.clock.tick()
        assert device.sim.io.n_events == expected


@pytest.mark.parametrize("active_low", [0, 1])
def test_one_handshake_clock_by_clock(active_low: int) -> None:
    device = device_of(*SHAPES[0])
    device.reset(active_low=active_low, word_serial=0)
    sim, io = device.sim, device.sim.io
    on, off = 1 - active_low, active_low
    assert (io.aer_ack, io.m_valid) == (off, 0)
    io.aer_req, io.aer_data, io.t_us, io.m_ready = on, 5 << 9 | 7 << 1 | 1, 100, 0
    for _ in range(3):  # two flip-flops, then the word is read
        sim.clock.tick()
        assert (io.aer_ack, io.m_valid) == (off, 0)
        io.t_us = io.t_us + 1
    sim.clock.tick()
    assert (io.aer_ack, io.m_valid, io.m_t, io.m_x, io.m_y, io.m_p) == (on, 1, 102, 7, 5, 1)
    for _ in range(5):
        sim.clock.tick()
        assert io.aer_ack == on  # as long as the request is there
    io.aer_req = off
    for _ in range(2):
        sim.clock.tick()
        assert io.aer_ack == on
    sim.clock.tick()
    assert (io.aer_ack, io.m_valid) == (off, 1)
    io.aer_req, io.t_us = on, 200  # a second event finds no room: no acknowledge, but the time of its arrival
    for _ in range(20):
        sim.clock.tick()
        assert (io.aer_ack, io.m_t) == (off, 102)
        io.t_us = io.t_us + 1
    io.m_ready = 1
    sim.clock.tick()
    assert (io.aer_ack, io.m_valid, io.m_t) == (on, 1, 202)


@pytest.mark.parametrize("mode", ["plain", "serial"])
@pytest.mark.parametrize("shape", SHAPES)
def test_nothing_is_lost_whenever_the_chip_moves(shape: tuple[int, int, int, int, int], mode: str) -> None:
    """Over a million words in all."""
    device = device_of(*shape)
    make = plain if mode == "plain" else serial
    for k, (name, chip) in enumerate(CHIPS.items()):
        for active_low in (0, 1):
            rng = np.random.default_rng([101, shape[0], k, active_low])
            device.reset(active_low=active_low, word_serial=int(mode == "serial"))
            pattern = random_pattern(rng, 0.1) if active_low else None
            clocks = check(device, make(rng, 25_000, shape), chip, 8 * k + active_low, pattern)
            print(f"{shape} {mode} {name}: {clocks:.2f} clocks a word")


@pytest.mark.parametrize("counter", ["n_outside", "n_rowless"])
def test_reset_forgets_what_was_to_be_counted(counter: str) -> None:
    """The word is beyond the sensor, or a column without a row; the reset of one clock comes at any moment of it."""
    sim = device_of(*SHAPES[0]).sim
    io, counted = sim.io, []
    io.word_serial, io.aer_row, io.aer_data = int(counter == "n_rowless"), 0, 0xFFFF
    for moment in range(12):
        io.aer_req = 0
        reset(sim, clocks=8)
        io.aer_req = 1
        for _ in range(moment):
            sim.clock.tick()
        counted.append(int(io[counter]))
        reset(sim, clocks=1)
        sim.clock.tick()
        assert int(io[counter]) == 0, moment
    assert set(counted) == {0, 1}


def test_reset_forgets_the_row() -> None:
    device = device_of(*SHAPES[0])
    for _ in range(2):
        device.reset(active_low=0, word_serial=1)
        assert len(device.run([[3 << 1, 0], [5, 1], [3 << 1, 0]], Chip(), 0).out) == 1
        assert device.sim.io.n_rowless == 1


@pytest.mark.parametrize("ready", [0, 1])
@pytest.mark.parametrize("lasts", [1, 5])
def test_a_flush_at_any_clock_drops_what_is_inside_and_reads_no_word_twice(lasts: int, ready: int) -> None:
    device = device_of(*SHAPES[0])
    sim, io = device.sim, device.sim.io
    dropped_in_all = 0
    for begin in range(30):
        device.reset(active_low=0, word_serial=0)
        rows, came = [1, 2, 3], []
        dropped = counted = 0
        for clock in range(60):
            io.flush, io.m_ready, io.t_us = int(begin <= clock < begin + lasts), ready or clock > 45, clock
            acknowledged = io.aer_ack
            if not acknowledged and rows:
                io.aer_req, io.aer_data = 1, rows[0] << 9
            elif acknowledged and io.aer_req:
                io.aer_req = 0
                del rows[0]
            if io.m_valid and (io.flush or io.m_ready):
                came.append(io.m_y)
                dropped += io.flush
                if clock > begin and not io.flush:
                    counted += 1
                    assert io.m_t >= begin + lasts  # the clock that stamps may begin anew with the flush
            request = io.aer_req
            sim.clock.tick()
            assert io.aer_ack in (acknowledged, request)
        assert came == [1, 2, 3]
        assert io.n_events == counted
        dropped_in_all += dropped
    assert dropped_in_all > 2


def test_a_flush_keeps_the_row() -> None:
    device = device_of(*SHAPES[0])
    device.reset(active_low=0, word_serial=1)
    device.run([[5, 1]], Chip(), 0)
    device.sim.io.flush = 1
    device.sim.clock.tick()
    device.sim.io.flush = 0
    assert device.run([[3 << 1, 0]], Chip(), 1).out[0, 1:].tolist() == [3, 5, 0]


@pytest.mark.parametrize("sync", [2, 3])
def test_clocks(sync: int) -> None:
    """A chip that answers at once gets a word through in 2 * SYNC + 3 clocks."""
    shape = SHAPES[0] if sync == 2 else SHAPES[1]
    device = device_of(*shape)
    run = device.run(plain(np.random.default_rng(1), 10_000, shape).words, Chip(), 1)
    assert 2 * sync + 3 <= run.clocks / 10_000 < 2 * sync + 3.01


# file, right, wrong, what is seen of it
TWINS = {
    "acknowledges for one clock": ("aer_in.v", "if (!request) begin", "begin", "took its signal back|no request"),
    "drops what finds no room": ("aer_in.v", "(!is_event || room)", "1'b1", "events lost or changed"),
    "overwrites what waits": ("aer_in.v", "if (state == DECIDE && room)", "if (state == DECIDE)", "withdrew or changed"),
    "listens too soon": ("aer_in.v", "if (request && !flush) begin is_row", "begin is_row", "no request"),
    "trusts the first flip-flop": ("synchronizer.v", "stages[STAGES-1]", "stages[0]", "stamped too early"),
    "has no flip-flop": ("synchronizer.v", "q = stages[STAGES-1]", "q = d", "events lost or changed"),
    "stamps when there is room": ("aer_in.v", "m_t <= arrival", "m_t <= t_us", "stamped too late"),
}


@pytest.mark.parametrize("twin", TWINS)
def test_a_broken_twin_is_seen(twin: str, tmp_path: Path) -> None:
    file, right, wrong, seen = TWINS[twin]
    device = device_of(*SHAPES[0], verilog=broken_copy(tmp_path, file, right, wrong))
    rng = np.random.default_rng(7)
    device.reset(active_low=0)
    chip = Chip(gap=3_000, react=3_000, skew=500, window=300)
    with pytest.raises((HardwareError, AssertionError), match=seen):
        check(device, plain(rng, 5_000, SHAPES[0]), chip, 3, random_pattern(rng, 0.1))

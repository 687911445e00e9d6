# SPDX-License-Identifier: Apache-2.0
"""Events from AXI4-Stream: unpacked fields, times that wrap, and skipped beats."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from evcot.hardware.streams import pack_events
from support.stream_device import Bundle, StreamDevice, check_reset, random_stalls

INPUT, OUTPUT = Bundle("s_axis_t", ("data", "keep", "last")), Bundle("m_", ("t", "x", "y", "p"))


@pytest.fixture
def device() -> StreamDevice:
    return StreamDevice("axis_events_in", inputs=[INPUT], outputs=[OUTPUT], has_idle=True)


def beats(words: NDArray[np.uint64], keep: ArrayLike = 255) -> NDArray[np.uint64]:
    return np.stack(
        [words, np.broadcast_to(np.asarray(keep, np.uint64), len(words)), np.arange(len(words), dtype=np.uint64) & 1], 1
    )


def events(device: StreamDevice, t: ArrayLike, x: ArrayLike = 5, y: ArrayLike = 6, keep: ArrayLike = 255) -> list[list[int]]:
    columns = [np.array(column) for column in np.broadcast_arrays(np.asarray(t), x, y, 1)]
    run = device.run({INPUT.prefix: beats(pack_events(*columns), keep)})
    return run.words[OUTPUT.prefix].astype(np.int64).tolist()


def test_reset_amid_events_leaves_nothing(device: StreamDevice) -> None:
    n = np.arange(100)
    check_reset(device, {INPUT.prefix: beats(pack_events(n, n, n, n & 1))})


@pytest.mark.parametrize("seed", range(3))
def test_events_come_out_as_they_went_in_at_any_pace(device: StreamDevice, seed: int) -> None:
    rng = np.random.default_rng([3, seed])
    device.stalls = random_stalls(rng, [INPUT.prefix, OUTPUT.prefix])
    t = np.cumsum(rng.integers(0, 3_000_000, 10_000))  # seven turns of 32 bits
    columns = [t, rng.integers(0, 346, 10_000), rng.integers(0, 260, 10_000), rng.integers(0, 2, 10_000)]
    run = device.run({INPUT.prefix: beats(pack_events(*columns))})
    found = run.words[OUTPUT.prefix].astype(np.int64)
    assert np.array_equal(found, np.stack(columns, 1))
    assert t[-1] > 3 << 32


def test_a_time_that_falls_by_half_its_range_has_wrapped_and_a_smaller_fall_has_not(device: StreamDevice) -> None:
    times = [(1 << 32) - 10, (1 << 32) + 5, (1 << 32) + 3]
    assert [t for t, *_ in events(device, times)] == times
    device.reset()
    assert [t for t, *_ in events(device, [5, (1 << 32) - 1, 3])] == [5, (1 << 32) - 1, (1 << 32) + 3]
    half = 1 << 31
    device.reset()
    assert [t for t, *_ in events(device, [half + 5, 5])] == [half + 5, (1 << 32) + 5]
    device.reset()
    assert [t for t, *_ in events(device, [half + 4, 5])] == [half + 4, 5]


def test_beats_that_are_cut_or_beyond_the_sensor_are_skipped_and_counted(device: StreamDevice) -> None:
    found = events(device, [1, 2, 3, 4, 5], [345, 346, 5, 5, 5], [259, 5, 260, 5, 6], [255, 255, 255, 127, 255])
    assert [t for t, *_ in found] == [1, 5]
    assert device.sim.io.n_skipped == 3


def test_an_event_takes_2_clocks_and_one_can_come_every_clock(device: StreamDevice) -> None:
    run = device.run({INPUT.prefix: beats(pack_events(*np.zeros((4, 20), np.int64)))})
    assert set((run.given[OUTPUT.prefix] - run.accepted[INPUT.prefix]).tolist()) == {2}
    assert set(np.diff(run.accepted[INPUT.prefix]).tolist()) == {1}

# SPDX-License-Identifier: Apache-2.0
"""filter_mask.v: pixels that software marks as hot give no events."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.base import Stalls
from support.filter_trials import FilterDevice, FilterTraffic, check_reset_amid_events, compare_with_reference, filter_traffic
from support.testing import PATTERNS, Sink, Source, always, run_streams

FIELDS = ["tick", "event", "skip", "x", "y", "p"]


def mask_filter(width: int, height: int) -> FilterDevice:
    parameters = {"X_W": 9, "Y_W": 9, "TICK_W": 4, "WIDTH": width, "HEIGHT": height}
    return FilterDevice("filter_mask", parameters, {"enable": 1})


def mark(device: FilterDevice, x: int, y: int, hot: int = 1) -> None:
    device.set(mask_valid=1, mask_x=x, mask_y=y, mask_hot=hot)
    device.sim.clock.tick()
    device.set(mask_valid=0)


class Sensor:
    """The contract: an event stays when it lies on the sensor, on a pixel that is not marked."""

    def __init__(self, width: int, height: int) -> None:
        self.hot = np.zeros((height, width), np.bool_)

    def mark(self, x: int, y: int, hot: int) -> None:
        if y < self.hot.shape[0] and x < self.hot.shape[1]:
            self.hot[y, x] = hot

    def __call__(self, batch: FilterTraffic) -> NDArray[np.bool_]:
        height, width = self.hot.shape
        stays = (batch.x < width) & (batch.y < height)
        stays[stays] = ~self.hot[batch.y[stays], batch.x[stays]]
        return stays


def every_address(device: FilterDevice) -> FilterTraffic:
    y, x = np.divmod(np.arange(1024), 32)
    return FilterTraffic(
        np.full(1024, device.now), x.astype(np.uint16), y.astype(np.uint16), np.zeros(1024, np.uint8), np.ones(1024, np.bool_)
    )


def test_a_marked_pixel_is_silent_until_it_is_unmarked() -> None:
    device, sensor = mask_filter(21, 13), Sensor(21, 13)
    assert compare_with_reference(device, every_address(device), sensor) == 21 * 13 / 1024
    for x, y in [(3, 4), (0, 0), (20, 12), (20, 0), (0, 12), (3, 5)]:
        mark(device, x, y)
        sensor.mark(x, y, 1)
    assert compare_with_reference(device, every_address(device), sensor) == (21 * 13 - 6) / 1024
    mark(device, 3, 4, hot=0)
    sensor.mark(3, 4, 0)
    assert compare_with_reference(device, every_address(device), sensor) == (21 * 13 - 5) / 1024


@pytest.mark.parametrize(("x", "y"), [(21, 0), (20, 13), (0, 13), (32, 0), (65535, 0), (0, 32), (0, 32767)])
def test_a_mark_beyond_the_sensor_is_ignored(x: int, y: int) -> None:
    device = mask_filter(21, 13)
    mark(device, x, y)
    assert compare_with_reference(device, every_address(device), Sensor(21, 13)) == 21 * 13 / 1024


def test_hands_everything_on_when_not_enabled_and_keeps_its_marks() -> None:
    device, sensor = mask_filter(21, 13), Sensor(21, 13)
    device.set(enable=0)
    mark(device, 3, 4)
    sensor.mark(3, 4, 1)
    assert compare_with_reference(device, every_address(device), lambda batch: np.ones(1024, np.bool_)) == 1
    device.set(enable=1)
    compare_with_reference(device, every_address(device), sensor)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (21, 13), (32, 32), (346, 260)])
def test_reset_unmarks_every_pixel_one_a_clock(width: int, height: int) -> None:
    device = mask_filter(width, height)
    assert device.settled_after == width * height
    for x, y in ((0, 0), (width - 1, height - 1)):
        mark(device, x, y)
    device.sim.io.rst = 1
    device.sim.clock.tick()
    device.sim.io.rst = 0
    assert (device.sim.io.idle, device.sim.io.s_ready, device.sim.io.m_valid) == (0, 0, 0)
    mark(device, 0, 0)  # lost: all are being unmarked
    device.settle()
    traffic = filter_traffic(np.random.default_rng(41), 5000, width, height, skips=0)
    assert compare_with_reference(device, traffic, Sensor(width, height)) == 1


def test_reset_amid_events_leaves_nothing() -> None:
    check_reset_amid_events(mask_filter(7, 5))


@pytest.mark.parametrize(("width", "height"), [(1, 1), (21, 13), (32, 32), (346, 260)])
def test_random_marks_traffic_and_stalls_are_exact(width: int, height: int) -> None:
    print("seed 42")
    rng = np.random.default_rng([42, width, height])
    device, sensor, by_marks = mask_filter(width, height), Sensor(width, height), []
    for run in range(6):
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        for x, y in rng.integers(0, [width + 2, height + 2], (min(8 + width * height, 3000), 2)).tolist():
            hot = int(rng.random() < 0.7)
            mark(device, x, y, hot)
            sensor.mark(x, y, hot)
        traffic = filter_traffic(rng, 45_000, width, height, beyond=30, first_tick=device.now)
        compare_with_reference(device, traffic, sensor)
        by_marks.append(float(np.mean(Sensor(width, height)(traffic) & ~sensor(traffic))))
    assert max(by_marks) > 0.02  # events dropped for a mark and not for lying beyond


def test_a_token_every_clock_six_clocks_later() -> None:
    traffic = filter_traffic(np.random.default_rng(43), 1000, 21, 13)
    _, times = mask_filter(21, 13).stream_timed(traffic, traffic.keep)
    assert (np.diff(times.accepted) == 1).all()
    assert (times.given - times.accepted == 6).all()


@pytest.mark.parametrize("stall", PATTERNS)
def test_a_mark_counts_for_every_token_taken_in_its_clock_or_later(stall: str) -> None:
    """Each token stands on the pixel that is marked and unmarked meanwhile; for tokens inside then, either may hold."""
    rng = np.random.default_rng(44)
    sim = mask_filter(21, 13).sim
    sim.io.mask_x, sim.io.mask_y = 3, 4
    source = Source(sim, "s", FIELDS, [(0, 1, 0, 3, 4, 0)] * 600, PATTERNS[stall](rng))
    sink = Sink(sim, "m", FIELDS, PATTERNS[stall](rng))
    hot = np.zeros((2, 600), np.bool_)  # may it be hot, must it be
    marks = 0

    def mark_now_and_then(clock: int) -> None:
        nonlocal marks
        hold = clock < 3 or rng.random() < 0.9
        sim.io.mask_valid = int(not hold)
        if not hold:
            marks += 1
            sim.io.mask_hot = marks % 2
            hot[:, source.taken :] = marks % 2
            inside = slice(len(sink.words), source.taken)
            hot[0, inside] = True
            hot[1, inside] = False

    run_streams(sim, [source], [sink], on_clock=mark_now_and_then)
    dropped = np.array([word[2] for word in sink.words], np.bool_)
    assert len(dropped) == 600
    assert (dropped <= hot[0]).all()
    assert (dropped >= hot[1]).all()
    assert (~hot[0]).sum() > 50
    assert hot[1].sum() > 50


def test_a_mark_holds_the_tokens_up_for_one_clock() -> None:
    sim = mask_filter(21, 13).sim
    sink = Sink(sim, "m", FIELDS, always())

    def mark_at_ten(clock: int) -> None:
        sim.io.mask_valid = int(clock == 10)

    run_streams(sim, [Source(sim, "s", FIELDS, [(0, 1, 0, 1, 1, 0)] * 30, always())], [sink], on_clock=mark_at_ten)
    assert np.diff(sink.clocks).tolist() == [1] * 6 + [2] + [1] * 22

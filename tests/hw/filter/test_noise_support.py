# SPDX-License-Identifier: Apache-2.0
"""noise_support.v: the support of the activity filter follows the noise as the model's does."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from evcot.filters.chain import FilterChain
from evcot.filters.contract import FILTER_REGISTERS, Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot_cosim.devices.base import Stalls
from support.filter_trials import FilterDevice, compare_with_reference, filter_traffic
from support.tokens import ticked

ACTIVITY = 1 << Filter.ACTIVITY


def device_of(width: int, height: int, tick_w: int = 8, cell_stamp_w: int = 0) -> FilterDevice:
    """The activity filter, whose decisions depend on every support."""
    sizes = {"X_W": width.bit_length(), "Y_W": height.bit_length(), "WIDTH": width, "HEIGHT": height}
    fixed = {"HAS": ACTIVITY, "TICK_W": tick_w, "CELL_PX": 1, "CELL_STAMP_W": cell_stamp_w}
    return FilterDevice("filter_chain", {**fixed, **sizes})


def model_of(device: FilterDevice, registers: FilterRegisters) -> FilterChain:
    device.reset()
    for field in fields(registers):
        if field.name != "hot_pixels":
            device.write(FILTER_REGISTERS[field.name].address, getattr(registers, field.name))
    given = device.model.parameters
    return FilterChain(registers, FilterShape(given["WIDTH"], given["HEIGHT"], cell_px=1))


def registers_of(noise_log2: int, least: list[int], ticks: int = 300, shift: int = 4) -> FilterRegisters:
    return FilterRegisters(
        enable=ACTIVITY, activity_support=0, activity_ticks=ticks << shift, stamp_shift=shift, noise_log2=noise_log2,
        **{f"noise_{n}": one for n, one in zip(range(2, 7), least, strict=True)},
    )  # fmt: skip


@pytest.mark.parametrize(("width", "height", "tick_w"), [(64, 48, 8), (29, 22, 1), (8, 8, 20), (5, 3, 8), (346, 260, 32)])
def test_random_traffic_is_exact_under_stalls(width: int, height: int, tick_w: int) -> None:
    print("seed 20291")
    device, stayed, supports = device_of(width, height, tick_w), [], set()
    for run, noise_log2 in enumerate((4, 0, 9, 14, 6, 20)):
        rng = np.random.default_rng([20291, run])
        least = np.sort((2 ** rng.uniform(2, 11, 5)).astype(int)).tolist()
        model = model_of(device, registers_of(noise_log2, least))
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        pace = 2.0 ** rng.integers(-3, 3) * 2**noise_log2 / (width * height / 50 + 20)
        traffic = filter_traffic(
            rng, 3_000, width, height, ticks_per_event=min(pace, 300), longest_gap=1 << 16, beyond=1, skips=0.02
        )

        def wanted(batch, model=model):  # type: ignore[no-untyped-def]
            keep = batch.keep.copy()
            model.narrow(batch, keep)
            supports.add(model.noise.support)
            return keep

        stayed.append(compare_with_reference(device, traffic, wanted, parts=3))
    assert len(supports) > 2 or width * height <= 64
    assert 0.02 < np.mean(stayed) < 0.98


def test_the_number_of_a_window_wraps() -> None:
    device = device_of(64, 48, 20)
    model = model_of(device, registers_of(4, [50, 100, 200, 300, 400]))
    rng = np.random.default_rng(20292)
    ticks = np.sort(rng.integers(0, 16 * 5_000, 20_000))
    far = rng.random(20_000) < 0.002
    events = ticked(ticks, np.where(far, rng.integers(0, 64, 20_000), rng.integers(0, 24, 20_000)), rng.integers(0, 24, 20_000))
    assert np.array_equal(device.stream(events), model.feed(events))


def test_a_level_saturates() -> None:
    """Of six cells, in windows of one tick, five have an event of one pixel, and in every eighth tick the last has none."""
    device = device_of(29, 22, 20)
    model = model_of(device, registers_of(6, [60_000] * 5))
    ticks = np.repeat(np.arange(400), 8)
    x, y = np.tile([1, 2, 1, 10, 18, 4, 12, 20], 400), np.tile([1, 1, 2, 4, 4, 12, 12, 12], 400)
    there = (x != 20) | (ticks % 8 > 0)
    events = ticked(ticks[there], x[there], y[there])
    keep = device.stream(events)
    assert np.array_equal(keep, model.feed(events))
    assert model.noise is not None
    assert (model.noise.level, model.noise.support) == (65_535, 6)
    assert 0 < model.noise.state[7] < 256 // 4, "empty cells, on the mean"


def test_a_fixed_support_holds_and_nothing_is_measured() -> None:
    device = device_of(64, 48)
    registers = FilterRegisters(enable=ACTIVITY, activity_support=2, activity_ticks=300)
    model = model_of(device, registers)
    traffic = filter_traffic(np.random.default_rng(3), 10_000, 64, 48, skips=0)
    assert 0.02 < compare_with_reference(device, traffic, model.feed) < 0.98


class TestClocks:
    """What the headers of noise_support.v and filter_cells.v claim."""

    def test_an_event_takes_1_clock_and_comes_out_after_5_and_14(self) -> None:
        device = device_of(346, 260, 20, cell_stamp_w=24)
        model_of(device, registers_of(14, [84, 239, 454, 716, 1013]))
        traffic = filter_traffic(np.random.default_rng(1), 4_000, 346, 260, ticks_per_event=1, skips=0)
        _, times = device.stream_timed(traffic, traffic.keep)
        assert set(np.diff(times.accepted)) == {1}
        assert set(times.given - times.accepted) == {19}

    def test_the_end_of_a_window_takes_101_clocks_and_one_for_each_measured_before(self) -> None:
        device = device_of(346, 260, 20, cell_stamp_w=24)
        model_of(device, registers_of(14, [84, 239, 454, 716, 1013]))
        events = ticked(10 * np.arange(5_000), np.arange(5_000) % 346, np.arange(5_000) % 260)
        _, times = device.stream_timed(events)
        ends = np.diff(events.ticks >> 14) > 0
        waits = np.diff(times.given)
        assert ends.sum() == 3
        assert waits[ends].tolist() == [1 + 101, 1 + 102, 1 + 103]
        assert set(waits[~ends]) == {1}

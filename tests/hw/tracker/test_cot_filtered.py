# SPDX-License-Identifier: Apache-2.0
"""Filters in front of the trackers: hardware and golden model decide the same, in the camera's own numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.filters.contract import Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.hardware.motion.model import MotionModel
from evcot.tracks.log import DROPPED, Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import StreamTimes, build_device
from evcot_cosim.lockstep.random_runs import random_filters
from support import moving
from support.tokens import ticked
from support.trials import bare_device, random_config, random_traffic

SHAPE = Shape(n_slots=4, x_w=6, y_w=6, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20)
SENSOR = FilterShape(width=60, height=50, stamp_w=10, recent_depth=8)
SLOT = SlotConfig(
    init_radix=4, radix_th=2, radix_min=3, radix_max=7, hist_avg=1, max_ticks=400,
    clust_nev=2, nev_min=1, nev_max=4, nev_th=300, detect_ticks=250,
)  # fmt: skip


def enable(*filters: Filter) -> int:
    return sum(1 << which for which in filters)


@pytest.mark.parametrize(
    ("module", "enabled"),
    [
        ("cot_array", 255),
        ("cot_chain", 255),
        ("cot_array", enable(Filter.MASK, Filter.ACTIVITY)),
    ],
    ids=["array behind all", "chain behind all", "array behind two"],
)
def test_random_filters_registers_traffic_and_stalls_are_exact(module: Module, enabled: int) -> None:
    print("seed 7")
    built, kept, kinds = None, [], dict.fromkeys(Kind, 0)
    for run in range(9):
        rng = np.random.default_rng([7, run, enabled])
        config = replace(random_config(rng, SHAPE, module), filters=random_filters(rng, SENSOR, enabled), filter_shape=SENSOR)
        built = built or build_device(config, waves=False)
        device = bare_device(config, model=built, stalls=Stalls.random(rng) if run % 3 else None)
        model = CotModel(config)
        for part in range(2):
            traffic = random_traffic(rng, SHAPE, 4_000, float(rng.choice([0.3, 2])), device.now)
            hardware, golden = device.stream(traffic), model.feed(traffic)
            for field in Decisions._fields:
                same = np.array_equal(getattr(hardware, field), getattr(golden, field))
                assert same, f"run {run}, part {part}: {field} differs"
            kept.append(float((golden.owner != DROPPED).mean()))
            for kind in Kind:
                kinds[kind] += int(np.count_nonzero(golden.records["kind"] == kind))
    print(kept, kinds)
    assert min(kept) < 0.9
    assert max(kept) > 0.1  # something was taken out, and something left to track
    assert min(count for kind, count in kinds.items() if kind != Kind.MERGED or module != "cot_chain") > 20


@pytest.mark.parametrize("module", ["cot_array", "cot_chain"])
def test_clocks_with_and_without_a_waveform_are_the_same(module: Module, tmp_path: Path) -> None:
    """A waveform needs whole evaluations at both edges; without one the drive takes a shorter way."""
    rng = np.random.default_rng(8)
    config = replace(random_config(rng, SHAPE, module), filters=random_filters(rng, SENSOR, 255), filter_shape=SENSOR)
    built, traffic = build_device(config, waves=False), random_traffic(rng, SHAPE, 2_000, 0.3, 0)
    stalls = Stalls.random(rng)
    short, whole = (bare_device(config, model=built, stalls=stalls) for _ in range(2))
    decided, times = short.stream_timed(traffic)
    with whole.dumping(tmp_path / "w.vcd", 0, 10):
        again, whole_times = whole.stream_timed(traffic)
    assert len(decided.records) > 20
    assert short.cycle == whole.cycle
    for field in Decisions._fields:
        assert np.array_equal(getattr(decided, field), getattr(again, field)), field
    for field in StreamTimes._fields:
        assert np.array_equal(getattr(times, field), getattr(whole_times, field)), field


@pytest.mark.parametrize("stalls", [None, 5])
def test_with_motion(stalls: int | None) -> None:
    filters = FilterRegisters(enable=enable(Filter.REFRACTORY), refractory_ticks=200)
    sensor = FilterShape(width=128, height=64, stamp_w=12)
    config = MotionConfig(moving.SHAPE, moving.QUICK, filters=filters, filter_shape=sensor)
    events = moving.scene(1)
    golden = MotionModel(config).feed(events)
    waits = None if stalls is None else Stalls.random(np.random.default_rng(stalls))
    hardware = bare_device(config, stalls=waits).stream(events)
    for field in Decisions._fields:
        assert np.array_equal(getattr(hardware, field), getattr(golden, field)), field
    assert 0 < np.count_nonzero(golden.owner == DROPPED) < len(events)
    assert len(golden.records) > 20
    assert len(MotionModel(replace(config, filters=FilterRegisters())).feed(events).records) != len(golden.records)


@pytest.mark.parametrize("engine", ["model", "rtl"])
def test_records_carry_the_numbers_of_the_camera(engine: str) -> None:
    filters = FilterRegisters(enable=enable(Filter.POLARITY), polarity=1)
    config = replace(CotConfig.uniform(SHAPE, SLOT), filters=filters, filter_shape=SENSOR)
    events = ticked([0, 10, 20, 30, 40, 900], 20, 20, [0, 1, 0, 1, 0, 0])
    made = bare_device(config).stream(events) if engine == "rtl" else CotModel(config).feed(events)
    assert made.owner.tolist() == [DROPPED, 0, DROPPED, 0, DROPPED, DROPPED]
    assert made.records["kind"].tolist() == [Kind.BORN, Kind.LOST]
    assert made.records["seq"].tolist() == [3, 5]  # the loss comes before the event that tells of it, though that is nobody's
    assert made.records["time"].tolist() == [30, 430]


def test_a_hot_pixel_starts_no_life() -> None:
    filters = FilterRegisters(enable=enable(Filter.MASK), hot_pixels=((20, 20),))
    config = replace(CotConfig.uniform(SHAPE, SLOT), filters=filters, filter_shape=SENSOR)
    made = bare_device(config).stream(ticked(np.arange(200), [20, 21] * 100, 20))
    assert set(made.owner[::2].tolist()) == {DROPPED}
    assert set(made.owner[1::2].tolist()) == {0}


@pytest.mark.parametrize("module", ["cot_array", "cot_chain"])
def test_reset_empties_the_memories(module: Module) -> None:
    filters = FilterRegisters(enable=enable(Filter.ACTIVITY), activity_ticks=500)
    config = replace(CotConfig.uniform(SHAPE, SLOT, module=module), filters=filters, filter_shape=SENSOR)
    device = bare_device(config)
    story = ticked([0, 1], [20, 21], 20)
    first = device.stream(story).owner.tolist()
    device.reset()
    assert device.stream(story).owner.tolist() == first == [DROPPED, 0]


def test_a_single_tracker_has_no_filters_in_front() -> None:
    one = CotConfig.uniform(replace(SHAPE, n_slots=1), SLOT, module="cot")
    with pytest.raises(ConfigError, match="use cot_array with one slot"):
        replace(one, filters=FilterRegisters(enable=enable(Filter.POLARITY)), filter_shape=SENSOR)

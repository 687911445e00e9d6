# SPDX-License-Identifier: Apache-2.0
"""filter_chain.v: eight filters in a row decide what the software's chain decides, whichever are enabled or built."""

from __future__ import annotations

import re
from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.chain import FilterChain
from evcot.filters.contract import FILTER_REGISTERS, Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot_cosim.devices.base import Stalls
from evcot_cosim.rtl.files import rtl_files
from support.filter_trials import FilterDevice, FilterTraffic, compare_with_reference, filter_traffic
from support.tokens import ticked

ALL = (1 << len(Filter)) - 1
SHAPE = FilterShape(width=29, height=22, stamp_w=10, recent_depth=12)


def chain(has: int = ALL, shape: FilterShape = SHAPE) -> FilterDevice:
    sizes = {"WIDTH": shape.width, "HEIGHT": shape.height, "STAMP_W": shape.stamp_w, "RECENT_DEPTH": shape.recent_depth}
    sizes |= {"CELL_PX": shape.cell_px}
    return FilterDevice("filter_chain", {"HAS": has, "X_W": 5, "Y_W": 5, "TICK_W": 8, **sizes})


def latency(module: str) -> int:
    """What the header of a module says."""
    found = re.search(r"Latency:.*?(\d+) clocks? from s_ to m_", rtl_files()[f"{module}.v"].read_text())
    assert found
    return int(found[1])


def write(device: FilterDevice, registers: FilterRegisters) -> None:
    for field in fields(registers):
        if field.name != "hot_pixels":
            device.write(FILTER_REGISTERS[field.name].address, getattr(registers, field.name))
    for x, y in registers.hot_pixels:
        device.write(FILTER_REGISTERS["mask"].address, 1 << 31 | y << 16 | x)


def random_registers(rng: np.random.Generator, enable: int) -> FilterRegisters:
    """Registers under which each filter lets a good part stay: many are in the row."""
    return FilterRegisters(
        enable=enable,
        region_x0=int(rng.integers(0, 3)),
        region_x1=int(rng.integers(26, 40)),
        region_y0=int(rng.integers(0, 3)),
        region_y1=int(rng.integers(19, 40)),
        polarity=int(rng.integers(2)),
        refractory_ticks=int(2 ** rng.uniform(0, 6)),
        activity_ticks=int(2 ** rng.uniform(4, 8.9)),
        activity_support=int(rng.integers(1, 3)),
        recent_ticks=int(2 ** rng.uniform(4, 8.9)),
        recent_radius=int(rng.integers(2, 12)),
        recent_support=int(rng.integers(1, 4)),
        decay_rate=int(2 ** rng.uniform(16, 22)),
        decay_epsilon=int(rng.integers(0, 40)),
        decay_support=int(rng.integers(1, 300)),
        rowcol_ticks=int(2 ** rng.uniform(4, 8.9)),
        rowcol_radius=int(rng.integers(1, 12)),
        rowcol_support=int(rng.integers(1, 4)),
        hot_pixels=tuple(zip(rng.integers(0, 29, 40).tolist(), rng.integers(0, 22, 40).tolist(), strict=True)),
    )


def agrees(
    device: FilterDevice, registers: FilterRegisters, rng: np.random.Generator, n: int, shape: FilterShape = SHAPE
) -> float:
    """Streams random traffic from reset through hardware and software alike; returns which part stays."""
    device.reset()
    write(device, registers)
    golden = FilterChain(registers, shape)

    def wanted(batch: FilterTraffic) -> NDArray[np.bool_]:
        keep = batch.keep.copy()
        golden.narrow(batch, keep)
        return keep

    parts = [
        filter_traffic(rng, n // 2, 29, 22, ticks_per_event=pace, longest_gap=5000, beyond=3, first_tick=start)
        for pace, start in ((0.3, 0), (3, 10 * n))
    ]
    return float(np.mean([compare_with_reference(device, part, wanted) for part in parts]))


@pytest.fixture(scope="module")
def device() -> FilterDevice:
    return chain()


def test_every_choice_of_filters_is_exact(device: FilterDevice) -> None:
    print("seed 71")
    kept = []
    for enable in range(ALL + 1):
        rng = np.random.default_rng([71, enable])
        device.stall(Stalls.random(rng) if enable % 3 == 1 else Stalls())
        kept.append(agrees(device, random_registers(rng, enable), rng, 500))
    assert kept[0] > 0.94  # but for those that came in dropped
    assert all(kept[1 << which] < kept[0] for which in Filter)
    assert min(kept) < 0.05
    assert np.median(kept) > 0.1


def test_all_filters_together_are_exact(device: FilterDevice) -> None:
    print("seed 72")
    kept = []
    for run in range(6):
        rng = np.random.default_rng([72, run])
        device.stall(Stalls.random(rng) if run % 3 == 1 else Stalls())
        lenient = replace(
            random_registers(rng, ALL),
            activity_support=1,
            recent_support=1,
            decay_support=int(rng.integers(1, 60)),
            rowcol_support=1,
        )
        kept.append(agrees(device, lenient, rng, 12_000))
    assert np.median(kept) > 0.05


@pytest.mark.parametrize("has", [0b01010101, 0b10101010, 0b10100100])
def test_filters_that_are_not_built_hand_everything_on(has: int) -> None:
    print("seed 73")
    rng = np.random.default_rng([73, has])
    device = chain(has)
    registers = random_registers(rng, ALL)
    device.reset()
    write(device, registers)
    golden = FilterChain(replace(registers, enable=has), SHAPE)
    traffic = filter_traffic(rng, 20_000, 29, 22, ticks_per_event=3, longest_gap=5000, beyond=3, skips=0)
    kept = compare_with_reference(device, traffic, golden.feed)
    assert kept < 1
    assert kept > 0.01


@pytest.mark.parametrize("has", [ALL, 0b01010101, 0b10101010, 0b10100100])
def test_a_token_every_clock_after_the_latencies_of_all_that_are_built(has: int) -> None:
    device = chain(has)
    write(device, FilterRegisters(enable=ALL))
    traffic = filter_traffic(np.random.default_rng(74), 2000, 29, 22, ticks_per_event=0)  # no time passes: no walk
    _, times = device.stream_timed(traffic, traffic.keep)
    assert (np.diff(times.accepted) == 1).all()
    clocks = sum(latency(f"filter_{which.name.lower()}") for which in Filter if has >> which & 1)
    assert (times.given - times.accepted == clocks).all()
    assert has != ALL or clocks == latency("filter_chain")


@pytest.mark.parametrize(("side", "has"), [(1, ALL), (2, ALL), (4, ALL), (2, 0b01010010), (4, 0b00001000)])
def test_with_cells_refractory_and_activity_are_one_and_decide_the_same(side: int, has: int) -> None:
    print("seed 76")
    shape = replace(SHAPE, cell_px=side)
    device, kept = chain(has, shape), []
    for run in range(4):
        rng = np.random.default_rng([76, side, has, run])
        device.stall(Stalls.random(rng) if run % 2 else Stalls())
        enable = has if run % 2 else has & int(rng.integers(ALL + 1))
        shift = {1: 0, 2: 2, 4: 4}[side]
        registers = replace(
            random_registers(rng, enable), refractory_ticks=int(rng.integers(1, 20)) << shift, stamp_shift=shift,
            activity_ticks=int(rng.integers(6, 24)) << shift, recent_support=1, decay_support=int(rng.integers(1, 60)),
        )  # fmt: skip
        kept.append(agrees(device, registers, rng, 4000, shape))
    assert 0 < np.median(kept) < 0.97


def test_a_row_of_none_is_a_wire() -> None:
    device = chain(0)
    device.set(s_valid=1, s_event=1, s_x=17, m_ready=0)
    assert (device.sim.io.m_valid, device.sim.io.m_event, device.sim.io.m_x, device.sim.io.s_ready) == (1, 1, 17, 0)
    device.set(m_ready=1)
    assert (device.sim.io.s_ready, device.sim.io.idle) == (1, 1)


def test_registers_written_between_runs_count_from_then_on(device: FilterDevice) -> None:
    """Disabled and enabled again, a filter remembers what it saw before."""
    device.stall(Stalls())
    device.reset()
    write(device, FilterRegisters(enable=1 << Filter.ACTIVITY, activity_ticks=100))

    def stays(tick: int, x: int, p: int = 0) -> bool:
        return bool(device.stream(ticked(tick, x, 10, p))[0])

    assert not stays(0, 10)
    assert stays(10, 11)
    write(device, FilterRegisters(enable=1 << Filter.POLARITY, activity_ticks=100))
    assert not stays(20, 20)
    assert stays(30, 20, 1)
    write(device, FilterRegisters(enable=1 << Filter.ACTIVITY, activity_ticks=100))
    assert stays(60, 10)
    assert not stays(70, 21)  # the one at 20 never reached the filter
    write(device, FilterRegisters(enable=1 << Filter.ACTIVITY, activity_ticks=20))
    assert not stays(100, 20)  # at its neighbour 21 the last event is 30 ticks ago


def test_reset_disables_all_filters_and_empties_their_memories(device: FilterDevice) -> None:
    print("seed 75")
    rng = np.random.default_rng(75)
    registers = replace(random_registers(rng, ALL), recent_support=1, decay_support=1, rowcol_support=1)
    agrees(device, registers, rng, 2000)
    device.reset()
    assert device.settled_after >= 29 * 22  # the longest walks: a pixel a clock
    traffic = filter_traffic(rng, 2000, 29, 22, skips=0)
    assert compare_with_reference(device, traffic, lambda batch: np.ones(2000, np.bool_)) == 1
    agrees(device, replace(registers, hot_pixels=()), rng, 2000)  # as one that never held an event


def test_idle_is_low_while_a_mark_is_under_way(device: FilterDevice) -> None:
    device.reset()
    assert device.sim.io.idle == 1
    write(device, FilterRegisters(hot_pixels=((3, 4),)))
    assert device.sim.io.idle == 0
    assert device.settle() == 3

# SPDX-License-Identifier: Apache-2.0
"""Nothing depends on the values that registers have before the first reset: `evcot_top` with every filter and tracker.

Icarus begins with X everywhere, Verilator with random values; both must give what the golden model decides. The program:
slots are committed but no filter, events, one more commit, which waits until nothing is under way, a soft reset, everything is
committed, events.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.filters.contract import Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import RECORD, Shape
from evcot.hardware.golden import golden_model
from evcot.hardware.modules import Module
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RECORD, MotionRegisters
from evcot.hardware.registers import register_map
from evcot.hardware.streams import pack_events
from evcot.ticks import TickedEvents
from evcot.tracks.log import DROPPED
from evcot_cosim.devices.base import reset
from evcot_cosim.devices.published_device import Top, rtl, simulation
from evcot_cosim.devices.top_device import (
    Command,
    TopDevice,
    address_of,
    bank_address,
    configuration,
    poll,
    slot_address,
    write,
)
from evcot_cosim.fpga.serial_host import levels, request
from evcot_cosim.fpga.sources import closure
from evcot_cosim.rtl.files import rtl_files
from support import four_state
from support.four_state import needs_icarus, replay
from support.testing import broken_copy
from support.top import EVERY
from support.trials import random_traffic

WIDTH, HEIGHT = 20, 16
SHAPE = Shape(n_slots=2, x_w=5, y_w=5, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=32, time_w=32)
SENSOR = FilterShape(width=WIDTH, height=HEIGHT, stamp_w=10, recent_depth=4)
FILTERS = FilterRegisters(
    region_x0=1, region_x1=18, polarity=1, refractory_ticks=3, activity_ticks=40, recent_ticks=60, recent_radius=3,
    decay_rate=1 << 22, decay_epsilon=4, decay_support=40, rowcol_ticks=90, rowcol_radius=3, stamp_shift=1,
    hot_pixels=((5, 5), (9, 7), (0, 0)),
)  # fmt: skip
LIVELY = MotionRegisters(
    step_log2=5, birth_support=2, birth_px=0, birth_ticks=0, birth_travel=8, nev_low=1, nev_high=2, seed_px=2,
    side_max=8, detect_ticks=2_000, life_ticks=2_000, coast_ticks=4_000, gap_corrections=1, join_steps=1, report_steps=1,
)  # fmt: skip
STATUS, CONTROL = address_of("status"), address_of("control")
WRITE = write(STATUS, 0)[1]
SOFT_RESET = write(CONTROL, 1 << 9)
EVENTS, QUIET = 150, 2_000
# Every second filter, the others and all, with each size of a memory's cells; the other trackers without filters.
BUILDS = [("cot_array", 0x55, 1), ("cot_array", 0xAA, 2), ("cot_array", 0xFF, 0), ("cot_array", 0xFF, 4),
          ("cot_chain", 0, 0), ("cot_motion", 0, 0)]  # fmt: skip
EVERY_BUILD = pytest.mark.parametrize(("module", "has", "cell_px"), BUILDS)


class Part(NamedTuple):
    """A part of the program: accesses to the registers, then events under this configuration, from reset; None: no events."""

    accesses: list[Command]
    config: CotConfig | MotionConfig
    traffic: TickedEvents | None

    @property
    def words(self) -> NDArray[np.uint64]:
        """The input words of the events."""
        if self.traffic is None:
            return np.zeros(0, np.uint64)
        return pack_events(self.traffic.ticks, self.traffic.x, self.traffic.y, self.traffic.p)


def events_of(module: Module) -> int:
    """Of each part: cot_motion's jobs take effect 64 events later."""
    return 6 * EVENTS if module == "cot_motion" else EVENTS


def case(module: Module, has: int, cell_px: int = 0) -> tuple[CotConfig | MotionConfig, list[Part]]:
    """The shapes, and the program."""
    motion = module == "cot_motion"
    config = MotionConfig(SHAPE, LIVELY) if motion else CotConfig.uniform(SHAPE, EVERY, module=module)
    filters = replace(FILTERS, enable=has, hot_pixels=FILTERS.hot_pixels if has >> Filter.MASK & 1 else ())
    sensor = replace(SENSOR, cell_px=cell_px)
    whole = replace(config, filters=filters, filter_shape=sensor) if has else config
    enable = [poll(STATUS, 2, 0), write(CONTROL, 1)]
    rng = np.random.default_rng([60, has])
    banks = [bank_address(bank) for bank in MOTION_BANKS] if motion else []
    again = [*(write(address, 1) for address in (slot_address(0), *banks)), poll(STATUS, 2, 0), SOFT_RESET]
    first = random_traffic(rng, SHAPE, events_of(module), 1.5, 0)
    second = random_traffic(rng, SHAPE, events_of(module), 1.5, int(first.ticks[-1]) + 1)
    parts = [
        Part([*configuration(config), *enable], config, on_sensor(first)),
        Part(again, config, None),
        Part([*configuration(whole), *enable], whole, on_sensor(second)),
    ]
    return replace(config, filter_shape=sensor), parts


def on_sensor(traffic: TickedEvents) -> TickedEvents:
    return replace(traffic, x=traffic.x % WIDTH, y=traffic.y % HEIGHT)


def word(stream: str, **values: int) -> int:
    """A word of a stream, as the register map lays it out."""
    (layout,) = (found for found in register_map().streams if found.name == stream)
    assert {field.name for field in layout.fields} == set(values)
    return sum(int(values[field.name]) << field.lsb for field in layout.fields)


@functools.cache
def expected(module: Module, has: int, cell_px: int = 0) -> four_state.Beats:
    """What the model decides, as the hardware says it."""
    found = four_state.Beats(np.zeros(0, MOTION_RECORD if module == "cot_motion" else RECORD), [], [], [], [])
    for part in case(module, has, cell_px)[1]:
        found.responses.extend(0 for access in part.accesses if access[1] == WRITE)
        if part.traffic is None:
            continue
        events = replace(part.traffic, ticks=part.traffic.ticks - part.traffic.ticks[0])
        decided = golden_model(part.config).feed(events)
        found = found._replace(records=np.concatenate([found.records, decided.records]))
        for seq, (p, owner) in enumerate(zip(events.p.tolist(), decided.owner.tolist(), strict=True)):
            if owner >= 0:
                found.owned.append(word("owned", x=decided.rel_x[seq], y=decided.rel_y[seq], slot=owner, p=p, seq=seq))
                found.user.append(owner)
            elif owner != DROPPED:
                found.passed.append(word("passed", x=events.x[seq], y=events.y[seq], p=p, seq=seq))
    return found


def in_verilator(module: Module, has: int, seed: int, cell_px: int = 0) -> four_state.Beats:
    config, parts = case(module, has, cell_px)
    device = TopDevice(config, {"HAS": has, "FIFO_DEPTH": 8, "RECORD_DEPTH": 2}, initial_seed=seed)
    device.sim.io.aer_req = 1  # no request
    reset(device.sim, 4)
    runs = [device.run(part.words, part.accesses, quiet_clocks=QUIET) for part in parts]
    responses = [int(command["response"]) for run in runs for command in run.commands if command["op"] == WRITE]
    return four_state.Beats(
        np.concatenate([run.records for run in runs]),
        [int(word) for run in runs for word in run.owned],
        [int(user) for run in runs for user in run.user],
        [int(word) for run in runs for word in run.passed],
        responses,
    )


def in_icarus(folder: Path, module: Module, has: int, seed: int, cell_px: int = 0) -> four_state.Beats:
    _, parts = case(module, has, cell_px)
    program = [four_state.reset()]
    for part in parts:
        program += [*four_state.commands(part.accesses), *four_state.words(part.words), four_state.quiet(QUIET)]
    tracker = register_map().trackers.index(module.removeprefix("cot_"))
    given = {"TRACKER": tracker, "HAS": has, "WIDTH": WIDTH, "HEIGHT": HEIGHT, "CELL_PX": cell_px}
    return four_state.play_top(folder, program, given, seed, MOTION_RECORD if module == "cot_motion" else RECORD)


def same(found: four_state.Beats, wanted: four_state.Beats, module: Module) -> None:
    """Equal; of a chain, the order between its trackers depends on the stalls."""
    for name, *both in zip(wanted._fields, found, wanted, strict=True):
        one, other = (sorted(map(repr, list(beats))) if module == "cot_chain" else list(beats) for beats in both)
        assert len(one) == len(other), name
        assert one == other, name


@EVERY_BUILD
def test_the_program_uses_what_is_built(module: Module, has: int, cell_px: int) -> None:
    wanted = expected(module, has, cell_px)
    assert len(wanted.records) > 60
    assert len(wanted.owned) > 60
    decided = len(wanted.owned) + len(wanted.passed)
    assert decided == 2 * events_of(module) if not has else EVENTS < decided < 2 * EVENTS


@needs_icarus
@EVERY_BUILD
def test_four_states(tmp_path: Path, module: Module, has: int, cell_px: int) -> None:
    same(in_icarus(tmp_path, module, has, 1 + has + cell_px, cell_px), expected(module, has, cell_px), module)


@pytest.mark.parametrize(("module", "has", "cell_px"), BUILDS[3:])
def test_random_initial_values(module: Module, has: int, cell_px: int) -> None:
    for seed in range(1, 4):
        same(in_verilator(module, has, seed, cell_px), expected(module, has, cell_px), module)


@needs_icarus
def test_a_filter_whose_clock_has_no_reset_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = broken_copy(tmp_path / "verilog", "filter_regs.v", "decay_rate <= 25'd0;", "")
    monkeypatch.setenv("EVCOT_VERILOG", str(broken))
    with pytest.raises(AssertionError, match=r"X at|STUCK"):
        in_icarus(tmp_path, "cot_array", 1 << Filter.DECAY, 1)


# Modules that are not within `evcot_top`: nothing depends on the values that registers have before the first reset.
#
# As in test_initial_values.py, in Icarus from X and in Verilator from random values; cot_published_chain and classifier
# have tests of their own.

DIVISOR, CLOCKS = 4, 1_500


def ports(**widths: str) -> np.dtype[np.void]:
    return np.dtype(list(widths.items()))


AER_OUT = Top(
    "aer_out", (("SLOT_W", 3),),
    ports(rst="u1", active_low="u1", s_valid="u1", s_kind="u1", s_slot="u1", s_x="u2", s_y="u2", s_p="u1", aer_ack="u1"),
    ports(s_ready="u1", aer_req="u1", aer_data="u4", idle="u1"),
)  # fmt: skip
UART_HOST = Top(
    "uart_host", (("DIVISOR", DIVISOR), ("TIMEOUT", 20), ("ADDR_W", 16)),
    ports(
        rst="u1", rx="u1", m_axil_awready="u1", m_axil_wready="u1", m_axil_bvalid="u1", m_axil_bresp="u1", m_axil_arready="u1",
        m_axil_rvalid="u1", m_axil_rdata="u4", m_axil_rresp="u1", s_axis_tvalid="u1", s_axis_tdata="u4", s_axis_tkeep="u1",
        s_axis_tlast="u1",
    ),
    ports(
        tx="u1", m_axil_awvalid="u1", m_axil_awaddr="u2", m_axil_wvalid="u1", m_axil_wdata="u4", m_axil_bready="u1",
        m_axil_arvalid="u1", m_axil_araddr="u2", m_axil_rready="u1", s_axis_tready="u1",
    ),
)  # fmt: skip
HOUGH_LINES = Top(
    "hough_lines", (("WIDTH", 8), ("HEIGHT", 6), ("TICK_W", 1)),
    ports(
        rst="u1", leak_log2="u1", s_valid="u1", s_tick="u1", s_event="u1", s_skip="u1", s_x="u2", s_y="u2", s_p="u1",
        m_ready="u1",
    ),
    ports(
        s_ready="u1", m_valid="u1", m_tick="u1", m_event="u1", m_skip="u1", m_angle="u1", m_rho="u1", m_x="u2", m_y="u2",
        m_p="u1", idle="u1",
    ),
)  # fmt: skip
VALID_WITH = {
    **{f"m_{name}": "m_valid" for name in ("tick", "event", "skip", "angle", "rho", "x", "y", "p")},
    "aer_data": "aer_req", "m_axil_awaddr": "m_axil_awvalid", "m_axil_wdata": "m_axil_wvalid",
    "m_axil_araddr": "m_axil_arvalid",
}  # fmt: skip
TOPS = pytest.mark.parametrize("top", [AER_OUT, UART_HOST, HOUGH_LINES], ids=lambda top: top.module)


def from_power_on(top: Top) -> NDArray[np.void]:
    """Random inputs of the ports' widths, each held for some clocks, after a reset of two."""
    rng = np.random.default_rng(70)
    rows = np.zeros(CLOCKS, top.given)
    widths = {"s_kind": 2, "s_slot": 3, "s_x": 9, "s_y": 9, "m_axil_bresp": 2, "m_axil_rresp": 2, "s_axis_tkeep": 4}
    for name, (kind, *_) in (top.given.fields or {}).items():
        width = widths.get(name, 1 if kind.itemsize == 1 else 8 * kind.itemsize)
        values = rng.integers(0, 1 << width, CLOCKS, np.uint64)
        rows[name] = values[np.maximum.accumulate(np.where(rng.random(CLOCKS) < 0.3, np.arange(CLOCKS), 0))]
    rows["rst"] = 0
    rows["rst"][:2] = 1
    if top is AER_OUT:
        rows["active_low"] = 0
    elif top is HOUGH_LINES:
        rows["leak_log2"] = 5
        rows["s_x"] %= 8
        rows["s_y"] %= 8
    else:
        asked = [request("W", 8, 0x12345678), request("R", 12), request("W", 16, 1), request("R", 8)]
        line = levels(b"".join(asked), DIVISOR, idle=3)[: CLOCKS - 10]
        rows["rx"] = 1
        rows["rx"][10 : 10 + len(line)] = line
    return rows


def meant(top: Top, row: Iterable[int]) -> dict[str, int]:
    """Outputs that mean something at one clock."""
    values = dict(zip(top.read.names or (), map(int, row), strict=True))
    return {name: value for name, value in values.items() if values.get(VALID_WITH.get(name, ""), 1)}


def test_every_module_is_within_one_that_is_tested() -> None:
    tops = ["evcot_top", "cot_published_chain", "classifier", AER_OUT.module, UART_HOST.module, HOUGH_LINES.module]
    modules = {path.stem for path in rtl_files().values() if path.suffix == ".v"}
    assert modules == {*closure(tops), "async_fifo"}, "async_fifo has two clocks, and a test of its own in Icarus"


@needs_icarus
@TOPS
def test_initial_values_outside_four_states(tmp_path: Path, top: Top) -> None:
    inputs = from_power_on(top)
    expected = rtl(top, inputs)
    assert len(np.unique(expected)) > 30
    found = replay(tmp_path, top.module, dict(top.parameters), inputs, top.read)
    for clock, (told, row) in enumerate(zip(found, expected, strict=True)):
        for name, value in meant(top, row).items() if clock > 0 else ():
            assert set(told[name]) <= set("01"), (clock, name, told[name])
            assert int(told[name], 2) == value, (clock, name)


@TOPS
@pytest.mark.parametrize("seed", [1, 2])
def test_initial_values_outside_random_initial_values(top: Top, seed: int) -> None:
    inputs = from_power_on(top)
    for clock, rows in enumerate(zip(rtl(top, inputs, simulation(top, seed)), rtl(top, inputs), strict=True)):
        found, expected = (meant(top, row) for row in rows)
        assert clock == 0 or found == expected, clock

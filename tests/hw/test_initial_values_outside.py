# SPDX-License-Identifier: Apache-2.0
"""Modules that are not within `evcot_top`: nothing depends on the values that registers have before the first reset.

As in test_initial_values.py, in Icarus from X and in Verilator from random values; cot_published_chain has tests of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.clocked import Top, rtl, simulation
from evcot_cosim.fpga.sources import closure
from evcot_cosim.fpga.uart_line import levels, request
from evcot_cosim.rtl.files import rtl_files
from support.four_state import needs_icarus, replay

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
VALID_WITH = {
    "aer_data": "aer_req", "m_axil_awaddr": "m_axil_awvalid", "m_axil_wdata": "m_axil_wvalid", "m_axil_araddr": "m_axil_arvalid"
}  # fmt: skip
TOPS = pytest.mark.parametrize("top", [AER_OUT, UART_HOST], ids=lambda top: top.module)


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
    tops = ["evcot_top", "cot_published_chain", AER_OUT.module, UART_HOST.module]
    modules = {path.stem for path in rtl_files().values() if path.suffix == ".v"}
    assert modules == {*closure(tops), "async_fifo"}, "async_fifo has two clocks, and a test of its own in Icarus"


@needs_icarus
@TOPS
def test_four_states(tmp_path: Path, top: Top) -> None:
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
def test_random_initial_values(top: Top, seed: int) -> None:
    inputs = from_power_on(top)
    for clock, rows in enumerate(zip(rtl(top, inputs, simulation(top, seed)), rtl(top, inputs), strict=True)):
        found, expected = (meant(top, row) for row in rows)
        assert clock == 0 or found == expected, clock

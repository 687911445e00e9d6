# SPDX-License-Identifier: Apache-2.0
"""The five channels of AXI4-Lite become one access at a time."""

from __future__ import annotations

import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint


class Slave:
    """The slave, with someone behind it who answers after a few clocks and notes what it was asked."""

    def __init__(self, answers_after: int = 1) -> None:
        self.sim: PyVerilator = load("axi_lite_slave", {"ADDR_W": 8})
        reset(self.sim)
        self.answers_after = answers_after
        self.waited = 0
        self.asked: list[tuple[str, int]] = []
        self.given: list[tuple[str, int]] = []

    def clocks(self, n: int, **inputs: int) -> None:
        """Clocks with these inputs; an address or a word on offer is taken back when it has been taken."""
        io = self.sim.io
        for port, value in inputs.items():
            io[port] = value
        for _ in range(n):
            answers = bool(io.request_valid) and self.waited >= self.answers_after
            io.answer, io.answer_data, io.answer_error = int(answers), 0x100 + int(io.request_word), int(io.request_word) == 7
            if answers:
                self.asked.append(("write" if io.request_write else "read", int(io.request_word)))
            self.waited = 0 if answers else self.waited + int(io.request_valid)
            taken = [channel for channel in ("aw", "w", "ar") if io[f"s_axil_{channel}valid"] and io[f"s_axil_{channel}ready"]]
            if io.s_axil_bvalid and io.s_axil_bready:
                self.given.append(("b", int(io.s_axil_bresp)))
            if io.s_axil_rvalid and io.s_axil_rready:
                self.given.append(("r", int(io.s_axil_rdata) << 2 | int(io.s_axil_rresp)))
            self.sim.clock.tick()
            for channel in taken:
                io[f"s_axil_{channel}valid"] = 0


READY = {"s_axil_bready": 1, "s_axil_rready": 1}


def test_address_and_data_of_a_write_come_in_any_order() -> None:
    for first, second in ((("aw", {"s_axil_awaddr": 20}), ("w", {})), (("w", {}), ("aw", {"s_axil_awaddr": 20}))):
        slave = Slave()
        slave.clocks(6, s_axil_wdata=0x1234, s_axil_wstrb=5, **{f"s_axil_{first[0]}valid": 1}, **first[1], **READY)
        assert slave.asked == []
        slave.clocks(6, **{f"s_axil_{second[0]}valid": 1}, **second[1])
        assert (slave.asked, slave.given) == ([("write", 5)], [("b", 0)])
        assert (slave.sim.io.request_data, slave.sim.io.request_strb) == (0x1234, 5)


def test_an_error_is_slverr_and_a_read_brings_its_word() -> None:
    slave = Slave()
    slave.clocks(6, s_axil_arvalid=1, s_axil_araddr=4 * 7, **READY)
    slave.clocks(6, s_axil_arvalid=1, s_axil_araddr=4 * 9 + 3)
    slave.clocks(6, s_axil_awvalid=1, s_axil_awaddr=4 * 7, s_axil_wvalid=1)
    assert slave.given == [("r", 0x107 << 2 | 2), ("r", 0x109 << 2), ("b", 2)]


def test_reads_and_writes_that_wait_take_turns() -> None:
    slave = Slave(answers_after=0)
    for _ in range(12):
        slave.clocks(1, s_axil_arvalid=1, s_axil_araddr=4, s_axil_awvalid=1, s_axil_awaddr=8, s_axil_wvalid=1, **READY)
    assert slave.asked[:4] in ([("read", 1), ("write", 2)] * 2, [("write", 2), ("read", 1)] * 2)


def test_a_response_waits_and_holds_up_its_own_kind_alone() -> None:
    slave = Slave()
    slave.clocks(8, s_axil_awvalid=1, s_axil_awaddr=8, s_axil_wvalid=1, s_axil_rready=1)
    assert slave.sim.io.s_axil_bvalid == 1
    slave.clocks(8, s_axil_awvalid=1, s_axil_awaddr=12, s_axil_wvalid=1, s_axil_arvalid=1, s_axil_araddr=16)
    assert slave.asked == [("write", 2), ("read", 4)]
    slave.clocks(8, s_axil_bready=1)
    assert slave.asked[2:] == [("write", 3)]
    assert slave.given == [("r", 0x104 << 2), ("b", 0), ("b", 0)]


def test_a_word_that_was_read_waits_and_holds_up_its_own_kind_alone() -> None:
    slave = Slave()
    slave.clocks(8, s_axil_arvalid=1, s_axil_araddr=8, s_axil_bready=1)
    assert slave.sim.io.s_axil_rvalid == 1
    slave.clocks(8, s_axil_arvalid=1, s_axil_araddr=12, s_axil_awvalid=1, s_axil_awaddr=16, s_axil_wvalid=1)
    assert slave.asked == [("read", 2), ("write", 4)]
    slave.clocks(8, s_axil_rready=1)
    assert slave.asked[2:] == [("read", 3)]
    assert slave.given == [("b", 0), ("r", 0x102 << 2), ("r", 0x103 << 2)]


def test_an_access_stands_until_answered() -> None:
    slave = Slave(answers_after=50)
    slave.clocks(40, s_axil_arvalid=1, s_axil_araddr=8, **READY)
    assert (slave.sim.io.request_valid, slave.sim.io.request_word, slave.asked) == (1, 2, [])
    slave.clocks(20)
    assert slave.asked == [("read", 2)]


def test_refuses_an_address_too_narrow() -> None:
    assert "ADDR_W_must_be_at_least_3" in lint("axi_lite_slave", ADDR_W=2)[1]


@pytest.mark.parametrize("width", [3, 32])
def test_is_clean_at_any_width(width: int) -> None:
    assert lint("axi_lite_slave", ADDR_W=width) == (0, "")

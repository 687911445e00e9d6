# SPDX-License-Identifier: Apache-2.0
"""evcot_top as an Amaranth component: the ports of the Verilog module, in the clock domain `sync`.

    m.submodules.evcot = evcot = Evcot(N=8, WIDTH=346, HEIGHT=260)

Written for Amaranth 0.5. Give the release's evcot.v to the platform: platform.add_file("evcot.v", open("evcot.v")).
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import ClockSignal, Instance, Module, ResetSignal
from amaranth.lib.wiring import Component, In, Out

__all__ = ["Evcot"]

_BUS = {
    "awvalid": In(1), "awready": Out(1), "awaddr": In(14), "awprot": In(3), "wvalid": In(1), "wready": Out(1), "wdata": In(32),
    "wstrb": In(4), "bvalid": Out(1), "bready": In(1), "bresp": Out(2), "arvalid": In(1), "arready": Out(1), "araddr": In(14),
    "arprot": In(3), "rvalid": Out(1), "rready": In(1), "rdata": Out(32), "rresp": Out(2),
}  # fmt: skip


def _stream(width: int, flow: Any, back: Any) -> dict[str, Any]:
    return {"tvalid": flow(1), "tready": back(1), "tdata": flow(width), "tkeep": flow(width // 8), "tlast": flow(1)}


class Evcot(Component):
    """The tracker: its parameters by name, as in evcot_top.v."""

    def __init__(self, N: int = 8, X_W: int = 9, Y_W: int = 9, DATA_W: int = 64, **parameters: int) -> None:
        self._parameters = {"N": N, "X_W": X_W, "Y_W": Y_W, "DATA_W": DATA_W, **parameters}
        ports = {f"s_axil_{name}": member for name, member in _BUS.items()}
        ports |= {f"s_axis_{name}": member for name, member in _stream(64, In, Out).items()}
        ports |= {f"m_axis_records_{name}": member for name, member in _stream(DATA_W, Out, In).items()}
        ports |= {f"m_axis_owned_{name}": member for name, member in _stream(64, Out, In).items()}
        ports |= {f"m_axis_passed_{name}": member for name, member in _stream(64, Out, In).items()}
        ports |= {"m_axis_owned_tuser": Out(max(1, (N - 1).bit_length())), "irq": Out(1)}
        ports |= {"aer_req": In(1, init=1), "aer_ack": Out(1), "aer_row": In(1), "aer_data": In(X_W + Y_W + 1)}
        super().__init__(ports)

    def elaborate(self, platform: Any) -> Module:
        """The instance with every port connected."""
        m = Module()
        connected = {
            f"{'i' if member.flow is In else 'o'}_{name}": getattr(self, name)
            for name, member in self.signature.members.items()
        }
        chosen = {f"p_{name}": value for name, value in self._parameters.items()}
        m.submodules.evcot = Instance("evcot_top", **chosen, i_clk=ClockSignal(), i_rst=ResetSignal(), **connected)
        return m

# SPDX-License-Identifier: Apache-2.0
"""evcot_top in a LiteX system: registers on AXI4-Lite, events in and records out as streams, an interrupt.

    self.evcot = Evcot(platform, "evcot.v", N=8, WIDTH=346, HEIGHT=260)
    self.bus.add_slave("evcot", self.evcot.bus, SoCRegion(origin=0x9000_0000, size=1 << 14, cached=False))

Written for LiteX 2024.12. `source_file` is the release's evcot.v.
"""

from __future__ import annotations

from typing import Any

from litex.gen import LiteXModule
from litex.soc.interconnect import axi, stream
from migen import ClockSignal, Instance, ResetSignal, Signal

__all__ = ["Evcot"]


class Evcot(LiteXModule):
    """The tracker: its parameters by name, as in evcot_top.v; owned and passed events are accepted and dropped."""

    def __init__(self, platform: Any, source_file: str, **parameters: int) -> None:
        self.bus = bus = axi.AXILiteInterface(data_width=32, address_width=14)
        self.events = events = stream.Endpoint([("data", 64)])  # an event a word: docs/registers.md
        self.records = records = stream.Endpoint([("data", 64)])  # six words a record
        self.irq = Signal()

        ports: dict[str, Any] = {}
        for channel, fields, to in (("aw", ("addr",), "i"), ("w", ("data", "strb"), "i"), ("b", ("resp",), "o"),
                                    ("ar", ("addr",), "i"), ("r", ("data", "resp"), "o")):  # fmt: skip
            end = getattr(bus, channel)
            ports[f"{to}_s_axil_{channel}valid"] = end.valid
            ports[f"{'o' if to == 'i' else 'i'}_s_axil_{channel}ready"] = end.ready
            for name in fields:
                ports[f"{to}_s_axil_{channel}{name}"] = getattr(end, name)
        self.specials += Instance(
            "evcot_top",
            **{f"p_{name}": value for name, value in parameters.items()},
            i_clk=ClockSignal(), i_rst=ResetSignal(), o_irq=self.irq,
            i_s_axil_awprot=0, i_s_axil_arprot=0, **ports,
            i_s_axis_tvalid=events.valid, o_s_axis_tready=events.ready, i_s_axis_tdata=events.data,
            i_s_axis_tkeep=0xFF, i_s_axis_tlast=0,
            o_m_axis_records_tvalid=records.valid, i_m_axis_records_tready=records.ready,
            o_m_axis_records_tdata=records.data, o_m_axis_records_tlast=records.last,
            i_m_axis_owned_tready=1, i_m_axis_passed_tready=1, i_aer_req=1, i_aer_row=0, i_aer_data=0,
        )  # fmt: skip
        platform.add_source(source_file)

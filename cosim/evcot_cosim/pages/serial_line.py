# SPDX-License-Identifier: Apache-2.0
"""Timing diagrams of a board's serial line: one byte bit by bit, and a request with its response byte by byte."""

from __future__ import annotations

from evcot.hardware.registers import register_map

from ..devices.base import reset
from ..fpga.serial_host import BYTE_BITS, Receiver, levels, request
from ..rtl.build import load
from .trace import Diagram, wave

__all__ = ["uart_byte", "uart_frames"]

_DIVISOR = 4


def uart_byte() -> Diagram:
    """The byte 'R' (0x52) from uart_tx, one column a bit."""
    sim = load("uart_tx", {"DIVISOR": _DIVISOR})
    reset(sim)
    sim.io.s_valid, sim.io.s_data = 1, ord("R")
    sim.clock.tick()
    sim.io.s_valid = 0
    line = ["1"]
    for clock in range((BYTE_BITS + 1) * _DIVISOR):
        if clock % _DIVISOR == _DIVISOR // 2:
            line.append(str(int(sim.io.tx)))
        sim.clock.tick()
    bits = ["x", "=start", *(f"={bit}" for bit in range(8)), "=stop", "x"]
    return {"signal": [{"name": "tx", **wave(line)}, {"name": "bit", **wave(bits)}], "config": {"hscale": 1}}


def uart_frames() -> Diagram:
    """The register `id` is read through uart_host, one column a byte."""
    identity = next(word for word in register_map().words if word.name == "id")
    sim = load("uart_host", {"DIVISOR": _DIVISOR})
    sim.io.rx = 1
    reset(sim)
    io = sim.io
    io.m_axil_arready = 1
    io.m_axil_rdata = int.from_bytes(b"EVCT", "big")
    question = request("R", identity.address)
    line = [1] * _DIVISOR + levels(question, _DIVISOR)
    receiver, asked = Receiver(_DIVISOR), False
    for level in line + [1] * (16 * BYTE_BITS * _DIVISOR - len(line)):
        io.rx = level
        io.m_axil_rvalid = int(asked)
        asked = bool(int(io.m_axil_arvalid)) or (asked and not int(io.m_axil_rready))
        receiver.sample(int(io.tx))
        sim.clock.tick()
    columns = 1 + len(question) + len(receiver.received) + 1
    rx, tx = ["1"] * columns, ["1"] * columns
    for i, value in enumerate(question):
        rx[1 + i] = "=" + _shown(i, value)
    first = 1 + receiver.began[0] // (BYTE_BITS * _DIVISOR)
    for i, value in enumerate(receiver.received):
        tx[first + i] = "=" + _shown(i, value)
    meaning = ["x", "=read", "=address", "=address", *["=data"] * 4]
    response = ["=read", "=resp", *["=data"] * 4, "=sum"]
    meaning += ["x"] * (first - len(meaning)) + response + ["x"] * (columns - first - len(response))
    lanes = [("rx", rx), ("tx", tx), ("", meaning)]
    return {"signal": [{"name": name, **wave(states)} for name, states in lanes], "config": {"hscale": 1}}


def _shown(place: int, value: int) -> str:
    return f"'{chr(value)}'" if place == 0 else f"{value:02x}"

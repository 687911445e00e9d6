# SPDX-License-Identifier: Apache-2.0
"""The cocotb side of the comparison: the same work for each event as a lean drive, one trigger a clock.

Runs inside the simulator. $EVCOT_BENCH_INPUT names an .npz with ticks, x, y, p and register writes; the outcome goes to
$EVCOT_BENCH_OUTPUT as JSON.
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

_RECORD = ("seq", "time", "id", "other", "x", "y", "support", "radius", "n_ev", "slot", "kind")


@cocotb.test()
async def drive(dut: Any) -> None:
    """Configure, then stream all events and collect the three streams."""
    with np.load(os.environ["EVCOT_BENCH_INPUT"]) as columns:
        ticks, x, y, p = (columns[name].tolist() for name in ("ticks", "x", "y", "p"))
        writes = columns["writes"].tolist()
    Clock(dut.clk, 10, "ns").start()
    falling = FallingEdge(dut.clk)
    for name in ("s_valid", "cfg_valid"):
        getattr(dut, name).value = 0
    for name in ("m_cm_ready", "m_own_ready", "m_pass_ready", "s_event", "rst"):
        getattr(dut, name).value = 1
    await falling
    await falling
    dut.rst.value = 0
    dut.cfg_valid.value = 1
    for slot, address, data in writes:
        dut.cfg_slot.value, dut.cfg_addr.value, dut.cfg_data.value = slot, address, data
        await falling
    dut.cfg_valid.value = 0
    await falling
    while not dut.idle.value:
        await falling

    s_valid, s_ready, s_tick, s_x, s_y, s_p = dut.s_valid, dut.s_ready, dut.s_tick, dut.s_x, dut.s_y, dut.s_p
    cm_valid, cm_fields = dut.m_cm_valid, [getattr(dut, f"m_cm_{name}") for name in _RECORD]
    own_valid, own_seq, own_slot, own_x, own_y = dut.m_own_valid, dut.m_own_seq, dut.m_own_slot, dut.m_own_x, dut.m_own_y
    pass_valid, pass_seq = dut.m_pass_valid, dut.m_pass_seq
    idle = dut.idle
    n = len(ticks)
    owner = [0] * n
    rel = [(0, 0)] * n
    records: list[tuple[int, ...]] = []
    index = now = 0

    wall_s, cpu_s = time.perf_counter(), time.thread_time()
    s_valid.value = 1
    while index < n or not idle.value:
        # What is set here stands at the coming rising edge; every output comes from a register.
        if index < n:
            s_tick.value = ticks[index] - now
            s_x.value = x[index]
            s_y.value = y[index]
            s_p.value = p[index]
            if s_ready.value:
                now = ticks[index]
                index += 1
        else:
            s_valid.value = 0
        await falling
        if cm_valid.value:
            records.append(tuple(int(field.value) for field in cm_fields))
        if own_valid.value:
            seq = int(own_seq.value)
            owner[seq] = int(own_slot.value)
            rel[seq] = (int(own_x.value), int(own_y.value))
        if pass_valid.value:
            owner[int(pass_seq.value)] = -1
    wall_s, cpu_s = time.perf_counter() - wall_s, time.thread_time() - cpu_s

    outcome = {"wall_s": wall_s, "cpu_s": cpu_s, "records": len(records), "owner_sum": sum(owner)}
    Path(os.environ["EVCOT_BENCH_OUTPUT"]).write_text(json.dumps(outcome))

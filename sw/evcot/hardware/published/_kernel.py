# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels of the model of the published tracker: the update of every register at a clock edge."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .registers import REGISTERS, SELECT, SELECT_NONE

__all__ = [
    "CASCADE_FIELDS",
    "ENABLE",
    "REGISTER_NAMES",
    "SELECTED",
    "TRACKERS",
    "TRACKER_FIELDS",
    "acknowledges",
    "edge",
    "requests",
    "run",
    "run_one",
]

Table = NDArray[Any]
Row = Any
"""A record of a structured table, with a field per port."""

TRACKERS = 4

# States of the FSM, as in cot_published.v.
(INIT_CELL, IDLE, REQ_RECEIVED, EV_DISCRI, EV_PASS_TH, EV_NO_PROC, EV_PROC, PROC_TIMING, PROC_NEV, PROC_CENTRE, PROC_SEND) = (
    range(11)
)

# Fields of one tracker; Numba inlines plain module-level integers as constants.
(STATE, TAKEN, EV_HIGH, EV_LOW, LO_HIGH, HI_HIGH, LO_LOW, HI_LOW, INSIDE, CM_HIGH, CM_LOW, AV_HIGH, AV_LOW, G, N_EV, COUNT,
 UPDATED, QUIET, TC, TC2, TC2_1, TC2_2, DIFF, LAST_DIFF) = range(24)  # fmt: skip
TRACKER_FIELDS = 24

# Fields of the cascade: the selected tracker, and the line that carries the words of all four.
SELECTED, BUSY, OWNER, FREE = range(4)
CASCADE_FIELDS = 4

# Registers of one tracker, as columns of its table.
REGISTER_NAMES = tuple(REGISTERS)
(INIT_CM_LOW, INIT_CM_HIGH, RADIX_TH, INIT_RADIX, MAX_TIME, NEV_TH, HIST_AVG, ENABLE, RADIX_STEP, RADIX_MAX, RADIX_MIN) = range(
    len(REGISTER_NAMES)
)
FIRST, BYTES, MASKS, RESETS = zip(
    *((entry.address, entry.n_bytes, (1 << entry.bits) - 1, entry.reset) for entry in REGISTERS.values()), strict=True
)

MASK32 = (1 << 32) - 1
QUIET_TOP = 7  # quiet updates after which the next one shrinks the window


@njit(cache=True, nogil=True, inline="always")
def _step(value: int, target: int, k: int) -> int:
    """floor((target + (2^k - 1) value) / 2^k)."""
    return (target + ((1 << k) - 1) * value) >> k


@njit(cache=True, nogil=True, inline="always")
def _ack_n(s: Table, req_n: int) -> int:
    """The acknowledge of one tracker, given its request."""
    return int(not (s[STATE] == INIT_CELL or s[STATE] == REQ_RECEIVED or (s[TAKEN] and not req_n)))


@njit(cache=True, nogil=True)
def _initialise(s: Table, r: Table) -> None:
    """INIT_CELL: reset everything but TC and the event."""
    s[CM_HIGH] = s[AV_HIGH] = r[INIT_CM_HIGH]
    s[CM_LOW] = s[AV_LOW] = r[INIT_CM_LOW]
    s[G] = r[INIT_RADIX]
    s[N_EV] = r[NEV_TH]
    s[COUNT] = s[UPDATED] = s[QUIET] = 0
    s[TC2_1] = s[TC2_2] = s[LAST_DIFF] = 0


@njit(cache=True, nogil=True)
def _set_window(s: Table, r: Table) -> None:
    radius = s[G] + r[RADIX_TH]
    s[LO_HIGH] = max(s[CM_HIGH] - radius, 0)
    s[HI_HIGH] = min(s[CM_HIGH] + radius, 255)
    s[LO_LOW] = max(s[CM_LOW] - radius, 0)
    s[HI_LOW] = min(s[CM_LOW] + radius, 255)


@njit(cache=True, nogil=True)
def _set_radius(s: Table, r: Table) -> None:
    g = s[G]
    # The top edge (the far end of the high coordinate) never counts.
    beyond = s[EV_LOW] < s[CM_LOW] - g or s[EV_LOW] > s[CM_LOW] + g or s[EV_HIGH] < s[CM_HIGH] - g
    if not s[UPDATED]:
        s[UPDATED] = 1
        s[G] = r[INIT_RADIX]
    elif beyond:
        s[G] = min(g + r[RADIX_STEP], r[RADIX_MAX])
        s[QUIET] = 0
    elif s[QUIET] == QUIET_TOP:
        s[G] = max(g - r[RADIX_STEP], r[RADIX_MIN])
        s[QUIET] = 0
    else:
        s[QUIET] += 1


@njit(cache=True, nogil=True)
def _set_n_ev(s: Table) -> None:
    n = s[N_EV]
    if s[DIFF] > 2 * s[LAST_DIFF] and n > 1:
        s[N_EV] = n >> 1
    elif s[DIFF] < s[LAST_DIFF] >> 1 and n < 128:
        s[N_EV] = n << 1
    elif n <= 1:
        s[N_EV] = 2
    elif n >= 128:
        s[N_EV] = 255
    s[LAST_DIFF] = s[DIFF]


@njit(cache=True, nogil=True)
def _clock(s: Table, r: Table, rst: int, req_n: int, high: int, low: int, pass_ack_n: int, ack_n: int) -> None:
    """One clock edge of one tracker, from its fields, its registers and its inputs just before the edge."""
    state = s[STATE]
    tc2 = s[TC2]
    s[TAKEN] = not req_n and (s[TAKEN] or state == REQ_RECEIVED)
    expired = s[TC] == r[MAX_TIME]
    s[TC] = 0 if state == EV_PROC else (s[TC] + 1) & MASK32
    s[TC2] = 0 if state == INIT_CELL else (tc2 + 1) & MASK32

    if state == INIT_CELL:
        _initialise(s, r)
        if req_n:
            s[STATE] = IDLE
    elif state == IDLE:
        s[EV_HIGH], s[EV_LOW] = high, low
        _set_window(s, r)
        if expired:
            s[STATE] = INIT_CELL
        elif s[TAKEN] == 0 and not req_n:
            s[STATE] = REQ_RECEIVED
    elif state == REQ_RECEIVED:
        inside_high = s[LO_HIGH] < s[EV_HIGH] < s[HI_HIGH]
        s[INSIDE] = inside_high and s[LO_LOW] < s[EV_LOW] < s[HI_LOW]
        s[COUNT] = (s[COUNT] + s[INSIDE]) & 255
        s[STATE] = EV_DISCRI
    elif state == EV_DISCRI:
        if not s[INSIDE]:
            s[STATE] = EV_PASS_TH
        else:
            s[STATE] = EV_PROC if s[COUNT] >= s[N_EV] else EV_NO_PROC
    elif state == EV_PASS_TH:
        if not pass_ack_n:
            s[STATE] = IDLE
    elif state == EV_NO_PROC:
        s[AV_HIGH] = _step(s[AV_HIGH], s[EV_HIGH], r[HIST_AVG])
        s[AV_LOW] = _step(s[AV_LOW], s[EV_LOW], r[HIST_AVG])
        if not ack_n:
            s[STATE] = IDLE
    elif state == EV_PROC:
        s[COUNT] = 0
        _set_radius(s, r)
        s[STATE] = PROC_TIMING
    elif state == PROC_TIMING:
        s[DIFF] = (tc2 - s[TC2_2]) & MASK32
        s[TC2_2] = s[TC2_1]
        s[TC2_1] = tc2
        s[STATE] = PROC_NEV
    elif state == PROC_NEV:
        _set_n_ev(s)
        s[STATE] = PROC_CENTRE
    elif state == PROC_CENTRE:
        s[CM_HIGH] = _step(s[CM_HIGH], s[AV_HIGH], r[HIST_AVG])
        s[CM_LOW] = _step(s[CM_LOW], s[AV_LOW], r[HIST_AVG])
        s[STATE] = PROC_SEND
    elif not ack_n:
        s[STATE] = IDLE

    if rst:
        s[STATE] = INIT_CELL
        s[TAKEN] = s[TC] = 0


@njit(cache=True, nogil=True)
def run_one(s: Table, r: Table, inputs: Table, outputs: Table) -> None:
    """Clock a single tracker: `inputs` and `outputs` have a row per clock; outputs are those just before the edge."""
    for i in range(len(inputs)):
        at, out = inputs[i], outputs[i]
        state = s[STATE]
        out.s_ack_n = _ack_n(s, at.s_req_n)
        out.m_pass_req_n = out.m_req_n = 1
        out.m_pass_high = out.m_pass_low = out.m_event = out.m_high = out.m_low = 0
        if state == EV_PASS_TH:
            out.m_pass_req_n, out.m_pass_high, out.m_pass_low = 0, s[EV_HIGH], s[EV_LOW]
        elif state == EV_NO_PROC:
            out.m_req_n, out.m_event, out.m_high, out.m_low = 0, 1, s[EV_HIGH], s[EV_LOW]
        elif state == PROC_SEND:
            out.m_req_n, out.m_high, out.m_low = 0, s[CM_HIGH], s[CM_LOW]
        _clock(s, r, at.rst, at.s_req_n, at.s_high, at.s_low, at.m_pass_ack_n, at.m_ack_n)


@njit(cache=True, nogil=True)
def requests(c: Table, s: Table, r: Table, wires: Table, out: Row) -> None:
    """Compute the cascade's requests from its input request.

    `wires` has a row per link, tracker i between links i and i + 1: request, high, low, acknowledge. Row 0 holds the request.
    """
    for i in range(TRACKERS):
        if not r[i, ENABLE]:
            wires[i + 1, :3] = wires[i, :3]
        else:
            wires[i + 1, 0] = s[i, STATE] != EV_PASS_TH
            wires[i + 1, 1] = s[i, EV_HIGH]
            wires[i + 1, 2] = s[i, EV_LOW]

    first = -1
    for i in range(TRACKERS - 1, -1, -1):
        if s[i, STATE] == EV_NO_PROC or s[i, STATE] == PROC_SEND:
            first = i
    if c[BUSY]:
        granted = c[OWNER]
        offers = s[granted, STATE] == EV_NO_PROC or s[granted, STATE] == PROC_SEND
    else:
        granted = max(first, 0)
        offers = c[FREE] and first >= 0
    c[OWNER] = granted
    out.m_req_n = not offers
    out.m_word = 0
    if offers:
        t = s[granted]
        if t[STATE] == EV_NO_PROC:
            out.m_word = (0x10 | granted) << 17 | t[EV_HIGH] << 9 | t[EV_LOW] << 1 | 1
        else:
            out.m_word = granted << 17 | t[CM_HIGH] << 9 | t[CM_LOW] << 1
    out.m_pass_req_n = wires[TRACKERS, 0]
    offers = not wires[TRACKERS, 0]
    out.m_pass_high = wires[TRACKERS, 1] if offers else 0
    out.m_pass_low = wires[TRACKERS, 2] if offers else 0


@njit(cache=True, nogil=True)
def acknowledges(s: Table, r: Table, pass_ack_n: int, wires: Table, out: Row) -> None:
    """Compute the cascade's acknowledges from those of its receivers."""
    wires[TRACKERS, 3] = pass_ack_n
    for i in range(TRACKERS - 1, -1, -1):
        wires[i, 3] = _ack_n(s[i], wires[i, 0]) if r[i, ENABLE] else wires[i + 1, 3]
    out.s_ack_n = wires[0, 3]


@njit(cache=True, nogil=True)
def edge(c: Table, s: Table, r: Table, at: Row, wires: Table, out: Row) -> None:
    """One clock edge of the cascade and of its registers."""
    for i in range(TRACKERS):
        req_n = wires[i, 0] or not r[i, ENABLE]
        ack_n = not (i == c[OWNER] and not out.m_req_n and not at.m_ack_n)
        rst = at.rst or c[SELECTED] == i
        _clock(s[i], r[i], rst, req_n, wires[i, 1], wires[i, 2], wires[i + 1, 3], ack_n)
    c[BUSY] = not out.m_req_n
    c[FREE] = out.m_req_n and (c[FREE] or at.m_ack_n)
    if at.cfg_valid:
        if c[SELECTED] < TRACKERS:
            _write(r[c[SELECTED]], at.cfg_addr, at.cfg_data)
        if at.cfg_addr == SELECT:
            c[SELECTED] = at.cfg_data
    if at.rst:
        c[SELECTED], c[BUSY], c[FREE] = SELECT_NONE, 0, 1
        for column in range(len(RESETS)):
            r[:, column] = RESETS[column]


@njit(cache=True, nogil=True)
def _write(r: Table, address: int, data: int) -> None:
    """Write to a register of one tracker."""
    for column in range(len(FIRST)):
        if FIRST[column] <= address < FIRST[column] + BYTES[column]:
            if column == ENABLE:
                data = int(data != 0)
            shift = 8 * (address - FIRST[column])
            r[column] = (r[column] & ~(255 << shift) | data << shift) & MASKS[column]


@njit(cache=True, nogil=True)
def run(c: Table, s: Table, r: Table, inputs: Table, outputs: Table) -> None:
    """Clock the cascade: `inputs` and `outputs` have a row per clock; outputs are those just before the edge."""
    wires = np.ones((TRACKERS + 1, 4), np.int64)
    for i in range(len(inputs)):
        at, out = inputs[i], outputs[i]
        wires[0, 0], wires[0, 1], wires[0, 2] = at.s_req_n, at.s_high, at.s_low
        requests(c, s, r, wires, out)
        acknowledges(s, r, at.m_pass_ack_n, wires, out)
        edge(c, s, r, at, wires, out)

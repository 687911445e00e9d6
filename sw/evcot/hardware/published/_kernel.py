# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels of the model of the published tracker: the update of every register at a clock edge."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from .registers import REGISTERS, SELECT, SELECT_FIRST, TRACKERS

__all__ = [
    "CASCADE_FIELDS",
    "ENABLE",
    "LIBRARY_LINE",
    "NOBODY",
    "REGISTER_NAMES",
    "RESETS",
    "SELECTED",
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

# States of the FSM, as in cot_published.v.
(INIT_CELL, IDLE, REQ_RECEIVED, EV_DISCRI, EV_PASS_TH, EV_NO_PROC, EV_PROC, PROC_TIMING, PROC_NEV, PROC_CENTRE, PROC_SEND) = (
    range(11)
)

# Fields of one tracker; Numba inlines plain module-level integers as constants.
(STATE, EXPIRED, EV_HIGH, EV_LOW, LO_HIGH, HI_HIGH, LO_LOW, HI_LOW, INSIDE, CM_HIGH, CM_LOW, AV_HIGH, AV_LOW, G, N_EV, COUNT,
 UPDATED, QUIET, TC, TC2, TC2_1, TC2_2, DIFF, LAST_DIFF) = range(24)  # fmt: skip
TRACKER_FIELDS = 24

# Fields of the cascade: the selected tracker, and the line that carries the words of all four. LIBRARY_LINE chooses between
# published_line.v, with LINE_STATE, OWNER, the registers of its outputs and PATTERN, a bit for each tracker whose event its
# pattern cell acknowledges, and aer_merge.v, with BUSY, OWNER and FREE.
SELECTED, LIBRARY_LINE, LINE_STATE, OWNER, LINE_REQ_N, LINE_WORD, LINE_ACKED, PATTERN, BUSY, FREE = range(10)
CASCADE_FIELDS = 10
NOBODY = -1  # selected, or acknowledged by the line
LINE_IDLE, LINE_CONNECT, LINE_ACKNOWLEDGE = range(3)
IDLE_WORD = (1 << 25) - 1

# Who sends on the line, in the order of rank: the centres of all trackers, then their events.
SENDERS = 2 * TRACKERS

# Registers of one tracker, as columns of its table.
REGISTER_NAMES = tuple(REGISTERS)
(INIT_CM_LOW, INIT_CM_HIGH, RADIX_TH, INIT_RADIX, MAX_TIME, NEV_TH, HIST_AVG, ENABLE, RADIX_STEP, RADIX_MAX, RADIX_MIN) = range(
    len(REGISTER_NAMES)
)
FIRST, BYTES, MASKS = zip(*((entry.address, entry.n_bytes, (1 << entry.bits) - 1) for entry in REGISTERS.values()), strict=True)
RESETS = np.array([entry.resets for entry in REGISTERS.values()], np.int64).T.copy()
"""(TRACKERS, registers) values after reset."""
K_MIN, K_MAX = REGISTERS["hist_avg"].low, REGISTERS["hist_avg"].high

MASK32 = (1 << 32) - 1
QUIET_TOP = 7  # quiet updates after which the next one shrinks the window


@njit(cache=True, nogil=True, inline="always")
def _step(value: int, target: int, k: int) -> int:
    """floor((target + (2^k - 1) value) / 2^k)."""
    return (target + ((1 << k) - 1) * value) >> k


@njit(cache=True, nogil=True, inline="always")
def _ack_n(s: Table) -> int:
    """The acknowledge of one tracker."""
    return int(s[STATE] == IDLE or s[STATE] == PROC_SEND)


@njit(cache=True, nogil=True, inline="always")
def _event_req_n(s: Table) -> int:
    return int(s[STATE] != EV_NO_PROC and s[STATE] != PROC_CENTRE)


@njit(cache=True, nogil=True, inline="always")
def _centre_req_n(s: Table) -> int:
    return int(s[STATE] != PROC_SEND)


@step
def _initialise(s: Table, r: Table) -> None:
    """INIT_CELL: reset everything but TC and the event."""
    s[CM_HIGH] = s[AV_HIGH] = r[INIT_CM_HIGH]
    s[CM_LOW] = s[AV_LOW] = r[INIT_CM_LOW]
    s[G] = r[INIT_RADIX]
    s[N_EV] = r[NEV_TH]
    s[COUNT] = s[UPDATED] = s[QUIET] = 0
    s[TC2_1] = s[TC2_2] = s[LAST_DIFF] = 0


@step
def _set_window(s: Table, r: Table) -> None:
    radius = s[G] + r[RADIX_TH]
    s[LO_HIGH] = max(s[CM_HIGH] - radius, 0)
    s[LO_LOW] = max(s[CM_LOW] - radius, 0)
    # The sums have 9 bits.
    s[HI_HIGH] = min((s[CM_HIGH] + radius) & 511, 255)
    s[HI_LOW] = min((s[CM_LOW] + radius) & 511, 255)


@step
def _set_radius(s: Table, r: Table) -> None:
    g = s[G]
    # The far end of the low coordinate never counts.
    beyond = s[EV_LOW] < s[CM_LOW] - g or s[EV_HIGH] < s[CM_HIGH] - g or s[EV_HIGH] > s[CM_HIGH] + g
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


@step
def _set_n_ev(s: Table) -> None:
    n = s[N_EV]
    if s[DIFF] > (2 * s[LAST_DIFF] & MASK32) and n > 1:
        s[N_EV] = n >> 1
    elif s[DIFF] < s[LAST_DIFF] >> 1 and n < 128:
        s[N_EV] = n << 1
    elif n <= 1:
        s[N_EV] = 2
    elif n >= 128:
        s[N_EV] = 255
    s[LAST_DIFF] = s[DIFF]


@step
def _clock(
    s: Table, r: Table, rst: int, req_n: int, high: int, low: int, pass_ack_n: int, event_ack_n: int, centre_ack_n: int
) -> None:
    """One clock edge of one tracker, from its fields, its registers and its inputs just before the edge."""
    state = s[STATE]
    tc2 = s[TC2]
    expired = s[EXPIRED]
    s[EXPIRED] = state != INIT_CELL and (expired or s[TC] == r[MAX_TIME])
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
        elif centre_ack_n and not req_n:
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
        if req_n and not pass_ack_n:
            s[STATE] = IDLE
    elif state == EV_NO_PROC:
        s[AV_HIGH] = _step(s[AV_HIGH], s[EV_HIGH], r[HIST_AVG])
        s[AV_LOW] = _step(s[AV_LOW], s[EV_LOW], r[HIST_AVG])
        if req_n and not event_ack_n:
            s[STATE] = IDLE
    elif state == EV_PROC:
        s[COUNT] = 0
        _set_radius(s, r)
        s[STATE] = INIT_CELL if expired else PROC_TIMING
    elif state == PROC_TIMING:
        if tc2 > s[TC2_2]:
            s[DIFF] = tc2 - s[TC2_2]
        s[TC2_2] = s[TC2_1]
        s[TC2_1] = tc2
        s[STATE] = PROC_NEV
    elif state == PROC_NEV:
        _set_n_ev(s)
        s[STATE] = PROC_CENTRE
    elif state == PROC_CENTRE:
        if req_n and not event_ack_n:
            s[CM_HIGH] = _step(s[CM_HIGH], s[AV_HIGH], r[HIST_AVG])
            s[CM_LOW] = _step(s[CM_LOW], s[AV_LOW], r[HIST_AVG])
            s[STATE] = PROC_SEND
    elif not centre_ack_n:
        s[STATE] = IDLE

    if rst:
        s[STATE] = INIT_CELL
        s[TC] = s[EXPIRED] = 0


@njit(cache=True, nogil=True)
def run_one(s: Table, r: Table, inputs: Table, outputs: Table) -> None:
    """Clock a single tracker: `inputs` and `outputs` have a row per clock; outputs are those just before the edge."""
    for i in range(len(inputs)):
        at, out = inputs[i], outputs[i]
        out.s_ack_n = _ack_n(s)
        out.m_pass_req_n = s[STATE] != EV_PASS_TH
        out.m_event_req_n, out.m_centre_req_n = _event_req_n(s), _centre_req_n(s)
        out.m_pass_high, out.m_pass_low = (0, 0) if out.m_pass_req_n else (at.s_high, at.s_low)
        out.m_event_high, out.m_event_low = (0, 0) if out.m_event_req_n else (s[EV_HIGH], s[EV_LOW])
        out.m_centre_high, out.m_centre_low = (0, 0) if out.m_centre_req_n else (s[CM_HIGH], s[CM_LOW])
        _clock(s, r, at.rst, at.s_req_n, at.s_high, at.s_low, at.m_pass_ack_n, at.m_event_ack_n, at.m_centre_ack_n)


@njit(cache=True, nogil=True, inline="always")
def _sends(s: Table, sender: int) -> bool:
    """Whether a sender on the line has a request."""
    if sender < TRACKERS:
        return bool(not _centre_req_n(s[sender]))
    return bool(not _event_req_n(s[sender - TRACKERS]))


@step
def _word(s: Table, sender: int) -> int:
    """The word of a sender on the line."""
    if sender < TRACKERS:
        return int(sender << 17 | s[sender, CM_HIGH] << 9 | s[sender, CM_LOW] << 1)
    i = sender - TRACKERS
    return int((0x10 | i) << 17 | s[i, EV_HIGH] << 9 | s[i, EV_LOW] << 1 | 1)


@step
def _first(s: Table) -> int:
    """The sender of the highest rank among those with a request, or NOBODY."""
    for sender in range(SENDERS):
        if _sends(s, sender):
            return sender
    return NOBODY


@step
def requests(c: Table, s: Table, r: Table, wires: Table, at: Row, out: Row) -> None:
    """Compute the cascade's requests from its input request.

    `wires` has a row per link, tracker i between links i and i + 1: request, acknowledge. Row 0 holds the request.
    """
    for i in range(TRACKERS):
        wires[i + 1, 0] = s[i, STATE] != EV_PASS_TH if r[i, ENABLE] else wires[i, 0]
    out.m_pass_req_n = wires[TRACKERS, 0]
    out.m_pass_high, out.m_pass_low = (0, 0) if out.m_pass_req_n else (at.s_high, at.s_low)

    if c[LIBRARY_LINE]:
        out.m_req_n = c[LINE_REQ_N]
        out.m_word = c[LINE_WORD]
        return
    if c[BUSY]:
        offers = _sends(s, c[OWNER])
    else:
        first = _first(s)
        c[OWNER] = max(first, 0)
        offers = bool(c[FREE] and first != NOBODY)
    out.m_req_n = not offers
    out.m_word = _word(s, c[OWNER]) if offers else 0


@step
def acknowledges(s: Table, r: Table, pass_ack_n: int, wires: Table, out: Row) -> None:
    """Compute the cascade's acknowledges from that of the receiver of passed events."""
    wires[TRACKERS, 1] = pass_ack_n
    for i in range(TRACKERS - 1, -1, -1):
        wires[i, 1] = _ack_n(s[i]) if r[i, ENABLE] else wires[i + 1, 1]
    out.s_ack_n = wires[0, 1]


@step
def _library_line(c: Table, s: Table, rst: int, ack_n: int) -> None:
    """One clock edge of published_line.v, before that of its senders."""
    c[LINE_ACKED] = NOBODY
    first = _first(s)
    if c[LINE_STATE] == LINE_IDLE:
        c[LINE_WORD] = IDLE_WORD
        if first != NOBODY:
            c[LINE_STATE] = LINE_CONNECT
    elif c[LINE_STATE] == LINE_CONNECT:
        c[LINE_REQ_N] = first == NOBODY
        if first != NOBODY:
            c[LINE_WORD] = _word(s, first)
            c[OWNER] = first
        if not ack_n:
            c[LINE_STATE] = LINE_ACKNOWLEDGE
    else:
        c[LINE_REQ_N] = 1
        c[LINE_ACKED] = c[OWNER]
        if not _sends(s, c[OWNER]) and ack_n:
            c[LINE_STATE] = LINE_IDLE
    if rst:
        c[LINE_STATE], c[OWNER], c[LINE_REQ_N], c[LINE_WORD], c[LINE_ACKED] = LINE_IDLE, 0, 1, IDLE_WORD, NOBODY


@step
def _pattern_cells(c: Table, s: Table, rst: int) -> None:
    """One clock edge of the pattern cells, before that of their trackers."""
    c[PATTERN] = 0
    for i in range(TRACKERS):
        if not rst and not _event_req_n(s[i]):
            c[PATTERN] |= 1 << i


@step
def edge(c: Table, s: Table, r: Table, at: Row, wires: Table, out: Row) -> None:
    """One clock edge of the cascade and of its registers."""
    if c[LIBRARY_LINE]:
        acked, answered = c[LINE_ACKED], c[PATTERN]
        _library_line(c, s, at.rst, at.m_ack_n)
        _pattern_cells(c, s, at.rst)
    else:
        answered = (1 << TRACKERS) - 1
        acked = NOBODY if out.m_req_n or at.m_ack_n else c[OWNER]
        c[BUSY] = not out.m_req_n
        c[FREE] = out.m_req_n and (c[FREE] or at.m_ack_n)
        if at.rst:
            c[BUSY], c[FREE] = 0, 1
    for i in range(TRACKERS):
        req_n = wires[i, 0] or not r[i, ENABLE]
        rst = at.rst or c[SELECTED] == i
        event_ack_n = acked != TRACKERS + i or not answered >> i & 1
        _clock(s[i], r[i], rst, req_n, at.s_high, at.s_low, wires[i + 1, 1], event_ack_n, acked != i)
    if at.cfg_valid:
        if c[SELECTED] != NOBODY:
            _write(r[c[SELECTED]], at.cfg_addr, at.cfg_data)
        if at.cfg_addr == SELECT:
            selected = np.int64(at.cfg_data) - SELECT_FIRST
            c[SELECTED] = selected if 0 <= selected < TRACKERS else NOBODY
    if at.rst:
        c[SELECTED] = NOBODY
        for i in range(TRACKERS):
            for column in range(RESETS.shape[1]):
                r[i, column] = RESETS[i, column]


@step
def _write(r: Table, address: int, data: int) -> None:
    """Write to a register of one tracker."""
    for column in range(len(FIRST)):
        if FIRST[column] <= address < FIRST[column] + BYTES[column]:
            if column == ENABLE:
                if data != 0x00 and data != 0xFF:
                    return
                data &= 1
            elif column == HIST_AVG:
                data = min(max(data, K_MIN), K_MAX)
            shift = 8 * (address - FIRST[column])
            r[column] = (r[column] & ~(255 << shift) | data << shift) & MASKS[column]


@njit(cache=True, nogil=True)
def run(c: Table, s: Table, r: Table, inputs: Table, outputs: Table) -> None:
    """Clock the cascade: `inputs` and `outputs` have a row per clock; outputs are those just before the edge."""
    wires = np.ones((TRACKERS + 1, 2), np.int64)
    for i in range(len(inputs)):
        at, out = inputs[i], outputs[i]
        wires[0, 0] = at.s_req_n
        requests(c, s, r, wires, at, out)
        acknowledges(s, r, at.m_pass_ack_n, wires, out)
        edge(c, s, r, at, wires, out)

# SPDX-License-Identifier: Apache-2.0
"""The compiled test bench around the model of the published cascade: a sender of events and two receivers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from ._kernel import (
    BUSY,
    EXPIRED,
    FREE,
    IDLE,
    LIBRARY_LINE,
    LINE_ACKED,
    LINE_CONNECT,
    LINE_IDLE,
    LINE_REQ_N,
    LINE_STATE,
    MASK32,
    MAX_TIME,
    NOBODY,
    PATTERN,
    SELECTED,
    STATE,
    TC,
    TC2,
    acknowledges,
    edge,
    requests,
)
from .registers import TRACKERS

__all__ = ["BENCH_FIELDS", "CLOCK", "PASSED", "WORDS", "play"]

Table = NDArray[Any]

# Fields of the test bench around the cascade: state of the sender, then for each receiver the clocks waited, the number of
# words, and whether it has taken the word that is requested.
CLOCK, SENT, SENDER, HOLDING, WAITED, WORDS, HELD, PASS_WAITED, PASSED, PASS_HELD = range(10)
BENCH_FIELDS = 10
READY, REQUESTS, RELEASED = range(3)


@step
def _rests(c: Table, s: Table) -> bool:
    """Whether every tracker is idle or held in reset, and the output line is free."""
    for i in range(TRACKERS):
        if (s[i, STATE] != IDLE or s[i, EXPIRED]) and c[SELECTED] != i:
            return False
    if c[LIBRARY_LINE]:
        waits = c[LINE_STATE] == LINE_IDLE or (c[LINE_STATE] == LINE_CONNECT and c[LINE_REQ_N])
        return bool(waits and c[LINE_ACKED] == NOBODY and c[PATTERN] == 0)
    return bool(c[BUSY] == 0 and c[FREE] == 1)


@step
def _quiet_clocks(b: Table, c: Table, s: Table, r: Table, clock: Table) -> int:
    """Number of clocks from now on in which only timers advance."""
    if b[SENDER] != READY or not _rests(c, s):
        return 0
    quiet = clock[b[SENT]] - b[CLOCK]
    for i in range(TRACKERS):
        quiet = min(quiet, (r[i, MAX_TIME] - s[i, TC]) & MASK32)
    return int(max(quiet, 0))


@njit(cache=True, nogil=True, inline="always")
def _receive(b: Table, req_n: int, delays: Table, waited: int, count: int, held: int) -> int:
    """The acknowledge of a receiver that takes each word after its delay and releases it with the request."""
    return int(req_n or (not b[held] and b[waited] < delays[b[count] % len(delays)]))


@njit(cache=True, nogil=True, inline="always")
def _received(b: Table, req_n: int, ack_n: int, waited: int, count: int, held: int) -> int:
    """A receiver's clock edge; returns whether it took a word."""
    takes = int(not b[held] and not req_n and not ack_n)
    b[held] = int(not req_n and not ack_n)
    b[waited] = 0 if req_n or b[held] else b[waited] + 1
    b[count] += takes
    return takes


@njit(cache=True, nogil=True)
def play(
    b: Table,
    c: Table,
    s: Table,
    r: Table,
    events: tuple[Table, ...],
    delays: tuple[Table, ...],
    outcome: tuple[Table, ...],
    inputs: Table,
    outputs: Table,
    traces: bool,
) -> tuple[bool, int]:
    """Clock the cascade between a sender and two receivers until all events are processed, or until the trace is full.

    Args:
        b, c, s, r: state of the test bench, of the cascade, of its trackers, and their registers.
        events: earliest clock of each request, high, low.
        delays: delays in clocks of the sender's release after the acknowledge, of the receiver of words, and of the receiver of
            passed events; each repeats from the start.
        outcome: output arrays: clock of each event's acknowledge; clock and word of words; clock, high, low of passed events.
        inputs, outputs: ports per clock, if `traces`; else one row of each, as work space.

    Returns:
        Whether it is finished, and the number of rows traced.
    """  # fmt: skip
    clock, high, low = events
    release, ack, pass_ack = delays
    acknowledged, word_clock, word, pass_clock, pass_high, pass_low = outcome
    wires = np.ones((TRACKERS + 1, 2), np.int64)
    n, rows = len(clock), 0
    while b[SENT] < n or b[SENDER] != READY or not _rests(c, s):
        if traces:
            if rows == len(inputs):
                return False, rows
        elif b[SENT] < n:
            quiet = _quiet_clocks(b, c, s, r, clock)
            b[CLOCK] += quiet
            for i in range(TRACKERS):
                s[i, TC] = (s[i, TC] + quiet) & MASK32
                s[i, TC2] = (s[i, TC2] + quiet) & MASK32
        at, out = inputs[rows], outputs[rows]
        rows += traces

        if b[SENDER] == READY and b[SENT] < n and b[CLOCK] >= clock[b[SENT]]:
            b[SENDER], b[HOLDING] = REQUESTS, -1
        at.s_req_n = wires[0, 0] = b[SENDER] != REQUESTS
        event = min(b[SENT], n - 1)
        at.s_high = high[event]
        at.s_low = low[event]
        requests(c, s, r, wires, at, out)
        at.m_ack_n = _receive(b, out.m_req_n, ack, WAITED, WORDS, HELD)
        at.m_pass_ack_n = _receive(b, out.m_pass_req_n, pass_ack, PASS_WAITED, PASSED, PASS_HELD)
        acknowledges(s, r, at.m_pass_ack_n, wires, out)
        edge(c, s, r, at, wires, out)

        if _received(b, out.m_req_n, at.m_ack_n, WAITED, WORDS, HELD):
            word_clock[b[WORDS] - 1], word[b[WORDS] - 1] = b[CLOCK], out.m_word
        if _received(b, out.m_pass_req_n, at.m_pass_ack_n, PASS_WAITED, PASSED, PASS_HELD):
            k = b[PASSED] - 1
            pass_clock[k], pass_high[k], pass_low[k] = b[CLOCK], out.m_pass_high, out.m_pass_low
        if b[SENDER] == REQUESTS:
            if b[HOLDING] < 0 and not out.s_ack_n:
                acknowledged[b[SENT]] = b[CLOCK]
                b[HOLDING] = release[b[SENT] % len(release)]
            if b[HOLDING] == 0:
                b[SENDER] = RELEASED
            elif b[HOLDING] > 0:
                b[HOLDING] -= 1
        elif b[SENDER] == RELEASED and out.s_ack_n:
            b[SENDER] = READY
            b[SENT] += 1
        b[CLOCK] += 1
    return True, rows

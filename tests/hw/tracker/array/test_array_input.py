# SPDX-License-Identifier: Apache-2.0
"""array_input.v: tokens with their time, issued again as often as they are thrown out before they are committed."""

from __future__ import annotations

from itertools import accumulate

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Source, lint, run_streams

FIELDS = ["tick", "event", "skip", "x", "y", "p"]
X_W, Y_W, TICK_W, CLOCK_W = 6, 5, 4, 12
PARAMETERS = {"X_W": X_W, "Y_W": Y_W, "TICK_W": TICK_W, "CLOCK_W": CLOCK_W}
PLACES = 16


@pytest.mark.parametrize("source", PATTERNS)
@pytest.mark.parametrize(("takes", "commits", "rewinds"), [(1.0, 1.0, 0.0), (0.9, 0.8, 0.05), (0.5, 0.2, 0.2), (1.0, 0.5, 0.4)])
def test_tokens_are_issued_in_order_from_the_first_that_is_not_committed(
    source: str, takes: float, commits: float, rewinds: float
) -> None:
    sim = load("array_input", PARAMETERS)
    io = sim.io
    io.s_valid = io.m_take = io.commit = io.rewind = 0
    reset(sim)
    rng = np.random.default_rng([6, int(10 * takes), int(10 * rewinds), list(PATTERNS).index(source)])
    limits = [1 << TICK_W, 2, 2, 1 << X_W, 1 << Y_W, 2]
    words = [tuple(word) for word in rng.integers(0, limits, (300, len(limits))).tolist()]
    times = [time % (1 << CLOCK_W) for time in accumulate(tick for tick, *_ in words)]
    offered = Source(sim, "s", FIELDS, words, PATTERNS[source](rng))
    issued = committed = again = 0
    rewound, waits = -9, False  # the clock of the last rewind; was there a token to come back to?

    def on_clock(clock: int) -> None:
        nonlocal issued, committed, again, rewound, waits
        assert io.empty == (offered.taken == committed)
        assert offered.taken - committed <= PLACES
        rests = clock == rewound + 1  # what stands on m_ was thrown out, and nobody is there to commit
        if clock == rewound + 3 and waits:
            assert io.m_valid == 1
        take = bool(io.m_valid) and not rests and rng.random() < takes
        commit = not rests and issued > committed and rng.random() < commits
        rewind = not rests and rng.random() < rewinds
        io.m_take, io.commit, io.rewind = take, commit, rewind
        committed += commit
        if take:
            _, event, skip, x, y, p = words[issued]
            assert (io.m_time, io.m_counts, io.m_event) == (times[issued], event | skip, event), (clock, issued)
            assert (io.m_x, io.m_y, io.m_p) == (x, y, p), (clock, issued)
            issued += 1
        if rewind:
            again += issued - committed
            issued, rewound, waits = committed, clock, offered.taken > committed

    run_streams(sim, [offered], [], on_clock=on_clock, quiet_clocks=400)
    assert (issued, committed, io.empty) == (len(words), len(words), 1)
    assert (again > 5) == (rewinds > 0)


def test_three_clocks_through_and_a_token_every_clock_until_all_places_are_taken() -> None:
    sim = load("array_input", PARAMETERS)
    io = sim.io
    reset(sim)
    sim.clock.tick()
    io.s_valid, io.s_event, io.m_take = 1, 1, 1
    valid, ready = [], []
    for clock in range(24):
        valid.append(int(io.m_valid))
        ready.append(int(io.s_ready))
        io.s_x = clock
        if valid[-1]:
            assert io.m_x == sum(valid) - 1
        sim.clock.tick()
    assert valid == [0] * 3 + [1] * PLACES + [0] * (21 - PLACES)
    assert ready == [1] * PLACES + [0] * (24 - PLACES)


@pytest.mark.parametrize("tick_w", [1, 32])
def test_lints_clean(tick_w: int) -> None:
    assert lint("array_input", TICK_W=tick_w) == (0, "")

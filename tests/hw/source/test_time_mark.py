# SPDX-License-Identifier: Apache-2.0
"""time_mark.v against the software decoder's rule, mark by mark."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.recordings.formats.time_marks import advance
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint

TOP = "time_mark"


@pytest.mark.parametrize(("mark_w", "high_w"), [(2, 3), (12, 36), (28, 42), (28, 58)])
def test_lints_clean(mark_w: int, high_w: int) -> None:
    assert lint(TOP, MARK_W=mark_w, HIGH_W=high_w) == (0, "")


@pytest.mark.parametrize(
    ("mark_w", "high_w", "rule"), [(1, 9, "MARK_W_must_be_at_least_2"), (9, 9, "HIGH_W_must_exceed_MARK_W")]
)
def test_refuses_parameters(mark_w: int, high_w: int, rule: str) -> None:
    code, log = lint(TOP, MARK_W=mark_w, HIGH_W=high_w)
    assert code != 0
    assert rule in log


@pytest.mark.parametrize("mark_w", [3, 12])
def test_any_mark_after_any_mark(mark_w: int) -> None:
    """8 steps to every side of all steps that matter: none, half a turn and a whole one."""
    sim = load(TOP, {"MARK_W": mark_w, "HIGH_W": 24})
    reset(sim)
    assert (sim.io.known, sim.io.high) == (0, 0)
    rng, size, high = np.random.default_rng(5), 1 << mark_w, -1
    for _ in range(5_000):
        step = int(rng.choice([0, size // 2, rng.integers(size)])) + int(rng.integers(-8, 9))
        mark, is_set = (max(high, 0) + step) % size, int(rng.random() < 0.9)
        sim.io.set, sim.io.mark = is_set, mark
        assert sim.io.differs == (high < 0 or mark != high % size)
        sim.clock.tick()
        high = int(advance(high, mark, size)) if is_set else high
        assert (sim.io.known, sim.io.high) == (high >= 0, max(high, 0) % (1 << 24))
    assert high > 100 * size
    reset(sim)
    assert (sim.io.known, sim.io.high) == (0, 0)

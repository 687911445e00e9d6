# SPDX-License-Identifier: Apache-2.0
"""dff.v against its twin, in both reset modes."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.hardware.dff import Dff
from evcot_cosim.rtl.build import load
from support.testing import lint

COMPLEMENT = "RESET_TO_COMPLEMENT"


@pytest.mark.parametrize("mode", [0, 1])
def test_lints_clean(mode: int) -> None:
    assert lint("dff", RESET_TO_COMPLEMENT=mode) == (0, "")


@pytest.mark.parametrize("mode", [-1, 2])
def test_refuses_an_unknown_reset(mode: int) -> None:
    code, log = lint("dff", RESET_TO_COMPLEMENT=mode)
    assert code != 0
    assert "RESET_TO_COMPLEMENT_must_be_0_or_1" in log


@pytest.mark.parametrize(("mode", "in_reset"), [(0, [0, 0, 0]), (1, [0, 1, 0])])
def test_reset_then_data(mode: int, in_reset: list[int]) -> None:
    sim = load("dff", {COMPLEMENT: mode})
    sim.io.rst = 1
    outputs = []
    for d in (1, 0, 1):
        sim.io.d = d
        sim.clock.tick()
        outputs.append(int(sim.io.q))
    assert outputs == in_reset
    sim.io.rst = 0
    assert sim.io.q == in_reset[-1]  # nothing moves between two clocks
    sim.clock.tick()
    assert sim.io.q == 1


@pytest.mark.parametrize("mode", [0, 1])
def test_random_inputs_match_the_twin(mode: int) -> None:
    sim, twin = load("dff", {COMPLEMENT: mode}), Dff(reset_to_complement=bool(mode))
    assert sim.io.q == twin.q
    for d, rst in np.random.default_rng(mode).random((2000, 2)) < (0.5, 0.2):
        sim.io.d, sim.io.rst = int(d), int(rst)
        sim.clock.tick()
        assert sim.io.q == twin.step(bool(d), rst=bool(rst))

# SPDX-License-Identifier: Apache-2.0
"""The flip-flop and the synchroniser."""

from __future__ import annotations

import re

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import rtl_files

COMPLEMENT = "RESET_TO_COMPLEMENT"


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
def test_random_inputs_come_out_a_clock_later_or_are_reset(mode: int) -> None:
    sim = load("dff", {COMPLEMENT: mode})
    assert sim.io.q == 0
    for d, rst in np.random.default_rng(mode).random((2000, 2)) < (0.5, 0.2):
        sim.io.d, sim.io.rst = int(d), int(rst)
        sim.clock.tick()
        assert bool(sim.io.q) == ((mode and not d) if rst else d)


TOP = "synchronizer"


def test_no_module_puts_logic_before_a_synchronizer() -> None:
    inputs = [
        (path.name, found)
        for path in rtl_files().values()
        for found in re.findall(r"synchronizer #\(.*?\.d\s*\((.*?)\),\n", path.read_text(), re.DOTALL)
    ]
    assert len(inputs) >= 3
    assert [(name, found) for name, found in inputs if not re.fullmatch(r"\w+", found)] == []


@pytest.mark.parametrize("attribute", ["ASYNC_REG", "altera_attribute", "syn_preserve", "keep"])
def test_its_registers_are_kept_by_the_tools_of_every_vendor(attribute: str) -> None:
    declaration = re.search(r"((?:\(\*.*?\*\)\s*)+)reg \[STAGES-1:0\] stages;", rtl_files()[f"{TOP}.v"].read_text(), re.DOTALL)
    assert declaration is not None
    assert re.search(rf"\b{attribute} = ", declaration[1])


@pytest.mark.parametrize(("stages", "after_reset"), [(2, 0), (4, 1)])
def test_a_row_of_flip_flops(stages: int, after_reset: int) -> None:
    sim = load(TOP, {"STAGES": stages, "RESET": after_reset})
    sim.io.d = 1 - after_reset
    reset(sim)
    sent = np.random.default_rng(1).integers(0, 2, 200).tolist()
    seen = []
    for d in sent:
        sim.io.d = d
        seen.append(int(sim.io.q))
        sim.clock.tick()
    assert seen == ([after_reset] * stages + sent)[:200]

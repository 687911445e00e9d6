# SPDX-License-Identifier: Apache-2.0
"""synchronizer.v: so many clocks late, and as it shall be after reset."""

from __future__ import annotations

import re

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import rtl_files
from support.testing import lint

TOP = "synchronizer"


@pytest.mark.parametrize("stages", [2, 3, 4])
def test_lints_clean(stages: int) -> None:
    assert lint(TOP, STAGES=stages, RESET=stages % 2) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"), [({"STAGES": 1}, "STAGES_must_be_2_to_4"), ({"RESET": 2}, "RESET_must_be_0_or_1")]
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


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

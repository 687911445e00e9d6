# SPDX-License-Identifier: Apache-2.0
"""A difference between hardware and model with few events, as a test that fails until it is gone."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from evcot.errors import OutputError
from evcot.hardware.contract import Shape
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.mismatch import MismatchError
from evcot_cosim.lockstep.random_runs import Design, random_case, run_case
from evcot_cosim.lockstep.shrink import difference_in, shrunk, write_test
from support.testing import broken_copy

SHAPE = Shape(n_slots=2, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20, tick_w=3)


def test_a_case_shrinks_to_a_test_that_fails_on_the_broken_hardware_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = "m_cm_support <= w_support[SUP_W-1:0] | {SUP_W{w_support[SUP_W]}};"
    verilog = broken_copy(tmp_path / "rtl", "array_update.v", right, right.replace(" | ", " - 1'b1 | "))
    cases = [random_case(Design("cot_array", SHAPE), seed, 2_000) for seed in range(4)]
    broken = build_device(cases[0].config, verilog=verilog)
    case = next(case for case in cases if difference_in(case, broken))
    small, mismatch = shrunk(case, broken)
    print(len(small.events), mismatch)
    assert len(small.events) < 40
    assert mismatch.field == "record.support"
    assert difference_in(small, broken) == mismatch

    write_test(small, mismatch, tmp_path, "found", broken)
    assert (tmp_path / "found.vcd").stat().st_size > 1_000
    with pytest.raises(OutputError, match=r"test_found\.py"):
        write_test(small, mismatch, tmp_path, "found", broken)
    test = runpy.run_path(str(tmp_path / "test_found.py"))
    test["test_hardware_and_model_agree"]()
    monkeypatch.setenv("EVCOT_VERILOG", str(verilog))
    with pytest.raises(MismatchError, match=r"record\.support"):
        test["test_hardware_and_model_agree"]()


def test_where_both_agree_there_is_nothing_to_shrink() -> None:
    case = random_case(Design("cot_array", SHAPE), 1, 500)
    assert run_case(case).events == 500
    with pytest.raises(ValueError, match="hardware and model agree"):
        shrunk(case)

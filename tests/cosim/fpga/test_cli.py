# SPDX-License-Identifier: Apache-2.0
"""fpga.cli: which of the measured figures are recorded."""

from __future__ import annotations

from dataclasses import replace

from evcot_cosim.fpga.cli import recorded_rows
from evcot_cosim.fpga.figures import Figure, Figures

SMALL = Figure("cot_array", 8, "ecp5-25", "key", 3_662, 3_053, 0, 568, 0, 1, (150.0,))


def by_name(*figures: Figure) -> Figures:
    return {figure.name: figure for figure in figures}


def test_a_larger_device_says_nothing_more_once_a_smaller_one_was_routed() -> None:
    larger = [replace(SMALL, device=device) for device in ("ecp5-45", "ecp5-85")]
    assert list(recorded_rows(by_name(*larger, SMALL))) == ["cot_array N=8 ecp5-25"]


def test_what_does_not_fit_is_kept_up_to_the_device_that_it_fits() -> None:
    full = replace(SMALL, fmax_mhz=(), misfit="does not fit: 69 of 56 block RAMs")
    larger = [replace(SMALL, device=device) for device in ("ecp5-45", "ecp5-85")]
    assert list(recorded_rows(by_name(full, *larger))) == ["cot_array N=8 ecp5-25", "cot_array N=8 ecp5-45"]


def test_a_larger_size_says_nothing_more_where_a_smaller_one_does_not_fit() -> None:
    full = replace(SMALL, n=4, device="up5k", fmax_mhz=(), misfit="does not fit: 35 of 30 block RAMs")
    sizes = recorded_rows(by_name(*(replace(full, n=n) for n in (4, 8, 16)), replace(SMALL, n=2, device="up5k")))
    assert [row.n for row in sizes.values()] == [2, 4, 8]  # 8 is in every table


def test_other_sizes_and_families_are_other_cases() -> None:
    others = [replace(SMALL, n=16, device="ecp5-45"), replace(SMALL, device="hx8k"), replace(SMALL, device="gowin")]
    assert len(recorded_rows(by_name(SMALL, *others))) == 4


def test_modules_and_devices_of_the_past_are_dropped() -> None:
    assert not recorded_rows(by_name(replace(SMALL, module="cot_engine"), replace(SMALL, device="ecp5-12")))

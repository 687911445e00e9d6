# SPDX-License-Identifier: Apache-2.0
"""The table of figures: its file, the noise of seeds, and the detection of regressions."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot_cosim.fpga import cli
from evcot_cosim.fpga.cli import recorded_rows
from evcot_cosim.fpga.devices import DEVICES, Resources
from evcot_cosim.fpga.figures import Figure, Figures, growths, load, save, seed_noise

SIX = Figure("cot_array", 8, "ecp5-25", "k", 4000, 3000, 0, 600, 2, 5, (118.0, 120.0, 121.0, 119.5, 122.0))


def worse(now: Figure, before: Figure = SIX, noise: float = 0.01) -> list[str]:
    return [growth.what for growth in growths(before, now, noise)]


def test_a_design_that_misses_its_own_constraint_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    asked = replace(SIX, module="evcot_top_davis", n=4)
    assert cli._slow([SIX, asked, replace(asked, fmax_mhz=())]) == 0
    assert cli._slow([SIX, replace(asked, fmax_mhz=(90.0, 99.0, 120.0))]) == 1
    assert capsys.readouterr().err == "evcot: evcot_top_davis N=4 ecp5-25: median Fmax 99.0 MHz: must be at least 100\n"


def test_a_file_gives_back_what_was_saved(tmp_path: Path) -> None:
    none = replace(SIX, module="filter_mask", n=None, seeds=0, fmax_mhz=(), misfit="does not fit: 38 of 32 block RAMs")
    figures = {row.name: row for row in (SIX, none)}
    save(tmp_path / "figures.json", figures, {"yosys": "0.70"})
    assert load(tmp_path / "figures.json") == figures
    assert list(figures) == ["cot_array N=8 ecp5-25", "filter_mask ecp5-25"]
    assert len((tmp_path / "figures.json").read_text().splitlines()) < 12
    assert load(tmp_path / "none.json") == {}


def test_a_tool_that_was_not_used_keeps_its_version(tmp_path: Path) -> None:
    save(tmp_path / "figures.json", {}, {"yosys": "0.70", "nextpnr-ice40": "0.11"})
    save(tmp_path / "figures.json", {}, {"yosys": "0.71"})
    assert json.loads((tmp_path / "figures.json").read_text())["tools"] == {"yosys": "0.71", "nextpnr-ice40": "0.11"}


@pytest.mark.parametrize("text", ["", "[]", '{"figures": [{"module": "cot"}]}', '{"figures": 1}'])
def test_another_file_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "figures.json"
    path.write_text(text)
    with pytest.raises(ConfigError, match=r"figures.json: not a table of figures: "):
        load(path)


def test_five_percent_more_is_allowed_and_six_are_not() -> None:
    assert worse(SIX) == []
    assert worse(replace(SIX, luts=4200, ffs=3150)) == []
    assert worse(replace(SIX, luts=4201)) == ["luts"]
    assert worse(replace(SIX, ffs=3180, multipliers=3)) == ["ffs", "multipliers"]
    assert worse(replace(SIX, block_rams=1)) == ["block_rams"]
    assert worse(replace(SIX, luts=2000)) == []


def test_a_few_pieces_of_a_small_module_are_allowed() -> None:
    small = replace(SIX, luts=40, ffs=20)
    assert worse(replace(small, luts=48, ffs=28), small) == []
    assert worse(replace(small, luts=49), small) == ["luts"]


def test_a_slower_median_counts_beyond_limit_and_noise() -> None:
    def slower(part: float) -> Figure:
        return replace(SIX, fmax_mhz=tuple(mhz * part for mhz in SIX.fmax_mhz))

    assert worse(slower(0.96)) == []
    assert worse(slower(0.94)) == ["median Fmax"]
    assert worse(slower(0.94), noise=0.05) == []  # two standard errors are 8 % then
    assert worse(slower(0.90), noise=0.05) == ["median Fmax"]
    assert worse(slower(1.2)) == []


def test_what_no_longer_fits_is_worse() -> None:
    assert worse(replace(SIX, fmax_mhz=(), misfit="does not fit: 25,000 of 24,288 LUTs")) == ["fit"]


def test_chance_alone_trips_the_check_rarely() -> None:
    rng = np.random.default_rng(5)
    noise, trips = 0.04, 0
    for _ in range(2000):
        before, now = (replace(SIX, fmax_mhz=tuple(rng.normal(120, 120 * noise, 5))) for _ in range(2))
        trips += bool(growths(before, now, noise))
    assert trips < 0.04 * 2000


def test_the_noise_of_seeds_is_pooled() -> None:
    rng = np.random.default_rng(6)
    rows = [replace(SIX, fmax_mhz=tuple(rng.normal(mhz, mhz * 0.03, 5))) for mhz in rng.uniform(20, 200, 200)]
    assert seed_noise(rows) == pytest.approx(0.03, rel=0.1)
    assert seed_noise([replace(SIX, fmax_mhz=(100.0,))]) == 0.05


def test_cells_are_counted_by_their_names() -> None:
    ecp5 = DEVICES["ecp5-25"]
    assert ecp5.count(
        {"LUT4": 10, "CCU2C": 3, "TRELLIS_FF": 7, "TRELLIS_DPR16X4": 2, "PFUMX": 4, "DP16KD": 1, "MULT18X18D": 2}
    ) == (Resources(luts=24, ffs=7, block_rams=1, lut_rams=8, multipliers=2))
    assert DEVICES["xilinx7"].count({"LUT6": 1, "LUT2": 1, "RAMB36E1": 1, "RAMB18E1": 1, "FDRE": 3, "DSP48E1": 1}) == Resources(
        luts=2, ffs=3, block_rams=3, multipliers=1
    )
    assert DEVICES["hx8k"].count({"SB_LUT4": 5, "SB_CARRY": 4, "SB_DFFESR": 2, "SB_DFF": 1}) == Resources(luts=5, ffs=3)


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

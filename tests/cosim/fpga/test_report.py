# SPDX-License-Identifier: Apache-2.0
"""Figures: their file, the noise of seeds and what is worse; and their page: tables, picture, latencies."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from PIL import Image

from evcot.errors import ConfigError
from evcot_cosim.fpga import __main__ as cli
from evcot_cosim.fpga.__main__ import recorded_rows
from evcot_cosim.fpga.catalogue import MODULES
from evcot_cosim.fpga.curves import draw
from evcot_cosim.fpga.devices import DEVICES, Resources
from evcot_cosim.fpga.figures import Figure, Figures, growths, load, save, seed_noise
from evcot_cosim.fpga.latency import clocks
from evcot_cosim.fpga.measure import Case, key_of
from evcot_cosim.fpga.report import outdated, shown_clocks, write_tables
from evcot_cosim.fpga.sources import closure, logic
from evcot_cosim.rtl.files import verilog_dir

REPOSITORY = verilog_dir().parents[1]
ARRAY = Figure("cot_array", 8, "ecp5-25", "k", 4_001, 3_000, 0, 600, 2, 3, (118.0, 125.0, 131.0))
MASK = Figure("filter_mask", None, "hx8k", "k", 200, 100, 40, 0, 0, misfit="does not fit: 40 of 32 block RAMs")
MARKS = "".join(f"{name}:\n<!-- {name} -->\nold\n<!-- end -->\n" for name in ("cost", "scaling", "latency", "noise"))


def table(*rows: Figure) -> Figures:
    return {row.name: row for row in rows}


@pytest.fixture
def page(tmp_path: Path) -> Path:
    """A page with a mark for each table."""
    (tmp_path / "fpga.md").write_text(MARKS)
    return tmp_path / "fpga.md"


def section(text: str, name: str) -> str:
    found = re.search(rf"<!-- {name} -->\n(.*?)<!-- end -->", text, re.DOTALL)
    assert found is not None
    return found[1]


def test_tables_say_what_was_measured(page: Path) -> None:
    page.write_text(f"before\n{MARKS}after\n")
    write_tables(page, table(ARRAY, MASK), {"cot_array N=8": 8, "filter_mask": 4})
    text = page.read_text()
    assert "| cot_array, N = 8 | 4,001 | 600 | 3,000 | 0 | 2 | 125 (131) |" in section(text, "cost")
    assert "| filter_mask | 200 | 0 | 100 | 40 | 0 | does not fit: 40 of 32 block RAMs |" in section(text, "cost")
    assert "| cot_array, N = 8 | 8 | ecp5-25 | 125 | 64 |" in section(text, "latency")  # 8 clocks of 8 ns
    assert "filter_mask" not in section(text, "latency")
    assert "| published tracker, its cell alone | 7 at 50 MHz |  |  | 140 |" in section(text, "latency")
    assert "cot_array" not in section(text, "scaling")  # one size does not scale
    assert "old" not in text
    assert text.startswith("before\ncost:\n")
    assert text.endswith("<!-- end -->\nafter\n")

    write_tables(page, table(ARRAY, MASK), {"cot_array N=8": 8, "filter_mask": 4})
    assert page.read_text() == text


def test_a_table_says_how_many_seeds_were_routed_where_they_are_not_the_usual_number(page: Path) -> None:
    cases = [
        (1, (118.0,), "118 (118), one seed |"),
        (2, (118.0, 122.0), "120 (122), 2 seeds |"),
        (3, (118.0, 122.0), "120 (122), 2 of 3 seeds |"),
        (3, ARRAY.fmax_mhz, "125 (131) |"),
    ]
    for seeds, fmax, says in cases:
        write_tables(page, table(replace(ARRAY, seeds=seeds, fmax_mhz=fmax)), {})
        assert says in section(page.read_text(), "cost")


def test_an_example_is_shown_at_the_size_it_has(page: Path) -> None:
    davis = replace(ARRAY, module="evcot_top_davis", n=4)
    write_tables(page, table(davis, replace(ARRAY, n=4)), {})
    cost = section(page.read_text(), "cost")
    assert "| evcot_top_davis, N = 4 |" in cost
    assert "cot_array" not in cost


def test_latency_is_that_on_the_first_device_that_was_routed_for(page: Path) -> None:
    too_small = replace(ARRAY, fmax_mhz=(), misfit="does not fit: more of everything")
    larger = [replace(ARRAY, device=device, fmax_mhz=(mhz,)) for device, mhz in (("ecp5-85", 160.0), ("ecp5-45", 100.0))]
    write_tables(page, table(too_small, *larger), {"cot_array N=8": 8})
    assert "| cot_array, N = 8 | 8 | ecp5-45 | 100 | 80 |" in section(page.read_text(), "latency")
    write_tables(page, table(*larger), {"cot_array N=8": 8}, {larger[1].name})
    assert "| cot_array, N = 8 | 8 | ecp5-85 | 160 | 50 |" in section(page.read_text(), "latency")


def test_scaling_tells_luts_once_for_one_synthesis_and_fmax_for_each_device(page: Path) -> None:
    small, large = replace(ARRAY, n=1, luts=900), replace(ARRAY, device="ecp5-85", fmax_mhz=(140.0,), misfit="gave up twice")
    tight = replace(ARRAY, device="hx8k", luts=4_100, fmax_mhz=(), misfit="does not fit: 35 of 32 block RAMs")
    fits = replace(tight, n=1, luts=800, seeds=1, fmax_mhz=(97.0,), misfit="")
    gowin = replace(small, device="gowin", luts=950, fmax_mhz=(), seeds=0)
    write_tables(page, table(small, ARRAY, large, fits, tight, gowin), {})
    assert section(page.read_text(), "scaling").splitlines()[2:] == [
        "| cot_array, LUTs, ecp5 | 900 | 4,001 |",
        "| cot_array, MHz, ecp5-25 | 125 (131) | 125 (131) |",
        "| cot_array, MHz, ecp5-85 |  | 140 (140), 1 of 3 seeds |",
        "| cot_array, LUTs, hx8k | 800 | 4,100 |",
        "| cot_array, MHz, hx8k | 97 (97), one seed | – |",
        "| cot_array, LUTs, gowin | 950 |  |",
    ]


def test_what_is_of_another_text_of_the_module_is_marked(page: Path) -> None:
    small = replace(ARRAY, n=1, luts=900)
    write_tables(page, table(small, ARRAY, MASK), {"cot_array N=1": 8, "cot_array N=8": 8}, {ARRAY.name})
    text = page.read_text()
    assert "| cot_array, N = 8 † | 4,001 |" in section(text, "cost")
    assert "| filter_mask | 200 |" in section(text, "cost")
    assert "| cot_array, LUTs, ecp5 | 900 | 4,001 † |" in section(text, "scaling")
    assert "| cot_array, MHz, ecp5-25 | 125 (131) | 125 (131) † |" in section(text, "scaling")
    assert "| cot_array, N = 8 | 8 | ecp5-25 | 125 † | 64 † |" in section(text, "latency")
    assert "| cot_array, N = 1 | 8 | ecp5-25 | 125 | 64 |" in section(text, "latency")
    assert shown_clocks(text) == {"cot_array N=1": 8, "cot_array N=8": 8}


def test_a_figure_is_outdated_when_its_key_is_not_that_of_the_sources() -> None:
    case = Case(MODULES["filter_polarity"], None, DEVICES["ecp5-25"])
    modules = closure([case.module.top])
    now = key_of(case, (modules, logic(modules)), "Yosys 1")
    fresh = Figure("filter_polarity", None, "ecp5-25", now, 33, 39, 0, 0, 0)
    assert outdated([fresh], "Yosys 1") == frozenset()
    assert outdated([fresh], "Yosys 2") == {fresh.name}
    elsewhere = replace(fresh, device="hx8k")  # with other commands
    assert outdated([fresh, elsewhere, replace(fresh, module="gone")], "Yosys 1") == {elsewhere.name, "gone ecp5-25"}


def test_a_mark_that_is_missing_is_named(page: Path) -> None:
    page.write_text(MARKS.replace("<!-- scaling -->", ""))
    with pytest.raises(ConfigError, match=r"fpga.md: <!-- scaling --> is there 0 times: must be once"):
        write_tables(page, table(ARRAY), {})


def test_the_picture_is_drawn_from_few_figures_or_many(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    legends = []
    monkeypatch.setattr(Axes, "legend", lambda axes, **_: legends.append(axes.get_title(loc="left")))
    draw(table(ARRAY), {}, tmp_path / "few.png")
    many = [replace(ARRAY, module=name, n=n) for name in ("cot_chain", "cot_array") for n in (1, 2, 4, 8)]
    draw(table(*many), {f"{row.module} N={row.n}": 8 for row in many}, tmp_path / "many.png")
    draw(table(*many), {f"{row.module} N={row.n}": 8 for row in many}, tmp_path / "old.png", {many[0].name})
    names = ("few.png", "many.png", "old.png")
    for name in names:
        with Image.open(tmp_path / name) as picture:
            assert picture.size == (1950, 615)
    assert legends == ["(b) Fmax, MHz: median and range over seeds"] * len(names), "one for all three panels"
    assert len({(tmp_path / name).read_bytes() for name in names}) == 3, "what is outdated is drawn otherwise"


# By the headers: cot_published_chain's 14 and 3 for each of three upstream; aer_in's and aer_out's SYNC + 2 and SETUP + 1.
LATENCIES = {
    "cot": 4, "cot_published_chain": 14 + 3 * 3, "filter_polarity": 1, "evt2_decoder": 6, "evt21_decoder": 6, "evt3_decoder": 6,
    "overload_fifo": 6, "aer_in": 2 + 2, "aer_out": 1 + 1,
}  # fmt: skip


@pytest.mark.parametrize(("name", "expected"), LATENCIES.items())
def test_latency_is_what_the_modules_header_and_the_page_say(name: str, expected: int) -> None:
    assert clocks(MODULES[name], None) == expected
    shown = section((REPOSITORY / "docs" / "fpga.md").read_text(), "latency")
    assert re.search(rf"^\| {name} \| {expected} \| ecp5-25 \| \d+(?: †)? \| \d+(?: †)? \|$", shown, re.MULTILINE)


def test_what_answers_nothing_has_no_latency() -> None:
    assert clocks(MODULES["lfsr_event_source"], None) is None


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


def test_a_larger_device_says_nothing_more_once_a_smaller_one_was_routed_or_fits() -> None:
    larger = [replace(SMALL, device=device) for device in ("ecp5-45", "ecp5-85")]
    assert list(recorded_rows(by_name(*larger, SMALL))) == ["cot_array N=8 ecp5-25"]
    full = replace(SMALL, fmax_mhz=(), misfit="does not fit: 69 of 56 block RAMs")
    assert list(recorded_rows(by_name(full, *larger))) == ["cot_array N=8 ecp5-25", "cot_array N=8 ecp5-45"]


def test_a_larger_size_says_nothing_more_where_a_smaller_one_does_not_fit() -> None:
    full = replace(SMALL, n=4, device="up5k", fmax_mhz=(), misfit="does not fit: 35 of 30 block RAMs")
    sizes = recorded_rows(by_name(*(replace(full, n=n) for n in (4, 8, 16)), replace(SMALL, n=2, device="up5k")))
    assert [row.n for row in sizes.values()] == [2, 4, 8]  # 8 is in every table


def test_other_sizes_and_families_are_other_cases_and_those_of_the_past_are_dropped() -> None:
    others = [replace(SMALL, n=16, device="ecp5-45"), replace(SMALL, device="hx8k"), replace(SMALL, device="gowin")]
    assert len(recorded_rows(by_name(SMALL, *others))) == 4
    assert not recorded_rows(by_name(replace(SMALL, module="cot_engine"), replace(SMALL, device="ecp5-12")))


def test_the_page_has_the_commands_that_map_for_few_luts() -> None:
    *before, synthesis = DEVICES["ecp5-45"].small
    assert f"`{'; '.join([*before, synthesis])} -top evcot_top -json out.json`" in (REPOSITORY / "docs" / "fpga.md").read_text()

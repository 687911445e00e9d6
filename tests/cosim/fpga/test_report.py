# SPDX-License-Identifier: Apache-2.0
"""The page of figures: what the tables say, that they are those of the recorded figures, and the picture."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.axes import Axes
from PIL import Image

from evcot.errors import ConfigError
from evcot_cosim.fpga.catalogue import MODULES
from evcot_cosim.fpga.curves import draw
from evcot_cosim.fpga.devices import DEVICES
from evcot_cosim.fpga.figures import Figure, Figures, load, recorded_with
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


def section(text: str, name: str) -> str:
    found = re.search(rf"<!-- {name} -->\n(.*?)<!-- end -->", text, re.DOTALL)
    assert found is not None
    return found[1]


def test_tables_say_what_was_measured(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
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


def test_a_table_says_how_many_seeds_were_routed_where_they_are_not_the_usual_number(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    page.write_text(MARKS)
    cases = [
        (1, (118.0,), "118 (118), one seed |"),
        (2, (118.0, 122.0), "120 (122), 2 seeds |"),
        (3, (118.0, 122.0), "120 (122), 2 of 3 seeds |"),
        (3, ARRAY.fmax_mhz, "125 (131) |"),
    ]
    for seeds, fmax, says in cases:
        write_tables(page, table(replace(ARRAY, seeds=seeds, fmax_mhz=fmax)), {})
        assert says in section(page.read_text(), "cost")


def test_an_example_is_shown_at_the_size_it_has(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    page.write_text(MARKS)
    davis = replace(ARRAY, module="evcot_top_davis", n=4)
    write_tables(page, table(davis, replace(ARRAY, n=4)), {})
    cost = section(page.read_text(), "cost")
    assert "| evcot_top_davis, N = 4 |" in cost
    assert "cot_array" not in cost


def test_latency_is_that_on_the_first_device_that_was_routed_for(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    page.write_text(MARKS)
    too_small = replace(ARRAY, fmax_mhz=(), misfit="does not fit: more of everything")
    larger = [replace(ARRAY, device=device, fmax_mhz=(mhz,)) for device, mhz in (("ecp5-85", 160.0), ("ecp5-45", 100.0))]
    write_tables(page, table(too_small, *larger), {"cot_array N=8": 8})
    assert "| cot_array, N = 8 | 8 | ecp5-45 | 100 | 80 |" in section(page.read_text(), "latency")
    write_tables(page, table(*larger), {"cot_array N=8": 8}, {larger[1].name})
    assert "| cot_array, N = 8 | 8 | ecp5-85 | 160 | 50 |" in section(page.read_text(), "latency")


def test_scaling_tells_luts_once_for_one_synthesis_and_fmax_for_each_device(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    page.write_text(MARKS)
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


def test_what_is_of_another_text_of_the_module_is_marked(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    page.write_text(MARKS)
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


def test_a_mark_that_is_missing_is_named(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    page.write_text(MARKS.replace("<!-- scaling -->", ""))
    with pytest.raises(ConfigError, match=r"fpga.md: <!-- scaling --> is there 0 times: must be once"):
        write_tables(page, table(ARRAY), {})


def test_the_page_is_that_of_the_recorded_figures(tmp_path: Path) -> None:
    page = tmp_path / "fpga.md"
    shown = (REPOSITORY / "docs" / "fpga.md").read_text()
    page.write_text(shown)
    recorded = REPOSITORY / "hw" / "fpga" / "figures.json"
    figures = load(recorded)
    write_tables(page, figures, shown_clocks(shown), outdated(figures.values(), recorded_with(recorded)))
    for name in ("cost", "scaling", "latency", "noise"):
        assert section(page.read_text(), name) == section(shown, name), "run make generate"


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

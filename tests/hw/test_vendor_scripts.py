# SPDX-License-Identifier: Apache-2.0
"""hw/fpga/scripts in a release: Tcl that runs to its end with the vendor's commands replaced, and names files that exist."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from evcot_cosim.fpga.release import write_release
from evcot_cosim.rtl.files import verilog_dir

SCRIPTS = sorted((verilog_dir().parent / "fpga" / "scripts").glob("*.tcl"))
VERSIONS = {"vivado": "Vivado 2023.2", "quartus": "Quartus Prime Standard 22.1", "radiant": "Radiant 2023.2"}

# Prints every command that Tcl does not have, with its arguments, one to a line.
STUBS = """
proc unknown {args} { puts [join $args \\t] }
rename package tcl_package
proc package {args} {}
source [lindex $argv 0]
"""


@pytest.fixture(scope="module")
def release(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("release")
    write_release(folder)
    return folder


def commands(folder: Path, script: str) -> list[list[str]]:
    """What a script of a release calls."""
    if shutil.which("tclsh") is None:
        pytest.skip("tclsh is not installed")
    (folder / "stubs.tcl").write_text(STUBS)
    run = ["tclsh", "stubs.tcl", f"scripts/{script}"]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return [line.split("\t") for line in done.stdout.splitlines()]


@pytest.mark.parametrize("script", [path.name for path in SCRIPTS])
def test_a_script_names_the_top_and_files_that_are_in_the_release(release: Path, script: str) -> None:
    words = [word for command in commands(release, script) for argument in command for word in argument.split()]
    files = {Path(word).relative_to(release).as_posix() for word in words if Path(word).suffix in (".v", ".sdc")}
    assert files == {"evcot.v", "examples/kv260_evcot.v", "scripts/kv260.sdc"}
    assert all((release / file).is_file() for file in files)
    assert (release / "examples" / "evcot_regs.vh").is_file()
    assert "kv260_evcot" in words
    assert str(release / "examples") in words


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_a_script_names_its_version_and_that_it_is_untested(path: Path) -> None:
    (version,) = (named for vendor, named in VERSIONS.items() if path.name.startswith(vendor))
    head = " ".join(line for line in path.read_text().splitlines() if line.startswith("#"))
    assert f"Written for {version}. Untested" in head
    assert re.search(r"[0-9]", version)


def test_there_is_one_for_each_vendor() -> None:
    assert [path.name.partition("_")[0] for path in SCRIPTS] == sorted(VERSIONS)


def test_a_file_that_is_missing_is_noticed(release: Path) -> None:
    text = (release / "scripts" / "vivado_kv260.tcl").read_text()
    (release / "scripts" / "broken.tcl").write_text(text.replace("/evcot.v", "/evcott.v"))
    words = [word for command in commands(release, "broken.tcl") for argument in command for word in argument.split()]
    assert str(release / "evcott.v") in words

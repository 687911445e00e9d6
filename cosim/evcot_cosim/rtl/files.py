# SPDX-License-Identifier: Apache-2.0
"""The sources of the RTL, and fingerprints of what a run's result depends on."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from functools import cache
from hashlib import blake2b
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path, PurePosixPath

import evcot

__all__ = [
    "code_fingerprint",
    "copy_rtl",
    "design_fingerprint",
    "manifest",
    "modules",
    "rtl_files",
    "search_flags",
    "verilog_dir",
    "versions",
]


_PACKAGE = Path(__file__).parents[1]


def verilog_dir() -> Path:
    """The folder of the RTL: $EVCOT_VERILOG, else the checkout's when running from one, else the installed package's copy."""
    if chosen := os.environ.get("EVCOT_VERILOG"):
        return Path(chosen).absolute()
    checkout = _PACKAGE.parents[1] / "hw" / "verilog"
    return checkout if checkout.is_dir() else _PACKAGE / "verilog"


def manifest(verilog: Path | None = None) -> list[str]:
    """The paths of all files below the RTL's folder, headers too, each after those that it needs."""
    lines = ((verilog or verilog_dir()) / "manifest.txt").read_text().splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def modules(verilog: Path | None = None) -> list[str]:
    """The names of all modules, each after those that it instantiates."""
    return [path.stem for path in map(PurePosixPath, manifest(verilog)) if path.suffix == ".v"]


def rtl_files(verilog: Path | None = None) -> dict[str, Path]:
    """Every Verilog file below a folder by its name, which is that of one file only."""
    return {path.name: path for path in sorted((verilog or verilog_dir()).rglob("*.v*"))}


def search_flags(verilog: Path | None = None) -> list[str]:
    """Arguments by which Verilator and Icarus find modules and headers."""
    folders = sorted({path.parent for path in rtl_files(verilog).values()})
    return [flag for folder in folders for flag in ("-y", str(folder), f"-I{folder}")]


def copy_rtl(folder: Path, verilog: Path | None = None) -> Path:
    """Copy the RTL and its manifest into one folder without sub-folders, which is made; returns it."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in (*rtl_files(verilog).values(), (verilog or verilog_dir()) / "manifest.txt"):
        (folder / path.name).write_bytes(path.read_bytes())
    return folder


_RESULTS_DEPEND_ON = ("numpy", "numba", "scipy")
_PACKAGES = ("devices", "lockstep", "rtl")  # of evcot_cosim, besides all of evcot


def versions() -> dict[str, str]:
    """Versions of what a result could depend on."""
    packages = {name: version(name) for name in _RESULTS_DEPEND_ON}
    return {"evcot": evcot.__version__, "python": platform.python_version(), **packages}


@cache
def code_fingerprint(further: Sequence[Path] = ()) -> str:
    """A digest of evcot's sources and `versions`: 16 hexadecimal digits.

    Args:
        further: source files on which the result depends, too.
    """
    summary = blake2b(repr(sorted(versions().items())).encode(), digest_size=8)
    spec = find_spec("evcot")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    package = Path(spec.submodule_search_locations[0])
    for folder in (package, *(Path(__file__).parents[1] / name for name in _PACKAGES)):
        for path in sorted((*folder.rglob("*.py"), *folder.rglob("*.cpp.j2"), *folder.rglob("*.toml"))):
            summary.update(str(path.relative_to(folder)).encode())
            summary.update(path.read_bytes())
    for path in further:
        summary.update(path.read_bytes())
    return summary.hexdigest()


@cache
def design_fingerprint() -> str:
    """A digest of the RTL's sources: 16 hexadecimal digits."""
    summary = blake2b(digest_size=8)
    for name, path in sorted(rtl_files().items()):
        summary.update(name.encode())
        summary.update(path.read_bytes())
    return summary.hexdigest()

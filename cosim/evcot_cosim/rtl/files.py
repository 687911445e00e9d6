# SPDX-License-Identifier: Apache-2.0
"""Where the RTL is: its folder, the manifest, and each file by its name, whichever sub-folder it is in."""

from __future__ import annotations

import os
from pathlib import Path, PurePosixPath

__all__ = ["copy_rtl", "manifest", "modules", "rtl_files", "search_flags", "verilog_dir"]

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

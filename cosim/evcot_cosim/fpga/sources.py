# SPDX-License-Identifier: Apache-2.0
"""The RTL as one text: a module with all that it instantiates and includes, in the order of the manifest."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from evcot.errors import ConfigError

from ..build.rtl import modules, rtl_files, verilog_dir

__all__ = ["closure", "flat", "stand_ins", "without_comments"]

_COMMENT = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)
_INCLUDE = re.compile(r'^[ \t]*`include[ \t]+"([^"]+)"[^\n]*\n', re.MULTILINE)
_PROOF = re.compile(r"^`ifdef FORMAL\n.*?^`endif\n+", re.MULTILINE | re.DOTALL)
_GUARD = re.compile(r"\A\s*`ifndef\s+\w+")
_WORD = re.compile(r"\b[A-Za-z_]\w*\b")


def without_comments(text: str) -> str:
    """Verilog without comments, empty lines and spaces at the ends of lines."""
    bare = _COMMENT.sub(lambda found: found[0] if found[0].startswith('"') else " ", text)
    return "".join(f"{line.rstrip()}\n" for line in bare.splitlines() if line.strip())


def closure(tops: Iterable[str], verilog: Path | None = None) -> list[str]:
    """`tops` and every module below them, in the manifest's order.

    Raises:
        ConfigError: a top is not in the manifest.
    """
    known, files = modules(verilog), rtl_files(verilog)
    waiting, needed = list(tops), set[str]()
    for top in waiting:
        if top not in known:
            raise ConfigError(f"module {top}: not in manifest.txt, which has {', '.join(known)}")
    while waiting:
        module = waiting.pop()
        if module not in needed:
            needed.add(module)
            words = set(_WORD.findall(_bare(files[f"{module}.v"])))
            waiting += [other for other in known if other in words]
    return [module for module in known if module in needed]


def flat(names: Iterable[str], verilog: Path | None = None, *, comments: bool = False) -> str:
    """The modules' sources one after another, includes put in their places; a guarded header only once, no rules to prove.

    Without comments the text, and so every name that a tool derives from its line numbers, does not change with them.
    """
    files = rtl_files(verilog)
    seen = set[str]()

    def included(found: re.Match[str]) -> str:
        text = files[found[1]].read_text()
        if _GUARD.match(without_comments(text)):
            if found[1] in seen:
                return ""
            seen.add(found[1])
        return text

    texts = (_PROOF.sub("", files[f"{module}.v"].read_text()) for module in names)
    text = "\n".join(_INCLUDE.sub(included, source) for source in texts)
    return text if comments else without_comments(text)


def stand_ins(names: Iterable[str], own: str, verilog: Path | None = None) -> str:
    """Those of these modules that hw/fpga/<own> has a body of a device's cells for, as one text; empty when `own` is."""
    folder = (verilog or verilog_dir()).parent / "fpga" / own
    files = [folder / f"{module}.v" for module in names if own]
    return "\n".join(without_comments(path.read_text()) for path in files if path.is_file())


def _bare(path: Path) -> str:
    return _stripped(path, path.stat().st_mtime_ns)


@cache
def _stripped(path: Path, _changed_ns: int) -> str:
    return without_comments(path.read_text())

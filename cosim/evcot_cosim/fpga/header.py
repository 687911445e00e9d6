# SPDX-License-Identifier: Apache-2.0
"""Parameters and ports of a module as its source declares them: widths as expressions, what a parameter is for."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from evcot.errors import ConfigError

from ..build.rtl import rtl_files, verilog_dir
from .sources import without_comments

__all__ = ["DeclaredPort", "Header", "Parameter", "clog2", "evaluate", "read"]

_PARAMETER = re.compile(r"^\s*parameter\s+(\w+)\s*=\s*(.+?),?\s*(?://\s*(.*))?$")
_PORT = re.compile(r"^\s*(input|output)\s+(?:wire|reg)\s*(?:\[(.+?):0\])?\s*(\w+(?:\s*,\s*\w+)*)\s*,?\s*(?://.*)?$")
_DEFINE = re.compile(r"^`define\s+(\w+)[ \t]+(\S+)", re.MULTILINE)


@dataclass(frozen=True)
class Parameter:
    """One parameter: its default is a Verilog expression; a derived one is not for the user to set."""

    name: str
    default: str
    meaning: str

    @property
    def derived(self) -> bool:
        return self.meaning.startswith("derived")


@dataclass(frozen=True)
class DeclaredPort:
    """One port; `left` is the expression of its highest bit, None where it is declared without a range."""

    name: str
    direction: Literal["in", "out"]
    left: str | None


@dataclass(frozen=True)
class Header:
    """What stands between `module` and the first `);`, and the title: the first sentence of the file."""

    top: str
    title: str
    parameters: tuple[Parameter, ...]
    ports: tuple[DeclaredPort, ...]

    def values(self, chosen: Mapping[str, int]) -> dict[str, int]:
        """All parameters, these chosen and the rest at their defaults."""
        values = dict(chosen)
        for parameter in self.parameters:
            if parameter.name not in values:
                values[parameter.name] = evaluate(parameter.default, values)
        return values


def clog2(value: int) -> int:
    """Verilog's $clog2."""
    return max(0, value - 1).bit_length()


def evaluate(expression: str, values: Mapping[str, int]) -> int:
    """A Verilog constant expression of parameters, + - * /, comparison, ?: and $clog2.

    Raises:
        ConfigError: it holds anything else.
    """
    choice = re.fullmatch(r"(.+?)\?(.+):(.+)", expression)
    if choice:
        return evaluate(choice[2] if evaluate(choice[1], values) else choice[3], values)
    text = expression.replace("$clog2", "clog2").replace("/", "//").strip()
    if re.search(r"[^\w\s()+\-*/<>=]", text):
        raise ConfigError(f"expression {expression}: more than this reader of Verilog headers knows")
    return int(eval(text, {"__builtins__": {}, "clog2": clog2}, dict(values)))


def read(top: str, verilog: Path | None = None) -> Header:
    """The header of a module.

    Raises:
        ConfigError: there is no such module, or it declares something in another style.
    """
    files = rtl_files(verilog)
    if f"{top}.v" not in files:
        raise ConfigError(f"module {top}: no {top}.v in {verilog or verilog_dir()}")
    text = files[f"{top}.v"].read_text()
    headers = (path for path in files.values() if path.suffix == ".vh")
    defines = {name: value for path in headers for name, value in _DEFINE.findall(path.read_text())}
    title = " ".join(line[3:] for line in text.splitlines()[1:] if line.startswith("// ")).split(". ")[0].rstrip(".")
    declaration = re.search(rf"^module {top}\b.*?^\);", text, re.MULTILINE | re.DOTALL)
    assert declaration is not None
    parameters, ports, meaning = [], [], ""
    for line in declaration[0].splitlines():
        line = re.sub(r"`(\w+)", lambda found: defines.get(found[1], found[0]), line)
        if found := _PARAMETER.match(line):
            parameters.append(Parameter(found[1], found[2], found[3] or meaning))
        elif found := _PORT.match(line):
            direction: Literal["in", "out"] = "in" if found[1] == "input" else "out"
            ports += [DeclaredPort(name, direction, found[2]) for name in re.split(r"\s*,\s*", found[3])]
        elif without_comments(line).strip(" \n()#;") not in ("", f"module {top}", f"module {top} #"):
            raise ConfigError(f"{top}.v: {line.strip()}: a declaration in another style than the others'")
        meaning = line.strip()[3:] if line.strip().startswith("//") else ""
    return Header(top, title, tuple(parameters), tuple(ports))

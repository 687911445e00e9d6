# SPDX-License-Identifier: Apache-2.0
"""Parameters and ports of a module as its source declares them: widths as expressions, and the comments on each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, takewhile
from pathlib import Path
from typing import Any, Literal

from evcot.errors import ConfigError

from ..rtl.files import rtl_files, verilog_dir
from .slang import checked, language, printed, pyslang, source_manager

__all__ = ["DeclaredPort", "Header", "Parameter", "evaluate", "read"]


@dataclass(frozen=True)
class Parameter:
    """One parameter; a derived one is not for the user to set."""

    name: str
    default: str
    """A Verilog expression, macros replaced by their values."""
    default_source: str
    """The same as it is written, with the names of macros."""
    meaning: str
    """The comment behind it, else the one above it."""

    @property
    def derived(self) -> bool:
        return self.meaning.startswith("derived")


@dataclass(frozen=True)
class DeclaredPort:
    """One port."""

    name: str
    direction: Literal["in", "out"]
    left: str | None
    """The expression of its highest bit, macros replaced by their values; None where it is declared without a range."""
    range_source: str
    """The range as it is written, with the names of macros; empty where there is none."""
    meaning: str
    """The comment behind it."""
    heading: str
    """The comment above the group that it stands in."""


@dataclass(frozen=True)
class Header:
    """What a module shows to the outside."""

    top: str
    comment: tuple[str, ...]
    """The lines of the comment at the top of the file, licence aside."""
    parameters: tuple[Parameter, ...]
    ports: tuple[DeclaredPort, ...]

    @property
    def title(self) -> str:
        """The first sentence of the comment."""
        return " ".join(self.comment).split(". ")[0].rstrip(".")

    def values(self, chosen: Mapping[str, int]) -> dict[str, int]:
        """All parameters, these chosen and the rest at their defaults."""
        values = dict(chosen)
        for parameter in self.parameters:
            if parameter.name not in values:
                values[parameter.name] = evaluate(parameter.default, values)
        return values


def evaluate(expression: str, values: Mapping[str, int]) -> int:
    """The value of a Verilog constant expression of parameters.

    Raises:
        ConfigError: it has none that is a whole number.
        ToolchainError: pyslang is not installed.
    """
    slang = pyslang()
    session = slang.ast.ScriptSession()
    for name, value in values.items():
        session.eval(f"parameter {name} = {value};")
    found = session.eval(expression).value
    if not isinstance(found, slang.SVInt) or found.hasUnknown or any(one.isError() for one in session.getDiagnostics()):
        raise ConfigError(f"expression {expression}: no whole number from {', '.join(values) or 'numbers alone'}")
    return int(found)


def read(top: str, verilog: Path | None = None) -> Header:
    """The header of a module.

    Raises:
        ConfigError: there is no such module, it is not Verilog, or it declares something in another style than ours.
        ToolchainError: pyslang is not installed.
    """
    files = rtl_files(verilog)
    if f"{top}.v" not in files:
        raise ConfigError(f"module {top}: no {top}.v in {verilog or verilog_dir()}")
    path, sources, kinds = files[f"{top}.v"], source_manager(verilog), pyslang().syntax.SyntaxKind
    (tree,) = checked(sources, [pyslang().syntax.SyntaxTree.fromFile(str(path), sources, language())])
    declared = (member for member in tree.root.members if member.kind == kinds.ModuleDeclaration)
    header = next((module.header for module in declared if module.header.name.valueText == top), None)
    if header is None:
        raise ConfigError(f"{path}: no module {top}")
    if header.ports is None or header.ports.kind != kinds.AnsiPortList:
        raise ConfigError(f"{path}: module {top}: its ports are not declared in the parentheses behind its name")
    comment = takewhile(lambda line: line.startswith("//"), path.read_text().splitlines()[1:])
    return Header(
        top,
        tuple(line[3:].rstrip() for line in comment),
        tuple(_parameters(path, sources, header.parameters)) if header.parameters is not None else (),
        tuple(_ports(path, sources, header.ports)),
    )


def _parameters(file: Path, sources: Any, declared: Any) -> Iterator[Parameter]:
    found = [(group, one) for group in _nodes(declared.declarations) for one in _nodes(group.declarators)]
    begins = [(group if one is group.declarators[0] else one).getFirstToken() for group, one in found]
    for (_, one), (behind, above) in zip(found, _comments(begins, declared.closeParen), strict=True):
        name = one.name.valueText
        if one.initializer is None:
            raise ConfigError(f"{file}: parameter {name}: has no default")
        default = one.initializer.expr
        yield Parameter(name, str(default).strip(), _written(sources, default), behind or above)


def _ports(file: Path, sources: Any, declared: Any) -> Iterator[DeclaredPort]:
    slang = pyslang()
    directions: dict[Any, Literal["in", "out"]] = {
        slang.parsing.TokenKind.InputKeyword: "in",
        slang.parsing.TokenKind.OutputKeyword: "out",
    }
    found = list(_nodes(declared.ports))
    if other := next((port for port in found if port.kind != slang.syntax.SyntaxKind.ImplicitAnsiPort), None):
        raise ConfigError(f"{file}: port {str(other).strip()}: has another name inside the module")
    # input a, b
    headers: Iterator[Any] = accumulate((port.header for port in found), lambda last, one: one if one.direction else last)
    comments = _comments([port.getFirstToken() for port in found], declared.closeParen)
    for port, header, (behind, above) in zip(found, headers, comments, strict=True):
        name = port.declarator.name.valueText
        direction = directions.get(header.direction.kind)
        if direction is None:
            raise ConfigError(f"{file}: port {name}: {header.direction.valueText}: neither input nor output")
        dimensions = [*header.dataType.dimensions, *port.declarator.dimensions]
        written = "".join(_written(sources, dimension) for dimension in dimensions)
        bounds = [dimension.specifier.selector for dimension in dimensions]
        simple = all(one.kind == slang.syntax.SyntaxKind.SimpleRangeSelect and str(one.right).strip() == "0" for one in bounds)
        if len(bounds) > 1 or not simple:
            raise ConfigError(f"{file}: port {name}: {written}: not one range that ends at 0")
        yield DeclaredPort(name, direction, str(bounds[0].left).strip() if bounds else None, written, behind, above)


def _nodes(separated: Any) -> Iterator[Any]:
    """What stands between the commas."""
    return (one for one in separated if not isinstance(one, pyslang().parsing.Token))


def _written(sources: Any, part: Any) -> str:
    return printed(sources, part).strip()


def _comments(begins: Sequence[Any], end: Any) -> Iterator[tuple[str, str]]:
    """For each of a list of declarations: the comment behind it in its line, and the one above its group.

    slang keeps what stands between two tokens with the second: comments behind a declaration are with the next one.
    """
    between = ["".join(part.getRawText() for part in token.trivia).split("\n") for token in (*begins, end)]
    behind = [""] * len(between)
    for i in reversed(range(len(begins))):  # what shares its line with the next shares the comment
        rest = between[i + 1]
        behind[i] = _said(rest[0]) if len(rest) > 1 else behind[i + 1]
    above = ""
    for lines, note in zip(between, behind[:-1], strict=False):
        goes_on = False
        for line in lines[1:-1]:
            said = _said(line)
            above = f"{above} {said}" if said and goes_on else said
            goes_on = bool(said)
        yield note, above


def _said(line: str) -> str:
    """The comment that is all of a line, or of what is left of one."""
    bare = line.strip()
    return bare[2:].strip() if bare.startswith("//") else ""

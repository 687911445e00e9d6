# SPDX-License-Identifier: Apache-2.0
"""The RTL as one text: a module with all that it instantiates and includes, in the order of the manifest."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError

from ..rtl.files import modules, rtl_files, verilog_dir
from .slang import checked, expanded, language, printed, pyslang, source_manager

__all__ = ["built", "closure", "flat", "logic", "stand_ins", "without_comments"]

_RULES = "parameter_check"  # the module whose instances check parameters and build nothing
_LINE_ENDS = (";", "begin", "end", "endmodule")


def without_comments(text: str) -> str:
    """Verilog without comments, empty lines and spaces at the ends of lines.

    Raises:
        ToolchainError: pyslang is not installed.
    """
    slang = pyslang()
    sources, kinds = slang.SourceManager(), slang.parsing.TriviaKind
    memory, complaints = slang.BumpAllocator(), slang.Diagnostics()
    lexer = slang.parsing.Lexer(sources.assignText(text), memory, complaints, sources)
    instead = {kinds.LineComment: "", kinds.BlockComment: " "}
    parts: list[str] = []
    token = None
    while token is None or token.kind != slang.parsing.TokenKind.EndOfFile:
        token = lexer.lex()
        parts += [instead.get(between.kind, between.getRawText()) for between in token.trivia]
        parts.append(token.rawText)
    return "".join(f"{line.rstrip()}\n" for line in "".join(parts).splitlines() if line.strip())


def closure(tops: Iterable[str], verilog: Path | None = None) -> list[str]:
    """`tops` and every module below them, in the manifest's order.

    Raises:
        ConfigError: a top is not in the manifest, or something is not Verilog.
        ToolchainError: pyslang is not installed.
    """
    known, files = modules(verilog), rtl_files(verilog)
    sources = source_manager(verilog)
    loader = pyslang().driver.SourceLoader(sources)
    for folder in sorted({str(path.parent) for path in files.values()}):
        loader.addSearchDirectories(folder)
    for top in tops:
        if top not in known:
            raise ConfigError(f"module {top}: not in manifest.txt, which has {', '.join(known)}")
        loader.addFiles(str(files[f"{top}.v"]))
    trees = checked(sources, loader.loadAndParseSources(language()))
    needed = {member.header.name.valueText for tree in trees for member in tree.root.members}
    return [module for module in known if module in needed]


def built(top: str, parameters: Mapping[str, int], verilog: Path | None = None) -> list[str]:
    """`closure` of a top with these parameters: without modules that stand only in generate blocks that they leave out.

    Raises:
        ConfigError: the top is not in the manifest, or something is not Verilog.
        ToolchainError: pyslang is not installed.
    """
    slang, files, sources = pyslang(), rtl_files(verilog), source_manager(verilog)
    names = closure([top], verilog)
    options = slang.ast.CompilationOptions()
    options.topModules = {top}
    options.paramOverrides = [f"{name}={value}" for name, value in parameters.items()]
    settings = language()
    settings.compilationOptions = options
    design = slang.ast.Compilation(settings)
    texts = [slang.syntax.SyntaxTree.fromFile(str(files[f"{name}.v"]), sources, language()) for name in names]
    for tree in checked(sources, texts):
        design.addSyntaxTree(tree)
    found: set[str] = set()

    def note(symbol: Any) -> bool:
        if symbol.kind == slang.ast.SymbolKind.Instance:
            found.add(symbol.definition.name)
        return True

    design.getRoot().visit(note)
    return [name for name in names if name in found]


def flat(names: Iterable[str], verilog: Path | None = None, *, comments: bool = False) -> str:
    """The modules' sources one after another, includes put in their places; a guarded header only once.

    Without comments the text, and so every name that a tool derives from its line numbers, does not change with them.

    Raises:
        ConfigError: something is not Verilog.
        ToolchainError: pyslang is not installed.
    """
    sources, tree = _tree(names, verilog)
    text = re.sub(r"\n{3,}", "\n\n", printed(sources, tree))
    return text if comments else without_comments(text)


def logic(names: Iterable[str], verilog: Path | None = None) -> str:
    """The modules' logic alone, one statement a line: macros put in, without comments, directives and rules for parameters.

    So a constant that a header gains, a rule or other line breaks change nothing, and all that may change a netlist does.

    Raises:
        ConfigError: something is not Verilog.
        ToolchainError: pyslang is not installed.
    """
    slang = pyslang()
    sources, tree = _tree((name for name in names if name != _RULES), verilog)
    memory, complaints, end = slang.BumpAllocator(), slang.Diagnostics(), slang.parsing.TokenKind.EndOfFile
    lexer = slang.parsing.Lexer(sources.assignText(expanded(sources, tree)), memory, complaints, sources)
    parts: list[str] = []
    inside_rule = False
    while (token := lexer.lex()).kind != end:
        word = token.rawText
        inside_rule = inside_rule or word == _RULES
        if not inside_rule:
            parts += [" " if token.trivia else "", word, "\n" if word in _LINE_ENDS else ""]
        inside_rule = inside_rule and word != ";"
    return "".join(parts)


def _tree(names: Iterable[str], verilog: Path | None) -> tuple[Any, Any]:
    """A manager of sources and the modules as one tree."""
    files, sources = rtl_files(verilog), source_manager(verilog)
    texts = {str(files[f"{module}.v"]): files[f"{module}.v"].read_text() for module in names}
    buffers = [sources.assignText(path, f"{text}\n") for path, text in texts.items()]
    (tree,) = checked(sources, [pyslang().syntax.SyntaxTree.fromBuffers(buffers, sources, language())])
    return sources, tree


def stand_ins(names: Iterable[str], own: str, verilog: Path | None = None) -> str:
    """Those of these modules that hw/fpga/<own> has a body of a device's cells for, as one text; empty when `own` is."""
    folder = (verilog or verilog_dir()).parent / "fpga" / own
    files = [folder / f"{module}.v" for module in names if own]
    return "\n".join(without_comments(path.read_text()) for path in files if path.is_file())

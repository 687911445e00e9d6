# SPDX-License-Identifier: Apache-2.0
"""The only use of slang, a reader of Verilog: its search paths, the version of the language, its error messages."""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError, ToolchainError

from ..rtl.files import rtl_files

__all__ = ["checked", "elaboration_errors", "expanded", "language", "printed", "pyslang", "source_manager"]


def pyslang() -> Any:
    """The package.

    Raises:
        ToolchainError: it is not installed.
    """
    try:
        return importlib.import_module("pyslang")
    except ImportError as error:
        raise ToolchainError("pyslang: not installed: pip install 'evcot[fpga]'") from error


def source_manager(verilog: Path | None = None) -> Any:
    """A manager of sources that finds the RTL's headers."""
    sources = pyslang().SourceManager()
    sources.setDisableProximatePaths(True)  # messages with whole paths
    for folder in sorted({path.parent for path in rtl_files(verilog).values()}):
        sources.addUserDirectories(str(folder))
    return sources


def language() -> Any:
    """The options that make it read Verilog-2005, in which SystemVerilog's keywords are names like others."""
    slang = pyslang()
    options = [slang.parsing.LexerOptions(), slang.parsing.PreprocessorOptions(), slang.parsing.ParserOptions()]
    for option in options:
        option.languageVersion = slang.LanguageVersion.v1364_2005
    return slang.Bag(options)


def checked(sources: Any, trees: Iterable[Any]) -> list[Any]:
    """The trees, if they have no error.

    Raises:
        ConfigError: one has, with its place.
    """
    trees = list(trees)
    for tree in trees:
        errors = [found for found in tree.diagnostics if found.isError()]
        if errors:
            report = pyslang().DiagnosticEngine.reportAll(sources, errors)
            raise ConfigError(report.splitlines()[0])
    return trees


def elaboration_errors(top: str, verilog: Path | None = None) -> list[str]:
    """What slang refuses when a module is elaborated with its default parameters, such as a net used before its declaration.

    Args:
        top: Name of the module.
        verilog: Folder of the RTL; None is the RTL that comes with evcot.

    Returns:
        One line per error: file, line, what is wrong and the names that are concerned.
    """
    slang, sources = pyslang(), source_manager(verilog)
    options = slang.ast.CompilationOptions()
    options.topModules, options.errorLimit = {top}, 0
    compilation = slang.ast.Compilation(slang.Bag([options]))
    for path in sorted(set(rtl_files(verilog).values())):
        if path.suffix == ".v":
            compilation.addSyntaxTree(slang.syntax.SyntaxTree.fromFile(str(path), sources, language()))
    errors = [found for found in compilation.getAllDiagnostics() if found.isError()]
    return [
        f"{sources.getFileName(one.location)}:{sources.getLineNumber(one.location)}: {one.code} {one.args}" for one in errors
    ]


def printed(sources: Any, part: Any) -> str:
    """A tree or a part of one as text: includes in their places, names of macros as they are written."""
    printer = pyslang().syntax.SyntaxPrinter(sources)
    printer.setIncludeDirectives(True).setExpandIncludes(True).setExpandMacros(False)
    text: str = printer.setIncludeComments(True).setSquashNewlines(False).print(part).str()
    return text


def expanded(sources: Any, part: Any) -> str:
    """A tree or a part of one as text: macros put in, without directives and comments."""
    printer = pyslang().syntax.SyntaxPrinter(sources)
    printer.setIncludeDirectives(False).setExpandIncludes(True).setExpandMacros(True)
    text: str = printer.setIncludeComments(False).print(part).str()
    return text

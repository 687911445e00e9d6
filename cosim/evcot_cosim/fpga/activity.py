# SPDX-License-Identifier: Apache-2.0
"""Toggles by module: the nets of a VCD, classified as registers and wires by their declarations in the RTL."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError

from ..waves.toggles import Activity
from ..waves.vcd import Declared
from .slang import checked, language, pyslang, source_manager
from .sources import closure, flat

__all__ = ["ModuleToggles", "by_module", "design_of", "nets_of", "uncounted"]

_TOP = "TOP."  # Verilator's scope around the top module
_INDEX = re.compile(r"\[\d+\]$")


@dataclass
class ModuleToggles:
    """The nets of all instances of a module, those of the modules below it not included.

    Attributes:
        instances: how many.
        registers: bits of flip-flops and memories.
        register_toggles: of these, together.
        wires: bits of what is not a register: each where it is driven, inputs not included.
        wire_toggles: of these, together, without glitches.
    """

    instances: int = 0
    registers: int = 0
    register_toggles: int = 0
    wires: int = 0
    wire_toggles: int = 0

    def __add__(self, other: ModuleToggles) -> ModuleToggles:
        return ModuleToggles(*(mine + theirs for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True)))


@dataclass(frozen=True)
class Design:
    """Paths, as `cot_array.u_match.free`.

    Attributes:
        modules: of every instance, the module's name.
        registers: what a clocked block assigns.
        memories: registers that are arrays; a waveform may leave out large ones.
        wires: what is driven otherwise, in the module that drives it.
        nets: these and what passes them on: everything but parameters.
    """

    top: str
    modules: Mapping[str, str]
    registers: frozenset[str]
    memories: frozenset[str]
    wires: frozenset[str]
    nets: frozenset[str]


def nets_of(design: Design, activity: Activity) -> list[Declared]:
    """The signals of a VCD that are nets of the design."""
    return [signal for signal in activity.signals if _path(signal) in design.nets]


def by_module(design: Design, activity: Activity) -> dict[str, ModuleToggles]:
    """The toggles of each module of a design, most first, from a VCD that Verilator has written of it.

    Memories that the VCD leaves out are not counted; `uncounted` names them.

    Raises:
        ConfigError: the VCD is not of this design.
    """
    found: dict[str, ModuleToggles] = {}
    for module in design.modules.values():
        found.setdefault(module, ModuleToggles()).instances += 1
    seen: set[str] = set()
    counted: set[str] = set()
    for signal in sorted(activity.signals, key=lambda one: _path(one) not in design.registers):
        path = _path(signal)
        register = path in design.registers
        # A wire that has several names is counted once. Registers are not: two that hold the same may share a code.
        if not register and (path not in design.wires or signal.code in seen):
            continue
        seen.add(signal.code)
        counted.add(path)
        one = found[design.modules[_instance(path, design.modules)]]
        if register:
            one.registers += signal.width
            one.register_toggles += activity.toggles_of(signal)
        else:
            one.wires += signal.width
            one.wire_toggles += activity.toggles_of(signal)
    if missing := sorted(design.registers - design.memories - counted):
        raise ConfigError(f"{missing[0]}: not in the waveform: must be of {design.top} with all that lies below it")
    return dict(sorted(found.items(), key=lambda item: -item[1].register_toggles - item[1].wire_toggles))


def uncounted(design: Design, activity: Activity) -> dict[str, int]:
    """How many memories of each module are not in a VCD of a design."""
    missing = design.registers & design.memories - {_path(signal) for signal in activity.signals}
    return dict(Counter(design.modules[_instance(path, design.modules)] for path in sorted(missing)))


def _path(signal: Declared) -> str:
    """The path of a signal in the design; of a memory's word that of the memory."""
    return _INDEX.sub("", signal.path.removeprefix(_TOP))


def _instance(path: str, modules: Mapping[str, str]) -> str:
    """The innermost instance that a path lies in: between it and the name there may be generate blocks."""
    while path not in modules:
        path = path.rpartition(".")[0]
    return path


def design_of(top: str, parameters: Mapping[str, int], verilog: Path | None = None) -> Design:
    """What a module with these parameters, and all that lies below it, consists of.

    Raises:
        ToolchainError: pyslang is not installed.
    """
    slang = pyslang()
    ast, sources = slang.ast, source_manager(verilog)
    text = flat(closure([top], verilog), verilog)
    (tree,) = checked(
        sources, [slang.syntax.SyntaxTree.fromBuffers([sources.assignText(f"{top}.v", text)], sources, language())]
    )
    options = ast.CompilationOptions()
    options.topModules = {top}
    options.paramOverrides = [f"{name}={value}" for name, value in parameters.items()]
    bag = language()
    bag.compilationOptions = options
    compilation = ast.Compilation(bag)
    compilation.addSyntaxTree(tree)
    modules: dict[str, str] = {}
    registers: set[str] = set()
    memories: set[str] = set()
    driven: set[str] = set()
    fed: set[str] = set()  # inputs, and what an instance's output drives: counted where it is driven

    def visit(node: Any) -> Any:
        if isinstance(node, ast.GenerateBlockSymbol) and node.isUninstantiated:
            return ast.VisitAction.Skip
        if isinstance(node, ast.InstanceSymbol):
            modules[node.hierarchicalPath] = node.definition.name
            inward = [port.name for port in node.body.portList if port.direction == ast.ArgumentDirection.In]
            fed.update(f"{node.hierarchicalPath}.{name}" for name in inward)
            for connection in node.portConnections:
                whole = connection.expression
                if whole is not None and connection.port.direction != ast.ArgumentDirection.In:
                    fed.update(_targets(ast, whole.left if isinstance(whole, ast.AssignmentExpression) else whole))
        elif isinstance(node, (ast.VariableSymbol, ast.NetSymbol)):
            driven.add(node.hierarchicalPath)
            if node.type.isUnpackedArray:
                memories.add(node.hierarchicalPath)
        elif isinstance(node, ast.AssignmentExpression) and node.isNonBlocking:
            registers.update(_targets(ast, node.left))
        return ast.VisitAction.Advance

    compilation.getRoot().visit(visit)
    wires = driven - registers - fed
    return Design(top, modules, frozenset(registers), frozenset(memories), frozenset(wires), frozenset(driven))


def _targets(ast: Any, left: Any) -> set[str]:
    """The paths of what an expression on the left of an assignment names, without its indices."""
    if isinstance(left, (ast.ElementSelectExpression, ast.RangeSelectExpression)):
        return _targets(ast, left.value)
    if isinstance(left, ast.ConcatenationExpression):
        return {path for part in left.operands for path in _targets(ast, part)}
    return {left.symbol.hierarchicalPath} if isinstance(left, ast.NamedValueExpression) else set()

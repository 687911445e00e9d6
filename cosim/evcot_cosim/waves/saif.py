# SPDX-License-Identifier: Apache-2.0
"""SAIF, the format in which tools that estimate power read toggles (IEEE 1801, annex; version 2.0, backward)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import evcot
from evcot.outputs import written_aside

from .toggles import Activity
from .vcd import Declared

__all__ = ["write_saif"]

_RANGE = re.compile(r"\[(\d+):(\d+)\]$")
_ESCAPED = re.compile(r"([^A-Za-z0-9_])")


@dataclass
class _Scope:
    signals: list[Declared] = field(default_factory=list)
    scopes: dict[str, _Scope] = field(default_factory=dict)


def write_saif(activity: Activity, path: Path, top: str, signals: Iterable[Declared], *, force: bool = False) -> None:
    """Write the toggles of those of some signals that are in and below one scope.

    Args:
        top: the scope, as in `TOP.cot_array`; its last part is the design's name in the file.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    root = _Scope()
    for signal in signals:
        if signal.scope == top or signal.scope.startswith(f"{top}."):
            scope = root
            for part in signal.scope[len(top) + 1 :].split("."):
                scope = scope.scopes.setdefault(part, _Scope()) if part else scope
            scope.signals.append(signal)
    design = top.rpartition(".")[2]
    with written_aside(path, force=force) as file:
        for line in _lines(activity, root, design):
            file.write(f"{line}\n".encode())


def _lines(activity: Activity, root: _Scope, design: str) -> Iterator[str]:
    yield "(SAIFILE"
    yield '(SAIFVERSION "2.0")'
    yield '(DIRECTION "backward")'
    yield f'(DESIGN "{design}")'
    yield f'(PROGRAM_NAME "evcot") (VERSION "{evcot.__version__}")'
    yield "(DIVIDER / )"
    yield f"(TIMESCALE {' '.join(_unit(activity.unit))})"
    yield f"(DURATION {activity.duration})"
    yield from _instance(activity, root, design)
    yield ")"


def _unit(text: str) -> tuple[str, str]:
    """Number and unit of "1ns" or "1 ns"."""
    found = re.fullmatch(r"(\d+)\s*(\w+)", text)
    return (found[1], found[2]) if found else ("1", "ns")


def _instance(activity: Activity, scope: _Scope, name: str) -> Iterator[str]:
    yield f"(INSTANCE {_name(name)}"
    if scope.signals:
        yield "(NET"
        for signal in scope.signals:
            yield from _nets(activity, signal)
        yield ")"
    for below, inner in scope.scopes.items():
        yield from _instance(activity, inner, below)
    yield ")"


def _nets(activity: Activity, signal: Declared) -> Iterator[str]:
    """One line a bit, with the bit's index in the declaration."""
    bits = activity.bits(signal)
    span = _RANGE.search(signal.reference)
    low, step = (int(span[2]), 1 if int(span[1]) >= int(span[2]) else -1) if span else (0, 1)
    name = _name(signal.name)
    for i in range(signal.width):
        at = bits.start + i
        high, unknown = int(activity.high[at]), int(activity.unknown[at])
        index = f"\\[{low + step * i}\\]" if span else ""
        zero = activity.duration - high - unknown
        yield f"({name}{index} (T0 {zero}) (T1 {high}) (TX {unknown}) (TC {int(activity.toggles[at])}) (IG 0))"


def _name(text: str) -> str:
    return _ESCAPED.sub(r"\\\1", text)

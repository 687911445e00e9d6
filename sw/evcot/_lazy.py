# SPDX-License-Identifier: Apache-2.0
"""Names of a package that are imported when they are first used, so that the package itself costs nothing to import."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

__all__ = ["lazily"]


def lazily(package: str, names: Mapping[str, Sequence[str]]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """A package's `__getattr__` and `__dir__`.

    Args:
        package: its `__name__`.
        names: module of the package -> the names that the package has from there, written as in an import statement: `a`, or
            `a as b`. None may be the name of a module of the package: importing that would put it in the name's place. With
            the module "" the names are those of modules of the package themselves.
    """
    source_of: dict[str, tuple[str, str]] = {}
    for module, own in names.items():
        for name in own:
            there, _, here = name.partition(" as ")
            source_of[here or there] = module, there

    def get(name: str) -> Any:
        if name not in source_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, there = source_of[name]
        value = getattr(import_module(f"{package}.{module}"), there) if module else import_module(f"{package}.{there}")
        setattr(sys.modules[package], name, value)
        return value

    def names_of() -> list[str]:
        return sorted(vars(sys.modules[package]).keys() | source_of.keys())

    return get, names_of

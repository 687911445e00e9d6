# SPDX-License-Identifier: Apache-2.0
"""The API reference is built from docstrings (`make docs`), so every public name of every module must have one."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from types import ModuleType

import pytest

import evcot
import evcot_cosim


def modules() -> Iterator[str]:
    for package in (evcot, evcot_cosim):
        for entry in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not entry.name.endswith("__main__"):
                yield entry.name


def public(module: ModuleType) -> Iterator[tuple[str, object]]:
    """Classes and functions that a module says are its own, and the methods of the former; properties may stand among a
    class's attributes."""
    for name in getattr(module, "__all__", ()):
        thing = getattr(module, name)
        if inspect.isclass(thing) or inspect.isfunction(thing):
            yield name, thing
        if inspect.isclass(thing):
            for key, member in vars(thing).items():
                if not key.startswith("_") and inspect.isfunction(member):
                    yield f"{name}.{key}", member


@pytest.mark.parametrize("name", list(modules()))
def test_every_public_name_is_there_and_documented(name: str) -> None:
    module = importlib.import_module(name)
    assert module.__doc__, f"{name} has no docstring"
    for entry, thing in public(module):
        assert inspect.getdoc(thing), f"{name}.{entry} has no docstring"

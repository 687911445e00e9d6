# SPDX-License-Identifier: Apache-2.0
"""The API reference is built from docstrings (`make docs`), so every public name of every module must have one; and the two
namespaces that users import have all that they promise."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
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


def undocumented(name: str) -> Iterator[str]:
    """A module, and what it says is its own, without a docstring."""
    module = importlib.import_module(name)
    if not module.__doc__:
        yield name
    yield from (f"{name}.{entry}" for entry, thing in public(module) if not inspect.getdoc(thing))


def test_every_public_name_is_there_and_documented() -> None:
    assert [thing for name in modules() for thing in undocumented(name)] == []


NAMESPACES = pytest.mark.parametrize("package", [evcot, evcot_cosim], ids=lambda package: str(package.__name__))


def promised(package: ModuleType) -> list[str]:
    names: list[str] = package.__all__
    return names


def shown_to_type_checkers(package: ModuleType) -> dict[str, str]:
    """Name -> the module that it is imported from, where TYPE_CHECKING is true."""
    assert package.__file__ is not None
    tree = ast.parse(Path(package.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    imported = (node for node in block.body if isinstance(node, ast.ImportFrom))
    return {alias.asname or alias.name: node.module or "" for node in imported for alias in node.names}


@NAMESPACES
def test_a_namespace_has_what_it_promises_and_says_so(package: ModuleType) -> None:
    assert len(set(promised(package))) == len(promised(package))
    assert set(promised(package)) <= set(dir(package))
    for name in promised(package):
        thing = getattr(package, name)
        if inspect.isclass(thing) or inspect.isroutine(thing) or inspect.ismodule(thing):
            assert inspect.getdoc(thing), name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        package.nothing  # noqa: B018


@NAMESPACES
def test_type_checkers_see_the_same_names(package: ModuleType) -> None:
    seen = shown_to_type_checkers(package)
    assert set(seen) == set(promised(package))
    for name, module in seen.items():
        thing = getattr(package, name)
        origin = importlib.import_module(f"{package.__name__}.{module}" if module else f"{package.__name__}.{name}")
        assert thing is origin or any(thing is value for value in vars(origin).values()), name


@NAMESPACES
def test_no_name_is_that_of_a_module(package: ModuleType) -> None:
    """Importing the module would put it in the place of what the package has by that name."""
    modules = {entry.name for entry in pkgutil.iter_modules(package.__path__)}
    assert {name for name in modules & set(promised(package)) if not inspect.ismodule(getattr(package, name))} == set()


@NAMESPACES
def test_every_function_of_a_namespace_says_what_may_go_wrong(package: ModuleType) -> None:
    for name in promised(package):
        thing = getattr(package, name)
        if inspect.isfunction(thing) and name not in ("decode_published", "lifetimes"):  # which refuse nothing
            text = inspect.getdoc(thing) or ""
            assert "Raises:\n" in text, f"{package.__name__}.{name}"


PAGE = (Path(__file__).parents[1] / "docs" / "api.md").read_text(encoding="utf-8")


@NAMESPACES
def test_the_page_names_all_that_is_stable(package: ModuleType) -> None:
    named = set(re.findall(rf"`{package.__name__}\.(\w+)`", PAGE))
    assert named == set(promised(package))


@pytest.mark.usefixtures("kernels")
def test_the_first_example_of_the_page_runs() -> None:
    code = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0]
    found: dict[str, object] = {}
    exec(code, found)
    log, model = found["log"], found["model"]
    assert isinstance(log, evcot.TrackLog)
    assert isinstance(model, evcot.TrackLog)
    assert min(len(log.of_kind(evcot.Kind.BORN)), len(model.of_kind(evcot.Kind.BORN))) > 0


ROOT = Path(__file__).parents[1]
PUBLIC = {"evcot", "evcot.anomalies", "evcot_cosim", "evcot_cosim.waves", "evcot_cosim.fpga.serial_host"}
PAGES = [
    *(page for page in sorted(ROOT.glob("docs/*.md")) if page.name != "architecture.md"),
    *sorted(ROOT.glob("docs/guides/*.py")), *sorted(ROOT.glob("hw/fpga/examples/*.py")), ROOT / "README.md",
]  # fmt: skip


def test_pages_and_examples_import_public_names_only() -> None:
    for page in PAGES:
        imported = re.findall(r"^\s*(?:from|import) (evcot[\w.]*)", page.read_text(encoding="utf-8"), re.MULTILINE)
        assert set(imported) <= PUBLIC, page

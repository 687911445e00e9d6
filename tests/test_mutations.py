# SPDX-License-Identifier: Apache-2.0
"""mutations.toml: every mistake has one place in the RTL as it is, and names tests that are there and caught it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from evcot_cosim.rtl.files import rtl_files
from mutations import Mutation, mutations, path_of
from support.testing import broken_text

RTL = {name: path.read_text() for name, path in rtl_files().items()}


@cache
def names_in(file: str) -> frozenset[str]:
    """Names of all tests of a file, `Class::test` for those in a class."""
    body = ast.parse(Path(path_of(file)).read_text(encoding="utf-8")).body
    classes = [one for one in body if isinstance(one, ast.ClassDef)]
    named = [(f"{one.name}::", part) for one in classes for part in one.body] + [("", part) for part in body]
    return frozenset(prefix + part.name for prefix, part in named if isinstance(part, ast.FunctionDef))


def faults(mutation: Mutation) -> Iterator[str]:
    """What is wrong with a row of mutations.toml."""
    try:
        broken_text(RTL[mutation.file], mutation.file, mutation.right, mutation.wrong)  # raises where the text is gone
    except Exception as error:
        yield f"{mutation.file}, {mutation.meaning}: {error!r}"
    if not mutation.tests:
        yield f"{mutation.file}, {mutation.meaning}: no test is named"
    for test in mutation.tests:
        file, _, name = test.partition("::")
        if not name:
            yield f"{file}: run python tests/mutations.py --new --write"
        elif name not in names_in(file):
            yield f"{test}: there is no such test"


def test_every_mutation_has_its_place_and_names_tests_that_exist() -> None:
    assert [fault for mutation in mutations() for fault in faults(mutation)] == []


def test_a_row_without_its_place_or_its_test_is_reported() -> None:
    (place, test) = faults(Mutation("gone", "cot_axis.v", "no such text", "", ("test_cot.py::test_of_nothing",)))
    assert "cot_axis.v, gone: " in place
    assert test == "test_cot.py::test_of_nothing: there is no such test"

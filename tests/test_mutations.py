# SPDX-License-Identifier: Apache-2.0
"""mutations.toml: every mistake has one place in the RTL as it is, and names tests that are there and caught it."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

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


@pytest.mark.parametrize("mutation", list(mutations()), ids=lambda mutation: f"{mutation.file} {mutation.meaning}")
def test_a_mutation_has_its_place_and_was_caught(mutation: Mutation) -> None:
    broken_text(RTL[mutation.file], mutation.file, mutation.right, mutation.wrong)  # raises where the text is gone
    assert mutation.tests
    for test in mutation.tests:
        file, _, name = test.partition("::")
        assert name, f"{file}: run python tests/mutations.py --new --write"
        assert name in names_in(file), f"{test}: there is no such test"

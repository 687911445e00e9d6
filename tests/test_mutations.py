# SPDX-License-Identifier: Apache-2.0
"""mutations.toml: every mistake has one place in the RTL as it is, and a test that caught it in docs/mutations.md."""

from __future__ import annotations

from pathlib import Path

import pytest

from mutations import Mutation, known_row, mutations
from support.testing import broken_copy


@pytest.mark.parametrize("mutation", list(mutations()), ids=lambda mutation: f"{mutation.file} {mutation.meaning}")
def test_a_mutation_has_its_place_and_was_caught(mutation: Mutation, tmp_path: Path) -> None:
    broken_copy(tmp_path, mutation.file, mutation.right, mutation.wrong)  # raises where the text is gone
    row = known_row(mutation)
    assert row is not None, "python tests/mutations.py --new --write"
    assert "**nothing**" not in row

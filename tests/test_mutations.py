# SPDX-License-Identifier: Apache-2.0
"""mutations.toml: every mistake has one place in the RTL as it is, and a test that caught it in docs/mutations.md."""

from __future__ import annotations

import pytest

from evcot_cosim.rtl.files import rtl_files
from mutations import Mutation, known_row, mutations
from support.testing import broken_text

RTL = {name: path.read_text() for name, path in rtl_files().items()}


@pytest.mark.parametrize("mutation", list(mutations()), ids=lambda mutation: f"{mutation.file} {mutation.meaning}")
def test_a_mutation_has_its_place_and_was_caught(mutation: Mutation) -> None:
    broken_text(RTL[mutation.file], mutation.file, mutation.right, mutation.wrong)  # raises where the text is gone
    row = known_row(mutation)
    assert row is not None, "python tests/mutations.py --new --write"
    assert "**nothing**" not in row

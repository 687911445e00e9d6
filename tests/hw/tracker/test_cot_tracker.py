# SPDX-License-Identifier: Apache-2.0
"""One set of ports for three kinds of trackers; the outputs of each are compared with the model in the tests of evcot_top."""

from __future__ import annotations

import pytest

from support.testing import lint


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_lints_clean(kind: int) -> None:
    assert lint("cot_tracker", TRACKER=kind, N=2) == (0, "")


@pytest.mark.parametrize("kind", [-1, 3])
def test_refuses_a_kind_that_is_none(kind: int) -> None:
    code, log = lint("cot_tracker", TRACKER=kind)
    assert code != 0
    assert "TRACKER_must_be_0_to_2" in log

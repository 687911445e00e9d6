# SPDX-License-Identifier: Apache-2.0
"""One set of ports for two kinds of trackers; the outputs of each are compared with the model in test_evcot_top.py."""

from __future__ import annotations

import pytest

from support.testing import lint


@pytest.mark.parametrize("kind", [0, 1])
def test_lints_clean(kind: int) -> None:
    assert lint("cot_tracker", TRACKER=kind, N=2) == (0, "")


@pytest.mark.parametrize("kind", [-1, 2])
def test_refuses_a_kind_that_is_none(kind: int) -> None:
    code, log = lint("cot_tracker", TRACKER=kind)
    assert code != 0
    assert "TRACKER_must_be_0_or_1" in log

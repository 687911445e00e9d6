# SPDX-License-Identifier: Apache-2.0
"""One set of ports for three kinds of trackers; what comes out of each is held against the model in test_evcot_top.py."""

from __future__ import annotations

import pytest

from evcot.errors import ToolchainError
from evcot_cosim.build import load
from evcot_cosim.testing import lint


def test_refuses_a_kind_that_is_none() -> None:
    with pytest.raises(ToolchainError, match="TRACKER must be 0 to 2"):
        load("cot_tracker", {"TRACKER": 3})


def test_a_source_of_evt_words_refuses_a_format_that_is_none() -> None:
    assert "FORMAT_must_be_EVT2_EVT21_or_EVT3" in lint("evt_source", FORMAT=2)[1]

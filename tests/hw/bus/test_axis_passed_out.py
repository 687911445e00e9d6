# SPDX-License-Identifier: Apache-2.0
"""axis_passed_out.v: an event a beat a clock later, its fields where registers.toml has them."""

from __future__ import annotations

import pytest

from support.beats import event_beats
from support.testing import lint

TOP = "axis_passed_out"


@pytest.mark.parametrize("w", [(1, 1, 1), (16, 16, 48)])
def test_lints_clean(w: tuple[int, int, int]) -> None:
    x_w, y_w, seq_w = w
    assert lint(TOP, X_W=x_w, Y_W=y_w, SEQ_W=seq_w) == (0, "")


def test_events_stand_in_their_beats_at_any_pace() -> None:
    widths = {"x": 16, "y": 16, "p": 1, "seq": 48}
    event_beats("passed", "s_pass_", widths, {"X_W": 16, "Y_W": 16, "SEQ_W": 48})

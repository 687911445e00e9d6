# SPDX-License-Identifier: Apache-2.0
"""axis_owned_out.v: an event a beat a clock later, its fields where registers.toml has them, the slot in tuser, too."""

from __future__ import annotations

import pytest

from support.beats import event_beats
from support.testing import lint

TOP = "axis_owned_out"


@pytest.mark.parametrize("w", [(1, 3, 1), (6, 14, 48)])
def test_lints_clean(w: tuple[int, int, int]) -> None:
    slot_w, rel_w, seq_w = w
    assert lint(TOP, SLOT_W=slot_w, REL_W=rel_w, SEQ_W=seq_w) == (0, "")


def test_events_stand_in_their_beats_at_any_pace() -> None:
    widths = {"slot": 6, "x": 14, "y": 14, "p": 1, "seq": 48}
    event_beats("owned", "s_own_", widths, {"SLOT_W": 6, "REL_W": 14, "SEQ_W": 48}, user="slot")

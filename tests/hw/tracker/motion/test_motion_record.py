# SPDX-License-Identifier: Apache-2.0
"""motion_record.v: records are held until accepted, and say what was there in the clock of `say`."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.testing import PATTERNS, Sink

SIDE_W = 25
WIDTHS = {"SLOT_W": 3, "SIDE_W": SIDE_W, "SUP_W": 12, "ID_W": 10, "SEQ_W": 40, "TIME_W": 44}
INPUTS = {
    "slot": 3, "id": 10, "stays_id": 10, "sum_x": SIDE_W + 1, "sum_y": SIDE_W + 1, "side_x": SIDE_W, "side_y": SIDE_W,
    "v_x": 16, "v_y": 16, "n_ev": 10, "support": 12, "seq": 40, "now": 44,
}  # fmt: skip
FIELDS = ("kind", "slot", "id", "other", "x", "y", "width", "height", "v_x", "v_y", "n_ev", "support", "seq", "time")


@pytest.mark.parametrize("pattern", PATTERNS)
def test_random_records(pattern: str) -> None:
    """Who has a record waits for `free`, and says it a clock later; its kind stands then for a clock."""
    sim, rng = load("motion_record", WIDTHS, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
    io, said, kinds = sim.io, [], set()
    sink = Sink(sim, "m_cm", FIELDS, PATTERNS[pattern](rng))
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    wants = says = False
    clock = held = 0
    while len(said) < 400:
        if not wants:
            io.kind = int(rng.integers(4))
            wants = rng.random() < 0.6
        for name, bits in INPUTS.items():
            setattr(io, name, int(rng.integers(1 << bits)))
        io.say = int(says)
        sink.drive()
        free = bool(int(io.free))
        word = sink.offered()
        assert free == (word is None or bool(int(io.m_cm_ready)))
        held += not free
        if says:
            values = {name: int(getattr(io, name)) for name in INPUTS}
            kind = int(io.kind)
            other = values["stays_id"] if kind == Kind.MERGED else 0
            middle = [values["sum_x"] >> 1, values["sum_y"] >> 1]
            sides = [values["side_x"], values["side_y"], values["v_x"], values["v_y"]]
            rest = [values["n_ev"], values["support"], values["seq"], values["now"]]
            said.append((kind, values["slot"], values["id"], other, *middle, *sides, *rest))
            kinds.add(kind)
            wants = False
        says = wants and free and not says
        sim.clock.tick()
        sink.clocked(word, clock)
        clock += 1
    assert sink.words == said[: len(sink.words)]
    assert len(said) - len(sink.words) <= 2
    assert kinds == {0, 1, 2, 3}
    assert (held > 0) == (pattern != "always")
    io.say, io.m_cm_ready, io.rst = 0, 0, 1
    sim.clock.tick()
    assert not int(io.m_cm_valid)

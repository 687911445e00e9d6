# SPDX-License-Identifier: Apache-2.0
"""motion_order.v: corrections, steps and merging give their commands one after another; slots begin, appear and end by them."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_control import WINDOW, Control, Said

N, SLOT_W, ID_W = 3, 2, 4
TO_SIDES = ("seed", "shrink", "offset", "reflect", "settle", "cover_both", "move", "shorten")
COMMANDS = (
    "load", "begin_job", "unite", *TO_SIDES, "speed", "correct", "count", "begin_bins", "place", "compare", "pair", "part",
    "ask", "meet", "take", "hold", "keep", "keep_window", "keep_now", "keep_until", "keep_id", "keep_start", "ends", "finish",
)  # fmt: skip
CORRECTION, SEED, STEP, END = range(4)
FREE, CANDIDATE, VISIBLE, LEFT = range(4)


class Order(Control):
    """All three of them: the slot is that of the clock, and what is loaded is said when it is there."""

    def __init__(self, sim: PyVerilator, rng: np.random.Generator) -> None:
        super().__init__(sim, rng, COMMANDS, TO_SIDES)
        self.reads = []
        self.wait: dict[str, int] = {}

    def slot(self) -> int:
        return int(self.io.at)

    def command(self, name: str, slot: int) -> Said:
        if name == "place":
            self.window_at = self.clocks + WINDOW
        return name, slot

    def clock(self) -> None:
        io = self.io
        loaded = int(io.load) or int(io.unite)
        io.read_next = int(self.read_at == self.clocks + 1)
        io.pair_done, io.meet_done = int(self.wait.get("compare") == 1), int(self.wait.get("ask") == 1)
        self.wait = {name: clocks - 1 for name, clocks in self.wait.items() if clocks > 1}
        self.wait |= {name: clocks for name, clocks in (("compare", 9), ("ask", 11)) if int(io[name])}
        super().clock()
        if loaded:
            self.lane = 1

    def job(self, kind: int, slot: int, corrections: int = 0, *, real: bool = True) -> list[Said]:
        """A job, and what was said until it was done, that clock and the next one included."""
        io = self.io
        self.said.clear()
        io.job_kind, io.job_slot, io.job_real, io.corrections = kind, slot, int(real), corrections
        self.clock()
        io.job_valid, begun = 1, 0
        self.sim.eval()
        while not int(io.job_done):
            begun += int(io.begun)
            self.clock()
        assert begun == 1
        self.clock()
        io.job_valid = 0
        self.clock()
        return list(self.said)


def names(said: list[Said]) -> list[str]:
    """Without bins that are cleared meanwhile."""
    return [name for name, *_ in said if name != "clear"]


@pytest.mark.parametrize(("stalls", "returns"), [(False, False), (True, True)])
def test_the_lives_of_two_slots(stalls: bool, returns: bool) -> None:
    sim = load("motion_order", {"N": N, "SLOT_W": SLOT_W, "ID_W": ID_W}, extra_flags=PORTS_ONLY_FLAGS)
    order, io = Order(sim, np.random.default_rng(1)), sim.io
    order.reset()
    order.stalls = stalls
    order.clock()
    io.shrinks = 1

    # Candidates begin, and have four corrections.
    written = ["keep", "keep_window", "keep_now", "finish", "keep_until"]
    for slot in (2, 0):
        said = order.job(SEED, slot)
        assert names(said) == ["seed", "keep_now", "settle", "begin_bins", "place", *written]
        assert [number for name, _, *more in said for number in more if name == "clear"] == list(range(16))
        assert {at for _, at, *_ in said} == {slot}
        assert (int(io.at), int(io.state)) == (slot, CANDIDATE)
        for corrections in range(4):
            io.instant = int(corrections == 1)
            said = order.job(CORRECTION, slot, corrections)
            starts = ["keep_start"] * (corrections == 3)
            turns = ["reflect" if corrections == 1 else "settle", *["speed"] * (corrections >= 2)]
            assert names(said) == [
                "fetch", "load", "begin_job", "shrink", "offset", "reflect", *turns, "correct", "count", *starts,
                "place", *written,
            ]  # fmt: skip
            assert {at for _, at, *_ in said} == {slot}
    assert (int(io.visible), int(io.candidate)) == (0, 5)

    # Both become visible in a step.
    io.appears = 1
    for slot in (0, 2):
        io.nearby = 5 & ~(1 << slot)
        said = order.job(STEP, slot, 4)
        assert names(said) == [
            "fetch", "load", "begin_job", "reflect", "move", "shorten", "reflect", "place", "ask", "keep_window",
            "fetch", "compare", "part", "keep_id", "keep_now", "say", "keep", "finish",
        ]  # fmt: skip
        assert [entry for entry in said if entry[0] in ("keep_id", "say")] == [("keep_id", slot), ("say", slot, Kind.BORN)]
        assert int(io.state) == VISIBLE
    for kind in (CORRECTION, STEP, END):  # of a free slot, and of an empty period
        assert order.job(kind, 1) == []
        assert order.job(kind, 0, real=False) == []
    assert (int(io.visible), int(io.candidate)) == (5, 0)
    io.shrinks = 0
    assert names(order.job(CORRECTION, 2, 63))[-8:] == ["keep_now", "say", "place", *written]
    assert ("say", 2, Kind.MOVED) in order.said

    # The lower one takes the other one in, with a record of each; then its life ends, or may return.
    io.alike, io.enough, io.weaker, io.later, io.nearby = 1, 1, 0, 1, 4
    said = order.job(STEP, 0, 4)
    assert names(said)[11:] == [
        "fetch", "compare", "pair", "take", "keep", "fetch", "load", "hold", "say", "settle", "ends", "fetch", "unite",
        "reflect", "cover_both", "settle", "keep_until", "place", "keep_window", "keep", "keep_now", "say", "ask", "take",
        "meet", "keep", "finish",
    ]  # fmt: skip
    assert [entry for entry in said if entry[0] == "say"] == [("say", 2, Kind.MERGED), ("say", 0, Kind.MOVED)]
    assert [at for name, at, *_ in said if name == "ends"] == [2]
    assert (int(io.visible), int(io.candidate)) == (1, 0)
    io.ended, io.may_return = 1, int(returns)
    said = order.job(STEP, 0, 4)
    leaves = ["place", "keep_window", "keep_until"] if returns else []
    assert names(said) == ["fetch", "load", "begin_job", "reflect", "keep_now", "say", *leaves, "keep", "finish"]
    assert (int(io.visible), int(io.left), int(io.state)) == (0, int(returns), LEFT if returns else FREE)
    assert ("say", 0, Kind.LOST) in said
    said = order.job(END, 0)
    assert names(said) == (["fetch", "load", "begin_job", "reflect", "keep", "finish"] if returns else [])
    assert (int(io.left), int(io.state)) == (0, FREE)

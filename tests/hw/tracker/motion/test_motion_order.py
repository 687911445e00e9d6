# SPDX-License-Identifier: Apache-2.0
"""motion_order.v: corrections, steps and merging give their commands one after another; slots begin, appear and end by them."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_control import WINDOW, Control, Said
from support.testing import lint

N, SLOT_W, ID_W = 3, 2, 4
UNTIL = 1
TO_SIDES = ("seed", "shrink", "offset", "reflect", "settle", "cover_both", "move", "shorten")
COMMANDS = (
    "load", "load_support", "unite", *TO_SIDES, "speed", "correct", "count", "begin_bins", "place", "compare", "pair", "part",
    "ask", "meet", "take", "hold", "keep", "keep_window", "keep_now", "keep_until", "keep_id", "keep_start",
)  # fmt: skip
MERGE = 40  # commands and operations of it


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
        if name == "keep_until":  # in a clock in which a job is done already
            assert int(self.io.since) == UNTIL
        return name, slot

    def clock(self) -> None:
        io = self.io
        loaded = int(io.load) or int(io.unite)
        io.read_next = int(any(due == self.clocks + 1 and what == "read" for due, what in self.under_way))
        io.pair_done, io.meet_done = int(self.wait.get("compare") == 1), int(self.wait.get("ask") == 1)
        self.wait = {name: clocks - 1 for name, clocks in self.wait.items() if clocks > 1}
        self.wait |= {name: clocks for name, clocks in (("compare", 9), ("ask", 11)) if int(io[name])}
        super().clock()
        if loaded:
            self.lane = 1

    def job(self, slot: int, corrections: int, *, seed: bool = False) -> list[Said]:
        """A job, and what was said until it was done, that clock and the next one included."""
        io = self.io
        self.said.clear()
        io.job_slot, io.job_seed, io.corrections = slot, int(seed), corrections
        self.clock()
        io.job_valid, begun = 1, 0
        while not int(io.job_done):
            begun += int(io.begun)
            self.clock()
        assert begun == 1
        self.clock()
        io.job_valid = 0
        self.clock()
        assert int(io.rests)
        return list(self.said)

    def step(self, slot: int) -> list[Said]:
        self.io.work_slot = slot
        return self.until_it_rests("do_step")

    def end(self, slot: int) -> list[Said]:
        self.io.work_slot = slot
        return self.until_it_rests("do_end")

    def until_it_rests(self, port: str) -> list[Said]:
        io = self.io
        self.said.clear()
        setattr(io, port, 1)
        self.clock()
        setattr(io, port, 0)
        while not int(io.rests):
            io.job_valid = 1  # one that comes meanwhile waits
            assert not int(io.begun)
            self.clock()
            io.job_valid = 0
        self.clock()
        return list(self.said)


def begins(order: Order, slot: int) -> None:
    order.io.begins, order.io.begins_slot = 1, slot
    order.clock()
    order.io.begins = 0


def names(said: list[Said]) -> list[str]:
    return [name for name, *_ in said]


@pytest.mark.parametrize("stalls", [False, True])
def test_the_lives_of_two_slots(stalls: bool) -> None:
    sim = load("motion_order", {"N": N, "SLOT_W": SLOT_W, "ID_W": ID_W}, extra_flags=PORTS_ONLY_FLAGS)
    order, io = Order(sim, np.random.default_rng(1)), sim.io
    order.reset()
    order.stalls = stalls
    order.clock()
    io.shrinks = 1

    # Candidates begin, and have four corrections.
    written = ["keep", "keep_window", "keep_now", "keep_until"]
    for slot in (2, 0):
        said = order.job(slot, 0, seed=True)
        assert names(said) == [
            "seed",
            "keep_now",
            "settle",
            "begin_bins",
            *["clear"] * 16,
            "place",
            "op_store op_full",
            *written,
        ]
        assert {at for _, at, *_ in said} == {slot}
        before = int(io.candidate)
        begins(order, slot)
        assert int(io.candidate) == before | 1 << slot
        for corrections in range(4):
            said = order.job(slot, corrections)
            starts = ["keep_start"] * (corrections == 3)
            turns = ["speed"] * (corrections >= 2)
            assert names(said) == [
                "op_read", "load", "shrink", "offset", "reflect", "settle", *turns, "correct", "count", *starts, "place",
                "op_store", *written,
            ]  # fmt: skip
            assert {at for _, at, *_ in said} == {slot}
    assert (int(io.visible), int(io.candidate)) == (0, 5)

    # Both become visible in a step.
    io.corrections, io.appears, io.nearby = 4, 1, 7
    for slot in (0, 2):
        said = order.step(slot)
        assert names(said) == [
            "op_read", "load", "load_support", "reflect", "move", "shorten", "reflect", "place", "keep_window", "ask",
            "op_read", "compare", "part", "keep_id", "keep_now", "say", "keep", "op_store op_full op_put",
        ]  # fmt: skip
        assert [entry for entry in said if entry[0] in ("keep_id", "say")] == [("keep_id", slot), ("say", slot, Kind.BORN)]
    assert order.step(1) == []  # a free slot
    assert (int(io.visible), int(io.candidate)) == (5, 0)
    io.shrinks = 0
    assert names(order.job(2, 63))[-7:-1] == ["say", "place", "op_store", "keep", "keep_window", "keep_now"]
    assert ("say", 2, Kind.MOVED) in order.said

    # The lower one takes the other one in, with a record of each; then its life ends.
    io.corrections, io.alike, io.enough, io.weaker = 4, 1, 1, 0
    said = order.step(0)
    merge = names(said)[11 : 13 + MERGE]
    merge[-4:] = sorted(merge[-4:])  # the record does not wait for the write
    assert merge == [
        "op_read", "compare", "pair", "take", "keep", "op_store op_full", "op_read", "load", "load_support", "take", "hold",
        "say", "settle", "op_read", "unite", "reflect", "cover_both", "settle", "begin_bins", "keep_until", *["clear"] * 16,
        "place", "keep_window", "keep", "keep_now", "op_store op_full op_put", "say",
    ]  # fmt: skip
    assert names(said)[13 + MERGE :] == ["ask", "take", "meet", "keep", "op_store op_full op_put"]
    assert [entry for entry in said if entry[0] == "say"] == [("say", 2, Kind.MERGED), ("say", 0, Kind.MOVED)]
    assert (int(io.visible), int(io.candidate)) == (1, 0)
    assert names(order.end(0)) == ["op_read", "load", "load_support", "reflect", "keep_now", "say"]
    assert order.said[-1] == ("say", 0, Kind.LOST)
    assert (int(io.visible), int(io.candidate)) == (0, 0)
    assert order.end(1) == []  # a free slot


def test_lint() -> None:
    assert lint("motion_order") == (0, "")
    assert lint("motion_order", N=1, SLOT_W=1) == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""motion_merge.v: two slots become one, in order, however long windows and records take."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_control import Control, Said, check_reset_of_job

N, SLOT_W, ID_W = 5, 3, 8
TO_SIDES = ("c_settle", "c_reflect", "c_cover")
COMMANDS = ("keep", "c_hold", *TO_SIDES, "lapse", "keep_until", "c_window", "keep_window", "keep_now")


def merge_of(stays: int, goes: int, visible: list[bool], later: bool) -> list[Said]:
    """What is done, in order. The slot that stays has been read, and is not in memory as it is."""
    said: list[Said] = [("keep", stays), ("fetch", goes), ("load", goes), ("c_hold", goes)]
    said += [("say", goes, Kind.MERGED)] * visible[goes]
    said += [("c_settle", goes), ("lapse", goes), ("fetch", stays), ("unite", stays)]
    said += [("c_reflect", stays), ("c_cover", stays), ("c_settle", stays)]
    said += [("keep_until", stays)] * later
    said += [("c_window", stays), ("keep_window", stays), ("keep", stays)]
    said += [("keep_now", stays), ("say", stays, Kind.MOVED)] * visible[stays]
    return said


def test_a_reset_at_any_moment_of_a_merge_ends_it() -> None:
    check_reset_of_job(load("motion_merge", {"SLOT_W": SLOT_W, "ID_W": ID_W}, extra_flags=PORTS_ONLY_FLAGS), COMMANDS, start=1)


@pytest.mark.parametrize("stalls", [False, True])
def test_random_merges(stalls: bool) -> None:
    sim = load("motion_merge", {"SLOT_W": SLOT_W, "ID_W": ID_W}, extra_flags=PORTS_ONLY_FLAGS)
    io, rng = sim.io, np.random.default_rng(1)
    control = Control(sim, rng, COMMANDS, TO_SIDES)
    control.reset()
    control.stalls = stalls
    clocks: set[int] = set()
    for case in range(48):  # each case six times
        stays, goes = (int(slot) for slot in rng.permutation(N)[:2])
        visible = [bool(rng.integers(2)) for _ in range(N)]
        visible[stays], visible[goes], later = bool(case & 1), bool(case & 2), bool(case & 4)
        ids = [int(number) for number in rng.integers(1 << ID_W, size=N)]
        io.stays = stays
        for _clock in range(int(rng.integers(1, 4))):
            assert int(io.rests)
            control.clock()
        io.goes, io.start = goes, 1
        control.said.clear()
        begun = control.clocks
        while True:
            # The id is there two clocks behind its slot, the comparison of two deadlines four.
            io.id = ids[control.at[2]] if control.steady(3) else int(rng.integers(1 << ID_W))
            io.at_state = 1 + visible[min(control.at[1], N - 1)]
            io.later = int(later if control.at[0] == stays and control.steady(4) else rng.integers(2))
            control.clock()
            io.start = 0
            if int(io.say):
                assert int(io.kind) != Kind.MERGED or int(io.stays_id) == ids[stays]
            if int(io.done):
                break
            assert not int(io.rests)
        assert control.said == merge_of(stays, goes, visible, later)
        clocks.add(control.clocks - begun)
    assert stalls or (min(clocks), max(clocks)) == (52, 55)

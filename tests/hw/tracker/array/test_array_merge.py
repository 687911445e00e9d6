# SPDX-License-Identifier: Apache-2.0
"""array_merge.v: of two tracks the first born stays, where both are on average."""

from __future__ import annotations

from fractions import Fraction
from math import floor
from typing import NamedTuple

import numpy as np
import pytest

from evcot_cosim.rtl.build import load
from support.testing import lint

SUP_W = 5


class Track(NamedTuple):
    """The context of a slot."""

    slot: int
    id: int
    cm_x: int
    cm_y: int
    g: int
    support: int


@pytest.mark.parametrize("means", [1, 2])
@pytest.mark.parametrize(("pos_x", "pos_y", "rounds"), [(7, 5, 1), (4, 6, 0)])
def test_random_tracks(pos_x: int, pos_y: int, rounds: int, means: int) -> None:
    sim = load("array_merge", {
        "POS_X": pos_x, "POS_Y": pos_y, "ROUND": rounds, "RADIX_W": 4, "SUP_W": SUP_W, "ID_W": 8, "SLOT_W": 3, "MEANS": means,
    })  # fmt: skip
    latency = 2 * max(pos_x, pos_y) + 5 if means == 2 else 4 * max(pos_x, pos_y) + 10
    rng, io, saturated = np.random.default_rng(pos_x), sim.io, 0

    nobody = Track(7, 0, 0, 0, 15, 0)

    def clock(track: Track = nobody, before: Track = nobody, b_first: int | None = None, **takes: int) -> None:
        """One clock with where one track is, and the rest of the context of the one before."""
        io.take_a, io.take_b = takes.get("take_a", 0), takes.get("take_b", 0)
        io.cm_x, io.cm_y, io.g = track.cm_x, track.cm_y, track.g
        io.slot, io.id, io.support = before.slot, before.id, before.support
        io.b_first = rng.integers(2) if b_first is None else b_first
        sim.clock.tick()

    for _ in range(60):
        ids = rng.permutation(256)[:2]
        draws = rng.integers([0, 0, 0, 1], [1 << pos_x, 1 << pos_y, 16, 1 << SUP_W], (2, 4))
        a, b = (Track(i, int(ids[i]), *map(int, draws[i])) for i in range(2))
        clock(a, take_a=1)
        clock(b, a, take_b=1)
        clock(before=b)
        b_first = int(rng.integers(2))  # whatever the ids say
        clock(b_first=b_first)
        for _ in range(2):
            clock()
        older, younger = (b, a) if b_first else (a, b)
        both = a.support + b.support
        saturated += both >= 1 << SUP_W
        assert (io.stays, io.stays_id, io.goes) == (older.slot, older.id, younger.slot)
        assert (io.join_g, io.join_support) == (max(a.g, b.g), min(both, (1 << SUP_W) - 1))
        assert io.done == 0
        clocks = 4
        while not io.done and clocks < 200:
            clock()
            clocks += 1
        assert clocks == latency
        at_best = (Fraction(getattr(a, at) * a.support + getattr(b, at) * b.support, both) for at in ("cm_x", "cm_y"))
        assert (io.join_x, io.join_y) == tuple(floor(mean + Fraction(rounds, 2)) for mean in at_best)
        clock()
        assert io.done == 1
    assert 5 < saturated < 55


@pytest.mark.parametrize(("pos_x", "pos_y"), [(13, 13), (24, 5), (4, 6)])
def test_lints_clean(pos_x: int, pos_y: int) -> None:
    assert lint("array_merge", POS_X=pos_x, POS_Y=pos_y) == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""motion_bins.v: counters in a memory, however close to one another events of one place come."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

BIN_W, PLACE_W = 6, 3
PLACES, WRITTEN_AFTER = 1 << PLACE_W, 4


def test_random_events() -> None:
    """Events of few places follow one another in 1 to 4 and more clocks; a reset drops what is under way, and nothing else."""
    sim, rng = load("motion_bins", {"BIN_W": BIN_W, "PLACE_W": PLACE_W}, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
    io = sim.io
    io.clear = 1
    for place in range(PLACES):
        io.place = place
        sim.clock.tick()
    io.clear = 0
    for _clock in range(WRITTEN_AFTER):
        sim.clock.tick()
    counters = [0] * PLACES
    under_way: list[tuple[int, int, bool]] = []  # clock in which it is written, place, whether it is cleared
    asked: int | None = None
    few, distances, dropped, wrapped = PLACES, set(), 0, 0
    last: dict[int, int] = {}
    for clock in range(9_000):
        if clock % 40 == 0:
            few = int(rng.integers(1, PLACES + 1))
        place, look, rst = int(rng.integers(few)), int(rng.integers(PLACES)), rng.random() < 0.004
        count, clear = rng.random() < 0.8, rng.random() < 0.03
        io.count, io.clear, io.place, io.look, io.rst = int(count), int(clear), place, look, int(rst)
        written = [(at, cleared) for due, at, cleared in under_way if due == clock]
        before = None if look in [at for at, _ in written] else counters[look]  # not looked at while it is written
        for at, cleared in written:
            wrapped += not cleared and counters[at] + 1 == 1 << BIN_W
            counters[at] = 0 if cleared else (counters[at] + 1) % (1 << BIN_W)
        under_way = [entry for entry in under_way if entry[0] > clock]
        if count or clear:
            under_way.append((clock + WRITTEN_AFTER - 1, place, clear))
            distances.add(clock - last.get(place, -9))
            last[place] = clock
        if rst:
            dropped += len(under_way)
            under_way = []
        sim.clock.tick()
        if asked is not None:
            assert int(io.looked) == asked, clock
        asked = before
    assert {1, 2, 3, 4, 5} <= distances
    assert dropped > 50
    assert wrapped > 10

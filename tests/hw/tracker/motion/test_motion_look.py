# SPDX-License-Identifier: Apache-2.0
"""motion_look.v: on which axes a box is looked at for a gap, how wide the gap must be, and where the box is cut."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

PX_W = 13


def test_random_boxes() -> None:
    """Lengths count as they were at `note` and in the clock before: a cut changes them before the other axis is looked at."""
    sim, rng = load("motion_look", {"PX_W": PX_W}, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
    io = sim.io
    seen = {"across": 0, "along": 0, "not": 0, "gap_px": 0, "half": 0}

    def show(lengths: list[int]) -> None:
        io.length_x, io.length_y = lengths
        io.is_long_x, io.is_long_y = (int(lengths[i] >= elongation * lengths[1 - i]) for i in (0, 1))

    for _ in range(2_000):
        elongation, gap_px = int(rng.integers(1, 16)), int(rng.integers(256)) >> int(rng.integers(8))
        lengths = [int(length) >> int(rng.integers(PX_W)) for length in rng.integers(1 << PX_W, size=2)]
        speeds = [int(speed) >> int(rng.integers(15)) for speed in rng.integers(1 << 15, size=2)]
        if rng.random() < 0.2:  # twice as fast on one axis as on the other, or nearly so
            speeds[1] = min(speeds[0] // 2 + int(rng.integers(-1, 2)) * (speeds[0] > 1), (1 << 15) - 1)
        if rng.random() < 0.2:  # just long enough, or nearly so
            lengths[0] = min(max(lengths[1] * elongation + int(rng.integers(-1, 2)), 0), (1 << PX_W) - 1)
        if rng.random() < 0.5:
            lengths.reverse()
            speeds.reverse()
        io.gap_px = gap_px
        io.speed_x, io.speed_y = speeds
        io.on_y = int(rng.integers(2))
        show([int(length) for length in rng.integers(1 << PX_W, size=2)])
        sim.clock.tick()
        show(lengths)
        sim.clock.tick()
        io.note = 1
        sim.clock.tick()
        io.note = 0
        io.length_x, io.length_y = (int(length) for length in rng.integers(1 << PX_W, size=2))
        sim.clock.tick()
        show([int(length) for length in rng.integers(1 << PX_W, size=2)])
        sim.clock.tick()
        for on_y in (0, 1) if int(io.on_y) == 0 else (1, 0):
            if int(io.on_y) != on_y:
                io.on_y = on_y
                sim.clock.tick()
            across = 2 * speeds[1 - on_y] >= speeds[on_y]
            along = not across and lengths[on_y] >= elongation * lengths[1 - on_y]
            assert int(io.looks) == (across or along)
            sim.clock.tick()
            half = lengths[1 - on_y] >> 1
            if across or along:
                assert int(io.narrowest) == (gap_px if across else max(gap_px, half))
            seen["across" if across else "along" if along else "not"] += 1
            seen["half" if along and half > gap_px else "gap_px"] += 1
    assert min(seen.values()) > 100


def test_every_cut() -> None:
    """The first pixel of the gap where the low part stays, else the first one behind it."""
    sim = load("motion_look", {"PX_W": PX_W}, extra_flags=PORTS_ONLY_FLAGS)
    io = sim.io
    for log2 in range(PX_W - 3):
        for begins in range(16):
            for low_stays in (0, 1):
                io.low_stays, io.begins, io.ends, io.bin_log2 = low_stays, begins, 15 - begins, log2
                sim.clock.tick()
                sim.clock.tick()
                assert int(io.cut_px) == (begins if low_stays else 15 - begins) << log2

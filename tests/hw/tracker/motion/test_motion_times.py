# SPDX-License-Identifier: Apache-2.0
"""motion_times.v: times of slots, the usual time and the deadline, ages in steps."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from evcot_cosim.rtl.build import load

SLOT_W, TIME_W = 2, 40
LAP = 1 << 32  # of deadlines
LAST, SEEDED, REPORTED = range(3)


def part_of(slot_w: int) -> Any:
    """The module after reset, and clocks with commands."""
    sim = load("motion_times", {"SLOT_W": slot_w, "TIME_W": TIME_W})
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0

    def pulse(*names: str, clocks: int = 0) -> None:
        for name in names:
            setattr(io, name, 1)
        sim.clock.tick()
        for name in names:
            setattr(io, name, 0)
        for _ in range(clocks):
            sim.clock.tick()

    return SimpleNamespace(io=io, pulse=pulse)


@pytest.fixture(name="part")
def _part() -> Any:
    return part_of(SLOT_W)


def ends_at(part: Any, deadline: int) -> bool:
    """Whether the slot's time is over at this tick, and was not one before."""
    found = []
    for counted in (deadline - 1, deadline):
        part.io.counted = counted % LAP
        part.pulse(clocks=3)
        found.append(int(part.io.ended))
    return found == [0, 1]


def usual_of(usual: int, ticks: int, first: bool) -> int:
    return ticks if first else usual + (ticks - usual >> 2) if ticks > 1 else usual


@pytest.mark.parametrize("slot_w", [1, 6])
def test_each_slot_has_three_times_and_a_deadline_of_its_own(slot_w: int) -> None:
    part, slots = part_of(slot_w), range(1 << slot_w)
    io, pulse = part.io, part.pulse
    times = {(at, since): 1_000 + 10 * at + since for at in slots for since in (LAST, SEEDED, REPORTED)}
    for (io.at, io.since), io.now in times.items():
        pulse("keep_now")
    for io.at in slots:
        io.counted, io.detect_ticks = 500, 1 + int(io.at)
        pulse("seed", clocks=2)
        pulse("keep_until")
    io.now = 5_000
    for (io.at, io.since), then in times.items():
        pulse(clocks=3)
        assert int(io.age) == 5_000 - then
    for io.at in slots:
        assert ends_at(part, 501 + int(io.at))


def test_corrections_and_the_deadline(part: Any) -> None:
    io, pulse, rng = part.io, part.pulse, np.random.default_rng(1)
    limits = {"life": 0, "coast": 0, "between": 0}
    for _ in range(300):
        life, coast = sorted(int(t) for t in rng.integers(1, 1 << 24, 2) >> rng.integers(0, 20))
        io.life_ticks, io.coast_ticks, io.life_log2 = life, coast, int(rng.integers(9))
        then = int(rng.integers(1 << 39))
        age = int(rng.integers(1 << 26)) >> int(rng.integers(26))
        if rng.random() < 0.4:
            age = coast >> int(io.life_log2) + 1
        io.at, io.since, io.now = int(rng.integers(4)), LAST, then
        pulse("keep_now")
        io.now, io.counted = then + age, (then + age) % LAP
        io.loaded = min(age, (1 << 24) - 1) if rng.random() < 0.5 else int(rng.integers(1 << 24)) >> int(rng.integers(24))
        io.first = int(rng.integers(2))
        pulse("load", clocks=6)
        ticks = max(1, min(age, (1 << 24) - 1))
        assert (int(io.age), int(io.ticks), int(io.beyond)) == (age, ticks, int(age >= 1 << 24))
        assert int(io.silent) == (age > 2 * int(io.loaded))
        usual = usual_of(int(io.loaded), ticks, bool(io.first))
        assert int(io.instant) == (ticks == 1)
        pulse("correct", clocks=8 + int(io.life_log2))
        assert int(io.usual) == usual
        pulse("keep_until")
        granted = min(max(usual << int(io.life_log2), life), coast)
        assert ends_at(part, then + age + granted)
        limits["life" if granted == life else "coast" if granted == coast else "between"] += 1
    assert min(limits.values()) > 30


def test_a_deadline_is_in_time_that_counts(part: Any) -> None:
    io, pulse = part.io, part.pulse
    io.at, io.now, io.counted, io.detect_ticks = 3, 1_000, 900, 70
    pulse("seed", clocks=2)
    pulse("keep_until")
    assert ends_at(part, 970)
    io.now = 1_100
    assert ends_at(part, 970)


def test_a_deadline_of_the_next_lap(part: Any) -> None:
    io, pulse = part.io, part.pulse
    io.at, io.counted, io.detect_ticks = 1, LAP - 5, 70
    pulse("seed", clocks=2)
    pulse("keep_until")
    assert ends_at(part, LAP + 65)
    io.counted = 65 + (1 << 30)
    pulse(clocks=3)
    assert int(io.ended) == 1


def test_a_candidate_has_the_time_to_be_detected(part: Any) -> None:
    io, pulse = part.io, part.pulse
    io.at, io.counted, io.detect_ticks = 3, 1_000, 70
    pulse("seed", clocks=2)
    pulse("keep_until")
    assert ends_at(part, 1_070)


def test_what_leaves_has_the_time_to_return(part: Any) -> None:
    io, pulse = part.io, part.pulse
    io.at, io.counted, io.detect_ticks, io.return_ticks = 2, 1_000, 70, 900
    pulse("load", clocks=2)
    usual = int(io.usual)
    pulse("leave", clocks=2)
    pulse("keep_until")
    assert ends_at(part, 1_900)
    assert int(io.usual) == usual


def test_ages_are_compared_and_counted_in_steps(part: Any) -> None:
    io, pulse, rng = part.io, part.pulse, np.random.default_rng(2)
    found = []
    for _ in range(200):
        times = [int(t) for t in rng.integers(1 << 39, size=2) >> rng.integers(0, 39)]
        io.now = int(rng.integers(1 << 39)) >> int(rng.integers(0, 20))
        io.join_steps, io.report_steps, io.together = (int(t) for t in rng.integers(1, (32, 16, 128)))
        for slot, then in enumerate(times):
            now, io.at, io.since, io.now = int(io.now), slot, SEEDED, then
            pulse("keep_now")
            io.now = now
        ages = [int(io.now) - then for then in times]
        io.at = 0
        pulse(clocks=5)
        pulse("take")
        io.at = 1
        pulse(clocks=5)
        assert int(io.older) == (ages[0] > ages[1])
        if ages[0] < 0:
            continue
        io.down = int(rng.integers(0, 36))
        pulse("divide", clocks=1)
        while int(io.dividing):
            pulse()
        steps = ages[0] >> int(io.down)
        assert int(io.enough) == (int(io.together) >= max(int(io.join_steps), steps))
        assert int(io.overdue) == (steps >= int(io.report_steps))
        found.append((int(io.enough), int(io.overdue)))
    assert set(found) == {(0, 0), (0, 1), (1, 0), (1, 1)}


def test_of_two_deadlines_one_is_held(part: Any) -> None:
    io, pulse = part.io, part.pulse
    for first, second in ((500, 600), (600, 500), (500, 500)):
        for slot, deadline in ((1, first), (2, second)):
            io.at, io.counted, io.detect_ticks = slot, 400, deadline - 400
            pulse("seed", clocks=2)
            pulse("keep_until", clocks=2)
        io.at = 1
        pulse(clocks=2)
        pulse("hold")
        io.at = 2
        pulse(clocks=3)
        assert int(io.later) == (first >= second)
        assert ends_at(part, second)
        pulse("keep_until")
        assert ends_at(part, first)

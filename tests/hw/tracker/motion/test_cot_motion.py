# SPDX-License-Identifier: Apache-2.0
"""cot_motion: scenes in which objects meet, random registers and traffic, restarts, in RTL and golden model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.ticks import TickedEvents
from evcot.trackers.presets import PRESETS, fit
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.random_runs import Design, random_case, random_motion, run_case
from support.logs import Square, bursts
from support.moving import LEAVES, QUICK, SHAPE, VARIANTS, leaves, scene
from support.testing import lint
from support.trials import bare_device

SHAPES = [
    Shape(n_slots=1, x_w=5, y_w=4, tc_w=12, radix_w=3, sup_w=6, id_w=2, seq_w=8, time_w=32),
    Shape(n_slots=3, x_w=7, y_w=6, tc_w=12, radix_w=5, sup_w=9, id_w=4, seq_w=16, time_w=36, tick_w=1),
    Shape(n_slots=8, tc_w=12),
    Shape(n_slots=16, x_w=10, y_w=11, tc_w=12, radix_w=12, sup_w=32, tick_w=31, time_w=32),
    Shape(n_slots=64, x_w=8, y_w=8, tc_w=12),
]


def equal(hardware: Decisions, model: Decisions) -> None:
    for name in ("owner", "rel_x", "rel_y", "records"):
        assert np.array_equal(getattr(hardware, name), getattr(model, name)), name


@pytest.mark.parametrize("name", VARIANTS)
def test_scenes_in_which_objects_meet(name: str) -> None:
    config = MotionConfig(SHAPE, replace(QUICK, **VARIANTS[name]))
    for seed in (1, 2):
        events = scene(seed, 6_000 if config.registers.step_log2 else 2_000)  # a step at every tick takes most of the clocks
        model = MotionModel(config).feed(events)
        assert len(model.records)
        stalls = Stalls.random(np.random.default_rng(seed)) if seed == 2 else None
        equal(bare_device(config, stalls=stalls).stream(events), model)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: f"N={shape.n_slots}")
@pytest.mark.parametrize("seed", range(4))
def test_random_registers_and_traffic(shape: Shape, seed: int) -> None:
    model = build_device(random_motion(np.random.default_rng(0), shape), waves=False)
    events = 8_000 if shape.n_slots < 16 else 3_000
    run_case(random_case(Design("cot_motion", shape), 100 * shape.n_slots + seed, events), model)


@pytest.mark.parametrize("step_ms", [5, 20, 100, 200])
def test_objects_whose_events_come_in_bursts(step_ms: int) -> None:
    events = bursts(step_ms, [Square(20, 20, 40, 30), Square(150, 100, -40, 10, side=30)], (240, 180), lasts_ms=1_500)
    ticks = TickedEvents.of(events)
    config = fit(PRESETS["motion"], 240, 180, 8).hardware
    model = MotionModel(config).feed(ticks)
    equal(bare_device(config).stream(ticks), model)
    assert (np.count_nonzero(model.records["kind"] == Kind.BORN) >= 2) == (step_ms <= 100)


@pytest.mark.parametrize("period", [60, 1_000])
def test_slots_that_are_corrected_more_than_once_in_a_burst(period: int) -> None:
    for name in ("quick", "quick turns", "everything is born"):
        config, events = MotionConfig(SHAPE, replace(QUICK, **VARIANTS[name])), scene(5, period=period)
        equal(bare_device(config).stream(events), MotionModel(config).feed(events))


def test_what_has_left_is_not_corrected() -> None:
    """Its last events, which come before this takes effect, complete a window."""
    config = MotionConfig(SHAPE, LEAVES)
    records = MotionModel(config).feed(leaves(12_000)).records
    events = leaves(int(records["time"][records["kind"] == Kind.LOST][0]))
    decided = MotionModel(config).feed(events)
    assert np.count_nonzero(decided.owner[1_000:1_041] == 0) >= 40
    equal(bare_device(config).stream(events), decided)


def test_stalls_change_nothing() -> None:
    config = MotionConfig(SHAPE, QUICK)
    plain = bare_device(config).stream(scene(3))
    for seed in range(3):
        stalls = Stalls.random(np.random.default_rng(seed), go=(0.9, 0.1, 0.2, 0.2))
        equal(bare_device(config, stalls=stalls).stream(scene(3)), plain)


@pytest.mark.parametrize("output", ["cm", "own", "passed"])
def test_an_output_that_waits_longer_than_the_watchdog_loses_nothing(output: str) -> None:
    config = MotionConfig(SHAPE, QUICK)
    waits = np.repeat(np.array([0, 1], np.uint8), 20_000)  # the watchdog restarts hardware that stands still for 2^14 clocks
    equal(bare_device(config, stalls=Stalls(**{output: waits})).stream(scene(3)), MotionModel(config).feed(scene(3)))


@pytest.mark.parametrize("writes", [1, 3])
def test_a_write_of_mode_restarts_a_slot_between_two_events(writes: int) -> None:
    rng, events = np.random.default_rng(4), scene(4)
    config = MotionConfig(SHAPE, replace(QUICK, birth_support=5, birth_ticks=10))
    device, model = bare_device(config), MotionModel(config)
    lost = 0
    for begin in range(0, len(events), 200):
        part = events[begin : begin + 200]
        equal(device.stream(part), model.feed(part))
        said = []
        for _ in range(writes):
            slot, mode = int(rng.integers(SHAPE.n_slots)), int(rng.choice([Mode.OFF, Mode.SEEDED]))
            device.write_mode(slot, mode)
            said.extend(model.write_mode(slot, mode))
        found = device.stream(events[:0]).records
        assert np.array_equal(found, np.array(said, found.dtype))
        lost += len(said)
    assert lost > 1


def test_events_that_a_filter_dropped_only_advance_time() -> None:
    events, rng = scene(2), np.random.default_rng(5)
    keep = rng.random(len(events)) < 0.7
    config = MotionConfig(SHAPE, QUICK)
    equal(bare_device(config).stream(events, keep), MotionModel(config).feed(events, keep))


def test_a_box_that_coasts_out_of_the_sensor_stops_within_reach() -> None:
    """A fast object that falls silent: its box comes to rest a sensor's width outside, and nothing wraps."""
    fast = replace(
        QUICK, friction=0, coast_ticks=2**24 - 1, life_ticks=2**24 - 1, birth_support=5, birth_ticks=0, birth_travel=8,
        side_step=30_000, speed_max=32_767, report_steps=1, ring_max=60, ring_any=0, ring_along=0, ring_across=0, ring_px=8,
    )  # fmt: skip
    n = 400
    ticks = np.arange(n, dtype=np.int64) * 4
    x = np.clip(np.arange(n) * 100 // n + np.tile([0, 3], n // 2), 0, 127).astype(np.uint16)
    y = (20 + np.arange(n) % 5).astype(np.uint16)
    events = TickedEvents(ticks, x, y, np.zeros(n, np.uint8))
    later = TickedEvents(ticks[-1:] + 200_000, x[:1] * 0, y[:1] * 0, np.zeros(1, np.uint8))
    config = MotionConfig(replace(SHAPE, n_slots=1), fast)
    device, model = bare_device(config), MotionModel(config)
    equal(device.stream(events), model.feed(events))
    found = model.feed(later)
    equal(device.stream(later), found)
    end_px = found.records["cm_x"][-1] / 4096
    assert abs(end_px) > 400  # it left the sensor of 128 pixels,
    assert np.all(found.records["cm_x"][-100:] == found.records["cm_x"][-1])  # then stays
    assert found.records["v_x"][-1] != 0  # and would go on


def test_a_silence_ends_lives_at_steps_alone() -> None:
    config, events = MotionConfig(SHAPE, replace(QUICK, birth_support=10, birth_ticks=0)), scene(1)
    device, model = bare_device(config), MotionModel(config)
    equal(device.stream(events), model.feed(events))
    later = TickedEvents(events.ticks[-1:] + 100_000, events.x[-1:], events.y[-1:], events.p[-1:])
    said = model.feed(later)
    assert Kind.LOST in said.records["kind"]
    period, places = 1 << QUICK.step_log2, 1 << (SHAPE.n_slots - 1).bit_length()
    own = said.records[said.records["kind"] != Kind.MERGED]  # a slot merges in the step of the one that stays
    assert np.all((own["time"] - own["slot"] * period // places) % period == 0)
    equal(device.stream(later), said)


def test_steps_of_many_slots_may_take_more_than_a_million_clocks_in_a_silence() -> None:
    """Candidates are compared with each other, and nothing is said: that is no hardware that stands still."""
    shape = replace(SHAPES[-1], tc_w=24)
    assert shape.n_slots == 64
    long, never = 2**20, 2**16 - 1
    registers = replace(
        QUICK, step_log2=0, nev_low=4, nev_high=4, seed_px=2, gap_corrections=0, birth_support=never, join_steps=1_023,
        detect_ticks=long, life_ticks=long, coast_ticks=long,
    )  # fmt: skip
    config = MotionConfig(shape, registers)
    which, rng = np.tile(np.arange(64), 40), np.random.default_rng(6)
    x, y = (place * 16 + 4 + rng.integers(0, 4, len(which)) for place in (which % 8, which // 8))
    events = TickedEvents(
        np.zeros(len(which), np.int64), x.astype(np.uint16), y.astype(np.uint16), (which * 0).astype(np.uint8)
    )
    silent = TickedEvents(np.array([400]), events.x[:1], events.y[:1], events.p[:1])
    device, model = bare_device(config), MotionModel(config)
    equal(device.stream(events), model.feed(events))
    before = device.cycle
    equal(device.stream(silent), model.feed(silent))
    assert device.cycle - before > 1 << 20


def test_clocks() -> None:
    """An event a clock, of one owner or of none; the step of a free slot takes six or seven, and a token eight."""
    shape = replace(SHAPE, n_slots=4, time_w=48)
    config = MotionConfig(shape, replace(QUICK, step_log2=20, nev_low=1_023, nev_high=1_023, seed_px=5))
    n = 1_000
    zero = np.zeros(n, np.int64)
    same = TickedEvents(zero, np.full(n, 60, np.uint16), np.full(n, 30, np.uint16), np.zeros(n, np.uint8))
    accepted = bare_device(config).stream_timed(same)[1].accepted
    assert accepted[-1] - accepted[200] == n - 1 - 200
    off = replace(config, modes=(Mode.OFF,) * 4)
    accepted = bare_device(off).stream_timed(same)[1].accepted
    assert accepted[-1] - accepted[0] == n - 1
    silent = TickedEvents(np.array([0, 100 << 20]), same.x[:2], same.y[:2], same.p[:2])
    device = bare_device(off)
    device.stream(silent)
    assert device.cycle < (8 + 4 * 7) * 101 + 60 + 1_030  # memories are cleared; a token holds 2^20 - 1 ticks: 101 of them


def test_clocks_between_corrections() -> None:
    """At 16 events a correction an event takes little more than a clock for one object or two; four wait for each other."""
    shape = replace(SHAPE, n_slots=4, time_w=48)
    registers = replace(
        QUICK, step_log2=20, nev_low=16, nev_high=16, gap_corrections=0, detect_ticks=2**20, life_ticks=2**20, coast_ticks=2**20
    )
    for objects, most in ((1, 1.1), (2, 1.2), (4, 1.3)):
        n = 4_000
        rng = np.random.default_rng(objects)
        place = rng.integers(0, objects, n) * 32
        x, y = (place + 12 + rng.integers(0, 8, n)).astype(np.uint16), (20 + rng.integers(0, 8, n)).astype(np.uint16)
        events = TickedEvents(np.zeros(n, np.int64), x, y, np.zeros(n, np.uint8))
        accepted = bare_device(MotionConfig(shape, registers)).stream_timed(events)[1].accepted
        clocks = (accepted[-1] - accepted[1_000]) / (n - 1_001)
        print(f"{objects} objects: {clocks:.2f} clocks an event")
        assert clocks < most


@pytest.mark.parametrize("objects", [1, 2, 3, 4])
def test_clocks_of_motion_steps(objects: int) -> None:
    """A period has a step of each slot; that of one that lives asks every other one, none of which is near."""
    registers = replace(
        QUICK, step_log2=4, nev_low=16, nev_high=16, gap_corrections=0, detect_ticks=2**20, life_ticks=2**24 - 1,
        coast_ticks=2**24 - 1, join_steps=15,
    )  # fmt: skip

    def clocks(periods: int) -> int:
        n, rng = 400 * objects, np.random.default_rng(1)
        x = np.arange(n) % objects * 60 + 30 + rng.integers(0, 8, n)
        events = TickedEvents(
            np.append(np.zeros(n, np.int64), periods << 4), np.append(x, x[-1]).astype(np.uint16),
            np.append(rng.integers(30, 38, n), 30).astype(np.uint16), np.zeros(n + 1, np.uint8),
        )  # fmt: skip
        device = bare_device(MotionConfig(Shape(n_slots=8), registers))
        device.stream(events)
        return device.cycle

    period = (clocks(300) - clocks(100)) / 200
    print(f"{objects} objects: {period:.1f} clocks a period")
    assert period <= 63 * objects + objects * (objects - 1)


def test_longest_wait_of_an_event() -> None:
    """16 objects in a grid, an event offered at every clock: it waits for one job at most."""
    registers = MotionRegisters()
    n, rng = 60_000, np.random.default_rng(16)
    ticks = np.arange(n) * 2  # a step of a slot every 128 events
    which = rng.integers(0, 16, n)
    side, along = rng.integers(0, 4, n), rng.integers(-9, 10, n)
    across = np.where(side % 2 == 0, 9, -9)
    moved = ticks // 2_000  # 0.5 px per ms
    x = 20 + which % 4 * 60 + moved + np.where(side < 2, across, along)
    y = 20 + which // 4 * 60 + np.where(side < 2, along, across)
    events = TickedEvents(ticks, x.astype(np.uint16), y.astype(np.uint16), np.zeros(n, np.uint8))
    config = MotionConfig(Shape(n_slots=16), registers)
    decisions, times = bare_device(config).stream_timed(events)
    live = len(set(decisions.owner[-2_000:].tolist()) - {-1})
    waits = np.diff(times.accepted)
    longest = int(waits.max())
    print(f"{live} live objects: an event waits at most {longest} clocks, {np.mean(waits):.2f} on average")
    assert live == 16
    assert longest <= 256


def test_time_must_be_wider_than_a_tick() -> None:
    assert "TIME_W_must_be_more_than_TICK_W" in lint("cot_motion", TIME_W=32, TICK_W=32)[1]
    with pytest.raises(ConfigError, match=r"^shape.time_w = 32: must be more than tick_w = 32 for cot_motion$"):
        MotionConfig(Shape(time_w=32, tick_w=32, tc_w=22))

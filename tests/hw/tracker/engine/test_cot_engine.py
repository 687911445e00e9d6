# SPDX-License-Identifier: Apache-2.0
"""The pipelined engine against the golden model and against cot_array: random traffic, stalls, register writes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.cot import CotModel, Decisions
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device
from support.ticked import ticked
from support.trials import OLD_AND_YOUNG, compare_random_runs, random_config, random_traffic, run_story

SHAPE = Shape(n_slots=3, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20)
EIGHT = replace(SHAPE, n_slots=8, id_w=32)
ONE_BIT = Shape(2, x_w=1, y_w=1, frac=0, tick_w=1, radix_w=1, nev_w=1, tc_w=1, sup_w=1, id_w=1, seq_w=8, time_w=8)

# Born with its first event, the centre jumps to every event; windows of 13 x 13 pixels.
JUMPY = SlotConfig(
    mode=Mode.SEEDED, init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=31, hist_avg=0,
    max_ticks=1000, clust_nev=1, nev_min=1, nev_max=8, nev_th=4000, detect_ticks=100,
)  # fmt: skip

# Slots -> shape, runs of 20,000 events.
RANDOM: dict[int, tuple[Shape, int]] = {
    1: (replace(SHAPE, n_slots=1, id_w=8), 4),
    2: (replace(SHAPE, n_slots=2, frac=1), 8),
    3: (SHAPE, 8),
    8: (EIGHT, 12),
    21: (replace(SHAPE, n_slots=21, x_w=10, y_w=6, radix_w=7, nev_w=4, tick_w=32, time_w=34), 6),
    32: (replace(SHAPE, n_slots=32, frac=8, x_w=9, y_w=8, id_w=8, tick_w=3), 6),
    64: (replace(SHAPE, n_slots=64, frac=0, x_w=8, y_w=8), 4),
}


def same(one: Decisions, other: Decisions) -> bool:
    """Every record, owner and recentred address."""
    return all(np.array_equal(mine, theirs) for mine, theirs in zip(one, other, strict=True))


@pytest.mark.parametrize("n", RANDOM)
def test_random_registers_traffic_and_stalls_are_exact(n: int) -> None:
    shape, runs = RANDOM[n]
    census = compare_random_runs(shape, "cot_engine", 2026, runs, 20_000)
    wanted = (Kind.BORN, Kind.MOVED, Kind.LOST) if n == 1 else Kind
    assert all(census[kind] > 10 for kind in wanted)


def test_one_bit_of_everything_is_exact() -> None:
    census = compare_random_runs(ONE_BIT, "cot_engine", 2026, 6, 10_000, rates=(0.1, 0.3, 1))
    assert all(census[kind] > 100 for kind in Kind)


def test_the_older_stays_when_its_id_is_the_higher_one() -> None:
    events, config = OLD_AND_YOUNG
    run = run_story(events, config, "cot_engine")
    assert run.records("kind", "slot", "track_id", "other_id", "x")[-2:] == [
        (Kind.MERGED, 0, 0, 1, 31),
        (Kind.MOVED, 1, 1, 0, 28.5),
    ]
    assert same(run.decisions, run_story(events, config, "cot_engine", "model").decisions)


@pytest.mark.parametrize(("frac", "id_w"), [(0, 32), (4, 32), (4, 3)])
def test_noise_that_is_born_merges_and_dies_all_the_time_is_exact(frac: int, id_w: int) -> None:
    shape, merged = replace(EIGHT, frac=frac, id_w=id_w), 0
    for seed in range(6):
        rng = np.random.default_rng([17, seed])
        slots = tuple(
            replace(
                JUMPY,
                mode=Mode.FIXED if rng.random() < 0.2 else Mode.SEEDED,
                init_cm_x=int(rng.integers(128)),
                init_cm_y=int(rng.integers(128)),
                clust_nev=int(rng.integers(1, 4)),
                hist_avg=int(rng.integers(0, 3)),
                radix_step=int(rng.integers(0, 4)),
                radix_min=int(rng.integers(1, 5)),
                max_ticks=int(rng.integers(1, 40)),
                detect_ticks=int(rng.integers(1, 40)),
                nev_max=int(rng.integers(3, 9)),
            )
            for _ in range(8)
        )
        config = CotConfig(shape, slots)
        n = 8_000
        x, y = (rng.integers(0, 128, n).astype(np.uint16) for _ in range(2))
        near = rng.random(n) < 0.7  # a cloud around a place that wanders: windows that overlap again and again
        for axis in (x, y):
            cloud = 64 + 40 * np.sin(np.arange(n) / 500 + seed) + rng.normal(0, 8, n)
            axis[near] = np.clip(cloud[near], 0, 127).astype(np.uint16)
        traffic = ticked(np.cumsum(rng.integers(0, 3, n)), x, y, rng.integers(0, 2, n, np.uint8))
        hardware = Device(config, "cot_engine", stalls=Stalls.random(rng) if seed % 3 else None).stream(traffic)
        golden = CotModel(config).feed(traffic)
        assert same(hardware, golden), f"seed {seed}"
        merged += int(np.count_nonzero(golden.records["kind"] == Kind.MERGED))
    assert merged > 1_000


def test_a_window_longer_than_its_timer_counts_as_the_longest() -> None:
    rng = np.random.default_rng(41)
    shape = replace(SHAPE, n_slots=1, tc_w=6)
    slot = replace(JUMPY, clust_nev=4, nev_max=16, nev_th=8, max_ticks=60, detect_ticks=60)
    gaps = np.repeat(rng.choice([1, 5, 16, 17, 22, 32, 33, 43], 400), 12)  # ticks between events, 63 at most in a timer
    traffic = ticked(np.cumsum(gaps), 20, 20)
    config = CotConfig(shape, (slot,))
    golden = CotModel(config).feed(traffic)
    assert same(Device(config, "cot_engine").stream(traffic), golden)
    assert len(np.unique(golden.records["n_ev"])) > 3
    assert set(golden.records["kind"].tolist()) == {Kind.BORN, Kind.MOVED}


def test_narrow_tokens_give_the_same_bits_as_wide_ones() -> None:
    records = 0
    for seed in range(6):
        runs = []
        for tick_w in (1, 3, 20):
            rng = np.random.default_rng([3, seed])
            shape = replace(SHAPE, tick_w=tick_w)
            config = random_config(rng, shape)
            traffic = random_traffic(rng, shape, 4_000, 3)
            runs.append(Device(config, "cot_engine", stalls=Stalls.random(rng)).stream(traffic))
        assert all(same(runs[0], other) for other in runs[1:]), f"seed {seed}"
        records += len(runs[0].records)
    assert records > 1_500


def test_registers_written_between_events_act_as_in_the_array() -> None:
    restarted = 0
    for seed in range(8):
        rng = np.random.default_rng([29, seed])
        config, other = random_config(rng, EIGHT), random_config(rng, EIGHT)
        array = Device(config, "cot_array")
        engine = Device(config, "cot_engine", stalls=Stalls.random(rng))
        for _ in range(12):
            traffic = random_traffic(rng, EIGHT, 400, float(rng.choice([0.3, 3])), array.now)
            decided = array.stream(traffic)
            assert same(engine.stream(traffic), decided), f"seed {seed}"
            slot = int(rng.integers(8))
            name = str(rng.choice(sorted(REGISTERS)))
            # One register, as it stands in another configuration; a slot is restarted by a write to `mode`.
            for device in (array, engine):
                io = device.sim.io
                io.cfg_valid, io.cfg_slot, io.cfg_addr = 1, slot, REGISTERS[name].address
                io.cfg_data = int(getattr(other.slots[slot], name))
                device.sim.clock.tick()
                io.cfg_valid = 0
            restarted += name == "mode"
    assert restarted > 3


def test_a_shorter_lifetime_counts_from_the_next_event_on() -> None:
    device = Device(CotConfig(SHAPE, (JUMPY,) * 3), "cot_engine")
    device.stream(ticked(1, 20, 20))
    io = device.sim.io
    io.cfg_valid, io.cfg_slot, io.cfg_addr, io.cfg_data = 1, 0, REGISTERS["max_ticks"].address, 5
    device.sim.clock.tick()
    io.cfg_valid = 0
    records = device.stream(ticked([2, 20], 20, 20)).records
    assert records[["kind", "time"]].tolist() == [(Kind.MOVED, 2), (Kind.LOST, 7), (Kind.BORN, 20)]


def test_a_mode_write_restarts_one_slot_alone() -> None:
    device = Device(CotConfig(SHAPE, (JUMPY,) * 3), "cot_engine")
    xs = [20, 60, 100]
    device.stream(ticked([1, 2, 3], xs, xs))
    io = device.sim.io
    io.m_cm_ready = 0
    device.write_registers(1, JUMPY)
    for _ in range(12):
        device.sim.clock.tick()
    assert (io.m_cm_valid, io.m_cm_kind, io.m_cm_slot, io.m_cm_id, io.m_cm_seq, io.m_cm_time) == (1, Kind.LOST, 1, 1, 3, 3)
    io.m_cm_ready = 1
    for _ in range(8):
        device.sim.clock.tick()
    assert (io.m_cm_valid, io.idle) == (0, 1)
    after = device.stream(ticked(5, xs, xs)).records
    assert after[["kind", "slot", "track_id"]].tolist() == [(Kind.MOVED, 0, 0), (Kind.BORN, 1, 3), (Kind.MOVED, 2, 2)]


class TestClocks:
    """What the header of cot_engine.v claims."""

    def burst(self, shape: Shape, slot: SlotConfig, x: NDArray[np.uint16]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        device = Device(CotConfig(shape, (slot,) * shape.n_slots), "cot_engine")
        events = ticked(0, x, x)
        device.stream(events[:1])  # the first token has the deadlines looked up
        _, times = device.stream_timed(events)
        return times.accepted, times.recorded

    @pytest.mark.parametrize(("n", "clocks"), [(1, 11), (3, 11), (8, 11), (16, 11), (17, 12), (32, 12)])
    def test_a_record_comes_11_clocks_after_its_event_and_12_where_slots_are_many(self, n: int, clocks: int) -> None:
        accepted, recorded = self.burst(replace(SHAPE, n_slots=n), JUMPY, np.full(1, 64, np.uint16))
        assert np.subtract(recorded, accepted).tolist() == [clocks]

    @pytest.mark.parametrize(("n", "more"), [(3, 6), (17, 7)])
    @pytest.mark.parametrize("n_ev", [2, 8, 16])
    def test_an_event_takes_a_clock_and_a_centre_six_or_seven_more(self, n: int, more: int, n_ev: int) -> None:
        slot = replace(JUMPY, clust_nev=n_ev, nev_min=n_ev, nev_max=n_ev)
        x = np.full(64 * n_ev, 64, np.uint16)
        _, recorded = self.burst(replace(SHAPE, n_slots=n), slot, x)
        assert set(np.diff(recorded)) == {n_ev + more}

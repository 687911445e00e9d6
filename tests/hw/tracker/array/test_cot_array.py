# SPDX-License-Identifier: Apache-2.0
"""The array of trackers: stories, random traffic, stalls and register writes through both cot_array.v and the golden model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.model import Decisions
from evcot.ticks import TickedEvents
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from support.tokens import ticked
from support.trials import (
    ENGINES,
    OLD_AND_YOUNG,
    Engine,
    Outcome,
    bare_device,
    compare_random_runs,
    random_config,
    random_traffic,
    run_story,
)

SHAPE = Shape(n_slots=3, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20)
EIGHT = replace(SHAPE, n_slots=8, id_w=32)
TWO = replace(SHAPE, n_slots=2, frac=1)
ONE_BIT = Shape(2, x_w=1, y_w=1, frac=0, tick_w=1, radix_w=1, nev_w=1, tc_w=1, sup_w=1, id_w=1, seq_w=8, time_w=8)

BORN, MOVED, MERGED, LOST = Kind.BORN, Kind.MOVED, Kind.MERGED, Kind.LOST

# Born with its first event, the centre jumps to every event; windows of 13 x 13 pixels.
JUMPY = SlotConfig(
    mode=Mode.SEEDED, init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=31, hist_avg=0,
    max_ticks=1000, clust_nev=1, nev_min=1, nev_max=8, nev_th=4000, detect_ticks=100,
)  # fmt: skip
# radix_min = g, so that a window without an event in its ring keeps its size.
SMALL = replace(JUMPY, radix_max=4)

Event = tuple[int, int, int]


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    chosen: Engine = request.param
    return chosen


def row(engine: Engine, xs: Iterable[int], slots: SlotConfig | Sequence[SlotConfig] = JUMPY) -> Outcome:
    """Events at tick 0 on the line y = 64."""
    return story(engine, [(0, x, 64) for x in xs], slots)


def story(engine: Engine, events: list[Event], slots: SlotConfig | Sequence[SlotConfig] = JUMPY) -> Outcome:
    slots = (slots,) * 3 if isinstance(slots, SlotConfig) else tuple(slots)
    return run_story(events, CotConfig(SHAPE, slots), "cot_array", engine)


class TestOwner:
    def test_the_active_window_comes_before_a_lower_candidate(self, engine: Engine) -> None:
        waiting = replace(JUMPY, mode=Mode.FIXED, init_cm_x=30, init_cm_y=64, clust_nev=5, nev_max=5)  # from 24 to 36
        run = row(engine, [40, 36, 30], [waiting, JUMPY, JUMPY])  # slot 1 is born at 40, from 34 to 46
        assert run.owners == [1, 1, 1]  # 36 lies in both; then slot 1 reaches from 30 to 42

    def test_the_lowest_candidate_comes_first(self, engine: Engine) -> None:
        here = replace(SMALL, mode=Mode.FIXED, init_cm_x=64, init_cm_y=64, clust_nev=2, nev_min=2)
        run = row(engine, [64, 64, 64, 58, 58, 66, 66], [replace(SMALL, mode=Mode.OFF), here, here])
        # Slot 1 collects 2 and is born; it follows to 58, its window ends at 64; slot 2 gets what lies beyond.
        assert run.owners == [1, 1, 1, 1, 1, 2, 2]
        assert [kind for kind in run.kinds if kind == BORN] == [BORN, BORN]

    def test_the_lowest_free_seeded_slot_starts_where_nobody_holds_the_event(self, engine: Engine) -> None:
        run = row(engine, [10, 40, 70, 100], [replace(JUMPY, mode=Mode.OFF), JUMPY, JUMPY])
        assert run.owners == [1, 2, -1, -1]

    def test_a_candidate_is_no_free_slot(self, engine: Engine) -> None:
        slow = replace(JUMPY, clust_nev=2)
        run = row(engine, [10, 40, 70, 100, 70], [slow] * 3)
        assert run.owners == [0, 1, 2, -1, 2]
        assert run.records("kind", "slot") == [(BORN, 2)]

    def test_addresses_are_those_of_the_owners_window(self, engine: Engine) -> None:
        wide = replace(JUMPY, init_radix=8, radix_min=8)
        run = row(engine, [10, 60, 55, 4], [JUMPY, wide, wide])
        assert run.owners == [0, 1, 1, 0]
        assert run.rel == [(6, 6), (10, 10), (5, 10), (0, 6)]


class TestLifetimes:
    def test_lives_that_end_on_the_way_to_one_event_end_in_order_of_time_then_of_slot(self, engine: Engine) -> None:
        events = [(0, 20, 64), (5, 60, 64), (5, 100, 64), (7, 20, 64), (5000, 20, 64)]
        run = story(engine, events)
        assert run.records("kind", "slot", "track_id", "time", "seq")[4:] == [
            (LOST, 1, 1, 1005, 4),
            (LOST, 2, 2, 1005, 4),
            (LOST, 0, 0, 1007, 4),
            (BORN, 0, 3, 5000, 4),
        ]

    def test_an_event_elsewhere_does_not_hide_the_end_of_a_life(self, engine: Engine) -> None:
        run = story(engine, [(0, 20, 64), (500, 60, 64), (999, 60, 64), (1000, 60, 64)])
        assert run.records("kind", "slot", "time", "seq")[3:] == [(LOST, 0, 1000, 3), (MOVED, 1, 1000, 3)]

    def test_a_slot_is_used_again_and_its_id_is_not(self, engine: Engine) -> None:
        run = story(engine, [(0, 20, 64), (2000, 90, 64), (4000, 20, 20)])
        assert [record for record in run.records("kind", "slot", "track_id") if record[0] == BORN] == [
            (BORN, 0, 0),
            (BORN, 0, 1),
            (BORN, 0, 2),
        ]


class TestMerge:
    def test_the_older_stays_at_the_centre_weighted_by_support(self, engine: Engine) -> None:
        # Slot 0 at 30, from 24 to 36. Slot 1 is born at 50, goes to 44 and to 40, from 34 to 46, with a support of 3.
        run = row(engine, [30, 50, 44, 40])
        assert run.records("kind", "slot", "track_id", "other_id", "x", "y", "support", "seq") == [
            (BORN, 0, 0, 0, 30, 64, 1, 0),
            (BORN, 1, 1, 0, 50, 64, 1, 1),
            (MOVED, 1, 1, 0, 44, 64, 2, 2),
            (MOVED, 1, 1, 0, 40, 64, 3, 3),
            (MERGED, 1, 1, 0, 40, 64, 3, 3),
            (MOVED, 0, 0, 0, 37.5, 64, 4, 3),  # (1 * 30 + 3 * 40) / 4
        ]
        assert run.owners == [0, 1, 1, 1]  # the event itself was slot 1's

    def test_the_older_stays_when_it_is_the_one_that_moves_and_has_the_higher_slot(self, engine: Engine) -> None:
        # Slot 1 is born first, for slot 0 waits elsewhere until it is born as id 1.
        waiting = replace(JUMPY, mode=Mode.FIXED, init_cm_x=50, init_cm_y=64)
        run = row(engine, [30, 50, 36, 40], [waiting, JUMPY, JUMPY])
        assert run.records("kind", "slot", "track_id")[:2] == [(BORN, 1, 0), (BORN, 0, 1)]
        # 36 is slot 1's and takes it to [30, 42], which holds no pixel of [44, 56]; 40 takes it to [34, 46].
        assert run.records("kind", "slot", "track_id", "other_id", "x", "support")[3:] == [
            (MOVED, 1, 0, 0, 40, 3),
            (MERGED, 0, 1, 0, 50, 1),
            (MOVED, 1, 0, 0, 42.5, 4),  # (3 * 40 + 1 * 50) / 4
        ]

    @pytest.mark.parametrize(("x", "merges"), [(43, False), (42, True)])
    def test_windows_merge_when_they_share_a_pixel_and_not_when_they_touch(self, engine: Engine, x: int, merges: bool) -> None:
        run = row(engine, [30, 48, x])  # slot 0 reaches to 36; slot 1 from x - 6
        assert (MERGED in run.kinds) == merges

    @pytest.mark.parametrize(("y", "merges"), [(43, False), (42, True)])
    def test_on_the_other_axis_too(self, engine: Engine, y: int, merges: bool) -> None:
        run = story(engine, [(0, 64, 30), (0, 64, 48), (0, 64, y)])
        assert (MERGED in run.kinds) == merges

    def test_the_older_stays_when_its_id_is_the_higher_one(self, engine: Engine) -> None:
        run = run_story(*OLD_AND_YOUNG, "cot_array", engine)
        births = [record for record in run.records("kind", "slot", "track_id") if record[0] == BORN]
        assert births == [(BORN, 0, 0), (BORN, 1, 1), *((BORN, 0, track % 8) for track in range(2, 9))]
        assert run.records("kind", "slot", "track_id", "other_id", "x")[-2:] == [(MERGED, 0, 0, 1, 31), (MOVED, 1, 1, 0, 28.5)]

    def test_a_birth_can_merge_at_once(self, engine: Engine) -> None:
        run = row(engine, [30, 42])  # 42 is outside [24, 36], its own window [36, 48] is not
        assert run.records("kind", "track_id", "x") == [(BORN, 0, 30), (BORN, 1, 42), (MERGED, 1, 42), (MOVED, 0, 36)]

    def test_growth_can_merge(self, engine: Engine) -> None:
        growing = replace(JUMPY, radix_step=4, radix_max=8, hist_avg=8)  # stays in place, g from 4 to 8
        run = row(engine, [30, 45, 50], [JUMPY, growing, growing])  # an event in the ring: [35, 55] overlaps [24, 36]
        assert run.records("kind", "track_id", "radius", "x") == [
            (BORN, 0, 6, 30),
            (BORN, 1, 6, 45),
            (MOVED, 1, 10, 45.0),
            (MERGED, 1, 10, 45.0),
            (MOVED, 0, 10, 40),  # (30 + 2 * 45) / 3
        ]

    @pytest.mark.parametrize(("radix_max", "radius"), [(31, 10), (6, 8)])
    def test_the_larger_g_stays_within_the_survivors_bound(self, engine: Engine, radix_max: int, radius: int) -> None:
        small, large = replace(JUMPY, radix_max=radix_max), replace(JUMPY, init_radix=8, radix_min=8)
        run = row(engine, [30, 44], [small, large, large])  # [24, 36] and [34, 54]
        assert run.records("kind", "track_id", "radius")[-1] == (MOVED, 0, radius)

    def test_the_survivors_own_g_stays_when_it_is_the_larger(self, engine: Engine) -> None:
        large = replace(JUMPY, init_radix=8, radix_min=8)
        run = row(engine, [30, 44], [large, JUMPY, JUMPY])
        assert run.records("kind", "track_id", "radius")[-2:] == [(MERGED, 1, 6), (MOVED, 0, 10)]

    def test_the_absorbed_slot_is_free_for_a_track_of_its_own(self, engine: Engine) -> None:
        run = row(engine, [30, 42, 100])
        assert run.owners == [0, 1, 1]
        assert run.records("kind", "slot", "track_id")[-1] == (BORN, 1, 2)

    def test_a_chain_reaction_of_three(self, engine: Engine) -> None:
        # Slot 0 at 36, [30, 42]. Slot 1 at 50, [44, 56], with 8 events. Slot 2 with g = 20 at 100, then at 78: [56, 100].
        wide = replace(JUMPY, init_radix=20, radix_min=20)
        run = row(engine, [36, *[50] * 8, 100, 78], [JUMPY, JUMPY, wide])
        assert run.records("kind", "track_id", "other_id", "x", "radius", "support")[-5:] == [
            (MOVED, 2, 0, 78, 22, 2),
            (MERGED, 2, 1, 78, 22, 2),
            (MOVED, 1, 0, 55.625, 22, 10),  # (8 * 50 + 2 * 78) / 10 = 55.6, to sixteenths; [34, 78] overlaps [30, 42]
            (MERGED, 1, 0, 55.625, 22, 10),
            (MOVED, 0, 0, 53.8125, 22, 11),  # (36 + 10 * 55.625) / 11 = 53.84
        ]
        assert run.owners[-1] == 2

    def test_the_lifetime_starts_over(self, engine: Engine) -> None:
        events = [(0, 30, 64), (900, 48, 64), (900, 42, 64), (1899, 100, 100), (1900, 100, 100)]
        run = story(engine, events)
        assert [record for record in run.records("kind", "track_id", "time") if record[0] == LOST] == [(LOST, 0, 1900)]

    def test_the_window_of_events_of_the_survivor_goes_on(self, engine: Engine) -> None:
        patient = replace(JUMPY, clust_nev=3, nev_min=3, nev_max=3)  # slot 0 has 2 of 3 when it is merged into
        run = row(engine, [30, 30, 30, 30, 30, 42, 36], [patient, JUMPY, JUMPY])
        assert run.records("kind", "track_id", "seq")[-3:] == [(MERGED, 1, 5), (MOVED, 0, 5), (MOVED, 0, 6)]

    def test_supports_add_up_and_saturate(self, engine: Engine) -> None:
        run = row(engine, [30] * 200 + [48] * 150 + [42])
        assert run.records("kind", "track_id", "support")[-2:] == [(MERGED, 1, 151), (MOVED, 0, 255)]


def overlaps(config: CotConfig, decisions: NDArray[np.void]) -> int:
    """Replays records and counts the pairs of active windows that share a pixel after an event; must be none."""
    shape, found = config.shape, 0
    windows: dict[int, tuple[int, int, int, int]] = {}
    last = len(decisions) - 1
    for i, record in enumerate(decisions):
        slot = int(record["slot"])
        if record["kind"] in (MERGED, LOST):
            del windows[slot]
        else:
            radius = int(record["radius"])
            x, y = ((int(record[name]) + ((1 << shape.frac) >> 1)) >> shape.frac for name in ("cm_x", "cm_y"))
            windows[slot] = (x - radius, x + radius, y - radius, y + radius)
        complete = i == last or decisions[i + 1]["seq"] != record["seq"]
        if complete and record["kind"] != LOST:
            lo_x, hi_x, lo_y, hi_y = windows.get(slot, (1, 0, 1, 0))
            found += sum(
                1
                for other, (a, b, c, d) in windows.items()
                if other != slot and max(a, lo_x) <= min(b, hi_x) and max(c, lo_y) <= min(d, hi_y)
            )
    return found


@pytest.mark.parametrize("seed", range(6))
def test_no_active_windows_ever_overlap_and_ids_are_never_reused(engine: Engine, seed: int) -> None:
    rng = np.random.default_rng([7, seed])
    slot = replace(JUMPY, clust_nev=3, nev_min=2, radix_step=2, radix_max=9, hist_avg=1, max_ticks=300)
    config = CotConfig(EIGHT, (slot,) * 8)
    events = random_traffic(rng, EIGHT, 12_000, 1)
    story = zip(events.ticks.tolist(), events.x.tolist(), events.y.tolist(), strict=True)
    run = run_story(story, config, "cot_array", engine)
    records = run.decisions.records
    assert run.kinds.count(MERGED) > 40
    assert overlaps(config, records) == 0
    born = records[records["kind"] == BORN]["track_id"]
    assert born.tolist() == list(range(len(born)))


def test_the_replay_sees_an_overlap() -> None:
    run = row("model", [30, 42])
    assert overlaps(run.config, run.decisions.records) == 0
    assert overlaps(run.config, run.decisions.records[:2]) == 1  # before the merge


def same(one: Decisions, other: Decisions) -> bool:
    """Every record, owner and recentred address."""
    return all(np.array_equal(mine, theirs) for mine, theirs in zip(one, other, strict=True))


def test_a_shorter_lifetime_counts_from_the_next_event_on() -> None:
    device = bare_device(CotConfig(SHAPE, (JUMPY,) * 3))
    device.stream(ticked(1, 20, 20))
    io = device.sim.io
    io.cfg_valid, io.cfg_slot, io.cfg_addr, io.cfg_data = 1, 0, REGISTERS["max_ticks"].address, 5
    device.sim.clock.tick()
    io.cfg_valid = 0
    records = device.stream(ticked([2, 20], 20, 20)).records
    assert records[["kind", "time"]].tolist() == [(Kind.MOVED, 2), (Kind.LOST, 7), (Kind.BORN, 20)]


def test_a_mode_write_restarts_one_slot_alone() -> None:
    device = bare_device(CotConfig(SHAPE, (JUMPY,) * 3))
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
    """What the header of cot_array.v and docs/array.md claim."""

    def burst(
        self, shape: Shape, slot: SlotConfig, traffic: TickedEvents
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.void]]:
        """Clocks of events and records, and the records."""
        device = bare_device(CotConfig(shape, (slot,) * shape.n_slots))
        device.stream(traffic[:1])  # the first token has the deadlines looked up
        decisions, times = device.stream_timed(traffic)
        return times.accepted, times.recorded, decisions.records

    @pytest.mark.parametrize(("n", "clocks"), [(1, 11), (3, 11), (8, 11), (16, 11), (17, 12), (32, 12)])
    def test_a_record_comes_11_clocks_after_its_event_and_12_where_slots_are_many(self, n: int, clocks: int) -> None:
        accepted, recorded, _ = self.burst(replace(SHAPE, n_slots=n), JUMPY, ticked(0, np.full(1, 64), 64))
        assert np.subtract(recorded, accepted).tolist() == [clocks]

    @pytest.mark.parametrize(("n", "more"), [(3, 6), (17, 7)])
    @pytest.mark.parametrize("n_ev", [2, 8, 16])
    def test_an_event_takes_a_clock_and_a_centre_six_or_seven_more(self, n: int, more: int, n_ev: int) -> None:
        slot = replace(JUMPY, clust_nev=n_ev, nev_min=n_ev, nev_max=n_ev)
        _, recorded, _ = self.burst(replace(SHAPE, n_slots=n), slot, ticked(0, np.full(64 * n_ev, 64), 64))
        assert set(np.diff(recorded)) == {n_ev + more}

    @pytest.mark.parametrize(("x", "prefix"), [(0, "own"), (64, "pass")])
    def test_owned_and_passed_events_come_out_after_11_clocks(self, x: int, prefix: str) -> None:
        device = bare_device(CotConfig(SHAPE, (replace(JUMPY, mode=Mode.FIXED, clust_nev=8),) * 3))
        device.stream(ticked(0, np.full(1, x), x))
        io = device.sim.io
        io.m_own_ready = io.m_pass_ready = io.m_cm_ready = 1
        io.s_valid, io.s_tick, io.s_event, io.s_x, io.s_y = 1, 0, 1, x, x
        clocks = 0
        while not io[f"m_{prefix}_valid"]:
            assert clocks or io.s_ready
            device.sim.clock.tick()
            io.s_valid = 0
            clocks += 1
        assert clocks == 11

    @pytest.mark.parametrize(("n", "most"), [(3, 2 * 3 + 40), (17, 2 * 17 + 45)])
    def test_the_end_of_a_life_takes_about_two_walks(self, n: int, most: int) -> None:
        x = [20, 60, 100, 20, 20, 20, 20, 20]
        late = ticked([0, 0, 0, 5000, 5000, 5000, 5000, 5000], x, x)
        alive = replace(late, ticks=np.zeros(8, np.int64))
        shape = replace(SHAPE, n_slots=n)
        _, ended, records = self.burst(shape, JUMPY, late)
        _, plain, _ = self.burst(shape, JUMPY, alive)
        assert np.count_nonzero(records["kind"] == LOST) == 3
        assert 3 * n < ended[-1] - ended[0] - (plain[-1] - plain[0]) <= 3 * most

    @pytest.mark.parametrize(("n", "clocks"), [(3, 4 * (7 + 4) + 25), (17, 2 * (7 + 4) + 22)])
    def test_a_merge_takes_two_clocks_a_bit_for_each_axis_or_for_both(self, n: int, clocks: int) -> None:
        x = [30, 42, *[100] * 10]
        apart = [30, 50, *[100] * 10]
        shape = replace(SHAPE, n_slots=n)
        _, merged, records = self.burst(shape, SMALL, ticked(0, x, x))
        _, plain, _ = self.burst(shape, SMALL, ticked(0, apart, apart))
        assert np.count_nonzero(records["kind"] == MERGED) == 1
        assert merged[-1] - merged[0] - (plain[-1] - plain[0]) == clocks


# Slots, frac and tick_w -> shape, runs of 50,000 events.
RANDOM: dict[int, tuple[Shape, int]] = {
    1: (replace(SHAPE, n_slots=1, id_w=8), 2),
    2: (TWO, 20),
    3: (SHAPE, 3),
    8: (EIGHT, 2),
    21: (replace(SHAPE, n_slots=21, x_w=10, y_w=6, radix_w=7, nev_w=4, tick_w=32, time_w=34), 2),
    32: (replace(SHAPE, n_slots=32, frac=8, x_w=9, y_w=8, id_w=8, tick_w=3), 2),
    64: (replace(SHAPE, n_slots=64, frac=0, x_w=8, y_w=8), 2),
}


@pytest.mark.parametrize("n", RANDOM)
def test_random_registers_traffic_and_stalls_are_exact(n: int) -> None:
    shape, runs = RANDOM[n]
    census = compare_random_runs(shape, "cot_array", 2026, runs, 50_000)
    wanted = (BORN, MOVED, LOST) if n == 1 else Kind
    assert all(census[kind] > 1_000 for kind in wanted)


def test_ids_that_wrap_all_the_time_are_exact() -> None:
    census = compare_random_runs(replace(EIGHT, id_w=3), "cot_array", 2026, 6, 20_000)
    assert all(census[kind] > 1_000 for kind in Kind)


def test_one_bit_of_everything_is_exact() -> None:
    census = compare_random_runs(ONE_BIT, "cot_array", 2026, 7, 20_000, rates=(0.1, 0.3, 1))
    assert all(census[kind] > 1_000 for kind in Kind)


def test_narrow_tokens_give_the_same_bits_as_wide_ones() -> None:
    records = 0
    for seed in range(12):
        runs = []
        for tick_w in (1, 3, 20):
            rng = np.random.default_rng([3, seed])
            shape = replace(TWO, tick_w=tick_w)
            config = random_config(rng, shape)
            traffic = random_traffic(rng, shape, 5_000, 3)
            runs.append(bare_device(config, stalls=Stalls.random(rng)).stream(traffic))
        for other in runs[1:]:
            assert all(np.array_equal(mine, theirs) for mine, theirs in zip(runs[0], other, strict=True)), f"seed {seed}"
        records += len(runs[0].records)
    assert records > 3_000


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
        hardware = bare_device(config, stalls=Stalls.random(rng) if seed % 3 else None).stream(traffic)
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
    assert same(bare_device(config).stream(traffic), golden)
    assert len(np.unique(golden.records["n_ev"])) > 3
    assert set(golden.records["kind"].tolist()) == {Kind.BORN, Kind.MOVED}


def test_registers_written_between_events_act_as_in_the_model() -> None:
    """One register at a time, or all of a slot where one alone would contradict the others; a write to `mode` restarts."""
    restarted = alone = 0
    for seed in range(16):
        rng = np.random.default_rng([29, seed])
        config, other = random_config(rng, EIGHT), random_config(rng, EIGHT)
        model, device = CotModel(config), bare_device(config, stalls=Stalls.random(rng))
        slots = list(config.slots)
        for _ in range(12):
            traffic = random_traffic(rng, EIGHT, 400, float(rng.choice([0.3, 3])), device.now)
            assert same(device.stream(traffic), model.feed(traffic)), f"seed {seed}"
            slot = int(rng.integers(8))
            name = str(rng.choice(sorted(REGISTERS)))
            try:
                changed = replace(slots[slot], **{name: getattr(other.slots[slot], name)})
                changed.check(EIGHT, "slot")
                slots[slot], written = changed, [name]
            except ConfigError:
                slots[slot] = replace(other.slots[slot], mode=slots[slot].mode)
                written = [name for name in REGISTERS if name != "mode"]
            ends = model.write_registers(slot, slots[slot], restart=name == "mode")
            io = device.sim.io
            io.m_cm_ready = io.cfg_valid = 1
            for name in written:
                io.cfg_slot, io.cfg_addr, io.cfg_data = slot, REGISTERS[name].address, int(getattr(slots[slot], name))
                device.sim.clock.tick()
            io.cfg_valid = 0
            lost = []
            for _ in range(20):
                if io.m_cm_valid:
                    lost.append((int(io.m_cm_kind), int(io.m_cm_slot), int(io.m_cm_id), int(io.m_cm_time)))
                device.sim.clock.tick()
            assert lost == [(int(row["kind"]), slot, int(row["track_id"]), int(row["time"])) for row in ends], f"seed {seed}"
            restarted += len(ends)
            alone += len(written) == 1
    assert restarted > 3
    assert alone > 50

# SPDX-License-Identifier: Apache-2.0
"""The chain of trackers: stories and random traffic through both cot_chain.v and the golden model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Mode, Shape
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from support.tokens import ticked
from support.trials import ENGINES, Engine, Outcome, bare_device, compare_random_runs, random_traffic, run_story

SHAPE = Shape(n_slots=3, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20)
EIGHT = replace(SHAPE, n_slots=8, frac=0, tick_w=3)
ONE_BIT = Shape(3, x_w=1, y_w=1, frac=0, tick_w=1, radix_w=1, nev_w=1, tc_w=1, sup_w=1, id_w=1, seq_w=8, time_w=8)

BORN, MOVED, MERGED, LOST = Kind.BORN, Kind.MOVED, Kind.MERGED, Kind.LOST

# Born with its first event, the centre jumps to every event; windows of 13 x 13 pixels.
JUMPY = SlotConfig(
    mode=Mode.SEEDED, init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=4, hist_avg=0,
    max_ticks=1000, clust_nev=1, nev_min=1, nev_max=8, nev_th=4000, detect_ticks=100,
)  # fmt: skip
OFF = replace(JUMPY, mode=Mode.OFF)

Event = tuple[int, int, int]


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    chosen: Engine = request.param
    return chosen


def story(engine: Engine, events: list[Event], slots: SlotConfig | Sequence[SlotConfig] = JUMPY) -> Outcome:
    slots = (slots,) * 3 if isinstance(slots, SlotConfig) else tuple(slots)
    return run_story(events, CotConfig(SHAPE, slots), "cot_chain", engine)


def test_each_tracker_sees_what_those_before_it_let_pass(engine: Engine) -> None:
    run = story(engine, [(0, x, 64) for x in (20, 50, 80, 110, 20, 50, 80)])
    assert run.owners == [0, 1, 2, -1, 0, 1, 2]


def test_ownership_is_by_order_even_where_a_later_tracker_is_active(engine: Engine) -> None:
    waiting = replace(JUMPY, mode=Mode.FIXED, init_cm_x=64, init_cm_y=64, clust_nev=5, nev_max=5)  # from 58 to 70
    run = story(engine, [(0, 72, 64), (0, 70, 64), (0, 71, 64)], [waiting, JUMPY, OFF])
    assert run.owners == [1, 0, 1]  # 70 lies in both windows


def test_windows_of_a_chain_may_overlap_and_never_merge(engine: Engine) -> None:
    run = story(engine, [(0, 30, 64), (0, 42, 64), (0, 37, 64)])
    assert run.records("kind", "slot", "x") == [(BORN, 0, 30), (BORN, 1, 42), (MOVED, 1, 37)]


def test_the_ids_of_n_trackers_stand_n_apart(engine: Engine) -> None:
    events = [(0, 20, 64), (0, 60, 64), (2000, 20, 64), (2000, 60, 64), (4000, 20, 64)]
    run = story(engine, events)
    assert [record for record in run.records("kind", "slot", "track_id") if record[0] == BORN] == [
        (BORN, 0, 0),
        (BORN, 1, 1),
        (BORN, 0, 3),
        (BORN, 1, 4),
        (BORN, 0, 6),
    ]


def test_time_reaches_a_tracker_whose_events_are_all_taken_before_it(engine: Engine) -> None:
    # Tracker 0 takes everything from tick 100 on; tracker 1 ends 1000 ticks after its only event all the same.
    events = [(50, 20, 64), (70, 60, 64), *((tick, 20, 64) for tick in range(100, 1300, 100))]
    run = story(engine, events)
    assert [record for record in run.records("kind", "slot", "time", "seq") if record[0] == LOST] == [(LOST, 1, 1070, 12)]


def test_lives_that_end_on_the_way_to_one_event_end_in_order_of_time_then_of_slot(engine: Engine) -> None:
    run = story(engine, [(0, 20, 64), (5, 60, 64), (5, 100, 64), (7, 20, 64), (5000, 20, 64)])
    assert run.records("kind", "slot", "track_id", "time", "seq")[4:] == [
        (LOST, 1, 1, 1005, 4),
        (LOST, 2, 2, 1005, 4),
        (LOST, 0, 0, 1007, 4),
        (BORN, 0, 3, 5000, 4),
    ]


def test_an_event_that_no_tracker_wants_comes_out_at_the_end(engine: Engine) -> None:
    run = story(engine, [(0, 20, 64), (3, 60, 64)], OFF)
    assert (run.owners, run.kinds) == ([-1, -1], [])


def test_time_goes_on_where_nobody_takes_what_passes() -> None:
    device = bare_device(CotConfig(SHAPE, (JUMPY,) * 3, module="cot_chain"))
    device.stream(ticked(0, 20, 20))
    io = device.sim.io
    io.s_valid, io.s_event, io.s_tick, io.m_cm_ready, io.m_pass_ready = 1, 0, 10, 0, 0
    for _ in range(600):
        device.sim.clock.tick()
    assert (io.m_cm_valid, io.m_cm_kind, io.m_cm_time) == (1, LOST, 1000)


class TestClocks:
    """What the header of cot_chain.v claims."""

    @pytest.mark.parametrize("upstream", [0, 1, 2, 7])
    def test_a_record_comes_later_by_2_clocks_for_every_upstream_tracker(self, upstream: int) -> None:
        shape = EIGHT if upstream > 2 else SHAPE
        config = CotConfig(shape, (*(OFF,) * upstream, *(JUMPY,) * (shape.n_slots - upstream)), module="cot_chain")
        _, times = bare_device(config).stream_timed(ticked([0] * 20, 64, 64))
        assert times.recorded[0] - times.accepted[0] == 7 + 2 * upstream
        assert set(np.diff(times.recorded)) == {5}  # the trackers work side by side: throughput is that of one

    def test_an_event_takes_3_clocks_where_no_centre_moves(self) -> None:
        config = CotConfig(SHAPE, (OFF,) * 3, module="cot_chain")
        _, times = bare_device(config).stream_timed(ticked([0] * 50, 64, 64))
        assert set(np.diff(times.accepted)[5:]) == {3}


# N -> shape, runs of 50,000 events.
RANDOM: dict[str, tuple[Shape, int, tuple[float, ...]]] = {
    "1 tracker": (replace(SHAPE, n_slots=1, frac=1), 8, (0.3, 2, 10)),
    "3 trackers": (SHAPE, 10, (0.3, 2, 10)),
    "8 trackers": (EIGHT, 7, (0.3, 2, 10)),
    "one bit": (ONE_BIT, 6, (0.1, 0.3, 1)),
}


@pytest.mark.parametrize("name", RANDOM)
def test_random_registers_traffic_and_stalls_are_exact(name: str) -> None:
    shape, runs, rates = RANDOM[name]
    census = compare_random_runs(shape, "cot_chain", 2026, runs, 50_000, rates=rates)
    assert all(census[kind] > 1_000 for kind in (BORN, MOVED, LOST))
    assert census[MERGED] == 0


def test_decisions_do_not_depend_on_stalls() -> None:
    rng = np.random.default_rng(8)
    config = CotConfig(SHAPE, (replace(JUMPY, clust_nev=3, nev_min=3, max_ticks=50),) * 3, module="cot_chain")
    traffic = random_traffic(rng, SHAPE, 20_000, 2)
    stalls = (Stalls(), Stalls.random(rng), Stalls.random(rng))
    runs = [bare_device(config, stalls=pattern).stream(traffic) for pattern in stalls]
    assert len(runs[0].records) > 1000
    for other in runs[1:]:
        assert all(np.array_equal(mine, theirs) for mine, theirs in zip(runs[0], other, strict=True))

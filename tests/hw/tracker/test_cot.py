# SPDX-License-Identifier: Apache-2.0
"""One tracker, tested with stories: the same events run through cot.v, an array of one slot and the golden model of both.

Ticks, places and arithmetic are worked out by hand in the comments.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest

from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from support.testing import Sink, Source, always, run_streams
from support.tokens import ticked
from support.trials import ENGINES, Outcome, bare_device, compare_random_runs, random_traffic, run_story

SHAPE = Shape(n_slots=1, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=8, seq_w=16, time_w=20)
PUBLISHED = replace(SHAPE, frac=0, tick_w=3)
ONE_BIT = Shape(1, x_w=1, y_w=1, frac=0, tick_w=1, radix_w=1, nev_w=1, tc_w=1, sup_w=1, id_w=1, seq_w=8, time_w=8)
WIDEST = Shape(1, x_w=16, y_w=16, frac=8, tick_w=32, radix_w=12, nev_w=16, tc_w=32, sup_w=32, id_w=32, seq_w=48, time_w=48)

BORN, MOVED, LOST = Kind.BORN, Kind.MOVED, Kind.LOST

# A window of 13 x 13 pixels that waits at (64, 64); the centre moves half of half of the way to an event.
FIXED = SlotConfig(
    mode=Mode.FIXED, init_cm_x=64, init_cm_y=64,
    init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=4, hist_avg=1,
    max_ticks=20, clust_nev=8, nev_min=8, nev_max=8, nev_th=0, detect_ticks=100,
)  # fmt: skip

Player = Callable[..., Outcome]
Event = tuple[int, int, int]


@pytest.fixture(params=[(module, engine) for module in ("cot", "cot_array") for engine in ENGINES], ids="-".join)
def play(request: pytest.FixtureRequest) -> Player:
    """Tells a story to one engine with a slot's registers, by default FIXED with some changed."""
    module, engine = request.param

    def teller(story: Iterable[Event], shape: Shape = SHAPE, **registers: int) -> Outcome:
        return run_story(story, CotConfig(shape, (replace(FIXED, **registers),)), module, engine)

    return teller


def at(ticks: Iterable[int], x: int = 64, y: int = 64) -> list[Event]:
    """Events at one place."""
    return [(tick, x, y) for tick in ticks]


def n_ev_of(n: int) -> dict[str, int]:
    """Registers of a tracker whose N_ev stays at n."""
    return {"clust_nev": n, "nev_min": n, "nev_max": n}


class TestTable2:
    """The paper's two situations: slow with N_ev 8 and TC 20, fast with N_ev 3 or 5 and TC 7."""

    @pytest.fixture(params=[(8, 20), (3, 7), (5, 7)], ids=["slow", "fast 3", "fast 5"])
    def situation(self, request: pytest.FixtureRequest) -> tuple[int, int]:
        chosen: tuple[int, int] = request.param
        return chosen

    def test_a_centre_goes_out_with_every_nevth_event(self, play: Player, situation: tuple[int, int]) -> None:
        n_ev, tc = situation
        run = play(at(range(1, 3 * n_ev + 1)), max_ticks=tc, **n_ev_of(n_ev))
        assert run.records("kind", "seq", "time", "support") == [
            (BORN, n_ev - 1, n_ev, n_ev),
            (MOVED, 2 * n_ev - 1, 2 * n_ev, 2 * n_ev),
            (MOVED, 3 * n_ev - 1, 3 * n_ev, 3 * n_ev),
        ]
        assert set(run.owners) == {0}

    def test_tc_overflow_ends_the_life_at_last_event_plus_tc(self, play: Player, situation: tuple[int, int]) -> None:
        n_ev, tc = situation
        run = play([*at(range(1, n_ev + 1)), (1000, 0, 0)], max_ticks=tc, **n_ev_of(n_ev))
        assert run.records("kind", "seq", "time") == [(BORN, n_ev - 1, n_ev), (LOST, n_ev, n_ev + tc)]

    def test_every_event_one_tick_before_the_overflow_keeps_it_alive(self, play: Player, situation: tuple[int, int]) -> None:
        n_ev, tc = situation
        first = n_ev + tc - 1
        second = first + tc - 1  # the N_ev-th event is still to come
        run = play([*at(range(1, n_ev + 1)), *at([first, second, second + tc])], max_ticks=tc, **n_ev_of(n_ev))
        assert run.records("kind", "time") == [(BORN, n_ev), (LOST, second + tc)]


class TestLife:
    def test_the_event_that_waits_at_the_overflow_opens_the_next_life(self, play: Player) -> None:
        run = play(at([1, 2, 3, 23, 24, 25]), **n_ev_of(3))  # 3 + 20 = 23: the end comes first, the event right after it
        assert run.records("kind", "track_id", "seq", "time", "support") == [
            (BORN, 0, 2, 3, 3),
            (LOST, 0, 3, 23, 3),
            (BORN, 1, 5, 25, 3),
        ]
        assert run.owners == [0] * 6

    def test_an_event_elsewhere_does_not_prolong_a_life(self, play: Player) -> None:
        run = play([*at([1, 2, 3]), (10, 0, 0), (22, 0, 0), (23, 0, 0)], **n_ev_of(3))
        assert run.records("kind", "seq", "time") == [(BORN, 2, 3), (LOST, 5, 23)]
        assert run.owners == [0, 0, 0, -1, -1, -1]

    def test_lost_shows_the_last_centre_and_goes_back_to_the_start(self, play: Player) -> None:
        # k = 0: the centre jumps to the event; 13 pixels from the start it is found again only after the loss.
        run = play([(1, 70, 60), (2, 75, 60), (3, 64, 64), (30, 64, 64)], hist_avg=0, **n_ev_of(1))
        assert run.records("kind", "x", "y", "radius", "n_ev", "support") == [
            (BORN, 70, 60, 6, 1, 1),
            (MOVED, 75, 60, 6, 1, 2),
            (LOST, 75, 60, 6, 1, 2),
            (BORN, 64, 64, 6, 1, 1),
        ]
        assert run.owners == [0, 0, -1, 0]

    def test_a_life_of_one_tick(self, play: Player) -> None:
        run = play(at([5, 5, 6, 6]), max_ticks=1, **n_ev_of(1))
        assert run.records("kind", "track_id", "time") == [
            (BORN, 0, 5),
            (MOVED, 0, 5),
            (LOST, 0, 6),
            (BORN, 1, 6),
            (MOVED, 1, 6),
        ]

    def test_ids_count_lives_and_are_not_reused(self, play: Player) -> None:
        run = play(at(range(0, 1000, 20)), **n_ev_of(1))
        assert [record for record in run.records("kind", "track_id") if record[0] == BORN] == [(BORN, i) for i in range(50)]
        assert [record for record in run.records("kind", "track_id") if record[0] == LOST] == [(LOST, i) for i in range(49)]

    def test_ids_wrap_at_their_width(self, play: Player) -> None:
        run = play(at(range(0, 258 * 20, 20)), **n_ev_of(1))
        assert [track_id for kind, track_id in run.records("kind", "track_id") if kind == BORN] == [*range(256), 0, 1]

    def test_support_saturates(self, play: Player) -> None:
        run = play(at([1] * 300), **n_ev_of(1))
        assert [support for (support,) in run.records("support")] == [*range(1, 256), *[255] * 45]


class TestCandidate:
    @pytest.mark.parametrize("third", [14, 15])
    def test_the_event_exactly_at_detect_ticks_still_counts(self, play: Player, third: int) -> None:
        run = play(at([5, 9, third]), detect_ticks=10, **n_ev_of(3))
        assert run.records("kind", "time", "support") == [(BORN, third, 3)]

    def test_a_candidate_that_takes_longer_starts_over_in_silence(self, play: Player) -> None:
        run = play(at([5, 9, 16, 20, 26]), detect_ticks=10, **n_ev_of(3))  # 16 > 5 + 10: it is the first of three again
        assert run.records("kind", "track_id", "time", "support") == [(BORN, 0, 26, 3)]
        assert run.owners == [0] * 5

    def test_its_time_begins_with_its_first_event(self, play: Player) -> None:
        run = play(at([4000, 4010]), detect_ticks=10, **n_ev_of(2))
        assert run.records("kind", "time") == [(BORN, 4010)]

    def test_it_has_no_lifetime(self, play: Player) -> None:
        run = play(at([0, 90, 100]), max_ticks=5, detect_ticks=100, **n_ev_of(3))
        assert run.records("kind", "time") == [(BORN, 100)]

    def test_the_average_of_one_that_starts_over_is_forgotten(self, play: Player) -> None:
        # Without the restart the average would begin at (64 + 70) / 2.
        run = play([(0, 70, 64), (50, 64, 64), (51, 64, 64)], detect_ticks=10, **n_ev_of(2))
        assert run.records("kind", "x", "y") == [(BORN, 64, 64)]


class TestWindow:
    def test_its_ends_count_on_both_sides(self, play: Player) -> None:
        places = [(58, 58), (70, 70), (57, 64), (71, 64), (64, 57), (64, 71), (58, 70), (70, 58)]
        run = play([(0, x, y) for x, y in places])
        assert run.owners == [0, 0, -1, -1, -1, -1, 0, 0]
        assert run.rel == [(0, 0), (12, 12), (0, 0), (0, 0), (0, 0), (0, 0), (0, 12), (12, 0)]

    def test_it_is_clipped_at_the_first_and_at_the_last_pixel(self, play: Player) -> None:
        corner = play([(0, 0, 0), (0, 6, 6), (0, 7, 0), (0, 127, 127)], init_cm_x=0, init_cm_y=0)
        assert corner.owners == [0, 0, -1, -1]
        assert corner.rel[:2] == [(6, 6), (12, 12)]
        corner = play([(0, 127, 127), (0, 121, 121), (0, 120, 127), (0, 0, 0)], init_cm_x=127, init_cm_y=127)
        assert corner.owners == [0, 0, -1, -1]
        assert corner.rel[:2] == [(6, 6), (0, 0)]

    def test_an_event_is_addressed_in_the_window_that_took_it_and_not_in_the_one_that_it_made(self, play: Player) -> None:
        run = play([(0, 70, 64), (0, 70, 64)], hist_avg=0, **n_ev_of(1))
        assert run.rel == [(12, 6), (6, 6)]

    def test_a_centre_belongs_to_the_nearest_pixel(self, play: Player) -> None:
        # The first event moves the centre to 65.5, whose pixel is 66: 72 is inside, 59 is not.
        run = play([(0, 70, 64), (0, 72, 64), (0, 59, 64)], **n_ev_of(1))
        assert run.records("x")[0] == (65.5,)
        assert run.owners == [0, 0, -1]


class TestStart:
    def test_a_seed_is_the_centre_and_the_first_event(self, play: Player) -> None:
        run = play([(0, 10, 20), (1, 16, 14), (2, 17, 20), (3, 10, 20)], mode=Mode.SEEDED, **n_ev_of(3))
        assert run.owners == [0, 0, -1, 0]
        assert run.rel == [(6, 6), (12, 0), (0, 0), (6, 6)]
        assert run.records("kind", "seq", "support") == [(BORN, 3, 3)]

    def test_a_seed_alone_can_be_a_birth(self, play: Player) -> None:
        run = play([(0, 10, 20), (9, 100, 100), (30, 100, 90)], mode=Mode.SEEDED, **n_ev_of(1))
        assert run.records("kind", "x", "y", "time") == [(BORN, 10, 20, 0), (LOST, 10, 20, 20), (BORN, 100, 90, 30)]

    def test_a_seeded_slot_is_free_again_after_a_candidate_that_was_too_slow(self, play: Player) -> None:
        run = play([(0, 10, 20), (10, 99, 99), (11, 99, 99)], mode=Mode.SEEDED, detect_ticks=10, **n_ev_of(2))
        assert run.owners == [0, -1, 0]
        assert run.rel[2] == (6, 6)

    def test_a_slot_that_is_off_lets_everything_pass(self, play: Player) -> None:
        run = play([(0, 64, 64), (5000, 64, 64), (5000, 0, 0)], mode=Mode.OFF, **n_ev_of(1))
        assert run.owners == [-1] * 3
        assert run.kinds == []


class TestAverage:
    def test_by_hand_with_fractional_bits(self, play: Player) -> None:
        # av 64, 67, 68.5, 69.25 and cm 64 + 3/2, 65.5 + 3/2, 67 + 2.25/2; on y towards 60: -2, -3, -3.5.
        run = play(at([0, 1, 2], 70, 60), **n_ev_of(1))
        assert run.records("x", "y") == [(65.5, 63.0), (67.0, 62.0), (68.125, 61.25)]

    def test_holds_the_nevth_event(self, play: Player) -> None:
        run = play([(0, 64, 64), (0, 70, 64)], **n_ev_of(2))  # without it av, and so the centre, would stay at 64
        assert run.records("x", "y") == [(65.5, 64.0)]

    def test_the_published_shift_floors(self, play: Player) -> None:
        # k = 1: av 64, 67, 68, 69 and cm 64 + floor(3/2), 65 + floor(3/2), 66 + floor(3/2); y: av 62, 61, 60, cm 63, 62, 61.
        run = play(at([0, 1, 2], 70, 60), PUBLISHED, **n_ev_of(1))
        assert run.records("x", "y") == [(65.0, 63.0), (66.0, 62.0), (67.0, 61.0)]

    @pytest.mark.parametrize(("k", "x"), [(1, 68), (2, 64), (3, 64)])
    def test_the_published_shift_stops_short_of_an_object_above(self, play: Player, k: int, x: int) -> None:
        # The average stops 2^k - 1 short of the object and the centre as much short of the average.
        run = play(at([0] * 60, 70), PUBLISHED, hist_avg=k, **n_ev_of(1))
        assert run.records("x")[-1] == (x,)

    @pytest.mark.parametrize("k", [1, 2, 3])
    def test_the_published_shift_reaches_an_object_below(self, play: Player, k: int) -> None:
        run = play(at([0] * 60, 58), PUBLISHED, hist_avg=k, **n_ev_of(1))
        assert run.records("x")[-1] == (58,)

    @pytest.mark.parametrize("target", [58, 70])
    @pytest.mark.parametrize("k", [1, 2, 3, 4])
    def test_fractional_bits_bring_the_centre_within_its_pixel_from_both_sides(self, play: Player, k: int, target: int) -> None:
        # Average and centre stop where half a step is less than the step's resolution: 2^(k-1)/16 pixels at most, each.
        run = play(at([0] * 200, target), hist_avg=k, **n_ev_of(1))
        (x,) = run.records("x")[-1]
        assert abs(float(str(x)) - target) <= 2 * 2 ** (k - 1) / 16


def windows(*durations: tuple[int, int]) -> list[Event]:
    """Windows of n events that take d ticks from the update before: all of them at the end, as one burst."""
    story: list[Event] = []
    now = 0
    for n, ticks in durations:
        now += ticks
        story += at([now] * n)
    return story


class TestNev:
    """N_ev of 4, from 2 to 8, with a threshold of 2 ticks."""

    LIMITS = {"clust_nev": 4, "nev_min": 2, "nev_max": 8, "nev_th": 2, "max_ticks": 4000}  # noqa: RUF012

    def n_ev(self, run: Outcome) -> list[object]:
        return [n_ev for (n_ev,) in run.records("n_ev")]

    def test_the_first_window_leaves_it_alone(self, play: Player) -> None:
        assert self.n_ev(play([*at([0, 1, 2, 99])], **self.LIMITS)) == [4]

    @pytest.mark.parametrize(("second", "n_ev"), [(8, 4), (12, 4), (13, 8), (7, 2)])
    def test_a_window_must_differ_by_more_than_the_threshold(self, play: Player, second: int, n_ev: int) -> None:
        first = at([0, 0, 0, 10])  # 10 ticks
        assert self.n_ev(play([*first, *at([10 + second] * 4)], **self.LIMITS)) == [4, n_ev]

    def test_it_doubles_while_windows_get_slower_up_to_its_bound(self, play: Player) -> None:
        run = play([*windows((4, 0), (4, 10), (8, 20), (8, 30))], **self.LIMITS)
        assert self.n_ev(run) == [4, 8, 8, 8]

    def test_it_halves_while_windows_get_faster_down_to_its_bound(self, play: Player) -> None:
        run = play([*at([0]), *windows((3, 40), (4, 30), (2, 20), (2, 10))], **self.LIMITS)
        assert self.n_ev(run) == [4, 2, 2, 2]

    def test_an_odd_bound_is_kept(self, play: Player) -> None:
        run = play(
            [*at([0]), *windows((4, 40), (5, 30), (3, 60), (6, 90))],
            clust_nev=5, nev_min=3, nev_max=7, nev_th=0, max_ticks=4000,
        )  # fmt: skip
        assert self.n_ev(run) == [5, 3, 6, 7]

    def test_a_new_life_begins_with_the_initial_n_ev(self, play: Player) -> None:
        run = play([*windows((4, 0), (4, 10)), *at([5000] * 4)], **self.LIMITS)
        assert run.records("kind", "n_ev") == [(BORN, 4), (MOVED, 8), (LOST, 8), (BORN, 4)]


class TestRadius:
    """g of 4 from 3 to 6 in a ring of 2; k = 8 keeps the centre where it is."""

    LIMITS = {"radix_step": 1, "radix_min": 3, "radix_max": 6, "hist_avg": 8}  # noqa: RUF012

    def radii(self, run: Outcome) -> list[object]:
        return [radius for (radius,) in run.records("radius")]

    @pytest.mark.parametrize(("dx", "dy"), [(1, 0), (-1, 0), (0, 1), (0, -1)])
    def test_it_grows_with_an_event_beyond_g_and_shrinks_without_within_its_bounds(
        self, play: Player, dx: int, dy: int
    ) -> None:
        distances = [5, 6, 6, 6, 5, 4, 3, 3]  # g: 4 to 5, 6, stays for 6 is not beyond 6 …
        run = play([(0, 64 + dx * d, 64 + dy * d) for d in distances], **self.LIMITS, **n_ev_of(1))
        assert self.radii(run) == [7, 8, 7, 8, 7, 6, 5, 5]

    def test_one_event_in_the_ring_is_enough(self, play: Player) -> None:
        run = play([(0, 69, 64), (0, 64, 64), (0, 64, 64), (0, 64, 64)], **self.LIMITS, **n_ev_of(2))
        assert self.radii(run) == [7, 6]  # grown, and the window after it begins with an empty ring

    def test_steps_stop_at_the_bounds(self, play: Player) -> None:
        registers = self.LIMITS | {"radix_step": 31}
        run = play([(0, 69, 64), (0, 64, 64)], **registers, **n_ev_of(1))
        assert self.radii(run) == [8, 5]


@pytest.mark.parametrize("module", ["cot", "cot_array", "cot_chain"])
@pytest.mark.parametrize("born", [True, False])
def test_a_mode_write_restarts_the_slot_and_ends_an_active_life(module: Module, born: bool) -> None:
    config = CotConfig(SHAPE, (replace(FIXED, **n_ev_of(3)),), module=module)
    device = bare_device(config)
    io = device.sim.io
    n = 5 if born else 2
    device.stream(ticked(np.arange(10, 10 + n), 64, 64))
    io.m_cm_ready = 0
    device.write_registers(0, config.slots[0])
    for _ in range(15):
        device.sim.clock.tick()
    assert io.m_cm_valid == born
    if born:
        assert (io.m_cm_kind, io.m_cm_id, io.m_cm_seq, io.m_cm_time, io.m_cm_support) == (LOST, 0, 5, 14, 5)
    io.m_cm_ready = 1
    for _ in range(10):
        device.sim.clock.tick()
    assert (io.m_cm_valid, io.idle) == (0, 1)
    after = device.stream(ticked([20, 21, 22], 64, 64))
    assert Outcome(config, after).records("kind", "track_id", "seq", "support") == [(BORN, int(born), n + 2, 3)]


def test_a_mode_write_after_a_passed_event_names_the_next_one_too() -> None:
    config = CotConfig(SHAPE, (replace(FIXED, **n_ev_of(1)),), module="cot")
    device = bare_device(config)
    device.stream(ticked([1, 2], [64, 0], [64, 0]))
    device.sim.io.m_cm_ready = 0
    device.write_registers(0, config.slots[0])
    for _ in range(5):
        device.sim.clock.tick()
    assert (device.sim.io.m_cm_kind, device.sim.io.m_cm_seq, device.sim.io.m_cm_time) == (LOST, 2, 2)


def timed(story: list[Event], **registers: int) -> tuple[list[int], list[int]]:
    """Clocks at which the events went in and the records came out, nothing stalled."""
    device = bare_device(CotConfig(SHAPE, (replace(FIXED, **registers),), module="cot"))
    _, times = device.stream_timed(ticked(*np.array(story).T))
    return times.accepted.tolist(), times.recorded.tolist()


class TestClocks:
    """What the header of cot.v claims."""

    def test_a_centre_comes_4_clocks_after_its_event_and_takes_5(self) -> None:
        accepted, recorded = timed(at([0] * 9), **n_ev_of(1))
        assert np.subtract(recorded, accepted).tolist() == [4] * 9
        assert set(np.diff(accepted)) == {5}

    @pytest.mark.parametrize("x", [64, 0], ids=["owned", "passed"])
    def test_other_events_take_3_clocks(self, x: int) -> None:
        accepted, recorded = timed(at([0] * 9, x), **n_ev_of(60))
        assert set(np.diff(accepted)) == {3}
        assert recorded == []

    def test_a_token_without_event_takes_3_clocks(self) -> None:
        accepted, _ = timed([(0, 0, 0), (10 * (2**20 - 1), 0, 0), (10 * (2**20 - 1), 0, 0)])
        assert np.diff(accepted).tolist() == [3 + 9 * 3, 3]

    @pytest.mark.parametrize(("n", "clocks"), [(60, 3 + 3), (1, 5 + 4)], ids=["candidate", "visible"])
    def test_a_token_that_ends_a_life_takes_3_clocks_more_and_4_with_a_record(self, n: int, clocks: int) -> None:
        accepted, recorded = timed(at([0, 200, 200]), max_ticks=100, detect_ticks=100, **n_ev_of(n))
        assert accepted[2] - accepted[1] == clocks
        assert len(recorded) == (4 if n == 1 else 0)

    def test_owned_and_passed_events_come_out_after_2_clocks(self) -> None:
        device = bare_device(CotConfig(SHAPE, (FIXED,), module="cot"))
        io = device.sim.io
        for x, prefix in ((64, "own"), (0, "pass")):
            io.s_valid, io.s_tick, io.s_event, io.s_x, io.s_y = 1, 0, 1, x, 64
            clocks = 0
            while not io[f"m_{prefix}_valid"]:
                assert clocks or io.s_ready
                device.sim.clock.tick()
                io.s_valid = 0
                clocks += 1
            assert clocks == 2
            io.m_own_ready = io.m_pass_ready = 1
            for _ in range(3):
                device.sim.clock.tick()


def test_ticks_travel_on_whether_the_event_does_or_not() -> None:
    device = bare_device(CotConfig(SHAPE, (replace(FIXED, **n_ev_of(2)),), module="cot"))
    fields = ["tick", "event", "x", "y", "p", "seq"]
    tokens = [
        (5, 1, 64, 64, 1, 0),
        (0, 1, 64, 64, 0, 1),
        (7, 1, 3, 4, 1, 2),
        (9, 0, 0, 0, 0, 3),
        (0, 0, 0, 0, 0, 3),
        (0, 1, 3, 4, 0, 3),
    ]
    passed = Sink(device.sim, "m_pass", fields, always())
    others = [Sink(device.sim, "m_own", ["x", "y", "p", "seq"], always()), Sink(device.sim, "m_cm", ["kind"], always())]
    run_streams(device.sim, [Source(device.sim, "s", fields, tokens, always())], [passed, *others])
    assert [(word[0], word[1], word[5]) for word in passed.words] == [(5, 0, 0), (7, 1, 2), (9, 0, 3), (0, 1, 3)]
    assert [word[2:5] for word in passed.words if word[1]] == [(3, 4, 1), (3, 4, 0)]
    assert others[0].words == [(6, 6, 1, 0), (6, 6, 0, 1)]


RANDOM = {
    "frac 4": (SHAPE, 12, (0.3, 2, 10)),
    "frac 0, 3-bit ticks": (PUBLISHED, 10, (0.3, 2, 10)),
    "frac 1, 1-bit ticks": (replace(SHAPE, frac=1, tick_w=1), 10, (0.1, 0.5, 2)),
    "one bit": (ONE_BIT, 10, (0.1, 0.3, 1)),
    "widest": (WIDEST, 10, (1, 10, 100)),
}


@pytest.mark.parametrize("name", RANDOM)
def test_random_registers_traffic_and_stalls_are_exact(name: str) -> None:
    shape, runs, rates = RANDOM[name]
    census = compare_random_runs(shape, "cot", 2026, runs, 50_000, rates=rates)
    assert all(census[kind] > 1_000 for kind in (BORN, MOVED, LOST))
    assert census[Kind.MERGED] == 0


def test_decisions_do_not_depend_on_stalls() -> None:
    rng = np.random.default_rng(8)
    config = CotConfig(SHAPE, (replace(FIXED, mode=Mode.SEEDED, **n_ev_of(3)),), module="cot")
    traffic = random_traffic(rng, SHAPE, 20_000, 2)
    patterns = (Stalls(), Stalls.random(rng), Stalls.random(rng))
    runs = [bare_device(config, stalls=stalls).stream(traffic) for stalls in patterns]
    assert len(runs[0].records) > 100
    for other in runs[1:]:
        assert all(np.array_equal(mine, theirs) for mine, theirs in zip(runs[0], other, strict=True))

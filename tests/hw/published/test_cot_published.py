# SPDX-License-Identifier: Apache-2.0
"""cot_published.v against the model at every clock, and each oddity of docs/published.md as a story.

Most stories are played to the first tracker of a cascade on a line without delay; cosim/evcot_cosim/devices/published_device.py
tells how. Where the tracker's own ports matter it is played alone.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.published._kernel import TC2
from evcot.hardware.published.model import REGISTERS, PublishedConfig, PublishedTracker
from evcot_cosim.devices.published_device import TRACKER, Event, at, equal, play, quiet, rtl
from support.four_state import needs_icarus, replay
from support.published import CONFIG, centres, every, n_evs, noise, one, reset_tracker, some_registers, wandering


def requests(n: int, *clocks: int, high: int = 100, low: int = 100) -> NDArray[np.void]:
    """n clocks of the single tracker, with a request at these; events and passed events are acknowledged at all times."""
    inputs = quiet(TRACKER, n)
    inputs["s_req_n"][list(clocks)] = 0
    inputs["m_event_ack_n"] = inputs["m_pass_ack_n"] = 0
    inputs["s_high"], inputs["s_low"] = high, low
    return inputs


def asserted(outputs: NDArray[np.void], line: str) -> list[int]:
    """The clocks in which a line is low."""
    return np.flatnonzero(outputs[line] == 0).tolist()


class TestClocks:
    """Counted from the clock whose end first sees the request."""

    def test_a_rejected_event_is_acknowledged_after_1_and_out_after_3(self) -> None:
        outputs = one(CONFIG, requests(20, 10, 11, 14, 15, high=200))
        assert asserted(outputs, "m_pass_req_n") == [10 + 3, 10 + 4 + 3]  # idle again after 4
        assert asserted(outputs, "s_ack_n") == [0, *range(11, 14), *range(15, 18)]  # InitCell is clock 0

    def test_an_event_of_the_cluster_is_out_after_3(self) -> None:
        assert asserted(one(CONFIG, requests(20, 10, 11, 14, 15)), "m_event_req_n") == [10 + 3, 10 + 4 + 3]

    def test_a_centre_is_out_after_7_its_last_event_after_6_and_idle_comes_after_8(self) -> None:
        inputs = requests(26, 10, 11, 18, 19)
        inputs["m_centre_ack_n"][17] = 0
        outputs = one(replace(CONFIG, nev_th=1), inputs)
        assert asserted(outputs, "m_event_req_n") == [10 + 6, 10 + 8 + 3]
        assert asserted(outputs, "m_centre_req_n") == [10 + 7]
        assert asserted(outputs, "s_ack_n") == [0, *range(11, 17), *range(19, 22)]


class TestHandshakes:
    def test_the_acknowledge_is_low_in_every_state_but_idle_and_the_one_that_sends_a_centre(self) -> None:
        inputs = requests(24, 10)  # the request is released long before
        inputs["m_centre_ack_n"][20:] = 0
        outputs = one(replace(CONFIG, nev_th=1), inputs)
        assert asserted(outputs, "m_centre_req_n") == [17, 18, 19, 20]
        assert asserted(outputs, "s_ack_n") == [0, *range(11, 17)]

    def test_a_request_is_served_once_however_long_it_lasts(self) -> None:
        result = play(at([10, 30]), CONFIG, release=[12, 0])
        assert result.outputs["s_ack_n"][10:30].tolist() == [1] + [0] * 14 + [1] * 5
        assert result.word_clock.tolist() == [13, 33]

    @pytest.mark.parametrize(("line", "high"), [("pass", 200), ("event", 100)])
    def test_an_output_waits_for_its_acknowledge_and_for_the_request_to_go(self, line: str, high: int) -> None:
        inputs = requests(30, *range(10, 20), high=high)
        inputs[f"m_{line}_ack_n"] = 1
        inputs[f"m_{line}_ack_n"][[13, 17, 18, 24]] = 0  # thrice while the request stands
        assert asserted(one(CONFIG, inputs), f"m_{line}_req_n") == list(range(13, 25))

    def test_the_last_event_of_a_window_waits_likewise_and_its_centre_with_it(self) -> None:
        inputs = requests(40, *range(10, 20))
        inputs["m_event_ack_n"] = 1
        inputs["m_event_ack_n"][[17, 18, 24]] = 0
        inputs["m_centre_ack_n"][24:28] = 0
        outputs = one(replace(CONFIG, nev_th=1), inputs)
        assert asserted(outputs, "m_event_req_n") == list(range(16, 25))
        assert asserted(outputs, "m_centre_req_n") == [25]

    def test_a_centre_does_not_wait_for_a_request_to_go(self) -> None:
        inputs = requests(30, 10, *range(17, 30))
        inputs["m_centre_ack_n"][17] = 0
        assert asserted(one(replace(CONFIG, nev_th=1), inputs), "m_centre_req_n") == [17]

    def test_no_request_is_taken_while_the_centre_is_still_acknowledged(self) -> None:
        inputs = requests(40, 10, *range(18, 40))
        inputs["m_centre_ack_n"][17:25] = 0
        outputs = one(replace(CONFIG, nev_th=1), inputs)
        assert asserted(outputs, "s_ack_n") == [0, *range(11, 17), *range(26, 40)]

    def test_an_acknowledge_that_is_still_low_takes_the_next_offer(self) -> None:
        inputs = requests(13, 3, 4, 7, 8, high=200)
        inputs["m_pass_ack_n"][:5] = 1
        assert asserted(one(CONFIG, inputs), "m_pass_req_n") == [6, 10]

    def test_a_passed_address_is_that_of_the_input_in_the_same_clock_and_an_events_is_kept(self) -> None:
        inputs = requests(20, 10)
        inputs["m_event_ack_n"] = inputs["m_pass_ack_n"] = 1
        inputs["s_high"][11:], inputs["s_low"][11:] = 7, np.arange(9)
        outputs = one(CONFIG, inputs)
        assert outputs["m_event_high"][13:].tolist() == outputs["m_event_low"][13:].tolist() == [100] * 7
        inputs["s_high"][10] = 200
        outputs = one(CONFIG, inputs)
        assert (outputs["m_pass_high"][13:].tolist(), outputs["m_pass_low"][13:].tolist()) == ([7] * 7, list(range(2, 9)))


class TestLostEvents:
    def test_an_event_that_meets_the_initialisation_is_acknowledged_and_lost(self) -> None:
        outputs = one(CONFIG, requests(11, 0, 1, 2, 5, 6))  # InitCell is clock 0
        assert outputs["s_ack_n"].tolist() == [0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 1]
        assert asserted(outputs, "m_event_req_n") == [8]

    def test_an_expired_cell_initialises_first_and_the_event_that_waits_is_lost(self) -> None:
        # TC is 0 at clock -1, which is InitCell, and so 50 at clock 49; idle acts on that at clock 50.
        results = [play(at([clock]), replace(CONFIG, max_time=50)) for clock in range(48, 53)]
        assert [len(result.word) for result in results] == [1, 1, 0, 0, 1]
        assert results[2].acknowledged.tolist() == [51]


class TestTime:
    def test_only_a_centre_update_clears_tc(self) -> None:
        # An event of the cluster every 10 clocks, and still the cell expires, at clock 200: the count starts over.
        result = play(every(10, 24), replace(CONFIG, nev_th=22, max_time=200))
        assert n_evs(result) == []
        result = play(every(10, 24), replace(CONFIG, nev_th=19, max_time=200))
        assert n_evs(result) == [19]

    def test_a_centre_update_clears_it(self) -> None:
        # Updates at the 4th, 6th and 8th event: TC never gets to 60.
        assert len(centres(play(every(10, 8), replace(CONFIG, max_time=60)))) == 3

    @pytest.mark.parametrize("clock", [46, 47, 48])
    def test_a_tracker_that_is_busy_at_that_clock_expires_when_it_is_idle(self, clock: int) -> None:
        config = replace(CONFIG, init_cm_low=100, nev_th=3, max_time=50)
        assert n_evs(play(at([10, clock, 80, 110]), config)) == []
        assert n_evs(play(at([10, clock, 80, 110, 140]), config)) == [2 + 3]
        assert n_evs(play(at([10, clock, 80]), replace(config, max_time=1000))) == [3]

    def test_an_update_that_begins_expired_is_abandoned(self) -> None:
        # The third event begins EvProc 3 clocks later. TC is 50 at clock 49, if no update has cleared it before.
        config = replace(CONFIG, init_cm_low=100, nev_th=3, max_time=50)
        for clock in (47, 48):
            assert len(play(at([10, 20, clock]), config).word) == 2  # the event is lost, too
            assert n_evs(play(at([10, 20, clock, 60, 70, 80]), config)) == [2 + 3]
        # Cleared in the very clock: the update is completed, and the life ends after it, with its halved N.
        assert n_evs(play(at([10, 20, 46, 80, 85, 90]), config)) == [3, 3]
        assert n_evs(play(at([10, 20, 45, 80, 90]), config)) == [3, 1]

    def test_an_abandoned_update_clears_tc(self) -> None:
        # TC is 0 at clock 51 and so 50 at clock 101: the second life ends, and its event at 80 counts no more.
        config = replace(CONFIG, init_cm_low=100, nev_th=3, max_time=50)
        assert n_evs(play(at([10, 20, 47, 80, 110, 140]), config)) == []

    def test_a_life_does_not_end_in_the_initialisation(self) -> None:
        # TC is 5 at clock 5: once idle, once still InitCell, because a request lasts.
        config = replace(CONFIG, max_time=5)
        assert asserted(one(config, requests(20, 0, 1, 2, 3)), "s_ack_n") == [0, 1, 2, 3, 4, 7]
        assert asserted(one(config, requests(20, 0, 1, 2, 3, 4)), "s_ack_n") == [0, 1, 2, 3, 4, 5]

    def test_it_expires_once_and_not_again_before_the_next_centre(self) -> None:
        config = replace(CONFIG, nev_th=3, max_time=50)
        assert n_evs(play(at([10, 20, 80, 500, 900]), config)) == [3 + 2]

    def test_a_new_life_starts_at_the_initial_centre_with_the_initial_n(self) -> None:
        config = replace(CONFIG, nev_th=2, max_time=2000)
        first = [*every(10, 6, 104, 96)]
        result = play([*first, *every(10, 2, 100, 100, first=4000)], config)
        assert centres(result)[0] == (101, 99)
        assert centres(result)[-1] == (100, 100)


class TestWindow:
    def test_its_ends_do_not_count(self) -> None:
        config = replace(CONFIG, nev_th=200)
        inside = [(92, 92), (108, 108), (92, 108), (108, 92), (100, 100)]
        outside = [(91, 100), (109, 100), (100, 91), (100, 109), (92, 109), (91, 92)]
        result = play([(20 * i, *place) for i, place in enumerate(inside + outside)], config)
        assert len(result.word) == len(inside)
        assert list(zip(result.pass_high.tolist(), result.pass_low.tolist(), strict=True)) == outside

    @pytest.mark.parametrize("edge", [0, 255])
    def test_the_first_and_the_last_address_are_never_inside(self, edge: int) -> None:
        near = 1 if edge == 0 else 254
        config = replace(CONFIG, init_cm_low=edge, init_cm_high=edge, init_radix=240, radix_th=7, nev_th=200)
        result = play([(0, near, near), (20, edge, near), (40, near, edge)], config)
        assert len(result.word) == 1
        assert len(result.pass_clock) == 2

    @pytest.mark.parametrize("axis", ["high", "low"])
    def test_its_upper_bound_wraps_at_512(self, axis: str) -> None:
        config = replace(CONFIG, init_radix=250, nev_th=200, **{f"init_cm_{axis}": 255})
        assert len(play(at([0]), replace(config, radix_th=6)).word) == 1
        assert len(play(at([0]), replace(config, radix_th=7)).word) == 0


class TestAverage:
    def test_it_floors(self) -> None:
        # k = 1: av 103, then 104 (104.5), then 105; the centre (105 + 100) / 2 = 102.5.
        assert centres(play(every(10, 4, 106), CONFIG)) == [(102, 100)]

    @pytest.mark.parametrize(("k", "stop"), [(1, 68), (2, 64), (3, 64)])
    def test_the_centre_stops_short_on_the_high_side(self, k: int, stop: int) -> None:
        config = replace(CONFIG, init_cm_low=64, init_cm_high=64, init_radix=30, radix_max=30, radix_min=30, hist_avg=k)
        assert centres(play(every(10, 400, 70, 70), config))[-1] == (stop, stop)
        assert centres(play(every(10, 400, 58, 58), config))[-1] == (58, 58)

    def test_the_nth_event_never_enters(self) -> None:
        assert centres(play([*every(10, 3), (30, 106, 94)], CONFIG)) == [(100, 100)]

    def test_it_runs_on_while_an_event_waits_to_be_acknowledged(self) -> None:
        # One event at 106, then the second makes a centre. Each clock of the wait: 103, 104, 105, 105, 105.
        found = [centres(play([(0, 106, 100), (50, 100, 100)], replace(CONFIG, nev_th=2), ack=[wait, 0])) for wait in range(4)]
        assert found == [[(101, 100)], [(102, 100)], [(102, 100)], [(102, 100)]]
        # Downwards: 97, 95 (95.5), 94 (94.5), 94: the centre halfway.
        found = [centres(play([(0, 94, 100), (50, 100, 100)], replace(CONFIG, nev_th=2), ack=[wait, 0])) for wait in range(4)]
        assert found == [[(98, 100)], [(97, 100)], [(97, 100)], [(97, 100)]]

    def test_it_runs_on_while_a_sender_holds_its_request(self) -> None:
        # The event is out at clock 3; the request is released at clock 2 + the delay.
        config = replace(CONFIG, nev_th=2)
        found = [centres(play([(0, 94, 100), (50, 100, 100)], config, release=[delay, 0])) for delay in range(5)]
        assert found == [[(98, 100)], [(98, 100)], [(97, 100)], [(97, 100)], [(97, 100)]]

    def test_the_centre_moves_once_however_long_the_last_event_waits(self) -> None:
        config = replace(CONFIG, nev_th=2)
        for wait in range(4):
            assert centres(play([(0, 106, 100), (50, 106, 100)], config, ack=[0, wait, 0])) == [(101, 100)]


def width(events: list[Event], config: PublishedConfig) -> int:
    """g after a story that leaves the centre at (100, 100): the first low coordinate outside, less the ring."""
    last = events[-1][0]
    n = len(play(events, config).word)
    for low in range(100, 256):
        if len(play([*events, (last + 30, 100, low)], config).word) == n:
            return low - 100 - config.radix_th
    raise AssertionError("no end")


class TestRadius:
    """N_ev is 1, then 2 for updates at an even pace; k = 8 keeps the centre of events at and below 100 where it is."""

    CONFIG = replace(CONFIG, nev_th=1, hist_avg=8, init_radix=10, radix_step=2, radix_max=15, radix_min=7)

    def updates(self, n: int, *places: tuple[int, int]) -> list[Event]:
        """n updates, each by an event at (100, 100) or, for the last of them, at `places`."""
        result: list[Event] = []
        decided = [(100, 100)] * (n - len(places)) + list(places)
        for i, (high, low) in enumerate(decided):
            if i:
                result.append((70 + 60 * i, 100, 100))
            result.append((100 + 60 * i, high, low))
        return result

    def test_the_first_update_leaves_the_initial_radius(self) -> None:
        assert width(self.updates(1, (111, 100)), self.CONFIG) == 10

    @pytest.mark.parametrize("place", [(111, 100), (100, 89), (89, 100)])
    def test_an_event_beyond_g_makes_it_grow(self, place: tuple[int, int]) -> None:
        assert width(self.updates(2, place), self.CONFIG) == 12

    def test_the_far_end_of_the_low_coordinate_never_triggers_growth(self) -> None:
        assert width(self.updates(2, (100, 111)), self.CONFIG) == 10

    def test_an_event_at_g_does_not(self) -> None:
        assert width(self.updates(4, (110, 100), (90, 100), (100, 90)), self.CONFIG) == 10

    def test_it_grows_up_to_radix_max(self) -> None:
        assert width(self.updates(4, (111, 100), (113, 100), (115, 100)), self.CONFIG) == 15
        assert width(self.updates(2, (111, 100)), replace(self.CONFIG, radix_max=4)) == 4  # even where that is less

    def test_the_eighth_quiet_update_makes_it_shrink(self) -> None:
        assert width(self.updates(1 + 7), self.CONFIG) == 10
        assert width(self.updates(1 + 8), self.CONFIG) == 8
        assert width(self.updates(1 + 15), self.CONFIG) == 8
        assert width(self.updates(1 + 16), self.CONFIG) == 7  # radix_min, where a step would undershoot

    def test_growth_starts_the_count_of_quiet_updates_over(self) -> None:
        assert width([*self.updates(8, (111, 100)), *shifted(self.updates(8), 480)[1:]], self.CONFIG) == 12


def shifted(events: list[Event], clocks: int) -> list[Event]:
    """The same events, later."""
    return [(clock + clocks, high, low) for clock, high, low in events]


class TestNev:
    def test_the_first_update_halves_it(self) -> None:
        assert n_evs(play(every(10, 6), CONFIG)) == [4, 2]

    def test_one_becomes_two_at_the_least(self) -> None:
        assert n_evs(play(every(10, 3), replace(CONFIG, nev_th=1))) == [1, 2]
        assert n_evs(play(every(10, 3), replace(CONFIG, nev_th=0))) == [1, 2]

    def test_slower_than_double_halves_and_faster_than_half_doubles(self) -> None:
        # TC2 at updates a < b < c < ...: the differences are a, b, c - a, d - b, ...: between windows two apart.
        story = [*at([0, 10, 20, 100]), *at([110, 180]), *at([190, 200]), *at([290, 300])]
        # TC2 = 105, 185, 205, ...; differences 105 (halves 4 to 2), 185, 100, 115.
        assert n_evs(play(story, CONFIG)) == [4, 2, 2, 2]
        # 105, 405: more than double, 2 becomes 1; then 430 - 105 = 325, 1 becomes 2.
        story = [*at([0, 10, 20, 100]), *at([110, 400]), *at([425]), *at([430, 440])]
        assert n_evs(play(story, CONFIG)) == [4, 2, 1, 2]
        # 1005, 1105, then 1125 - 1005 = 120: less than half, 2 becomes 4.
        story = [*at([0, 10, 20, 1000]), *at([1010, 1100]), *at([1110, 1120]), *every(10, 4, first=1130)]
        assert n_evs(play(story, CONFIG)) == [4, 2, 2, 4]

    def test_128_and_above_becomes_255(self) -> None:
        # 255 halves to 127 at the first update, doubles to 254 where windows get fast, then becomes 255.
        slow = [*every(100, 255), *every(100, 127, first=25_500)]
        fast = every(10, 127 + 254 + 255, first=38_200)
        assert n_evs(play([*slow, *fast], replace(CONFIG, nev_th=255)))[:5] == [255, 127, 127, 254, 255]


@needs_icarus
@pytest.mark.parametrize("seed", range(3))
def test_timers_of_days(tmp_path: Path, seed: int) -> None:
    """TC2 is given other values on the way, since to count to them would take hours: differences above bit 31, and below 0."""
    rng, n = np.random.default_rng([40, seed]), 6_000
    config = replace(CONFIG, nev_th=int(rng.integers(2, 12)), max_time=2**32 - 1)
    inputs = quiet(TRACKER, n)
    inputs["rst"][0] = 1
    inputs["s_req_n"] = np.arange(n) % 12 >= 3
    inputs["m_event_ack_n"] = inputs["m_pass_ack_n"] = 0
    inputs["m_centre_ack_n"] = np.arange(n) % 12 != 8  # the clock after the last in which it may be asked for
    inputs["s_high"] = inputs["s_low"] = 100
    clocks = np.arange(200, n, 60)
    values = rng.integers(0, 2**32, len(clocks)).tolist()
    model, parts, at = PublishedTracker(config), [], 0
    for clock, value in zip([*clocks.tolist(), n], [*values, 0], strict=True):
        parts.append(model.clocks(inputs[at:clock]))
        model._state[TC2], at = value, clock
    expected = np.concatenate(parts)
    registers = {name: int(getattr(config, name)) for name in REGISTERS.keys() - {"enable"}}
    wrapped = np.zeros(n, inputs.dtype)
    wrapped[:] = inputs
    deposits = {clock: {"tc2": value} for clock, value in zip(clocks.tolist(), values, strict=True)}
    found = replay(tmp_path, TRACKER.module, {}, wrapped, TRACKER.read, deposits, ties=registers)
    for clock, (told, row) in enumerate(zip(found, expected, strict=True)):
        if clock:
            for name in ("s_ack_n", "m_event_req_n", "m_centre_req_n", "m_pass_req_n"):
                assert int(told[name], 2) == row[name], (clock, name)
    assert (expected["m_centre_req_n"] == 0).sum() > 40


@pytest.mark.parametrize("seed", range(40))
def test_the_lone_tracker_under_lines_that_keep_no_protocol(seed: int) -> None:
    rng, n = np.random.default_rng([5, seed]), 30_000
    config = some_registers(rng)
    inputs = quiet(TRACKER, n)
    for name in ("s_req_n", "m_pass_ack_n", "m_event_ack_n", "m_centre_ack_n"):
        inputs[name] = noise(rng, n)
    inputs["s_high"], inputs["s_low"] = wandering(rng, n, config.init_cm_high), wandering(rng, n, config.init_cm_low)
    inputs["rst"] = rng.random(n) < rng.choice([0, 1e-3])
    reset_tracker(config)
    equal(rtl(TRACKER, inputs), PublishedTracker(config).clocks(inputs), inputs, seed)

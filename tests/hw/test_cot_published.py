# SPDX-License-Identifier: Apache-2.0
"""cot_published.v and its cascade against the model at every clock, and each oddity of docs/published.md as a story."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.published import (
    CASCADE_INPUT,
    CASCADE_OUTPUT,
    REGISTERS,
    SELECT,
    SELECT_NONE,
    TRACKER_INPUT,
    TRACKER_OUTPUT,
    Handshakes,
    Played,
    PublishedCascade,
    PublishedConfig,
    PublishedTracker,
    decode,
)
from evcot_cosim.build import build
from evcot_cosim.testing import lint

Ports = NDArray[np.void]
Event = tuple[int, int, int]  # clock, high, low

TRACKER, CHAIN = "cot_published", "cot_published_chain"
IO = {TRACKER: (TRACKER_INPUT, TRACKER_OUTPUT), CHAIN: (CASCADE_INPUT, CASCADE_OUTPUT)}

# What is on offer only while its request is low.
OFFERS = {"m_pass_high": "m_pass_req_n", "m_pass_low": "m_pass_req_n"} | dict.fromkeys(
    ("m_event", "m_high", "m_low", "m_word"), "m_req_n"
)

# A window from 91 to 109 around (100, 100), its ends not counted, that never expires; every fourth event moves the centre.
CONFIG = PublishedConfig(
    init_cm_low=100, init_cm_high=100, radix_th=2, init_radix=7, radix_step=1, radix_max=9, radix_min=5,
    nev_th=4, hist_avg=1, max_time=10_000_000,
)  # fmt: skip


@cache
def simulation(top: str) -> PyVerilator:
    """The module, with a loop inside that plays rows of ports."""
    given, told = IO[top]
    sets = "".join(f"top->{name} = in[{offset}];" for name, (_, offset) in (given.fields or {}).items())
    gets = ""
    for name, (kind, offset) in (told.fields or {}).items():
        value = f"top->{OFFERS[name]} ? 0 : top->{name}" if name in OFFERS else f"top->{name}"
        gets += f"{{ uint32_t v = {value}; memcpy(out + {offset}, &v, {kind.itemsize}); }}"
    drive = f"""#include <cstring>
#include "V{top}.h"
extern "C" void evcot_clocks(V{top}* top, int64_t n, const uint8_t* in, uint8_t* out) {{
    for (; n; --n, in += {given.itemsize}, out += {told.itemsize}) {{
        top->clk = 0; {sets} top->eval(); {gets} top->clk = 1; top->eval();
    }}
}}
"""
    return build(top, {}, {"clocks.cpp": drive}).load()


def rtl(top: str, inputs: Ports) -> Ports:
    """What the hardware's ports show just before each edge."""
    sim = simulation(top)
    inputs, outputs = np.ascontiguousarray(inputs), np.zeros(len(inputs), IO[top][1])
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (inputs, outputs))
    sim.lib.evcot_clocks(ctypes.c_void_p(sim.model), ctypes.c_int64(len(inputs)), *pointers)
    return outputs


def quiet(top: str, n: int) -> Ports:
    """n clocks in which nobody requests or acknowledges anything."""
    rows = np.zeros(n, IO[top][0])
    for name in rows.dtype.names or ():
        if name.endswith("_n"):
            rows[name] = 1
    return rows


def equal(found: Ports, expected: Ports, inputs: Ports, seed: object = None) -> None:
    """Names the first clock at which two traces differ."""
    if len(differing := np.flatnonzero(found != expected)):
        at = differing[0]
        raise AssertionError(f"seed {seed}, clock {at}, {inputs[at]}: hardware {found[at]}, model {expected[at]}")


def reset_chain(configs: Sequence[PublishedConfig]) -> None:
    """Resets the hardware and writes its registers, as the model's constructor does."""
    rows = quiet(CHAIN, 1)
    rows["rst"] = 1
    writes = [write for i, config in enumerate(configs) for write in config.writes(i)]
    writes += [(SELECT, SELECT_NONE)] if configs else []
    written = quiet(CHAIN, len(writes) + 1)
    written["cfg_valid"][:-1] = 1
    for row, (address, data) in zip(written, writes, strict=False):
        row["cfg_addr"], row["cfg_data"] = address, data
    rtl(CHAIN, np.concatenate([rows, written] if writes else [rows]))


def play(events: Iterable[Event], *configs: PublishedConfig, **patterns: list[int]) -> Played:
    """Plays a story, clocks counted from when all is ready, to a new cascade; the hardware must do the same at every clock."""
    model = PublishedCascade(configs)
    reset_chain(configs)
    ready = model.clock
    clock, high, low = np.array(list(events), np.int64).reshape(-1, 3).T
    handshakes = Handshakes(**{name: np.array(pattern) for name, pattern in patterns.items()})
    told = model.play(ready + clock, high, low, handshakes, trace=True)
    equal(rtl(CHAIN, told.inputs), told.outputs, told.inputs)
    return told._replace(
        acknowledged=told.acknowledged - ready, word_clock=told.word_clock - ready, pass_clock=told.pass_clock - ready
    )


def at(clocks: Iterable[int], high: int = 100, low: int = 100) -> list[Event]:
    """Events at one place."""
    return [(clock, high, low) for clock in clocks]


def every(gap: int, n: int, high: int = 100, low: int = 100, first: int = 0) -> list[Event]:
    """n events at one place, `gap` clocks apart."""
    return at(range(first, first + n * gap, gap), high, low)


def centres(told: Played) -> list[tuple[int, int]]:
    """(high, low) of every centre that came out."""
    words = decode(told.word)
    return [(int(word["high"]), int(word["low"])) for word in words[~words["event"]]]


def n_evs(told: Played) -> list[int]:
    """How many events each centre took, where nothing was rejected."""
    is_centre = np.flatnonzero(~decode(told.word)["event"])
    return [int(n) for n in np.diff(is_centre, prepend=-1)]


class TestClocks:
    """Counted from the clock whose end first sees the request."""

    def test_a_rejected_event_is_acknowledged_after_1_and_out_after_3(self) -> None:
        told = play([(10, 200, 200), (11, 200, 200)], CONFIG)
        assert told.acknowledged[0] == 10 + 1
        assert told.pass_clock[0] == 10 + 3
        assert told.pass_clock[1] == 10 + 4 + 3  # idle again after 4

    def test_an_event_of_the_cluster_is_out_after_3(self) -> None:
        told = play(at([10, 11]), CONFIG)
        assert told.word_clock.tolist() == [10 + 3, 10 + 4 + 3]

    def test_a_centre_is_out_after_7_and_idle_comes_after_8(self) -> None:
        told = play(at([10, 11]), replace(CONFIG, nev_th=1))
        assert told.word_clock.tolist() == [10 + 7, 10 + 8 + 3]

    @pytest.mark.parametrize(("tracker", "clocks"), [(0, 7), (1, 10), (2, 13), (3, 16)])
    def test_a_centre_of_the_cascade(self, tracker: int, clocks: int) -> None:
        elsewhere, here = replace(CONFIG, init_cm_low=200), replace(CONFIG, nev_th=1)
        told = play(at([10]), *[here if i == tracker else elsewhere for i in range(4)])
        assert told.word_clock.tolist() == [10 + clocks]
        assert told.word.tolist() == [tracker << 17 | 100 << 9 | 100 << 1]

    def test_rejected_by_all_after_12(self) -> None:
        told = play([(10, 5, 6)], CONFIG, CONFIG, CONFIG, CONFIG)
        assert told.pass_clock.tolist() == [10 + 12]
        assert (told.pass_high[0], told.pass_low[0]) == (5, 6)


class TestHandshakes:
    def test_the_acknowledge_stays_until_the_request_goes_and_the_event_is_taken_once(self) -> None:
        told = play(at([10, 30]), CONFIG, release=[12, 0])
        assert told.outputs["s_ack_n"][10:30].tolist() == [1] + [0] * 13 + [1] * 6
        assert told.word_clock.tolist() == [13, 33]

    def test_an_output_waits_for_its_acknowledge_and_the_tracker_with_it(self) -> None:
        told = play([(10, 200, 200), (10, 100, 100)], CONFIG, pass_ack=[9])
        assert told.pass_clock.tolist() == [10 + 3 + 9]
        assert told.acknowledged[1] == 10 + 3 + 9 + 1 + 1

    def test_an_acknowledge_that_is_still_low_takes_the_next_offer(self) -> None:
        inputs = quiet(TRACKER, 13)
        inputs["s_req_n"][[3, 4, 7, 8]] = 0
        inputs["m_pass_ack_n"][5:] = 0
        reset_tracker(CONFIG)
        outputs = rtl(TRACKER, inputs)
        equal(outputs, PublishedTracker(CONFIG).clocks(inputs), inputs)
        assert np.flatnonzero(outputs["m_pass_req_n"] == 0).tolist() == [6, 10]

    def test_two_words_at_once_leave_one_after_the_other_with_the_line_released_between(self) -> None:
        # The first word waits 20 clocks; meanwhile tracker 0 rejects nothing, so tracker 1 gets its event from a third place.
        other = replace(CONFIG, init_cm_low=200)
        told = play([(0, 100, 200), (1, 100, 100)], CONFIG, other, ack=[20])
        assert told.word.tolist() == [0x11 << 17 | 100 << 9 | 200 << 1 | 1, 0x10 << 17 | 100 << 9 | 100 << 1 | 1]
        requests = np.flatnonzero(np.diff(told.outputs["m_req_n"].astype(int)) == -1)
        releases = np.flatnonzero(np.diff(told.outputs["m_req_n"].astype(int)) == 1)
        assert len(requests) == len(releases) == 2
        assert requests[1] - releases[0] == 1


class TestLostEvents:
    def test_an_event_that_meets_the_initialisation_is_acknowledged_and_lost(self) -> None:
        inputs = quiet(TRACKER, 11)
        inputs["s_req_n"][0:3] = 0  # InitCell is clock 0
        inputs["s_req_n"][5:7] = 0
        inputs["s_high"] = inputs["s_low"] = 100
        inputs["m_ack_n"] = 0
        reset_tracker(CONFIG)
        outputs = rtl(TRACKER, inputs)
        equal(outputs, PublishedTracker(CONFIG).clocks(inputs), inputs)
        assert outputs["s_ack_n"].tolist() == [0, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1]
        assert np.flatnonzero(outputs["m_req_n"] == 0).tolist() == [8]

    def test_an_expired_cell_initialises_first_and_the_event_that_waits_is_lost(self) -> None:
        # TC is 0 at clock -1, which is InitCell, and so 50 at clock 49.
        kept = play(at([48]), replace(CONFIG, max_time=50))
        lost = play(at([49]), replace(CONFIG, max_time=50))
        late = play(at([51]), replace(CONFIG, max_time=50))
        assert [len(told.word) for told in (kept, lost, late)] == [1, 0, 1]
        assert lost.acknowledged.tolist() == [50]

    def test_a_tracker_that_initialises_loses_what_the_one_before_it_passes(self) -> None:
        # Tracker 0 passes at clock t + 3; tracker 1 would see it at the end of that clock.
        second = replace(CONFIG, init_cm_low=200, max_time=50)
        lost = [clock for clock in range(30, 60) if not len(play([(clock, 100, 200)], CONFIG, second).word)]
        assert lost == [46, 47]


class TestTime:
    def test_only_a_centre_update_clears_tc(self) -> None:
        # An event of the cluster every 10 clocks, and still the cell expires, at clock 199: the count starts over at 200.
        told = play(every(10, 24), replace(CONFIG, nev_th=22, max_time=200))
        assert n_evs(told) == []
        told = play(every(10, 24), replace(CONFIG, nev_th=19, max_time=200))
        assert n_evs(told) == [19]

    def test_a_centre_update_clears_it(self) -> None:
        # Updates at the 4th, 6th and 8th event: TC never gets to 60.
        assert len(centres(play(every(10, 8), replace(CONFIG, max_time=60)))) == 3

    def test_a_tracker_that_is_busy_at_that_clock_does_not_expire(self) -> None:
        config = replace(CONFIG, init_cm_low=100, nev_th=3, max_time=50)
        for clock in (46, 47, 48):  # busy at clock 49
            assert n_evs(play(at([10, clock, 80]), config)) == [3]
        assert n_evs(play(at([10, 40, 80]), config)) == []

    def test_it_expires_once_and_not_again_before_the_next_centre(self) -> None:
        config = replace(CONFIG, nev_th=3, max_time=50)
        assert n_evs(play(at([10, 20, 80, 500, 900]), config)) == [3 + 2]

    def test_a_new_life_starts_at_the_initial_centre_with_the_initial_n(self) -> None:
        config = replace(CONFIG, nev_th=2, max_time=2000)
        first = [*every(10, 6, 104, 96)]
        told = play([*first, *every(10, 2, 100, 100, first=4000)], config)
        assert centres(told)[0] == (101, 99)
        assert centres(told)[-1] == (100, 100)


class TestWindow:
    def test_its_ends_do_not_count(self) -> None:
        config = replace(CONFIG, nev_th=200)
        inside = [(92, 92), (108, 108), (92, 108), (108, 92), (100, 100)]
        outside = [(91, 100), (109, 100), (100, 91), (100, 109), (92, 109), (91, 92)]
        told = play([(20 * i, *place) for i, place in enumerate(inside + outside)], config)
        assert len(told.word) == len(inside)
        assert list(zip(told.pass_high.tolist(), told.pass_low.tolist(), strict=True)) == outside

    @pytest.mark.parametrize("edge", [0, 255])
    def test_the_first_and_the_last_address_are_never_inside(self, edge: int) -> None:
        near = 1 if edge == 0 else 254
        config = replace(CONFIG, init_cm_low=edge, init_cm_high=edge, init_radix=255, radix_th=7, nev_th=200)
        told = play([(0, near, near), (20, edge, near), (40, near, edge)], config)
        assert len(told.word) == 1
        assert len(told.pass_clock) == 2


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
        told: list[Event] = []
        decided = [(100, 100)] * (n - len(places)) + list(places)
        for i, (high, low) in enumerate(decided):
            if i:
                told.append((70 + 60 * i, 100, 100))
            told.append((100 + 60 * i, high, low))
        return told

    def test_the_first_update_leaves_the_initial_radius(self) -> None:
        assert width(self.updates(1, (100, 111)), self.CONFIG) == 10

    @pytest.mark.parametrize("place", [(100, 111), (100, 89), (89, 100)])
    def test_an_event_beyond_g_makes_it_grow(self, place: tuple[int, int]) -> None:
        assert width(self.updates(2, place), self.CONFIG) == 12

    def test_the_top_edge_never_triggers_growth(self) -> None:
        assert width(self.updates(2, (111, 100)), self.CONFIG) == 10

    def test_an_event_at_g_does_not(self) -> None:
        assert width(self.updates(4, (100, 110), (90, 100), (100, 90)), self.CONFIG) == 10

    def test_it_grows_up_to_radix_max(self) -> None:
        assert width(self.updates(4, (100, 111), (100, 113), (100, 115)), self.CONFIG) == 15
        assert width(self.updates(2, (100, 111)), replace(self.CONFIG, radix_max=4)) == 4  # even where that is less

    def test_the_eighth_quiet_update_makes_it_shrink(self) -> None:
        assert width(self.updates(1 + 7), self.CONFIG) == 10
        assert width(self.updates(1 + 8), self.CONFIG) == 8
        assert width(self.updates(1 + 15), self.CONFIG) == 8
        assert width(self.updates(1 + 16), self.CONFIG) == 7  # radix_min, where a step would undershoot

    def test_growth_starts_the_count_of_quiet_updates_over(self) -> None:
        assert width([*self.updates(8, (100, 111)), *shifted(self.updates(8), 480)[1:]], self.CONFIG) == 12


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


class TestCascade:
    def test_priority_alone_decides(self) -> None:
        told = play(at([0]), CONFIG, CONFIG, CONFIG, CONFIG)
        assert decode(told.word)["tracker"].tolist() == [0]

    def test_tags_of_events_and_centres(self) -> None:
        for tracker in range(4):
            configs = [replace(CONFIG, init_cm_high=10 + 60 * i, nev_th=2) for i in range(4)]
            told = play([(0, 10 + 60 * tracker, 101), (30, 10 + 60 * tracker, 101)], *configs)
            place = (10 + 60 * tracker) << 9
            assert told.word.tolist() == [(0x10 + tracker) << 17 | place | 101 << 1 | 1, tracker << 17 | place | 100 << 1]

    def test_a_disabled_tracker_passes_everything_through_at_once(self) -> None:
        off = replace(CONFIG, enable=False)
        told = play(at([10]), off, off, CONFIG)
        assert decode(told.word)["tracker"].tolist() == [2]
        assert told.word_clock.tolist() == [13]
        told = play(at([10]), off, off, off, off)
        assert told.pass_clock.tolist() == [10]

    def test_without_registers_everything_passes(self) -> None:
        assert len(play(at([10])).pass_clock) == 1


def reset_tracker(config: PublishedConfig) -> None:
    """Sets the register ports of the lone tracker and resets it."""
    for name in REGISTERS.keys() - {"enable"}:
        simulation(TRACKER).io[name] = int(getattr(config, name))
    rows = quiet(TRACKER, 1)
    rows["rst"] = 1
    rtl(TRACKER, rows)


def some_registers(rng: np.random.Generator) -> PublishedConfig:
    """Anything legal, the ends of ranges often; small numbers often, so that much happens."""

    def value(top: int) -> int:
        return int(rng.choice([0, 1, top, rng.integers(top + 1), min(top, rng.integers(24))]))

    return PublishedConfig(
        init_cm_low=value(255), init_cm_high=value(255), radix_th=value(7), init_radix=value(255), radix_step=value(7),
        radix_max=value(255), radix_min=value(255), nev_th=value(255), hist_avg=int(rng.integers(1, 9)),
        max_time=int(rng.choice([rng.integers(2000), rng.integers(1 << 32), 2**32 - 1, 10_000_000])),
        enable=bool(rng.random() < 0.8),
    )  # fmt: skip


def wandering(rng: np.random.Generator, n: int, start: int) -> NDArray[np.int64]:
    """A coordinate around a place that wanders, or jumps."""
    steps = rng.integers(-1, 2, n) + (rng.random(n) < 0.01) * rng.integers(-40, 41, n)
    return np.clip(start + np.cumsum(steps) + rng.integers(-12, 13, n), 0, 255)


def noise(rng: np.random.Generator, n: int) -> NDArray[np.uint8]:
    """A line that changes now and then, whatever the protocol says."""
    return (np.cumsum(rng.random(n) < rng.choice([0.05, 0.3, 0.7])) & 1).astype(np.uint8)


class TestLockStep:
    @pytest.mark.parametrize("seed", range(40))
    def test_the_lone_tracker_under_lines_that_keep_no_protocol(self, seed: int) -> None:
        rng, n = np.random.default_rng([5, seed]), 30_000
        config = some_registers(rng)
        inputs = quiet(TRACKER, n)
        for name in ("s_req_n", "m_pass_ack_n", "m_ack_n"):
            inputs[name] = noise(rng, n)
        inputs["s_high"], inputs["s_low"] = wandering(rng, n, config.init_cm_high), wandering(rng, n, config.init_cm_low)
        inputs["rst"] = rng.random(n) < rng.choice([0, 1e-3])
        reset_tracker(config)
        equal(rtl(TRACKER, inputs), PublishedTracker(config).clocks(inputs), inputs, seed)

    @pytest.mark.parametrize("seed", range(20))
    def test_the_cascade_under_lines_that_keep_no_protocol(self, seed: int) -> None:
        rng, n = np.random.default_rng([6, seed]), 40_000
        configs = [some_registers(rng) for _ in range(4)]
        model = PublishedCascade(configs)
        reset_chain(configs)
        inputs = quiet(CHAIN, n)
        for name in ("s_req_n", "m_pass_ack_n", "m_ack_n"):
            inputs[name] = noise(rng, n)
        inputs["s_high"] = wandering(rng, n, configs[seed % 4].init_cm_high)
        inputs["s_low"] = wandering(rng, n, configs[seed % 4].init_cm_low)
        inputs["rst"] = rng.random(n) < rng.choice([0, 1e-4])
        # Registers written at any time: somewhere near their addresses, or at the selection.
        inputs["cfg_valid"] = rng.random(n) < 0.02
        inputs["cfg_addr"] = np.where(rng.random(n) < 0.3, SELECT, rng.integers(76, 94, n))
        inputs["cfg_data"] = np.where(inputs["cfg_addr"] == SELECT, rng.integers(0, 8, n), rng.integers(0, 256, n))
        equal(rtl(CHAIN, inputs), model.clocks(inputs), inputs, seed)

    @pytest.mark.parametrize("seed", range(20))
    def test_the_cascade_between_partners_of_any_speed(self, seed: int) -> None:
        rng, n = np.random.default_rng([7, seed]), 4_000
        spread = 10 if seed % 2 else 60
        centre = rng.integers(40, 216, (4, 2))
        configs = [
            replace(some_registers(rng), init_cm_high=int(high), init_cm_low=int(low), init_radix=int(rng.integers(5, 30)))
            for high, low in centre
        ]
        which = rng.integers(4, size=n)
        high, low = np.clip(centre[which].T + rng.integers(-spread, spread + 1, (2, n)), 0, 255)
        clock = np.cumsum(rng.integers(rng.choice([2, 20, 60]), size=n))
        slow = rng.choice([1, 4, 12], 3)
        told = play(
            zip(clock.tolist(), high.tolist(), low.tolist(), strict=True),
            *configs,
            release=rng.integers(0, slow[0], 97).tolist(),
            ack=rng.integers(0, slow[1], 101).tolist(),
            pass_ack=rng.integers(0, slow[2], 103).tolist(),
        )
        print(f"seed {seed}: {len(told.word)} words, {len(centres(told))} of them centres, {len(told.pass_clock)} passed")
        assert len(told.word) + len(told.pass_clock) <= n


class TestRegisters:
    def write(self, inputs: Sequence[tuple[int, int]]) -> None:
        rows = quiet(CHAIN, len(inputs))
        rows["cfg_valid"] = 1
        for row, (address, data) in zip(rows, inputs, strict=True):
            row["cfg_addr"], row["cfg_data"] = address, data
        rtl(CHAIN, rows)

    def test_a_selected_tracker_is_held_in_reset_and_swallows_events(self) -> None:
        reset_chain([CONFIG])
        self.write([(SELECT, 0)])
        inputs = quiet(CHAIN, 8)
        inputs["s_req_n"][2:5] = 0
        assert rtl(CHAIN, inputs)["s_ack_n"].tolist() == [1] + [0] * 7
        self.write([(SELECT, SELECT_NONE)])
        rtl(CHAIN, quiet(CHAIN, 2))
        inputs["s_high"] = inputs["s_low"] = 100
        outputs = rtl(CHAIN, inputs)
        assert outputs["s_ack_n"].tolist() == [1, 1, 1, 0, 0, 1, 1, 1]
        assert np.flatnonzero(outputs["m_req_n"] == 0)[0] == 5

    def test_defaults(self) -> None:
        # Enabled, and nothing else written: centre (0, 0), R = 67, N_ev = 15.
        reset_chain([])
        self.write([(SELECT, 2), (REGISTERS["enable"][0], 255), (SELECT, SELECT_NONE)])
        model = PublishedCascade()
        model.write([(SELECT, 2), (REGISTERS["enable"][0], 255), (SELECT, SELECT_NONE)])
        rtl(CHAIN, quiet(CHAIN, 1))
        model.clocks(quiet(CHAIN, 1))
        places = [(66, 66), (67, 1), (1, 67), *[(1, 1)] * 20]
        clock = model.clock + 20 * np.arange(len(places))
        told = model.play(clock, *np.array(places).T, trace=True)
        equal(rtl(CHAIN, told.inputs), told.outputs, told.inputs)
        assert len(told.pass_clock) == 2
        assert decode(told.word)["tracker"].tolist() == [2] * 21
        assert n_evs(told)[0] == 15

    @pytest.mark.parametrize("name", REGISTERS)
    def test_each_has_its_address_and_width(self, name: str) -> None:
        """All ones written there, seen by its effect: a random run is the model's and not that of the register's default."""
        top = {"radix_th": 7, "radix_step": 7, "hist_avg": 15, "max_time": 255, "enable": 255}.get(name, 255)
        address, n_bytes = REGISTERS[name]
        writes = [*CONFIG.writes(1), *[(address + i, top if i == 0 else 0) for i in range(n_bytes)], (SELECT, SELECT_NONE)]
        if name == "enable":
            writes[-2] = (address, 0)
        rng = np.random.default_rng(8)
        n = 4000
        events = np.cumsum(rng.integers(10, 30, n)), rng.integers(90, 111, n), rng.integers(90, 111, n)
        runs = []
        for story in (writes, [*CONFIG.writes(1), (SELECT, SELECT_NONE)]):
            reset_chain([])
            self.write(story)
            model = PublishedCascade()
            model.write(story)
            told = model.play(model.clock + events[0], *events[1:], trace=True)
            equal(rtl(CHAIN, told.inputs), told.outputs, told.inputs)
            runs.append(told.word.tolist())
        assert runs[0] != runs[1]


class TestStyle:
    @pytest.mark.parametrize("top", [TRACKER, CHAIN, "aer_merge"])
    def test_lint(self, top: str) -> None:
        assert lint(top) == (0, "")

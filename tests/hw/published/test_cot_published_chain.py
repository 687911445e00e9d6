# SPDX-License-Identifier: Apache-2.0
"""cot_published_chain.v against the model at every clock: arbitration, registers, tags, and back-pressure between trackers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.published.model import REGISTERS, SELECT, SELECT_NONE, PublishedCascade, PublishedConfig, decode
from evcot_cosim.devices.published_device import CASCADE, LIBRARY, Top, at, equal, play, quiet, reset_cascade, rtl, simulation
from support.four_state import needs_icarus, replay
from support.published import CONFIG, centres, n_evs, noise, some_registers, wandering

TOPS = pytest.mark.parametrize("top", [CASCADE, LIBRARY], ids=["cascade", "library"])


class TestClocks:
    """Counted from the clock whose end first sees the request."""

    @pytest.mark.parametrize(("top", "event", "centre"), [(CASCADE, 6, 8), (LIBRARY, 8, 14)], ids=["cascade", "library"])
    @pytest.mark.parametrize("tracker", range(4))
    def test_a_centre_and_the_event_that_moves_it(self, top: Top, event: int, centre: int, tracker: int) -> None:
        elsewhere, here = replace(CONFIG, init_cm_low=200), replace(CONFIG, nev_th=1)
        result = play(at([10]), *[here if i == tracker else elsewhere for i in range(4)], top=top)
        assert result.word_clock.tolist() == [10 + 3 * tracker + clocks for clocks in (event, centre)]
        assert result.word.tolist() == [(0x10 | tracker) << 17 | 100 << 9 | 100 << 1 | 1, tracker << 17 | 100 << 9 | 100 << 1]

    @pytest.mark.parametrize(("top", "clocks"), [(CASCADE, 3), (LIBRARY, 5)], ids=["cascade", "library"])
    def test_an_event_of_a_cluster(self, top: Top, clocks: int) -> None:
        assert play(at([10]), CONFIG, top=top).word_clock.tolist() == [10 + clocks]

    @TOPS
    def test_rejected_by_all_after_12(self, top: Top) -> None:
        result = play([(10, 5, 6)], CONFIG, CONFIG, CONFIG, CONFIG, top=top)
        assert result.pass_clock.tolist() == [10 + 12]
        assert (result.pass_high[0], result.pass_low[0]) == (5, 6)


class TestLibraryLine:
    def test_the_average_takes_every_event_five_times(self) -> None:
        # One event at 94, then the second makes a centre: 97, 95, 94, 94, 94 on its line, 97 on the other.
        story, config = [(0, 94, 100), (50, 94, 100)], replace(CONFIG, nev_th=2)
        assert centres(play(story, config)) == [(98, 100)]
        assert centres(play(story, config, top=LIBRARY)) == [(97, 100)]
        slowly = replace(config, hist_avg=4)  # 99, 98, 97, 96, 95: each step floors
        assert centres(play([(0, 80, 100), (50, 80, 100)], replace(slowly, init_radix=30), top=LIBRARY)) == [(99, 100)]

    def test_it_takes_it_more_often_the_longer_the_receiver_waits(self) -> None:
        story, config = [(0, 60, 100), (90, 60, 100)], replace(CONFIG, nev_th=2, hist_avg=2, init_radix=60)
        found = [centres(play(story, config, top=LIBRARY, ack=[wait, 0]))[0][0] for wait in (0, 5, 20)]
        assert found == [92, 90, 90]

    def test_a_waiting_event_gives_way_to_the_word_of_a_tracker_before(self) -> None:
        other = replace(CONFIG, init_cm_low=200)
        result = play([(0, 100, 200), (1, 100, 100)], CONFIG, other, ack=[30], top=LIBRARY)
        assert decode(result.word)["tracker"].tolist() == [0, 1]
        result = play([(0, 100, 200), (1, 100, 100)], CONFIG, other, ack=[30])
        assert decode(result.word)["tracker"].tolist() == [1, 0]


def driven(*configs: PublishedConfig, n: int, asked: dict[range, tuple[int, int]], acked: Sequence[range]) -> NDArray[np.void]:
    """The library's outputs in n clocks: events requested in these ranges of clocks, words acknowledged in those."""
    inputs = quiet(LIBRARY, n)
    for clocks, place in asked.items():
        inputs["s_req_n"][clocks] = 0
        for row in inputs[clocks.start :]:
            row["s_high"], row["s_low"] = place
    for clocks in acked:
        inputs["m_ack_n"][clocks] = 0
    reset_cascade(LIBRARY, configs)
    outputs = rtl(LIBRARY, inputs)
    equal(outputs, PublishedCascade(configs).clocks(inputs), inputs)
    return outputs


def low(line: NDArray[np.uint8]) -> list[int]:
    """The clocks in which a line is low."""
    return np.flatnonzero(line == 0).tolist()


def event_word(tracker: int, high: int, low: int) -> int:
    return (0x10 | tracker) << 17 | high << 9 | low << 1 | 1


class TestReceiversOfTheLibrary:
    """Worked out by hand. An event requested in clock t is in EvNoProc from t + 3 on, its word on the line from t + 5 on."""

    def test_a_word_is_replaced_in_the_clock_of_its_acknowledge_and_sent_again(self) -> None:
        other = replace(CONFIG, init_cm_low=200)
        # Tracker 1 asks from clock 6 on, tracker 0 from 12 on, which is the clock of the acknowledge.
        out = driven(
            CONFIG, other, n=28, asked={range(2): (100, 200), range(9, 11): (100, 100)}, acked=[range(12, 14), range(20, 22)]
        )
        second, first = event_word(1, 100, 200), event_word(0, 100, 100)
        assert low(out["m_req_n"]) == [8, 9, 10, 11, 12, 13, 18, 19, 20, 21]
        assert out["m_word"][8:14].tolist() == [second] * 5 + [first]
        assert out["m_word"][18:22].tolist() == [second] * 4
        # Tracker 0 is acknowledged in clock 14, after 3 clocks in EvNoProc.
        assert low(out["s_ack_n"]) == [1, 2, 3, 4, 10, 11, 12, 13, 14]

    def test_the_request_lasts_a_clock_beyond_that_of_the_acknowledge_and_the_idle_word_is_all_ones(self) -> None:
        out = driven(CONFIG, n=16, asked={range(2): (94, 100)}, acked=[range(7, 9)])
        assert low(out["m_req_n"]) == [5, 6, 7, 8]
        idle = 2**25 - 1
        # The line is idle from clock 11 on; its word is a register.
        assert out["m_word"].tolist() == [idle] * 5 + [event_word(0, 94, 100)] * 7 + [idle] * 4

    def test_after_a_stale_acknowledge_an_event_takes_2_clocks_and_2_updates_of_the_average(self) -> None:
        # The receiver holds its acknowledge from clock 5 to 39: the second event has no word.
        story = {range(2): (94, 100), range(20, 22): (106, 100), range(60, 62): (100, 100)}
        out = driven(replace(CONFIG, nev_th=3), n=90, asked=story, acked=[range(5, 40), range(68, 70), range(74, 76)])
        assert [clock for clock in low(out["s_ack_n"]) if clock < 60] == [1, 2, 3, 4, 5, 6, 7, 21, 22, 23, 24]
        # The average: 97, 95, 94, 94, 94, then 100, 103; the centre moves from 100 to floor(203 / 2).
        words = [int(out["m_word"][clock]) for clock in (5, 68, 74)]
        assert words == [event_word(0, 94, 100), event_word(0, 100, 100), 101 << 9 | 100 << 1]
        assert low(out["m_req_n"]) == [5, 6, 68, 69, 74, 75]

    def test_after_a_stale_acknowledge_the_nth_event_takes_2_clocks_as_well(self) -> None:
        story = {range(2): (94, 100), range(20, 22): (94, 100)}
        out = driven(replace(CONFIG, nev_th=2), n=60, asked=story, acked=[range(5, 40), range(43, 45)])
        # Idle, ReqReceived, EvDiscri, EvProc, timing, N, twice centre; then the centre waits for the line, free from 41 on.
        assert low(out["s_ack_n"]) == [1, 2, 3, 4, 5, 6, 7, *range(21, 28)]
        assert low(out["m_req_n"]) == [5, 6, 43, 44]
        assert int(out["m_word"][43]) == 97 << 9 | 100 << 1

    def test_an_acknowledge_from_before_the_word_makes_an_event_a_clock_shorter(self) -> None:
        out = driven(CONFIG, n=20, asked={range(2): (94, 100)}, acked=[range(2, 8)])
        assert low(out["m_req_n"]) == [5]
        assert low(out["s_ack_n"]) == [1, 2, 3, 4, 5, 6]

    def test_a_receiver_that_ties_its_acknowledge_gets_one_word_and_its_tracker_goes_on(self) -> None:
        story = {range(clock, clock + 2): (100, 100) for clock in (0, 20, 40)}
        out = driven(CONFIG, n=60, asked=story, acked=[range(60)])
        assert low(out["m_req_n"]) == [5]
        assert low(out["s_ack_n"]) == [*range(1, 7), *range(21, 25), *range(41, 45)]


class TestCascade:
    def test_priority_alone_decides(self) -> None:
        result = play(at([0]), CONFIG, CONFIG, CONFIG, CONFIG)
        assert decode(result.word)["tracker"].tolist() == [0]

    @TOPS
    def test_tags_of_events_and_centres(self, top: Top) -> None:
        for tracker in range(4):
            configs = [replace(CONFIG, init_cm_high=10 + 60 * i, nev_th=2) for i in range(4)]
            result = play([(0, 10 + 60 * tracker, 101), (40, 10 + 60 * tracker, 101)], *configs, top=top)
            place = (10 + 60 * tracker) << 9
            event = (0x10 + tracker) << 17 | place | 101 << 1 | 1
            assert result.word.tolist() == [event, event, tracker << 17 | place | 100 << 1]

    @TOPS
    def test_a_disabled_tracker_passes_everything_through_at_once(self, top: Top) -> None:
        off = replace(CONFIG, enable=False)
        result = play(at([10]), off, off, CONFIG, top=top)
        assert decode(result.word)["tracker"].tolist() == [2]
        assert result.word_clock.tolist() == [13 if top is CASCADE else 15]
        result = play(at([10]), off, off, off, off, top=top)
        assert result.pass_clock.tolist() == [10]

    def test_without_registers_everything_passes(self) -> None:
        assert len(play(at([10])).pass_clock) == 1

    def test_two_words_at_once_leave_one_after_the_other_with_the_line_released_between(self) -> None:
        # The first word waits 20 clocks; meanwhile tracker 0 has an event from a third place.
        other = replace(CONFIG, init_cm_low=200)
        result = play([(0, 100, 200), (1, 100, 100)], CONFIG, other, ack=[20])
        assert result.word.tolist() == [0x11 << 17 | 100 << 9 | 200 << 1 | 1, 0x10 << 17 | 100 << 9 | 100 << 1 | 1]
        requests = np.flatnonzero(np.diff(result.outputs["m_req_n"].astype(int)) == -1)
        releases = np.flatnonzero(np.diff(result.outputs["m_req_n"].astype(int)) == 1)
        assert len(requests) == len(releases) == 2
        assert requests[1] - releases[0] == 1

    def test_a_tracker_that_initialises_loses_what_the_one_before_it_passes(self) -> None:
        # Tracker 0 passes at clock t + 3; tracker 1 would see it at the end of that clock.
        second = replace(CONFIG, init_cm_low=200, max_time=50)
        lost = [clock for clock in range(30, 60) if not len(play([(clock, 100, 200)], CONFIG, second).word)]
        assert lost == [47, 48]

    def test_a_tracker_that_is_busy_acknowledges_what_the_one_before_it_passes_and_it_is_lost(self) -> None:
        second = replace(CONFIG, init_cm_low=200)
        story = [(0, 100, 200), (1, 100, 201), (60, 100, 202)]
        assert decode(play(story, CONFIG, second, ack=[20, 0]).word)["low"].tolist() == [200, 202]
        assert decode(play(story, CONFIG, second).word)["low"].tolist() == [200, 201, 202]


class TestRegisters:
    def write(self, inputs: Sequence[tuple[int, int]]) -> None:
        rows = quiet(CASCADE, len(inputs))
        rows["cfg_valid"] = 1
        for row, (address, data) in zip(rows, inputs, strict=True):
            row["cfg_addr"], row["cfg_data"] = address, data
        rtl(CASCADE, rows)

    def test_a_selected_tracker_is_held_in_reset_and_swallows_events(self) -> None:
        reset_cascade(CASCADE, [CONFIG])
        self.write([(SELECT, 1)])
        inputs = quiet(CASCADE, 8)
        inputs["s_req_n"][2:5] = 0
        assert rtl(CASCADE, inputs)["s_ack_n"].tolist() == [1] + [0] * 7
        self.write([(SELECT, SELECT_NONE)])
        rtl(CASCADE, quiet(CASCADE, 2))
        inputs["s_high"] = inputs["s_low"] = 100
        outputs = rtl(CASCADE, inputs)
        assert outputs["s_ack_n"].tolist() == [1, 1, 1, 0, 0, 0, 0, 0]  # the event has no receiver
        assert np.flatnonzero(outputs["m_req_n"] == 0)[0] == 5

    @pytest.mark.parametrize(("tracker", "low"), [(0, 59), (1, 79), (2, 102), (3, 5)])
    def test_defaults(self, tracker: int, low: int) -> None:
        # Enabled, and nothing else written: centre (80, low), R = 67, N_ev = 15.
        writes = [(SELECT, tracker + 1), (REGISTERS["enable"][0], 255), (SELECT, SELECT_NONE)]
        reset_cascade(CASCADE, [])
        self.write(writes)
        model = PublishedCascade(library_line=False)
        model.write(writes)
        rtl(CASCADE, quiet(CASCADE, 1))
        model.clocks(quiet(CASCADE, 1))
        places = [(146, low), (147, low), (80, low + 66), (80, low + 67), *[(80, low)] * 20]
        clock = model.clock + 20 * np.arange(len(places))
        result = model.play(clock, *np.array(places).T, trace=True)
        equal(rtl(CASCADE, result.inputs), result.outputs, result.inputs)
        assert list(zip(result.pass_high.tolist(), result.pass_low.tolist(), strict=True)) == [(147, low), (80, low + 67)]
        assert set(decode(result.word)["tracker"].tolist()) == {tracker}
        assert n_evs(result)[0] == 15

    @pytest.mark.parametrize(
        ("writes", "on"), [([255], 1), ([1], 0), ([254], 0), ([255, 1], 1), ([255, 254], 1), ([255, 0], 0)]
    )
    def test_enable_knows_two_values(self, writes: list[int], on: int) -> None:
        reset_cascade(CASCADE, [])
        self.write([(SELECT, 2), *[(REGISTERS["enable"][0], value) for value in writes], (SELECT, SELECT_NONE)])
        assert rtl(CASCADE, self.request(80, 79))["m_pass_req_n"][4] == on  # without a tracker, wires

    @pytest.mark.parametrize("none", [0, 5, 127, 255])
    def test_any_other_number_selects_none(self, none: int) -> None:
        reset_cascade(CASCADE, [replace(CONFIG, enable=False)])
        self.write([(SELECT, 1), (REGISTERS["enable"][0], 255), (SELECT, none), (REGISTERS["enable"][0], 0)])
        rtl(CASCADE, quiet(CASCADE, 1))
        assert rtl(CASCADE, self.request(100, 100))["s_ack_n"].tolist() == [1, 1, 1, 1, 0, 0, 0, 0]

    @pytest.mark.parametrize(("written", "k"), [(0, 1), (1, 1), (8, 8), (9, 8), (16, 8), (255, 8)])
    def test_hist_avg_is_clamped(self, written: int, k: int) -> None:
        story = [*at([0, 20], 160), (40, 160, 100)]
        config = replace(CONFIG, init_radix=100, nev_th=3, hist_avg=k)
        expected = play(story, config)
        writes = [*config.writes(0), (SELECT, 1), (REGISTERS["hist_avg"][0], written), (SELECT, SELECT_NONE)]
        reset_cascade(CASCADE, [])
        self.write(writes)
        model = PublishedCascade(library_line=False)
        model.write(writes)
        model.clocks(quiet(CASCADE, 1))
        rtl(CASCADE, quiet(CASCADE, 1))
        clock, high, low = np.array(story).T
        result = model.play(model.clock + clock, high, low, trace=True)
        equal(rtl(CASCADE, result.inputs), result.outputs, result.inputs)
        assert result.word.tolist() == expected.word.tolist()

    def request(self, high: int, low: int) -> NDArray[np.void]:
        """Eight clocks with a request from the fourth on."""
        inputs = quiet(CASCADE, 8)
        inputs["s_req_n"][3:] = 0
        inputs["s_high"], inputs["s_low"] = high, low
        return inputs

    @pytest.mark.parametrize("name", REGISTERS)
    def test_each_has_its_address_and_width(self, name: str) -> None:
        """All ones written there, seen by its effect: a random run is the model's and not that of the register's default."""
        top = {"radix_th": 7, "radix_step": 7}.get(name, 255)
        address, n_bytes = REGISTERS[name]
        writes = [*CONFIG.writes(1), *[(address + i, top if i == 0 else 0) for i in range(n_bytes)], (SELECT, SELECT_NONE)]
        if name == "enable":
            writes[-2] = (address, 0)
        rng = np.random.default_rng(8)
        n = 4000
        events = np.cumsum(rng.integers(10, 30, n)), rng.integers(90, 111, n), rng.integers(90, 111, n)
        runs = []
        for story in (writes, [*CONFIG.writes(1), (SELECT, SELECT_NONE)]):
            reset_cascade(CASCADE, [])
            self.write(story)
            model = PublishedCascade(library_line=False)
            model.write(story)
            result = model.play(model.clock + events[0], *events[1:], trace=True)
            equal(rtl(CASCADE, result.inputs), result.outputs, result.inputs)
            runs.append(result.word.tolist())
        assert runs[0] != runs[1]


class TestLockStep:
    @TOPS
    @pytest.mark.parametrize("seed", range(20))
    def test_the_cascade_under_lines_that_keep_no_protocol(self, seed: int, top: Top) -> None:
        rng, n = np.random.default_rng([6, seed]), 40_000
        configs = [some_registers(rng) for _ in range(4)]
        model = PublishedCascade(configs, library_line=top is LIBRARY)
        reset_cascade(top, configs)
        inputs = quiet(top, n)
        for name in ("s_req_n", "m_pass_ack_n", "m_ack_n"):
            inputs[name] = noise(rng, n)
        inputs["s_high"] = wandering(rng, n, configs[seed % 4].init_cm_high)
        inputs["s_low"] = wandering(rng, n, configs[seed % 4].init_cm_low)
        inputs["rst"] = rng.random(n) < rng.choice([0, 1e-4])
        # Registers written at any time: somewhere near their addresses, or at the selection.
        inputs["cfg_valid"] = rng.random(n) < 0.02
        inputs["cfg_addr"] = np.where(rng.random(n) < 0.3, SELECT, rng.integers(76, 94, n))
        values = np.where(rng.random(n) < 0.3, rng.choice([0, 255], n), rng.integers(0, 256, n))
        inputs["cfg_data"] = np.where(inputs["cfg_addr"] == SELECT, rng.integers(0, 8, n), values)
        equal(rtl(top, inputs), model.clocks(inputs), inputs, seed)

    @TOPS
    @pytest.mark.parametrize("seed", range(20))
    def test_the_cascade_between_partners_of_any_speed(self, seed: int, top: Top) -> None:
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
        result = play(
            zip(clock.tolist(), high.tolist(), low.tolist(), strict=True),
            *configs,
            top=top,
            release=rng.integers(0, slow[0], 97).tolist(),
            ack=rng.integers(0, slow[1], 101).tolist(),
            pass_ack=rng.integers(0, slow[2], 103).tolist(),
        )
        print(f"seed {seed}: {len(result.word)} words, {len(centres(result))} of them centres, {len(result.pass_clock)} passed")
        assert len(result.word) - len(centres(result)) + len(result.pass_clock) <= n


def restarted(top: Top) -> NDArray[np.void]:
    """Inputs from power-on: a reset, writes to the registers, events, and a reset in the middle of what follows."""
    rng = np.random.default_rng(50)
    centre = [(60, 60), (60, 90), (90, 60), (90, 90)]
    configs = [replace(CONFIG, init_cm_high=high, init_cm_low=low, init_radix=14, max_time=700) for high, low in centre]
    writes = [write for i, config in enumerate(configs) for write in config.writes(i)] + [(SELECT, SELECT_NONE)]
    before = quiet(top, 1 + len(writes) + 5)
    before["rst"][0] = 1
    before["cfg_valid"][1:-5] = 1
    before["cfg_addr"][1:-5], before["cfg_data"][1:-5] = np.array(writes).T
    n = 800
    played = play(
        zip(np.cumsum(rng.integers(1, 40, n)).tolist(), *rng.integers(45, 106, (2, n)).tolist(), strict=True), *configs, top=top
    )
    assert len(centres(played)) > 20
    again = quiet(top, 60)
    again["rst"][:2] = 1
    rtl(top, quiet(top, 1))
    return np.concatenate([before, played.inputs, again])


@needs_icarus
@TOPS
def test_four_states(tmp_path: Path, top: Top) -> None:
    """No line depends on what a register holds before the first reset."""
    inputs = restarted(top)
    expected = rtl(top, inputs)
    found = replay(tmp_path, top.module, dict(top.parameters), inputs, top.read)
    for clock, (told, row) in enumerate(zip(found, expected, strict=True)):
        for name in top.read.names or ():
            valid = dict(top.valid_with).get(name)
            if clock > 0 and not (valid and row[valid]):
                assert set(told[name]) <= set("01"), (clock, name, told[name])
                assert int(told[name], 2) == row[name], (clock, name)


@pytest.mark.parametrize("seed", [1, 2])
def test_random_initial_values(seed: int) -> None:
    inputs = restarted(LIBRARY)
    found = rtl(LIBRARY, inputs, simulation(LIBRARY, seed))
    equal(found[1:], rtl(LIBRARY, inputs)[1:], inputs[1:], seed)

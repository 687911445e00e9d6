# SPDX-License-Identifier: Apache-2.0
"""cot_published_chain.v against the model at every clock: arbitration, registers, tags, and back-pressure between trackers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from evcot.hardware.published.model import REGISTERS, SELECT, SELECT_NONE, PublishedCascade, decode
from evcot_cosim.devices.published_device import CHAIN, at, equal, play, quiet, reset_chain, rtl
from support.published import CONFIG, centres, n_evs, noise, some_registers, wandering
from support.testing import lint


def test_lints_clean() -> None:
    assert lint(CHAIN) == (0, "")


class TestClocks:
    """Counted from the clock whose end first sees the request."""

    @pytest.mark.parametrize(("tracker", "clocks"), [(0, 7), (1, 10), (2, 13), (3, 16)])
    def test_a_centre_of_the_cascade(self, tracker: int, clocks: int) -> None:
        elsewhere, here = replace(CONFIG, init_cm_low=200), replace(CONFIG, nev_th=1)
        result = play(at([10]), *[here if i == tracker else elsewhere for i in range(4)])
        assert result.word_clock.tolist() == [10 + clocks]
        assert result.word.tolist() == [tracker << 17 | 100 << 9 | 100 << 1]

    def test_rejected_by_all_after_12(self) -> None:
        result = play([(10, 5, 6)], CONFIG, CONFIG, CONFIG, CONFIG)
        assert result.pass_clock.tolist() == [10 + 12]
        assert (result.pass_high[0], result.pass_low[0]) == (5, 6)


class TestCascade:
    def test_priority_alone_decides(self) -> None:
        result = play(at([0]), CONFIG, CONFIG, CONFIG, CONFIG)
        assert decode(result.word)["tracker"].tolist() == [0]

    def test_tags_of_events_and_centres(self) -> None:
        for tracker in range(4):
            configs = [replace(CONFIG, init_cm_high=10 + 60 * i, nev_th=2) for i in range(4)]
            result = play([(0, 10 + 60 * tracker, 101), (30, 10 + 60 * tracker, 101)], *configs)
            place = (10 + 60 * tracker) << 9
            assert result.word.tolist() == [(0x10 + tracker) << 17 | place | 101 << 1 | 1, tracker << 17 | place | 100 << 1]

    def test_a_disabled_tracker_passes_everything_through_at_once(self) -> None:
        off = replace(CONFIG, enable=False)
        result = play(at([10]), off, off, CONFIG)
        assert decode(result.word)["tracker"].tolist() == [2]
        assert result.word_clock.tolist() == [13]
        result = play(at([10]), off, off, off, off)
        assert result.pass_clock.tolist() == [10]

    def test_without_registers_everything_passes(self) -> None:
        assert len(play(at([10])).pass_clock) == 1

    def test_two_words_at_once_leave_one_after_the_other_with_the_line_released_between(self) -> None:
        # The first word waits 20 clocks; meanwhile tracker 0 rejects nothing, so tracker 1 gets its event from a third place.
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
        assert lost == [46, 47]


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
        result = model.play(clock, *np.array(places).T, trace=True)
        equal(rtl(CHAIN, result.inputs), result.outputs, result.inputs)
        assert len(result.pass_clock) == 2
        assert decode(result.word)["tracker"].tolist() == [2] * 21
        assert n_evs(result)[0] == 15

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
            result = model.play(model.clock + events[0], *events[1:], trace=True)
            equal(rtl(CHAIN, result.inputs), result.outputs, result.inputs)
            runs.append(result.word.tolist())
        assert runs[0] != runs[1]


class TestLockStep:
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
        result = play(
            zip(clock.tolist(), high.tolist(), low.tolist(), strict=True),
            *configs,
            release=rng.integers(0, slow[0], 97).tolist(),
            ack=rng.integers(0, slow[1], 101).tolist(),
            pass_ack=rng.integers(0, slow[2], 103).tolist(),
        )
        print(f"seed {seed}: {len(result.word)} words, {len(centres(result))} of them centres, {len(result.pass_clock)} passed")
        assert len(result.word) + len(result.pass_clock) <= n

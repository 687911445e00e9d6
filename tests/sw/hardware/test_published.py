# SPDX-License-Identifier: Apache-2.0
"""The model of the published tracker against the rules of docs/published.md applied event by event, and its own interface.

Its quirks, clock by clock and against the hardware, are in tests/hw/published/test_cot_published.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, RecordingError
from evcot.hardware.published.model import (
    CASCADE_INPUT,
    REGISTERS,
    SELECT,
    SELECT_NONE,
    TRACKER_INPUT,
    Handshakes,
    PublishedCascade,
    PublishedConfig,
    PublishedTracker,
    decode,
)

CONFIG = PublishedConfig(init_cm_low=100, init_cm_high=100, init_radix=20, radix_max=30, radix_min=10, nev_th=4)

# Clocks from an event's first clock to those at whose end InitCell has just been left, or TC2 is read.
FROM_CREATION = 1
TO_TIMING = 4


class Rules:
    """One life of one tracker, described without clock edges; events far enough apart not to wait for each other.

    The average is updated with each event as often as the line keeps it.
    """

    def __init__(self, config: PublishedConfig, updates: int) -> None:
        self.config = config
        self.average_updates = updates
        self.centre = self.average = (config.init_cm_high, config.init_cm_low)
        self.g = config.init_radix
        self.n = config.nev_th
        self.count = self.updates = self.quiet = self.last = 0
        self.times = [0, 0]

    def step(self, value: int, target: int) -> int:
        k = self.config.hist_avg
        return int(np.floor((target + (2**k - 1) * value) / 2**k))

    def words_of(self, clock: int, place: tuple[int, int]) -> list[int]:
        """The output words, none for an event outside; `clock` since the life began."""
        radius = self.g + self.config.radix_th
        if not all(max(c - radius, 0) < e < min(c + radius, 255) for c, e in zip(self.centre, place, strict=True)):
            return []
        self.count += 1
        event = 0x10 << 17 | place[0] << 9 | place[1] << 1 | 1
        if self.count < self.n:
            for _ in range(self.average_updates):
                self.average = tuple(map(self.step, self.average, place))  # type: ignore[assignment]
            return [event]
        self.count = 0
        self.set_radius(place)
        self.set_n(clock - self.times[-2])
        self.times.append(clock)
        self.centre = tuple(map(self.step, self.centre, self.average))  # type: ignore[assignment]
        return [event, self.centre[0] << 9 | self.centre[1] << 1]

    def set_radius(self, place: tuple[int, int]) -> None:
        config = self.config
        high, low = (e - c for e, c in zip(place, self.centre, strict=True))
        self.updates += 1
        if self.updates == 1:
            return
        if abs(high) > self.g or low < -self.g:
            self.g, self.quiet = min(self.g + config.radix_step, config.radix_max), 0
        elif self.quiet > 6:
            self.g, self.quiet = max(self.g - config.radix_step, config.radix_min), 0
        else:
            self.quiet += 1

    def set_n(self, diff: int) -> None:
        if diff > 2 * self.last and self.n > 1:
            self.n //= 2
        elif diff < self.last // 2 and self.n < 128:
            self.n *= 2
        elif self.n <= 1:
            self.n = 2
        elif self.n >= 128:
            self.n = 255
        self.last = diff


def random_events(rng: np.random.Generator, n: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Events around a wandering place, 20 to some hundred clocks apart, in bursts."""
    pace = np.repeat(rng.choice([3, 30, 400], n // 50 + 1), 50)[:n]
    clock = np.cumsum(20 + rng.integers(0, pace))
    places = 100 + np.cumsum(rng.integers(-1, 2, (2, n)), axis=1) // 2 + rng.integers(-18, 19, (2, n))
    high, low = np.clip(places, 0, 255)
    return clock, high, low


@pytest.mark.parametrize("library_line", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_events_far_apart_follow_the_rules(seed: int, library_line: bool) -> None:
    rng = np.random.default_rng([9, seed])
    config = replace(
        CONFIG, hist_avg=int(rng.integers(1, 5)), radix_th=int(rng.integers(8)), radix_step=int(rng.integers(8)),
        nev_th=int(rng.choice([0, 1, 2, 15, 200, 255])), max_time=2**32 - 1,
    )  # fmt: skip
    clock, high, low = random_events(rng, 5000)
    rules, cascade = Rules(config, 5 if library_line else 1), PublishedCascade([config], library_line=library_line)
    told = cascade.play(cascade.clock + clock, high, low)
    expected = [
        rules.words_of(int(t) + TO_TIMING + FROM_CREATION, (int(h), int(v))) for t, h, v in zip(clock, high, low, strict=True)
    ]
    print(f"seed {seed}: {len(told.word)} inside, {rules.updates} updates, N_ev {rules.n}, g {rules.g}")
    assert told.word.tolist() == [word for words in expected for word in words]
    assert len(told.pass_clock) == expected.count([])
    assert rules.updates > 3


def test_silence_that_is_skipped_gives_the_same_as_silence_that_is_played() -> None:
    rng = np.random.default_rng(10)
    clock = np.cumsum(rng.choice([1, 10, 300, 1700], 400))
    high, low = rng.integers(80, 121, (2, 400))
    configs = [replace(CONFIG, max_time=1500), replace(CONFIG, init_cm_low=130, max_time=700)]
    runs = [PublishedCascade(configs).play(clock, high, low, trace=trace) for trace in (False, True)]
    for quick, played in zip(runs[0][:6], runs[1][:6], strict=True):
        assert quick.tolist() == played.tolist()
    for_ever = PublishedCascade([replace(config, max_time=2**32 - 1) for config in configs]).play(clock, high, low)
    assert runs[0].word.tolist() != for_ever.word.tolist()
    assert len(runs[0].inputs) == 0
    assert len(runs[1].inputs) == len(runs[1].outputs) > 200_000


def test_a_run_may_be_cut_anywhere_between_events() -> None:
    rng = np.random.default_rng(11)
    clock, high, low = random_events(rng, 600)
    whole, parts = PublishedCascade([CONFIG]), PublishedCascade([CONFIG])
    expected = whole.play(50 + clock, high, low)
    told = [parts.play(50 + clock[part], high[part], low[part]) for part in (slice(0, 7), slice(7, 7), slice(7, 600))]
    for found, name in zip(zip(*told, strict=True), expected._fields, strict=True):
        assert np.concatenate(found).tolist() == getattr(expected, name).tolist(), name


def test_an_hour_of_silence_at_50_mhz_takes_no_time() -> None:
    cascade = PublishedCascade([CONFIG])
    hour = 3600 * 50_000_000
    told = cascade.play(np.array([100, hour]), np.array([100, 100]), np.array([100, 100]))
    assert told.word_clock.tolist() == [105, hour + 5]
    assert cascade.clock > hour


def test_one_tracker_loses_nothing_and_a_cascade_what_it_passes_to_one_that_is_busy() -> None:
    rng = np.random.default_rng(12)
    slow = Handshakes(np.array([3, 0]), np.array([5, 0, 1]))
    places = rng.integers(60, 141, (2, 3000))
    configs = [replace(CONFIG, init_cm_low=low) for low in (70, 90, 110, 130)]
    for n in (1, 4):
        told = PublishedCascade(configs[:n]).play(np.zeros(3000, np.int64), *places, slow)
        out = int(decode(told.word)["event"].sum()) + len(told.pass_clock)
        assert out == 3000 if n == 1 else 2000 < out < 3000
        assert (np.diff(told.acknowledged) >= 4).all()


def test_the_register_writes_of_a_configuration() -> None:
    config = PublishedConfig(init_cm_low=1, init_cm_high=2, max_time=0x04030201, hist_avg=5, enable=False)
    assert config.writes(3) == [
        (127, 4), (78, 1), (79, 2), (80, 3), (81, 64), (82, 1), (83, 2), (84, 3), (85, 4), (86, 15), (87, 5), (88, 0), (89, 3),
        (90, 17), (91, 1),
    ]  # fmt: skip


def test_writes_while_no_tracker_is_selected_do_nothing() -> None:
    cascade = PublishedCascade([CONFIG])
    cascade.write([(REGISTERS["enable"][0], 0), (SELECT, SELECT_NONE)])
    assert len(cascade.play(np.array([100]), np.array([100]), np.array([100])).word) == 1


def test_words_decode() -> None:
    words = decode(np.array([0x13 << 17 | 7 << 9 | 255 << 1 | 1, 2 << 17 | 200 << 9]))
    assert words.tolist() == [(3, True, 7, 255), (2, False, 200, 0)]


def test_a_lone_tracker_is_the_first_of_a_cascade() -> None:
    """It is acknowledged as the line without delay acknowledges it."""
    rng, n = np.random.default_rng(13), 5000
    cascade = PublishedCascade([CONFIG], library_line=False)
    rows = np.zeros(n, CASCADE_INPUT)
    rows["s_req_n"] = np.arange(n) // 3 % 3 != 0
    rows["m_ack_n"] = np.arange(n) % 4 != 0  # released after each word, as the line asks
    rows["s_high"], rows["s_low"] = rng.integers(80, 121, (2, n))
    told = cascade.clocks(rows)
    inputs = np.zeros(n + 1, TRACKER_INPUT)
    for name in ("s_req_n", "s_high", "s_low"):
        inputs[name][1:] = rows[name]
    inputs["s_req_n"][0] = 1  # InitCell
    taken = (told["m_req_n"] == 0) & (rows["m_ack_n"] == 0)
    is_event = told["m_word"] & 1
    inputs["m_event_ack_n"][1:], inputs["m_centre_ack_n"][1:] = ~(taken & (is_event == 1)), ~(taken & (is_event == 0))
    inputs["m_event_ack_n"][0] = inputs["m_centre_ack_n"][0] = 1
    expected = PublishedTracker(CONFIG).clocks(inputs)[1:]
    for name in ("s_ack_n", "m_pass_req_n", "m_pass_high", "m_pass_low"):
        assert told[name].tolist() == expected[name].tolist(), name
    assert decode(told["m_word"][taken])["event"].any()
    assert not decode(told["m_word"][taken])["event"].all()


class TestRefused:
    @pytest.mark.parametrize(
        ("field", "value"),
        [("hist_avg", 0), ("hist_avg", 9), ("radix_th", 8), ("nev_th", 256), ("max_time", 1 << 32), ("init_cm_low", -1)],
    )
    def test_a_register_outside_its_range(self, field: str, value: int) -> None:
        with pytest.raises(ConfigError, match=rf"published\.{field} = {value}: must be from"):
            replace(CONFIG, **{field: value})

    def test_five_trackers_and_events_for_a_tracker_that_is_still_selected(self) -> None:
        with pytest.raises(ConfigError, match=r"published\.enable = 255: must be true or false"):
            replace(CONFIG, enable=255)  # type: ignore[arg-type]
        with pytest.raises(ConfigError, match="5 published trackers: must be at most 4"):
            PublishedCascade([CONFIG] * 5)
        cascade = PublishedCascade([CONFIG])
        cascade.write([(SELECT, 1)])
        with pytest.raises(ConfigError, match="tracker 0 is selected"):
            cascade.play(np.array([100]), np.array([100]), np.array([100]))

    @pytest.mark.parametrize("pattern", [[], [-1], [[1]]])
    def test_a_pattern_that_is_none(self, pattern: list[int]) -> None:
        with pytest.raises(ConfigError, match=r"handshakes\.ack: must be a sequence of at least one number of clocks"):
            Handshakes(ack=np.array(pattern, np.int64))

    @pytest.mark.parametrize(
        ("events", "message"),
        [
            (([1], [256], [0]), "event 0: high = 256: must be from 0 to 255"),
            (([1, 2], [0, 0], [0, -1]), "event 1: low = -1: must be from 0 to 255"),
            (([1, 3, 2], [0] * 3, [0] * 3), "event 2: clock 2 lies before that of the event before it"),
            (([-1], [0], [0]), "events from clock -1 to -1: must be from 0 to 281474976710655"),
            (([1], [0, 0], [0]), "1 clocks, 2 high and 1 low coordinates: must be as many of each"),
        ],
    )
    def test_events_that_cannot_be(self, events: tuple[list[int], ...], message: str) -> None:
        with pytest.raises(RecordingError, match=message):
            PublishedCascade([CONFIG]).play(*map(np.array, events))

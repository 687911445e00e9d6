# SPDX-License-Identifier: Apache-2.0
"""classifier.v: the class of tracked objects, as the golden model names it, verdict by verdict.

In Icarus, from X: no output has an X, and the verdicts are the same.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.hardware.classifier import CELLS, CLASSES_MAX, HIDDEN, SERVICE_EVENTS, RecognitionRegisters
from evcot.recognition.model import Network
from evcot.recognition.weight_memory import BANKS, REGISTER_ADDRESSES, ROWS, memory_words
from evcot_cosim.devices.base import Pattern
from support.classifier_trials import (
    VERDICT_FIELDS,
    ClassifierTrial,
    OwnedEvents,
    candidate,
    joined,
    model_verdicts,
    object_events,
    random_network,
    random_owned,
    random_registers,
)
from support.four_state import needs_icarus, replay
from support.stream_device import random_pattern
from support.testing import EXHAUSTIVE

WINDOW = 256
MORE = 30 if EXHAUSTIVE else 1  # times as many random events
SHORT = RecognitionRegisters(window_log2=8, scale_start=200, shift_1=0, shift_2=4, classes=2)


@cache
def compiled(**parameters: int) -> ClassifierTrial:
    return ClassifierTrial(**parameters)


def trial_of(
    registers: RecognitionRegisters | None = None, network: Network | None = None, **parameters: int
) -> ClassifierTrial:
    trial = compiled(**parameters)
    trial.device.stalls = {}
    trial.reset()
    if registers is not None:
        trial.write(registers, network)
    return trial


def halves() -> Network:
    """Class 0 has its events in the upper half of the image, class 1 in the left half."""
    w1 = np.zeros((CELLS, CELLS, HIDDEN), np.int8)
    w1[: CELLS // 2, :, 0] = 1
    w1[:, : CELLS // 2, HIDDEN - 1] = 1
    w2 = np.zeros((HIDDEN, CLASSES_MAX), np.int8)
    w2[0, 0] = w2[HIDDEN - 1, 1] = 100
    return Network(w1.reshape(-1, HIDDEN), w2)


def bars(slot: int, n: int, *, upright: bool, track: int = 7) -> OwnedEvents:
    """A bar with nearly all of its events at one end: left of its middle, or above it."""
    rng = np.random.default_rng(n)
    along, across = np.where(rng.random(n) < 0.8, -60, 200), rng.integers(-40, 40, n)
    dx, dy = (across, along) if upright else (along, across)
    return OwnedEvents(np.full(n, slot), dx, dy, np.ones(n, bool), np.full(n, track))


def verdicts(trial: ClassifierTrial, *parts: OwnedEvents) -> list[dict[str, int]]:
    words = trial.run(joined(parts)).words["m_"].astype(np.int64)
    names = ("slot", "id", "seq", "class", "margin", "windows")
    return [dict(zip(names, word, strict=True)) for word in words.tolist()]


class TestStory:
    def test_second_window_of_a_track_gives_the_first_verdict(self) -> None:
        trial = trial_of(SHORT, halves())
        pause = candidate(1, SERVICE_EVENTS)
        assert not verdicts(trial, bars(0, WINDOW, upright=True), pause), "the first window only fits the image"
        (first,) = verdicts(trial, bars(0, WINDOW, upright=True), pause)
        assert (first["slot"], first["id"], first["class"], first["windows"]) == (0, 7, 0, 1)
        assert first["seq"] == 2 * WINDOW + SERVICE_EVENTS - 1, "of the event that closed the window"
        (second,) = verdicts(trial, bars(0, WINDOW, upright=True), pause)
        assert (second["class"], second["windows"]) == (0, 2)
        assert second["margin"] > first["margin"] > 0

    def test_class_is_that_of_the_object(self) -> None:
        trial = trial_of(SHORT, halves())
        pause = candidate(1, SERVICE_EVENTS)
        both = [
            joined([bars(0, WINDOW, upright=False, track=3), pause]),
            joined([bars(2, WINDOW, upright=True, track=4), pause]),
        ]
        found = verdicts(trial, *both, *both)
        assert [(one["slot"], one["id"], one["class"]) for one in found] == [(0, 3, 1), (2, 4, 0)]

    def test_candidate_event_ends_window_and_track(self) -> None:
        trial = trial_of(SHORT, halves())
        pause = candidate(1, SERVICE_EVENTS)
        assert not verdicts(trial, bars(0, WINDOW, upright=True), pause, bars(0, WINDOW - 1, upright=True), candidate(0))
        assert not verdicts(trial, bars(0, WINDOW, upright=True), pause), "the first window of another track"
        assert len(verdicts(trial, bars(0, WINDOW, upright=True), pause)) == 1

    def test_slot_pauses_until_768_owned_events_have_passed(self) -> None:
        trial = trial_of(SHORT, halves())
        ready, early = (candidate(1, SERVICE_EVENTS - off) for off in (1, 2))
        first = bars(0, WINDOW, upright=True)
        assert len(verdicts(trial, first, ready, bars(0, WINDOW, upright=True))) == 1
        trial = trial_of(SHORT, halves())
        assert not verdicts(trial, first, early, bars(0, WINDOW, upright=True))
        assert len(verdicts(trial, bars(0, 1, upright=True))) == 1

    def test_small_margin_is_none_of_these(self) -> None:
        trial = trial_of(SHORT, halves())
        pause = candidate(1, SERVICE_EVENTS)
        track = [bars(0, WINDOW, upright=True), pause, bars(0, WINDOW, upright=True), pause]
        (found,) = verdicts(trial, *track)
        assert 0 < found["margin"] < 255
        for margin_min, wanted in ((found["margin"], 0), (found["margin"] + 1, 15)):
            trial.run(None, [("margin_min", int(margin_min))])
            (again,) = verdicts(trial, *track)
            assert (again["class"], again["margin"]) == (wanted, found["margin"])

    def test_vote_is_halved_at_128_windows(self) -> None:
        trial = trial_of(SHORT, halves())
        one = joined([bars(0, WINDOW, upright=True), candidate(1, SERVICE_EVENTS)])
        found = verdicts(trial, *[one] * 140)
        assert [each["windows"] for each in found] == [*range(1, 129), *range(65, 76)]
        assert found[128]["margin"] < found[127]["margin"]


@pytest.mark.parametrize("n_slots", [8, 1, 3, 64])
def test_random_traffic_is_exact(n_slots: int) -> None:
    trial = trial_of(n_slots=n_slots)
    given = np.zeros(16, int)
    for run in range(12):
        rng = np.random.default_rng([20301, n_slots, run])
        trial.device.stalls = {} if run % 2 else {"s_": random_pattern(rng), "m_": random_pattern(rng)}
        trial.reset()
        trial.write(random_registers(rng, int(rng.choice([8, 8, 9, 10]))), random_network(rng))
        events = random_owned(rng, MORE * 50_000, n_slots, trial.rel_w, flips=float(rng.choice([0, 1e-5, 1e-4, 1e-3])))
        given += np.bincount(trial.run(events).words["m_"][:, 3].astype(int), minlength=16)
    print(f"{n_slots} slots: {12 * MORE * 50_000:,} owned events, {given.sum():,} verdicts")
    assert given.sum() > 100
    assert np.count_nonzero(given) >= 4


@pytest.mark.parametrize(("radix_w", "seq_w", "id_w"), [(1, 8, 1), (12, 48, 32)])
def test_random_traffic_is_exact_at_the_limits_of_widths(radix_w: int, seq_w: int, id_w: int) -> None:
    trial = trial_of(n_slots=5, radix_w=radix_w, seq_w=seq_w, id_w=id_w)
    for run in range(4):
        rng = np.random.default_rng([20302, radix_w, run])
        trial.reset()
        trial.write(random_registers(rng), random_network(rng))
        events = random_owned(rng, 30_000, 5, trial.rel_w, flips=1e-4)
        assert len(trial.run(events._replace(id=events.id % (1 << min(id_w, 15)))).words["m_"]) > 5


@pytest.mark.parametrize("window_log2", [8, 11, 12])
def test_windows_of_all_slots_that_close_together_are_exact(window_log2: int) -> None:
    """Slots take turns event by event, so that eight windows close in eight clocks."""
    rng = np.random.default_rng(20303)
    trial = trial_of(random_registers(rng, window_log2), random_network(rng))
    n = 12 * 8 << window_log2
    slots = [object_events(rng, slot, n // 8, 20 * (slot + 1), slot / 4) for slot in range(8)]
    events = OwnedEvents(*(np.stack(columns, axis=1).ravel() for columns in zip(*slots, strict=True)))
    given = trial.run(events).words["m_"]
    assert set(given[:8, 0].tolist()) == set(range(8))
    assert len(given) > 20


@pytest.mark.parametrize("off", [(-500, 300), (500, -480), (0, 0)])
@pytest.mark.parametrize("scale_start", [16, 4095])
def test_fit_stays_in_its_limits(off: tuple[int, int], scale_start: int) -> None:
    """Objects far from the middle of their box, in a point, or much larger than the image."""
    rng = np.random.default_rng(20304)
    for size in (0.1, 30, 300):
        trial = trial_of(RecognitionRegisters(window_log2=8, scale_start=scale_start), random_network(rng))
        parts = [object_events(rng, 0, 40_000, size, slant) for slant in (0, 3, -3)]
        for each in parts:
            dx, dy = np.clip(each.dx + off[0], -512, 511), np.clip(each.dy + off[1], -512, 511)
            assert len(trial.run(each._replace(dx=dx, dy=dy)).words["m_"]) > 30


def test_scale_of_an_object_beyond_the_image_stays_at_16() -> None:
    rng = np.random.default_rng(20312)
    trial = trial_of(RecognitionRegisters(window_log2=8, scale_start=40), random_network(rng), radix_w=12)
    spread = object_events(rng, 0, 20_000, 1)
    far = [rng.choice([-7_000, 7_000], 20_000) + rng.integers(-900, 900, 20_000) for _ in range(2)]
    assert len(trial.run(spread._replace(dx=far[0], dy=far[1])).words["m_"]) > 15


class TestRegisters:
    def test_reset_gives_them_the_defaults_of_the_contract(self) -> None:
        rng = np.random.default_rng(20310)
        network = random_network(rng)
        network.w2[:, CLASSES_MAX - 1] = 127  # the last class wins, if it counts
        trial = trial_of(RecognitionRegisters(), network, n_slots=3)
        found = trial.run(random_owned(rng, 60_000, 3, trial.rel_w, flips=0)).words["m_"]
        assert (found[:, 3] == CLASSES_MAX - 1).sum() > 5

    def test_writes_in_flow_take_effect_between_two_events(self) -> None:
        rng = np.random.default_rng(20305)
        trial = trial_of(random_registers(rng), random_network(rng))
        given = 0
        for run in range(10):
            trial.device.stalls = {"cfg_": slow_pattern(rng, 3_000), "s_": random_pattern(rng, 0.3 + 0.07 * run)}
            registers = random_registers(rng, int(rng.integers(8, 10)))
            names = ("scale_start", "classes", "shift_1", "window_log2", "margin_min", "shift_2")
            writes = [("enable", 1), *((name, getattr(registers, name)) for name in names)]
            events = random_owned(rng, MORE * 30_000, 8, trial.rel_w, flips=1e-5)
            given += len(trial.run(events, writes).words["m_"])
        print(f"registers in flow: {10 * MORE * 30_000:,} owned events, {given:,} verdicts")
        assert given > 100

    def test_write_waits_until_all_windows_are_evaluated(self) -> None:
        trial = trial_of(SHORT, halves())
        trial.device.stalls = {"cfg_": np.array([0] * 600 + [1] * 4_000, np.uint8)}
        trial.reset()
        trial.write(SHORT, halves())
        trial.device.cycle = 0
        one = [object_events(np.random.default_rng(1), slot, WINDOW, 40) for slot in (0, 1)]
        done = trial.run(joined(one), [("margin_min", 9)])
        assert done.accepted["s_"][-1] < 600
        assert done.accepted["cfg_"][0] > 2 * WINDOW + 179, "until the second window is evaluated"

    def test_disabled_classifier_counts_nothing(self) -> None:
        trial = trial_of(SHORT, halves())
        trial.run(None, [("enable", 0)])
        trial.run(bars(0, 4 * WINDOW, upright=True))
        trial.run(None, [("enable", 1)])
        assert not verdicts(trial, bars(0, WINDOW, upright=True), candidate(1, SERVICE_EVENTS))

    def test_reset_during_an_evaluation_ends_it(self) -> None:
        rng = np.random.default_rng(20306)
        trial = trial_of()
        for clocks in (290, 370, 900, 1_800):
            trial.write(random_registers(rng), random_network(rng))
            events = random_owned(rng, clocks, 2, trial.rel_w, flips=0)
            words = np.stack((events.slot, events.dx & 1023, events.dy & 1023, events.visible, events.id, events.id), axis=1)
            trial.device.run({"s_": words}, clocks=clocks)
            trial.reset()
            assert trial.device.sim.io.m_valid == 0
            trial.write(random_registers(rng), random_network(rng))
            trial.run(random_owned(rng, 20_000, 8, trial.rel_w, flips=0))


class TestWeights:
    def test_weights_written_in_flow_replace_the_old_ones(self) -> None:
        rng = np.random.default_rng(20307)
        trial = trial_of(random_registers(rng), random_network(rng))
        for _ in range(5):
            trial.run(random_owned(rng, MORE * 20_000, 8, trial.rel_w, flips=0), [("enable", 0)])
            trial.write_weights(random_network(rng), random_owned(rng, 5_000, 8, trial.rel_w))
            done = trial.run(random_owned(rng, MORE * 20_000, 8, trial.rel_w, flips=0), [("enable", 1)])
            assert len(done.words["m_"]) > 5
        print(f"weights in flow: {5 * (MORE * 40_000 + 5_000):,} owned events")

    def test_enabled_classifier_refuses_weights(self) -> None:
        trial = trial_of(SHORT, halves())
        trial.device.run({"weight_": [(0, 0)]}, clocks=50)
        assert trial.device.sim.io.weight_ready == 0
        trial.run(None, [("enable", 0)])
        assert trial.device.sim.io.weight_ready == 1
        assert read_back(trial, 0) == int(memory_words(halves())[0])

    def test_weights_can_be_read_back(self) -> None:
        network = random_network(np.random.default_rng(20308))
        trial = trial_of(SHORT, network)
        trial.run(None, [("enable", 0)])
        words = memory_words(network)
        assert len(words) == ROWS * BANKS
        for address in (0, 1, 359, 360, 361, 362, 363, 1111, len(words) - 1):
            assert read_back(trial, address) == words[address]


class TestVerdicts:
    def test_stalled_verdicts_wait_in_order_and_none_is_lost(self) -> None:
        rng = np.random.default_rng(20309)
        trial = trial_of(random_registers(rng), random_network(rng), verdicts=4)
        trial.device.stalls = {"m_": np.array([0] * 2_500 + [1] * 600, np.uint8)}
        assert len(trial.run(random_owned(rng, 60_000, 8, trial.rel_w, flips=0)).words["m_"]) > 50

    @pytest.mark.parametrize("waiting", [1, 4])
    def test_verdict_that_finds_the_queue_full_is_lost(self, waiting: int) -> None:
        rng = np.random.default_rng(20310)
        trial = trial_of(random_registers(rng), random_network(rng), verdicts=waiting)
        trial.device.stalls = {"m_": slow_pattern(rng, 4_000)}
        given = trial.run(random_owned(rng, 60_000, 8, trial.rel_w, flips=0), may_lose=True).words["m_"]
        assert len(given) > 10
        assert trial.lost > 10


class TestClocks:
    """What the headers of classifier.v and classifier_evaluator.v claim."""

    def test_verdict_comes_790_clocks_after_the_event_that_closes_the_window(self) -> None:
        trial = trial_of(SHORT, halves())
        one = joined([bars(0, WINDOW, upright=True), candidate(1, SERVICE_EVENTS)])
        trial.run(one)
        done = trial.run(one)
        assert done.given["m_"][0] - done.accepted["s_"][WINDOW - 1] == 790

    def test_next_verdicts_follow_by_765_clocks(self) -> None:
        trial = trial_of(SHORT, halves())
        in_turns = OwnedEvents(
            *(column.reshape(7, -1).T.ravel() for column in joined([bars(n, WINDOW, upright=True) for n in range(7)]))
        )
        pause = candidate(7, 7 * SERVICE_EVENTS)
        trial.run(joined([in_turns, pause]))
        done = trial.run(joined([in_turns, pause]))
        closed = done.accepted["s_"][len(in_turns.slot) - 7]
        assert (done.given["m_"] - closed).tolist() == [790 + 765 * n for n in range(7)]

    def test_first_window_of_a_track_takes_179_clocks(self) -> None:
        trial = trial_of(SHORT, halves())
        one = joined([bars(0, WINDOW, upright=True), candidate(2, SERVICE_EVENTS)])
        trial.run(one)
        old, new = bars(0, WINDOW, upright=True), bars(1, WINDOW, upright=True)
        done = trial.run(joined([old.part(0, WINDOW - 1), new, old.part(0, 1), candidate(2, SERVICE_EVENTS)]))
        assert done.given["m_"][0] - done.accepted["s_"][2 * WINDOW - 1] == 790 + 179 - 1


def slow_pattern(rng: np.random.Generator, clocks: int) -> Pattern:
    """Goes in one clock of so many."""
    pattern = np.zeros(clocks + int(rng.integers(100)), np.uint8)
    pattern[rng.integers(len(pattern))] = 1
    return pattern


def read_back(trial: ClassifierTrial, address: int) -> int:
    """A word of the weights, whose address must stand: an offer of a word that is refused would stand too."""
    trial.device.set(weight_address=address)
    for _ in range(3):
        trial.device.sim.clock.tick()
    return int(trial.device.sim.io.weight_read)


REGISTERS = RecognitionRegisters(window_log2=8, scale_start=200, shift_1=3, shift_2=6)
GIVEN = np.dtype(
    [
        ("rst", "u1"), ("cfg_valid", "u1"), ("cfg_addr", "u1"), ("cfg_data", "u2"),
        ("weight_valid", "u1"), ("weight_address", "u2"), ("weight_data", "u4"),
        ("s_valid", "u1"), ("s_slot", "u1"), ("s_dx", "u2"), ("s_dy", "u2"), ("s_visible", "u1"),
        ("s_id", "u2"), ("s_seq", "u4"), ("m_ready", "u1"),
    ]
)  # fmt: skip
READ = np.dtype(
    [
        ("cfg_ready", "u1"), ("weight_ready", "u1"), ("s_ready", "u1"), ("m_valid", "u1"), ("lost", "u1"), ("idle", "u1"),
        ("m_slot", "u1"), ("m_id", "u2"), ("m_seq", "u4"), ("m_class", "u1"), ("m_margin", "u2"), ("m_windows", "u1"),
    ]
)  # fmt: skip
HANDSHAKES = ("cfg_ready", "weight_ready", "s_ready", "m_valid", "lost", "idle")


def blocks(*parts: NDArray[np.void]) -> NDArray[np.void]:
    rows = np.concatenate(parts)
    rows["m_ready"] = 1
    return rows


@needs_icarus
def test_verdicts_do_not_depend_on_initial_values(tmp_path: Path) -> None:
    rng = np.random.default_rng(20311)
    network = random_network(rng)
    words = memory_words(network)
    track = [object_events(rng, slot, WINDOW, 40) for slot in (0, 3, 0, 3, 0)]
    events = joined([one for part in track for one in (part, candidate(1, SERVICE_EVENTS))])
    reset, idle = np.zeros(3, GIVEN), np.zeros(900, GIVEN)
    reset["rst"] = 1
    weights = np.zeros(len(words), GIVEN)
    weights["weight_valid"], weights["weight_address"], weights["weight_data"] = 1, np.arange(len(words)), words
    writes = [("window_log2", 8), ("scale_start", 200), ("shift_1", 3), ("shift_2", 6), ("enable", 1)]
    cfg = np.zeros(len(writes), GIVEN)
    cfg["cfg_valid"], cfg["cfg_addr"], cfg["cfg_data"] = (
        1,
        [REGISTER_ADDRESSES[name] for name, _ in writes],
        [v for _, v in writes],
    )
    tokens = np.zeros(len(events.slot), GIVEN)
    tokens["s_valid"], tokens["s_slot"], tokens["s_visible"], tokens["s_id"] = 1, events.slot, events.visible, events.id
    tokens["s_dx"], tokens["s_dy"], tokens["s_seq"] = events.dx & 1023, events.dy & 1023, np.arange(len(events.slot))
    inputs = blocks(reset, weights, cfg, tokens, idle)
    found = replay(tmp_path, "classifier", {}, inputs, READ)
    given = []
    for clock, told in enumerate(found[2:], 2):
        for name in (*HANDSHAKES, *(f"m_{field}" for field in VERDICT_FIELDS)) if told["m_valid"][-1] == "1" else HANDSHAKES:
            bits = told[name][-1:] if name in HANDSHAKES else told[name].replace("z", "")
            assert set(bits) <= set("01"), (clock, name, told[name])
        if told["m_valid"][-1] == "1":
            given.append([int(told[f"m_{field}"].replace("z", "0"), 2) for field in VERDICT_FIELDS])
    wanted = model_verdicts(REGISTERS, network, events)
    assert len(wanted) == 3
    assert given == wanted.tolist()

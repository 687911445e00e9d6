# SPDX-License-Identifier: Apache-2.0
"""The golden model by itself: compared with a slow model in plain Python, streams split anywhere, units of a TrackLog, and
registers that change between two events.

The stories that it shares with the hardware are in tests/hw.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import RECORD, Mode, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.golden import to_track_records, track
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.ticks import TickedEvents, tick_times
from evcot.tracks.log import TRACK, Kind
from support.tokens import ticked

SHAPE = Shape(n_slots=4, x_w=6, y_w=6, radix_w=5, nev_w=5, tc_w=10, sup_w=6, id_w=6)
SLOT = SlotConfig(
    init_radix=4, radix_th=2, radix_min=3, radix_max=7, hist_avg=1, max_ticks=40,
    clust_nev=3, nev_min=2, nev_max=6, nev_th=3, detect_ticks=25,
)  # fmt: skip


@dataclass
class Slow:
    """One slot, following docs/algorithm.md: exact fractions, no arithmetic shared with the model."""

    number: int
    config: SlotConfig
    shape: Shape

    def __post_init__(self) -> None:
        self.restart()

    took = began = 0  # of the window of events before, and when this one began

    def restart(self) -> None:
        config = self.config
        self.cm = [Fraction(config.init_cm_x), Fraction(config.init_cm_y)]
        self.av = list(self.cm)
        self.g, self.n_ev, self.count, self.support = config.init_radix, config.clust_nev, 0, 0
        self.ring = self.active = self.started = False
        self.deadline = math.inf

    @property
    def radius(self) -> int:
        return self.g + self.config.radix_th

    @property
    def waits(self) -> bool:
        return self.config.mode == Mode.FIXED

    @property
    def free(self) -> bool:
        return self.config.mode == Mode.SEEDED and not self.started

    @property
    def pixel(self) -> list[int]:
        return [math.floor(value + Fraction(1, 2)) if self.shape.frac else int(value) for value in self.cm]

    def holds(self, event: tuple[int, int]) -> bool:
        near = all(abs(value - centre) <= self.radius for value, centre in zip(event, self.pixel, strict=True))
        return (self.started or self.waits) and near

    def overlaps(self, other: Slow) -> bool:
        apart = [abs(a - b) for a, b in zip(self.pixel, other.pixel, strict=True)]
        return max(apart) <= self.radius + other.radius

    def towards(self, value: Fraction, target: Fraction) -> Fraction:
        unit = 1 << self.shape.frac
        half = Fraction(1, 2) if self.shape.frac else 0
        return value + Fraction(math.floor((target - value) * unit / (1 << self.config.hist_avg) + half), unit)

    def take(self, event: tuple[int, int], now: int) -> bool:
        """Whether it was the N_ev-th event."""
        config = self.config
        self.ring |= any(abs(value - centre) > self.g for value, centre in zip(event, self.pixel, strict=True))
        self.av = [self.towards(av, Fraction(value)) for av, value in zip(self.av, event, strict=True)]
        self.support = min(self.support + 1, (1 << self.shape.sup_w) - 1)
        if self.active:
            self.deadline = now + config.max_ticks
        elif not self.started or self.count == 0:
            self.deadline, self.began = now + config.detect_ticks + 1, now
        self.started = True
        self.count += 1
        return self.count == self.n_ev

    def update(self, now: int) -> Kind:
        config = self.config
        self.g = (
            min(self.g + config.radix_step, config.radix_max)
            if self.ring
            else max(self.g - config.radix_step, config.radix_min)
        )
        self.cm = [self.towards(cm, av) for cm, av in zip(self.cm, self.av, strict=True)]
        took, kind = now - self.began, Kind.MOVED if self.active else Kind.BORN
        if self.active and took > self.took + config.nev_th:
            self.n_ev = min(2 * self.n_ev, config.nev_max)
        elif self.active and took + config.nev_th < self.took:
            self.n_ev = max(self.n_ev // 2, config.nev_min)
        self.deadline = now + config.max_ticks
        self.took, self.began, self.count, self.ring, self.active = took, now, 0, False, True
        return kind


def slow_run(config: CotConfig, ticks: list[int], events: list[tuple[int, int]]) -> tuple[list[int], list[tuple[int, ...]]]:
    """Owners, and records as (seq, time, kind, slot, id, other, x, y, radius, n_ev, support), centres in 2^-frac pixels."""
    slots = [Slow(i, slot, config.shape) for i, slot in enumerate(config.slots)]
    unit = 1 << config.shape.frac
    chain = config.module == "cot_chain"
    births = [0] * len(slots) if chain else [0]
    owners: list[int] = []
    records: list[tuple[int, ...]] = []

    def record(seq: int, time: int, kind: Kind, slot: Slow, other: int = 0) -> None:
        x, y = (int(value * unit) for value in slot.cm)
        identity = ids[slot.number]
        records.append((seq, time, kind, slot.number, identity, other, x, y, slot.radius, slot.n_ev, slot.support))

    ids: dict[int, int] = {}
    born: dict[int, int] = {}  # how many births came before
    for seq, (now, event) in enumerate(zip(ticks, events, strict=True)):
        for slot in sorted((slot for slot in slots if slot.deadline <= now), key=lambda slot: (slot.deadline, slot.number)):
            if slot.active:
                record(seq, int(slot.deadline), Kind.LOST, slot)
            slot.restart()
        if chain:
            owner = next((slot for slot in slots if slot.holds(event) or slot.free), None)
        else:
            ranked = [slot for slot in slots if slot.active and slot.holds(event)]
            ranked += [slot for slot in slots if slot.holds(event)] + [slot for slot in slots if slot.free]
            owner = ranked[0] if ranked else None
        owners.append(-1 if owner is None else owner.number)
        if owner is None:
            continue
        if owner.free:
            owner.cm, owner.av = ([Fraction(value) for value in event] for _ in "ca")
        if not owner.take(event, now):
            continue
        kind = owner.update(now)
        if kind == Kind.BORN:
            counter = owner.number if chain else 0
            step, first = (len(slots), owner.number) if chain else (1, 0)
            ids[owner.number] = (first + step * births[counter]) % (1 << config.shape.id_w)
            born[owner.number] = sum(births)
            births[counter] += 1
        record(seq, now, kind, owner)
        while not chain:
            met = [slot for slot in slots if slot.active and slot is not owner and slot.overlaps(owner)]
            if not met:
                break
            stays, goes = sorted((owner, met[0]), key=lambda slot: born[slot.number])
            record(seq, now, Kind.MERGED, goes, ids[stays.number])
            total = stays.support + goes.support
            half = Fraction(1, 2) if config.shape.frac else 0
            pairs = zip(stays.cm, goes.cm, strict=True)
            means = [(a * stays.support + b * goes.support) / total for a, b in pairs]
            stays.cm = [Fraction(math.floor(mean * unit + half), unit) for mean in means]
            stays.av = list(stays.cm)
            stays.g = min(max(stays.g, goes.g), stays.config.radix_max)
            stays.support = min(total, (1 << config.shape.sup_w) - 1)
            stays.deadline = now + stays.config.max_ticks
            goes.restart()
            record(seq, now, Kind.MOVED, stays)
            owner = stays
    return owners, records


def crowd(n: int, seed: int, size: int = 64) -> TickedEvents:
    """Bursts around wandering targets, with noise and pauses."""
    rng = np.random.default_rng(seed)
    target = np.repeat(rng.integers(0, 5, n), rng.integers(1, 12, n))[:n]
    x, y = (
        np.clip(
            rng.uniform(0, size, 5)[target] + rng.normal(0, 8, 5)[target] * np.arange(n) / n + rng.normal(0, 2, n), 0, size - 1
        )
        for _ in "xy"
    )
    noise = rng.random(n) < 0.1
    x[noise], y[noise] = rng.uniform(0, size, (2, np.count_nonzero(noise)))
    steps = rng.poisson(1.0, n) + np.where(rng.random(n) < 0.01, rng.integers(0, 120, n), 0)
    return ticked(np.cumsum(steps), x.astype(np.uint16), y.astype(np.uint16))


FIELDS = ("seq", "time", "kind", "slot", "track_id", "other_id", "cm_x", "cm_y", "radius", "n_ev", "support")


@pytest.mark.parametrize("module", ["cot_array", "cot_chain"])
@pytest.mark.parametrize(("frac", "id_w"), [(0, 32), (1, 32), (4, 32), (8, 32), (4, 3)])
def test_it_is_what_the_contract_says_in_exact_fractions(module: Module, frac: int, id_w: int) -> None:
    waiting = replace(SLOT, mode=Mode.FIXED, init_cm_x=30, init_cm_y=40, radix_max=12, radix_step=3)
    config = CotConfig(
        replace(SHAPE, frac=frac, id_w=id_w),
        (SLOT, waiting, replace(SLOT, hist_avg=2), replace(SLOT, clust_nev=2)),
        module=module,
    )
    events = crowd(6000, seed=frac)
    told = CotModel(config).feed(events)
    places = list(zip(events.x.tolist(), events.y.tolist(), strict=True))
    owners, records = slow_run(config, events.ticks.tolist(), places)
    assert told.owner.tolist() == owners
    assert list(zip(*(told.records[name].tolist() for name in FIELDS), strict=True)) == records
    kinds = [record[2] for record in records]
    wanted = [Kind.BORN, Kind.MOVED, Kind.LOST, *([Kind.MERGED] if module == "cot_array" else [])]
    assert all(kinds.count(kind) >= 20 for kind in wanted)


@pytest.mark.parametrize("module", ["cot_array", "cot_chain"])
def test_it_does_not_matter_where_the_events_are_cut(module: Module) -> None:
    config = CotConfig.uniform(SHAPE, SLOT, module=module)
    events = crowd(3000, seed=9)
    whole, model = CotModel(config).feed(events), CotModel(config)
    bounds = [0, 0, 1, 2, 50, 1999, 3000, 3000]
    parts = [model.feed(events[a:b]) for a, b in pairwise(bounds)]
    joined = Decisions(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    assert len(whole.records) > 200
    assert all(np.array_equal(mine, theirs) for mine, theirs in zip(joined, whole, strict=True))
    assert model.time == events.ticks[-1]


def test_records_that_outgrow_their_buffer_are_all_kept() -> None:
    slot = replace(SLOT, clust_nev=1, nev_min=1, max_ticks=1)  # a birth and a loss for every event
    n = 20_000
    told = CotModel(CotConfig.uniform(SHAPE, slot)).feed(ticked(np.arange(n), 32, 32))
    assert len(told.records) == 2 * n - 1
    assert told.records["seq"].tolist() == [0, *np.repeat(np.arange(1, n), 2).tolist()]


def test_addresses_in_the_window_and_0_outside() -> None:
    config = CotConfig.uniform(replace(SHAPE, n_slots=1), SLOT)  # R = 6, a seed in the middle
    told = CotModel(config).feed(ticked(0, [20, 26, 14, 27], [20, 14, 26, 20]))
    assert told.owner.tolist() == [0, 0, 0, -1]
    assert (told.rel_x.tolist(), told.rel_y.tolist()) == ([6, 12, 0, 0], [6, 0, 12, 0])


@pytest.mark.parametrize(("tick_us", "ticks"), [(1, [0, 9, 10, 25]), (10, [0, 0, 1, 2]), (1000, [0, 0, 0, 0])])
def test_ticks_are_whole_and_begin_at_t0(tick_us: int, ticks: list[int]) -> None:
    assert tick_times(np.array([100, 109, 110, 125]), 100, tick_us).tolist() == ticks


class TestTrackLog:
    def test_units_are_pixels_microseconds_and_event_indices(self) -> None:
        raw = np.zeros(3, RECORD)
        raw["kind"], raw["seq"], raw["time"] = [Kind.MERGED, Kind.MOVED, Kind.LOST], [10, 10, 12], [5, 5, 9]
        raw["cm_x"], raw["cm_y"], raw["other_id"], raw["track_id"] = 24, 8, [3, 0, 0], [4, 3, 3]
        config = CotConfig(replace(SHAPE, frac=4), tick_us=100, slots=(SLOT,) * 4)
        out = to_track_records(raw, config, np.array([1_555, 1_599]), first_seq=10, t0_us=1_000)
        assert out.dtype == TRACK
        assert out["t_us"].tolist() == [1_555, 1_555, 1_900]  # an event's own time; a loss at its tick
        assert out["event_index"].tolist() == [10, 10, 12]
        assert (out["x"].tolist(), out["y"].tolist()) == ([1.5] * 3, [0.5] * 3)
        assert out["other_id"].tolist() == [3, -1, -1]

    def test_a_box_is_the_window_and_confidence_is_by_support(self) -> None:
        """A window of radius R holds 2 R + 1 pixels along each axis; a slot is active from `clust_nev` events on."""
        raw = np.zeros(3, RECORD)
        raw["radius"], raw["slot"], raw["support"] = [6, 7, 12], [0, 1, 1], [4, 10, 30]
        slots = replace(SLOT, clust_nev=4), replace(SLOT, clust_nev=10, nev_max=20), SLOT, SLOT
        out = to_track_records(raw, CotConfig(SHAPE, slots), np.zeros(1, np.int64), 0, 0)
        assert out["width"].tolist() == out["height"].tolist() == [13, 15, 25]
        assert out["radius"].tolist() == [6, 7, 12]
        assert out["confidence"].tolist() == [0.5, 0.5, 0.75]
        assert out[["angle", "vx", "vy"]].tolist() == [(0, 0, 0)] * 3

    def recording(self) -> Recording:
        events = crowd(2000, seed=5)
        return Recording(Events(7_000 + events.ticks * 10 + 3, events.x, events.y, events.p), 64, 64)

    def test_tick_0_is_the_first_event(self) -> None:
        recording, config = self.recording(), CotConfig(SHAPE, (SLOT,) * 4, tick_us=10)
        log = track(recording, config)
        t_us = recording.events.t_us
        told = CotModel(config).feed(ticked((t_us - t_us[0]) // 10, recording.events.x, recording.events.y))
        assert log.engine == "cot_array"
        assert np.array_equal(log.owner, told.owner)
        caused = log.records["kind"] != Kind.LOST
        assert np.array_equal(log.records["t_us"][caused], t_us[log.records["event_index"][caused]])
        lost = log.records[~caused]
        assert len(lost) > 5
        assert (lost["t_us"] <= t_us[lost["event_index"]]).all()
        assert (lost["t_us"] > t_us[lost["event_index"] - 1] - 10).all()

    def test_the_module_can_be_a_chain(self) -> None:
        recording, config = self.recording(), CotConfig(SHAPE, (SLOT,) * 4, tick_us=10)
        assert len(track(recording, config).of_kind(Kind.MERGED)) > 0
        chain = track(recording, replace(config, module="cot_chain"))
        assert (chain.engine, len(chain.of_kind(Kind.MERGED))) == ("cot_chain", 0)
        log = track(Recording(Events.empty(), 64, 64), config)
        assert (len(log.records), len(log.owner)) == (0, 0)
        raw = np.zeros(1, RECORD)
        raw["kind"], raw["time"] = Kind.LOST, 7
        lost = to_track_records(raw, replace(config, tick_us=1), np.empty(0, np.int64), 0, 100)
        assert lost["t_us"].tolist() == [107], "a loss needs no event"


WIDE = Shape(n_slots=2, x_w=7, y_w=7)
QUICK = SlotConfig(
    init_radix=6, radix_th=2, radix_step=1, radix_min=4, radix_max=8, hist_avg=1, max_ticks=1_000,
    clust_nev=1, nev_min=1, nev_max=1, detect_ticks=100,
)  # fmt: skip


def model_of(module: Module = "cot_array") -> CotModel:
    return CotModel(CotConfig.uniform(WIDE, QUICK, module=module))


def feed(model: CotModel, *events: tuple[int, int]) -> Decisions:
    ticks, x = np.array(events, np.int64).T
    return model.feed(ticked(ticks, x, 20))


def test_a_life_goes_on_with_the_new_values() -> None:
    model = model_of()
    feed(model, (0, 20))
    assert len(model.write_registers(0, replace(QUICK, radix_max=12, radix_step=4), restart=False)) == 0
    record = feed(model, (1, 27)).records[0]
    assert (Kind(record["kind"]), record["track_id"]) == (Kind.MOVED, 0)
    assert record["radius"] == 5 + 4 + 2  # born with g = 6 less the step of 1; the ring was marked: 4 more


def test_mode_restarts_a_slot_and_a_life_that_was_there_is_lost_now() -> None:
    model = model_of()
    model.write_registers(0, replace(QUICK, mode=Mode.OFF), restart=False)
    assert feed(model, (0, 20), (5, 21)).owner.tolist() == [0, 0], "without a restart mode stays"
    lost = model.write_registers(0, replace(QUICK, mode=Mode.OFF), restart=True)
    assert [(Kind(row["kind"]), int(row["seq"]), int(row["time"])) for row in lost] == [(Kind.LOST, 2, 5)]
    assert feed(model, (6, 21)).owner.tolist() == [1]  # the other slot
    with pytest.raises(ConfigError, match=r"slot\[1\].hist_avg = 9: must be an integer from 0 to 8"):
        model.write_registers(1, replace(QUICK, hist_avg=9), restart=False)


def test_a_deadline_that_is_set_stays_in_an_array_and_moves_in_a_chain() -> None:
    stories: tuple[tuple[Module, int], ...] = (("cot_array", 1_000), ("cot_chain", 30))
    for module, lost_at in stories:
        model = model_of(module)
        feed(model, (0, 20))
        model.write_registers(0, replace(QUICK, max_ticks=30), restart=False)
        records = feed(model, (900, 90), (2_000, 20)).records
        assert records["time"][records["kind"] == Kind.LOST].tolist()[0] == lost_at


def test_where_a_life_starts_is_loaded_when_the_one_before_ends() -> None:
    model = model_of()
    model.write_registers(0, replace(QUICK, init_radix=4, radix_min=4), restart=False)
    first = feed(model, (0, 20)).records[0]
    second = feed(model, (5_000, 20)).records
    assert first["radius"] == 5 + 2  # INIT_CELL was before the change
    assert second["radius"][second["kind"] == Kind.BORN].tolist() == [4 + 2]

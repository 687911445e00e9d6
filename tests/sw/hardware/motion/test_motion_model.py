# SPDX-License-Identifier: Apache-2.0
"""The golden model of the extended contract against a slow one in plain Python, on streams in which objects meet; the
registers of the contract: ranges, contradictions, and the file that sets them."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hardware.config import MotionConfig, with_module
from evcot.hardware.contract import Mode
from evcot.hardware.golden import to_track_records
from evcot.hardware.model import Decisions
from evcot.hardware.motion._kernel import RECORDS_PER_STEP
from evcot.hardware.motion._state import STEP_LOG2
from evcot.hardware.motion.contract import MOTION_RANGES, MOTION_RECORD, MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig, load_toml
from evcot.trackers.presets import PRESETS, fit
from evcot.tracks.log import DROPPED, Kind
from support.logs import Square, bursts
from support.moving import LEAVES, QUICK, SHAPE, VARIANTS, leaves, scene
from support.refusals import refused
from support.slow_motion import SlowArray

FEW_EVENTS = replace(QUICK, birth_support=20, nev_high=10)  # where most events are taken out


def config_of(registers: MotionRegisters, **shape: int) -> MotionConfig:
    return MotionConfig(replace(SHAPE, **shape), registers)


def as_tuples(records: NDArray[np.void]) -> list[tuple[int, ...]]:
    names = (
        "seq", "time", "kind", "track_id", "other_id", "cm_x", "cm_y", "width", "height", "v_x", "v_y", "support", "n_ev",
        "slot",
    )  # fmt: skip
    return list(zip(*(records[name].tolist() for name in names), strict=True))


def assert_equals_slow(
    config: MotionConfig, events: TickedEvents, keep: NDArray[np.bool_] | None = None
) -> tuple[Decisions, SlowArray]:
    """Owner for owner and record for record."""
    model = MotionModel(config)
    decided = model.feed(events, keep)
    shape = config.shape
    slow = SlowArray(config.registers, shape.n_slots, (1 << shape.sup_w) - 1, (1 << shape.id_w) - 1)
    feed_slow(slow, events, keep)
    assert decided.owner.tolist() == slow.owners
    assert model.visible.tolist() == slow.of_tracks
    assert as_tuples(decided.records) == slow.records
    return decided, slow


def feed_slow(slow: SlowArray, events: TickedEvents, keep: NDArray[np.bool_] | None = None) -> None:
    kept = [True] * len(events) if keep is None else keep.tolist()
    for event in zip(events.ticks.tolist(), events.x.tolist(), events.y.tolist(), kept, strict=True):
        slow.event(*event)


@pytest.mark.parametrize("name", VARIANTS)
def test_equals_a_slow_model(name: str) -> None:
    _, slow = assert_equals_slow(config_of(replace(QUICK, **VARIANTS[name])), scene(1))
    assert 0 < sum(slow.of_tracks) < len(slow.of_tracks)
    assert len(slow.records) > 0


def test_what_has_left_is_not_corrected() -> None:
    """It may return in the widest window, until its own deadline, though a correction is due when it has left."""
    config = config_of(LEAVES)
    records = MotionModel(config).feed(leaves(12_000)).records
    found, _ = assert_equals_slow(config, leaves(int(records["time"][records["kind"] == Kind.LOST][0])))
    kinds = found.records["kind"].tolist()
    assert (kinds.count(Kind.BORN), kinds.count(Kind.LOST)) == (1, 1)
    assert found.records["slot"][0] != found.records["slot"][-1], "another slot goes on with the track"


@pytest.mark.parametrize("step_ms", [5, 20, 100, 200])
def test_equals_a_slow_model_where_events_come_in_bursts(step_ms: int) -> None:
    config = fit(PRESETS["motion"], 240, 180, 8).hardware
    assert isinstance(config, MotionConfig)
    squares = [Square(20, 20, 40, 30), Square(150, 100, -40, 10, side=30)]
    assert_equals_slow(config, TickedEvents.of(bursts(step_ms, squares, (240, 180))))


@pytest.mark.parametrize("period", [60, 300, 1_000])
@pytest.mark.parametrize("name", ["quick", "quick turns", "coarse steps", "everything is born", "gaps at once"])
def test_equals_a_slow_model_where_slots_are_corrected_more_than_once_in_a_burst(name: str, period: int) -> None:
    assert_equals_slow(config_of(replace(QUICK, **VARIANTS[name])), scene(5, period=period))


@pytest.mark.parametrize("seed", [3, 4])
def test_equals_a_slow_model_whose_registers_change_while_lives_go_on(seed: int) -> None:
    rng, events = np.random.default_rng(seed), scene(seed)
    model = MotionModel(config_of(QUICK))
    slow = SlowArray(QUICK, SHAPE.n_slots, (1 << SHAPE.sup_w) - 1, (1 << SHAPE.id_w) - 1)
    records = []
    for begin in range(0, len(events), 150):
        part = events[begin : begin + 150]
        records += as_tuples(model.feed(part).records)
        feed_slow(slow, part)
        changed = replace(QUICK, **VARIANTS[str(rng.choice(list(VARIANTS)))])
        model.write_registers(changed)
        slow.write(changed, int(part.ticks[-1]))
    assert records == slow.records
    assert len(records) > 100


def test_the_scenes_show_every_kind_of_record_and_shared_events() -> None:
    """Else the comparison above would not say much."""
    kinds = set()
    for seed in (1, 2):
        for changes in VARIANTS.values():
            kinds |= set(MotionModel(config_of(replace(QUICK, **changes))).feed(scene(seed)).records["kind"].tolist())
    assert kinds == {int(kind) for kind in Kind}


def same(a: Decisions, b: Decisions) -> None:
    for name in Decisions._fields:
        assert np.array_equal(getattr(a, name), getattr(b, name)), name


@pytest.mark.parametrize("cuts", [[1], [3_000], [10, 11, 12, 5_999], list(range(0, 6_000, 7))])
def test_runs_may_be_cut_anywhere(cuts: list[int]) -> None:
    events = scene(3)
    whole = MotionModel(config_of(QUICK)).feed(events)
    model = MotionModel(config_of(QUICK))
    bounds = [0, *cuts, len(events)]
    parts = [model.feed(events[a:b]) for a, b in pairwise(bounds)]
    same(whole, Decisions(*(np.concatenate([getattr(part, name) for part in parts]) for name in Decisions._fields)))


def test_an_event_is_addressed_from_the_middle_of_its_owners_box_in_half_pixels() -> None:
    def addressed(events: TickedEvents) -> tuple[Decisions, NDArray[np.int64]]:
        decided = MotionModel(config_of(QUICK, radix_w=8)).feed(events)
        return decided, (np.stack([decided.rel_x, decided.rel_y]).astype(np.int64) + 512) % 1024 - 512

    # A candidate begins at the first event, and is in force 64 events later. Events move its sides, but not its box.
    x, y = np.array([30] * 65 + [33, 28]), np.array([20] * 65 + [19, 23])
    decided, rel = addressed(TickedEvents(0 * x, x.astype(np.uint16), y.astype(np.uint16), np.zeros(67, np.uint8)))
    assert decided.owner.tolist() == [0] + [-1] * 63 + [0] * 3
    assert rel[:, [0, 64, 65, 66]].T.tolist() == [[0, 0], [0, 0], [6, -2], [-4, 6]]
    decided, rel = addressed(scene(1))
    assert np.abs(rel).max() <= QUICK.side_max + 2 * QUICK.ring_max + 1
    assert not rel[:, decided.owner < 0].any()


@pytest.mark.parametrize("passing", [0.9, 0.3])
def test_dropped_events_have_no_owner_but_advance_time_and_the_count(passing: float) -> None:
    events = scene(2)
    keep = np.random.default_rng(5).random(len(events)) < passing
    keep[-1_000:] = False  # lives end while none is kept
    decided, slow = assert_equals_slow(config_of(FEW_EVENTS), events, keep)
    assert np.array_equal(decided.owner == DROPPED, ~keep)
    assert len(slow.records) > 100


@pytest.mark.parametrize("spare", [1, 2, 7])
def test_a_buffer_of_records_that_is_full_again_and_again_changes_nothing(spare: int, monkeypatch: pytest.MonkeyPatch) -> None:
    events = scene(1)
    keep = np.random.default_rng(spare).random(len(events)) < 0.6
    whole = MotionModel(config_of(FEW_EVENTS)).feed(events, keep)
    monkeypatch.setattr("evcot.hardware.motion.model._SPARE_RECORDS", spare)
    assert len(whole.records) > 10 * (RECORDS_PER_STEP + spare)
    same(MotionModel(config_of(FEW_EVENTS)).feed(events, keep), whole)


def test_a_slot_that_is_off_is_never_used() -> None:
    modes = tuple(Mode.OFF if i in (0, 3) else Mode.SEEDED for i in range(SHAPE.n_slots))
    decided = MotionModel(replace(config_of(QUICK), modes=modes)).feed(scene(1))
    assert set(np.unique(decided.owner)) >= {1, 2}
    assert not np.isin(decided.owner, (0, 3)).any()


def test_writing_mode_ends_a_life_with_a_record() -> None:
    events, model = scene(1), MotionModel(config_of(replace(QUICK, coast_ticks=100_000, life_ticks=100_000)))
    born = model.feed(events).records
    slot = int(born["slot"][born["kind"] == Kind.BORN][-1])
    ended = model.write_mode(slot, Mode.OFF)
    assert ended.dtype == MOTION_RECORD
    assert ended["kind"].tolist() in ([Kind.LOST], [])
    assert len(model.write_mode(slot, Mode.OFF)) == 0
    with pytest.raises(ConfigError, match=r"^slot\[1\].mode = 1: must be 0 \(off\) or 2 \(seeded\)$"):
        model.write_mode(1, Mode.FIXED)


def test_a_fixed_start_and_a_chain_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"^motion.modes\[0\] = 1: must be 0 \(off\) or 2 \(seeded\)$"):
        replace(config_of(QUICK), modes=(Mode.FIXED,) * SHAPE.n_slots)
    with pytest.raises(ConfigError, match=r"^hardware = 'cot_chain': these registers are those of cot_motion$"):
        with_module(config_of(QUICK), "cot_chain")


def test_records_in_pixels_and_seconds() -> None:
    raw = np.zeros(1, MOTION_RECORD)
    raw["cm_x"], raw["cm_y"], raw["width"], raw["height"] = 10 << 12, -4096, 32 << 12, 16 << 12
    raw["v_x"], raw["v_y"], raw["time"], raw["support"] = 2048, -4096, 5, 30
    config = replace(config_of(replace(QUICK, side_share=4)), tick_us=10)
    (record,) = to_track_records(raw, config, np.array([999]), 0, 1_000)
    assert (record["x"], record["y"], record["t_us"]) == (10.0, -1.0, 1_050)
    assert (record["width"], record["height"], record["radius"]) == (35.0, 18.0, 17.5)
    assert (record["vx"], record["vy"]) == (1562.5, -3125.0)  # of 320 us a step
    assert record["confidence"] == 0.5


NAMES = [field.name for field in fields(MotionRegisters)]


def registers_of(config: RunConfig) -> MotionRegisters:
    assert isinstance(config.hardware, MotionConfig)
    return config.hardware.registers


def test_every_register_has_a_range() -> None:
    assert list(MOTION_RANGES) == NAMES
    assert NAMES[STEP_LOG2] == "step_log2"


@pytest.mark.parametrize("name", NAMES)
def test_a_value_outside_its_range_is_named(name: str) -> None:
    low, high, meaning = MOTION_RANGES[name]
    for value in (int(low) - 1, int(high) + 1, 1.5, True):
        changes: dict[str, Any] = {name: value}
        with refused(ConfigError, f"motion.{name} = {value!r}: must be an integer from {low} to {high} ({meaning})"):
            replace(MotionRegisters(), **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"nev_low": 20, "nev_high": 10}, "motion.nev_low = 20: must be at most nev_high = 10"),
        ({"ring_px": 9, "ring_max": 8}, "motion.ring_px = 9: must be at most ring_max = 8"),
        ({"life_ticks": 9, "coast_ticks": 8}, "motion.life_ticks = 9: must be at most coast_ticks = 8"),
        ({"seed_px": 9, "side_max": 17}, "motion.seed_px = 9: must be at most half of side_max = 17"),
    ],
)
def test_contradictions_are_refused_and_values_at_their_limit_taken(changes: dict[str, int], message: str) -> None:
    with refused(ConfigError, message):
        MotionRegisters(**changes)
    MotionRegisters(nev_low=20, nev_high=20, ring_px=8, ring_max=8, life_ticks=9, coast_ticks=9, seed_px=9, side_max=18)


def test_a_file_sets_them(tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text('hardware = "cot_motion"\n[motion]\nside_max = 90\n', encoding="utf-8")
    base = PRESETS["motion"]
    assert registers_of(load_toml(path, base)) == replace(registers_of(base), side_max=90)
    assert registers_of(load_toml(path, PRESETS["davis346"])) == MotionRegisters(side_max=90), "no registers of it before"
    path.write_text("[motion]\nside = 90\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"\[motion\]: unknown field 'side'"):
        load_toml(path, base)


def test_the_preset_keeps_them_on_any_sensor() -> None:
    motion = PRESETS["motion"]
    assert motion.hardware.module == "cot_motion"
    assert registers_of(fit(motion, 640, 480, 4)) == registers_of(motion)
    hardware = {name: PRESETS[name].to_dict()["hardware"] for name in ("motion", "traffic")}
    assert [("registers" in values, "slots" in values) for values in hardware.values()] == [(True, False), (False, True)]

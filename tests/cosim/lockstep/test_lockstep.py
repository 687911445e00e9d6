# SPDX-License-Identifier: Apache-2.0
"""Lock-step: it agrees on the real RTL, and names event, field and values on RTL that was broken on purpose."""

from __future__ import annotations

import json
import pickle
import threading
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

import evcot
import evcot_cosim
from evcot.errors import EvcotError
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, SlotConfig, with_module
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.modules import Module
from evcot.recordings.files import read_recording
from evcot.scenes.registry import SCENES, simulate_scene
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.lockstep import CHUNK, Lockstep, Step, chunks, cut, dump_window
from evcot_cosim.lockstep.mismatch import MismatchError
from support.full_disk import full_disk
from support.testing import broken_copy
from support.trials import random_traffic

SHAPE = Shape(n_slots=2, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20, tick_w=3)
# Windows of 13 x 13 pixels, born with their first event, always at their last one.
JUMPY = SlotConfig(
    init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=31, hist_avg=0,
    max_ticks=1000, clust_nev=1, nev_min=1, nev_max=8, nev_th=4000, detect_ticks=100,
)  # fmt: skip
CONFIG = CotConfig.uniform(SHAPE, JUMPY)
LIVELY = CotConfig.uniform(SHAPE, replace(JUMPY, max_ticks=30))


def at(*events: tuple[int, int]) -> Events:
    """Events (tick, x) on the line y = 64, half a second after the clock's zero."""
    t_us, x = np.array(events, np.int64).T
    n = len(x)
    return Events(t_us + 500_000, x.astype(np.uint16), np.full(n, 64, np.uint16), np.zeros(n, np.uint8))


def busy(n: int, seed: int = 1, tick_us: int = 1) -> Events:
    """Random traffic as a recording has it."""
    traffic = random_traffic(np.random.default_rng(seed), SHAPE, n, 1)
    return Events(500_000 + traffic.ticks * tick_us, traffic.x, traffic.y, traffic.p)


def zeros(n: int) -> Events:
    """As many events at once, all in one corner."""
    return Events(np.zeros(n, np.int64), np.zeros(n, np.uint16), np.zeros(n, np.uint16), np.zeros(n, np.uint8))


def run_all(lockstep: Lockstep, runs: Iterator[Events]) -> None:
    for run in runs:
        lockstep.feed(run)


class TestAgreement:
    @pytest.mark.parametrize("top", ["cot", "cot_chain", "cot_array"])
    def test_the_rtl_is_the_model(self, top: Module) -> None:
        config = with_module(LIVELY, top)
        events = busy(5000)
        with Lockstep(config, stalls=Stalls.random(np.random.default_rng(1))) as lockstep:
            steps = [lockstep.feed(run) for run in chunks(events, 700)]
        assert lockstep.events == 5000
        assert lockstep.records == sum(len(step.hardware.records) for step in steps) > 1000
        assert lockstep.wall_s > 0
        for step in steps:
            assert step.model is not None
            assert np.array_equal(step.hardware.records, step.model.records)
            assert np.array_equal(step.hardware.owner, step.model.owner)

    def test_without_checking_the_hardware_runs_alone(self) -> None:
        with Lockstep(LIVELY, check=False) as lockstep:
            step = lockstep.feed(busy(500))
        assert step.model is None
        assert len(step.hardware.owner) == 500

    def test_tick_0_is_the_first_event_and_ticks_are_whole(self) -> None:
        config = replace(LIVELY, tick_us=10)
        with Lockstep(config) as lockstep:
            step = lockstep.feed(at((3, 64), (12, 64), (13, 64), (22, 64), (23, 64)))
        assert step.hardware.records["time"].tolist() == [0, 0, 1, 1, 2]

    def test_close_ends_the_second_thread(self) -> None:
        before = threading.active_count()
        with Lockstep(LIVELY) as lockstep:
            lockstep.feed(busy(10))
            assert threading.active_count() == before + 1
        assert threading.active_count() == before


class TestChunks:
    def test_they_cover_everything_in_order_without_copies(self) -> None:
        events = busy(25)
        parts = list(chunks(events, 10))
        assert [len(part) for part in parts] == [10, 10, 5]
        assert np.array_equal(np.concatenate([part.t_us for part in parts]), events.t_us)
        assert all(np.shares_memory(part.x, events.x) for part in parts)

    def test_by_default_they_bound_memory(self) -> None:
        events = zeros(CHUNK + 1)
        assert [len(part) for part in chunks(events)] == [CHUNK, 1]
        assert list(chunks(Events.empty())) == []


class TestMismatch:
    @pytest.mark.parametrize(
        ("file", "right", "wrong", "events", "expected"),
        [
            # An event on the window's last column passes.
            (
                "array_match.v",
                "{1'b0, m_lo_x_not} + 1'b1;",
                "{1'b0, m_lo_x_not};",
                at((0, 20), (5, 64), (7, 64), (9, 70)),
                (3, 9, "owner", -1, 1),
            ),
            (
                "array_update.v",
                "assign v_rel_x = rel_x[RADIX_W+1:0];",
                "assign v_rel_x = rel_x[RADIX_W+1:0] + (seq == 2);",
                at((0, 64), (5, 65), (7, 66)),
                (2, 7, "rel_x", 8, 7),
            ),
            (
                "array_update.v",
                "m_cm_support <= w_support[SUP_W-1:0] | {SUP_W{w_support[SUP_W]}};",
                "m_cm_support <= w_support[SUP_W-1:0] - 1'b1;",
                at((0, 64), (5, 65)),
                (0, 0, "record.support", 0, 1),
            ),
            (
                "array_update.v",
                "w_reports <= v_last || v_join || v_report;",
                "w_reports <= v_last || v_join;",
                at((0, 64), (5, 65), (2000, 20)),
                (2, 2000, "record.time", 2000, 1005),
            ),
            # The second run has a record less than it should.
            (
                "array_update.v",
                "w_reports <= v_last || v_join || v_report;",
                "w_reports <= (v_last && seq != 3) || v_join || v_report;",
                at((0, 64), (5, 65), (6, 66), (7, 67)),
                (3, 7, "records", "1 records", "2 records"),
            ),
            (
                "array_output.v",
                "if (s_valid) begin",
                "if (s_valid && s_seq != 3) begin",
                at((0, 20), (0, 60), (1, 100), (8, 100)),
                (3, 8, "stream", "cot_array lost event 3 (clock ", "in order"),
            ),
        ],
        ids=["owner", "address", "record", "missing loss", "missing record", "stream"],
    )
    def test_the_first_difference_is_named(
        self, tmp_path: Path, file: str, right: str, wrong: str, events: Events, expected: tuple[int, int, str, object, object]
    ) -> None:
        verilog = broken_copy(tmp_path / "rtl", file, right, wrong)
        model = build_device(CONFIG, waves=False, verilog=verilog)
        with Lockstep(CONFIG, model=model, seed=5) as lockstep, pytest.raises(MismatchError) as caught:
            run_all(lockstep, chunks(events, 2))  # the event's index counts from the first run
        found = caught.value.mismatch
        event_index, tick, field, hardware, model = expected
        assert (found.event_index, found.tick, found.field, found.model) == (event_index, tick, field, model)
        if field == "stream":
            assert str(found.hardware).startswith(str(hardware))
        else:
            assert found.hardware == hardware
            assert str(caught.value) == (
                f"cot_array: event {event_index}, tick {tick}: {field}: hardware has {hardware}, model has {model}"
            )
        assert (found.seed, found.config) == (5, CONFIG)
        assert isinstance(caught.value, EvcotError)

    def test_its_record_repeats_the_run(self, tmp_path: Path) -> None:
        right = "m_cm_support <= w_support[SUP_W-1:0] | {SUP_W{w_support[SUP_W]}};"
        verilog = broken_copy(tmp_path / "rtl", "array_update.v", right, right.replace(" | ", " - 1'b1 | "))
        model = build_device(CONFIG, waves=False, verilog=verilog)
        with Lockstep(CONFIG, model=model, seed=5) as lockstep, pytest.raises(MismatchError) as caught:
            lockstep.feed(at((0, 64)))
        stored = json.loads(json.dumps(asdict(caught.value.mismatch)))
        config = stored.pop("config")
        assert stored == {
            "event_index": 0, "tick": 0, "field": "record.support", "hardware": 0, "model": 1, "seed": 5
        }  # fmt: skip
        slots = tuple(SlotConfig(**slot) for slot in config["slots"])
        assert CotConfig(Shape(**config["shape"]), slots, config["tick_us"], module=config["module"]) == CONFIG

    def test_a_broken_chain_is_found_too(self, tmp_path: Path) -> None:
        verilog = broken_copy(
            tmp_path / "rtl",
            "cot_axis.v",
            "!wide_rel[REL_W-1] &&",
            "!wide_rel[REL_W-1] && |wide_rel &&",
        )
        config = replace(CONFIG, module="cot_chain")
        model = build_device(config, waves=False, verilog=verilog)
        with (
            Lockstep(config, model=model) as lockstep,
            pytest.raises(MismatchError, match=r"event 1, tick 3: owner: hardware has 1, model has 0"),
        ):
            lockstep.feed(at((0, 64), (3, 58)))


def test_blocks_of_any_length_are_cut_into_chunks_of_one() -> None:
    events = busy(40)
    blocks = [events[begin:end] for begin, end in ((0, 3), (3, 3), (3, 7), (7, 30), (30, 31), (31, 40))]
    found = list(cut(blocks, 8))
    assert [len(chunk) for chunk in found] == [8] * 5
    assert [len(chunk) for chunk in cut(blocks[:4], 8)] == [8, 8, 8, 6]
    assert np.array_equal(np.concatenate([chunk.t_us for chunk in found]), events.t_us)
    assert list(cut([], 8)) == []


class TestDumpWindow:
    def test_it_stops_with_the_window(self, tmp_path: Path) -> None:
        seen: list[int] = []
        dump_window(zeros(3 * CHUNK), LIVELY, tmp_path / "w.vcd", 5, 6, progress=seen.append)
        assert seen == [CHUNK]

    def test_a_fault_of_the_hardware_is_what_it_shows(self, tmp_path: Path) -> None:
        verilog = broken_copy(tmp_path / "rtl", "array_output.v", "if (s_valid) begin", "if (s_valid && s_owned) begin")
        config = CotConfig.uniform(SHAPE, replace(JUMPY, mode=Mode.OFF))
        dump_window(busy(50), config, tmp_path / "w.vcd", 0, 40, model=build_device(config, verilog=verilog))
        assert (tmp_path / "w.vcd").stat().st_size > 1000


def test_every_kind_of_record_is_compared() -> None:
    with Lockstep(LIVELY) as lockstep:
        step = lockstep.feed(busy(20_000))
    assert set(step.hardware.records["kind"]) == set(Kind)


DATA = Path(__file__).parents[4] / "shared" / "data"
RECORDINGS = ["traffic_outbound.aedat4", "hand_dvs128.aedat4", "pendulum_dvs128.aedat"]


def check(recording: evcot.Recording) -> None:
    run = evcot_cosim.cosim(recording)
    log = evcot.track(recording)
    for hardware in (run.hardware, run.model):
        assert hardware.records.tobytes() == log.records.tobytes()
        assert hardware.owner.tobytes() == log.owner.tobytes()
    assert len(log.records)
    assert np.any(log.owner >= 0)


@pytest.mark.parametrize("scene", SCENES)
def test_on_a_scene(scene: str) -> None:
    check(simulate_scene(scene, 4711, {"duration_us": 600_000}).recording)


@pytest.mark.parametrize("name", RECORDINGS)
def test_on_a_recording(name: str) -> None:
    if not (DATA / name).is_file():
        pytest.skip(f"{name} is not here")
    check(read_recording(DATA / name))


FILTERS = FilterConfig(refractory_us=20, activity_us=200)
FILTERED = replace(LIVELY, filters=FILTERS.registers(1), filter_shape=FILTERS.shape(128, 128))


def same(one: Step, other: Step) -> bool:
    return all(np.array_equal(*pair) for pair in zip(one.hardware, other.hardware, strict=True))


@pytest.mark.parametrize(("config", "seed"), [(LIVELY, None), (FILTERED, 5)], ids=["plain", "filtered and stalled"])
def test_a_restored_run_is_the_unbroken_one(config: CotConfig, seed: int | None) -> None:
    def started() -> Lockstep:
        stalls = None if seed is None else Stalls.random(np.random.default_rng(seed))
        return Lockstep(config, stalls=stalls, seed=seed, model=build_device(config, waves=False, savable=True))

    parts = list(chunks(busy(6_000, 3), 1_000))
    with started() as unbroken, started() as first, started() as second:
        wanted = [unbroken.feed(part) for part in parts]
        assert sum(len(step.hardware.records) for step in wanted[3:]) > 100
        for part in parts[:3]:
            first.feed(part)
        second.feed(parts[0])  # whatever it did before is forgotten
        second.restore(pickle.loads(pickle.dumps(first.state())))
        assert all(same(second.feed(part), step) for part, step in zip(parts[3:], wanted[3:], strict=True))
        assert second.device.cycle == unbroken.device.cycle
        assert (second.events, second.records) == (unbroken.events, unbroken.records)
        assert np.array_equal(second.latency, unbroken.latency)


def test_state_is_saved_in_memory_where_no_file_can_be_written() -> None:
    """Verilator's own writer ends the process on a full disk."""
    with Lockstep(LIVELY, model=build_device(LIVELY, waves=False, savable=True)) as lockstep:
        with full_disk(0):
            lockstep.restore(lockstep.state())
        assert len(lockstep.feed(busy(1_000, 3)).hardware.owner) == 1_000

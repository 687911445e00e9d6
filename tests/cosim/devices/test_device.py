# SPDX-License-Identifier: Apache-2.0
"""The simulated hardware as an object: streaming and interactive drive, faults, waveforms, memory; rows of ports; long gaps."""

from __future__ import annotations

import errno
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.errors import ConfigError, OutputError, RecordingError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import RECORD, Mode, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.golden import GoldenTracker, golden_model
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, preset, run_config
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import (
    SILENT_CLOCKS_MAX,
    HardwareError,
    Stalls,
    check_addresses,
    check_silence,
    check_waits,
)
from evcot_cosim.devices.device import Device, build_device, order_of
from evcot_cosim.devices.published_device import Top, rtl, simulation
from evcot_cosim.devices.tracker import DeviceTracker
from evcot_cosim.lockstep.cosim import run_cosim
from evcot_cosim.lockstep.lockstep import Lockstep
from evcot_cosim.lockstep.random_runs import Design, random_case, random_outlines, run_case
from evcot_cosim.rtl import build as building
from evcot_cosim.waves.vcd import parse
from support.filter_trials import FilterDevice
from support.full_disk import full_disk
from support.testing import PATTERNS, Sink, Source, broken_copy, run_streams
from support.tokens import ticked
from support.trials import bare_device, random_traffic

SHAPE = Shape(n_slots=2, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20, tick_w=3)
SLOT = SlotConfig(
    init_radix=5, radix_th=2, radix_min=4, radix_max=9, hist_avg=1, max_ticks=60,
    clust_nev=2, nev_min=1, nev_max=4, nev_th=2, detect_ticks=30,
)  # fmt: skip
TOPS: tuple[Module, ...] = ("cot", "cot_chain", "cot_array")
PATHS = [str(Path(__file__).parent), str(Path(__file__).parents[2])]  # for a process that imports this module


def config_of(top: Module, slot: SlotConfig = SLOT) -> CotConfig:
    return CotConfig.uniform(replace(SHAPE, n_slots=1) if top == "cot" else SHAPE, slot, module=top)


def traffic(n: int, seed: int = 1) -> TickedEvents:
    return random_traffic(np.random.default_rng(seed), SHAPE, n, 1)


def same(a: Decisions, b: Decisions) -> bool:
    return all(np.array_equal(mine, theirs) for mine, theirs in zip(a, b, strict=True))


def joined(parts: list[Decisions]) -> Decisions:
    return Decisions(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def cut(events: TickedEvents, *places: int) -> list[TickedEvents]:
    return [events[a:b] for a, b in pairwise([0, *places, len(events)])]


class TestStalls:
    @pytest.mark.parametrize("stream", ["source", "cm", "own", "passed"])
    def test_a_pattern_must_go_at_some_time(self, stream: str) -> None:
        with pytest.raises(ConfigError, match=rf"stalls\.{stream}: never goes"):
            Stalls(**{stream: np.zeros(5, np.uint8)})

    def test_random_patterns_come_from_the_seed_and_differ_in_length(self) -> None:
        one, again = Stalls.random(np.random.default_rng(3)), Stalls.random(np.random.default_rng(3))
        patterns = [one.source, one.cm, one.own, one.passed]
        assert all(
            np.array_equal(a, b) for a, b in zip(patterns, [again.source, again.cm, again.own, again.passed], strict=True)
        )
        assert len({len(pattern) for pattern in patterns}) == 4

    def test_a_seed_makes_the_same_patterns_again_and_none_stalls_nothing(self) -> None:
        assert len(Stalls.seeded(None).source) == 0
        assert np.array_equal(Stalls.seeded(1).source, Stalls.seeded(1).source)

    def test_how_often_each_stream_goes_can_be_chosen(self) -> None:
        stalls = Stalls.random(np.random.default_rng(3), (0.1, 0.9, 0.5, 1.0))
        shares = [pattern.mean() for pattern in (stalls.source, stalls.cm, stalls.own, stalls.passed)]
        assert shares == pytest.approx([0.1, 0.9, 0.5, 1.0], abs=0.03)

    def test_a_stalled_stream_takes_longer_and_decides_the_same(self) -> None:
        free, slow = (
            bare_device(config_of("cot_array")),
            bare_device(config_of("cot_array"), stalls=Stalls(own=np.array([1] + [0] * 39))),
        )
        events = traffic(2000)
        assert same(free.stream(events), slow.stream(events))
        assert slow.cycle > 2 * free.cycle


class TestStream:
    @pytest.mark.parametrize("top", TOPS)
    def test_it_does_not_matter_where_the_events_are_cut(self, top: Module) -> None:
        events = traffic(3000)
        whole = bare_device(config_of(top)).stream(events)
        pieces = bare_device(config_of(top))
        parts = [pieces.stream(part) for part in cut(events, 0, 1, 2, 1700, 1700, 2999)]
        assert len(whole.records) > 300
        assert same(joined(parts), whole)

    def test_no_events_are_no_decisions(self) -> None:
        device = bare_device(config_of("cot_array"))
        assert [len(column) for column in device.stream(cut(traffic(5), 0)[0])] == [0, 0, 0, 0]
        assert (device.seq, device.now) == (0, 0)

    def test_more_records_than_events_by_far_are_all_kept(self) -> None:
        slot = replace(SLOT, clust_nev=1, nev_max=1, max_ticks=1)  # a birth and a loss for every event
        n = 20_000
        events = ticked(np.arange(n), 64, 64)
        result = bare_device(config_of("cot_array", slot)).stream(events)
        assert len(result.records) == 2 * n - 1
        assert same(result, CotModel(config_of("cot_array", slot)).feed(events))

    @pytest.mark.parametrize("top", TOPS)
    def test_numbers_and_times_are_whole_however_narrow_the_hardware_counts(self, top: Module) -> None:
        config = config_of(top)
        narrow = replace(config, shape=replace(config.shape, seq_w=8, time_w=18))
        events = replace(traffic(20_000), ticks=np.arange(20_000) * 14)
        result = bare_device(narrow, stalls=Stalls.random(np.random.default_rng(2))).stream(events)
        assert result.records["seq"].max() > 2**8
        assert result.records["time"].max() > 2**18
        assert same(result, CotModel(narrow).feed(events))

    def test_reset_begins_again(self) -> None:
        device = bare_device(config_of("cot_array"))
        first = device.stream(traffic(1000))
        device.reset()
        assert (device.seq, device.now, device.cycle) == (0, 0, 0)
        assert same(device.stream(traffic(1000)), first)

    def test_events_in_microseconds_are_counted_from_the_first_since_reset(self) -> None:
        ticks = traffic(2000)
        events = Events(987_654 + ticks.ticks * 10, ticks.x, ticks.y, ticks.p)
        config = replace(config_of("cot_array"), tick_us=10)
        wanted = bare_device(config).stream(replace(ticks, ticks=ticks.ticks - ticks.ticks[0]))
        assert wanted.records["time"].max() > 1000
        device = bare_device(config)
        assert same(joined([device.stream(events[:700]), device.stream(events[700:])]), wanted)
        device.reset()
        assert same(device.stream(events[:0]), bare_device(config).stream(ticks[:0]))
        told, _ = device.stream_timed(events)
        assert same(told, wanted)

    def test_time_that_runs_back_is_refused_before_anything_is_driven(self) -> None:
        device = bare_device(config_of("cot_array"))
        device.stream(ticked([0, 5], 20, 20))
        for ticks, message in (([4], "event 2: tick 4 follows tick 5"), ([5, 9, 8, 7], "event 4: tick 8 follows tick 9")):
            with pytest.raises(RecordingError, match=f"^{message}: time must not run back$"):
                device.stream(ticked(ticks, 20, 20))
        assert (device.now, device.seq) == (5, 2)
        assert len(device.stream(ticked([5, 5], 20, 20)).owner) == 2

    def test_a_mask_of_another_length_is_refused(self) -> None:
        device = bare_device(config_of("cot_array"))
        with pytest.raises(RecordingError, match=r"^keep holds 3 values: must be one for each of 2 events$"):
            device.stream(ticked([0, 5], 20, 20), np.ones(3, np.bool_))

    def test_two_devices_share_nothing(self) -> None:
        one, other = bare_device(config_of("cot_array")), bare_device(config_of("cot_array", replace(SLOT, mode=Mode.OFF)))
        parts = cut(traffic(2000), 1000)
        first = one.stream(parts[0])
        assert not len(other.stream(parts[0]).records)
        assert same(joined([first, one.stream(parts[1])]), bare_device(config_of("cot_array")).stream(traffic(2000)))

    @pytest.mark.parametrize("top", TOPS)
    def test_timing_changes_nothing(self, top: Module) -> None:
        events = traffic(2000)
        result, times = bare_device(config_of(top)).stream_timed(events)
        assert same(result, bare_device(config_of(top)).stream(events))
        assert (np.diff(times.accepted) > 0).all()
        assert len(times.recorded) == len(result.records)
        caused = result.records["kind"] != Kind.LOST
        seq = result.records["seq"].astype(np.int64)
        assert (times.recorded[caused] > times.accepted[seq[caused]]).all()

    def test_a_chain_tells_in_order_what_its_trackers_tell_as_it_comes(self) -> None:
        records = np.zeros(5, RECORD)
        records["seq"], records["time"] = [4, 4, 4, 3, 4], [9, 8, 8, 7, 12]
        records["kind"] = [Kind.LOST, Kind.LOST, Kind.LOST, Kind.MOVED, Kind.BORN]
        records["slot"] = [0, 2, 1, 1, 0]
        assert order_of(records).tolist() == [3, 2, 1, 0, 4]


@pytest.mark.parametrize("top", TOPS)
def test_writes_of_a_slot_in_a_row_are_finished_one_after_the_other(top: Module) -> None:
    """Of the first write only what it ends is left; its restart does not mix with the registers of the second."""
    rng, config = np.random.default_rng(8), config_of(top)
    device, model, ended = bare_device(config), CotModel(config), 0
    for part in cut(traffic(3_000, 9), *range(100, 3_000, 100)):
        said = []
        for _ in range(int(rng.integers(1, 5))):
            slot, radix, mode = (int(rng.integers(low, high)) for low, high in ((0, config.shape.n_slots), (4, 12), (0, 3)))
            registers = replace(SLOT, mode=mode, init_radix=radix, init_cm_x=radix * 9, radix_max=12)
            device.write_registers(slot, registers)
            said.append(model.write_registers(slot, registers, restart=True))
        found, wanted = device.stream(part), model.feed(part)
        ended += sum(map(len, said))
        assert same(found, wanted._replace(records=np.concatenate([*said, wanted.records])))
    assert ended > 5


def test_a_single_tracker_has_one_slot() -> None:
    with pytest.raises(ConfigError, match=r"shape\.n_slots = 2: must be 1 for a single tracker"):
        replace(config_of("cot_array"), module="cot")


def interactive(device: Device, events: TickedEvents, pattern: str) -> Decisions:
    """The same events poked in and their decisions peeked out, port by port, clock by clock."""
    rng = np.random.default_rng(9)
    single = device.config.module == "cot"
    slot = [] if single else ["slot"]
    tick_max = (1 << device.shape.tick_w) - 1
    tokens: list[tuple[int, ...]] = []
    columns = (np.diff(events.ticks, prepend=0).tolist(), events.x, events.y, events.p)
    for seq, (wait, x, y, p) in enumerate(zip(*columns, strict=True)):
        seq_word = [seq] if single else []
        tokens += [(tick_max, 0, 0, 0, 0, *seq_word)] * (max(wait - 1, 0) // tick_max)
        tokens += [(wait - max(wait - 1, 0) // tick_max * tick_max, 1, int(x), int(y), int(p), *seq_word)]
    go: Callable[[], Any] = lambda: PATTERNS[pattern](rng)  # noqa: E731
    sim = device.sim
    fields = ["seq", "time", "id", "x", "y", "support", "radius", "n_ev", "kind", *(["other"] if slot else []), *slot]
    source = Source(sim, "s", ["tick", "event", "x", "y", "p", *(["seq"] if single else [])], tokens, go(), rng)
    cm = Sink(sim, "m_cm", fields, go())
    own = Sink(sim, "m_own", ["seq", "x", "y", "p", *slot], go())
    passed = Sink(sim, "m_pass", ["seq", "x", "y", "p", *(["event"] if single else [])], go())
    run_streams(sim, [source], [cm, own, passed], quiet_clocks=60)

    records = np.zeros(len(cm.words), RECORD)
    names = {"id": "track_id", "x": "cm_x", "y": "cm_y", "other": "other_id"}
    for field, values in zip(fields, zip(*cm.words, strict=True), strict=True):
        records[names.get(field, field)] = values
    n = len(events)
    owner, rel_x, rel_y = np.full(n, -1, np.int16), np.zeros(n, np.uint16), np.zeros(n, np.uint16)
    for seq, x, y, p, *which in own.words:
        assert p == events.p[seq]
        owner[seq], rel_x[seq], rel_y[seq] = (which or [0])[0], x, y
    through = [word for word in passed.words if not single or word[4]]
    left = np.flatnonzero(owner == -1)
    assert [word[:4] for word in through] == [(int(i), int(events.x[i]), int(events.y[i]), int(events.p[i])) for i in left]
    return Decisions(records[order_of(records)] if device.config.module == "cot_chain" else records, owner, rel_x, rel_y)


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("top", TOPS)
def test_interactive_and_streaming_drive_give_the_same(top: Module, pattern: str) -> None:
    events = traffic(300, seed=5)
    streamed = bare_device(config_of(top)).stream(events)
    assert set(streamed.records["kind"]) >= {Kind.BORN, Kind.MOVED, Kind.LOST}
    assert same(interactive(bare_device(config_of(top)), events, pattern), streamed)


class TestFaults:
    @pytest.mark.parametrize(
        ("file", "right", "wrong", "message", "seq"),
        [
            ("array_output.v", "if (s_valid) begin", "if (s_valid && s_seq != 7) begin", "lost event 7", 7),
            ("array_output.v", "<= s_seq;", "<= s_seq - (s_seq == 5);", "gave twice, or out of order, owned event 4", 4),
            ("array_output.v", "in_y, s_p};", "in_y, s_p ^ (s_seq == 3)};", "changed the polarity of owned event 3", 3),
            ("array_output.v", "s_x};", "s_x} + 1'b1;", "changed the address or polarity of passed event 7", 7),
            ("array_output.v", "<= s_seq;", "<= s_seq + (s_owned ? 0 : 9);", "gave twice, or out of order, passed event", None),
            ("array_input.v", "s_ready <= !level[4] &&", "s_ready <= !written[3] &&", "stands still", 9),
            ("array_update.v", "if (m_cm_ready) m_cm_valid <= 1'b0;", "", "sends more records than 14 events can cause", None),
        ],
        ids=["lost", "repeated", "polarity", "address", "unknown", "stuck", "endless"],
    )
    def test_each_is_named_with_the_event(
        self, tmp_path: Path, file: str, right: str, wrong: str, message: str, seq: int | None
    ) -> None:
        verilog = broken_copy(tmp_path, file, right, wrong)
        config = CotConfig.uniform(SHAPE, replace(SLOT, mode=Mode.FIXED, init_cm_x=64, init_cm_y=64))
        x = [64] * 7 + [0] * 7
        with pytest.raises(HardwareError, match=f"cot_array {message}") as caught:
            bare_device(config, verilog=verilog).stream(ticked(np.arange(14), x, x))
        if seq is not None:
            assert caught.value.seq == seq


def test_a_model_that_more_than_the_clock_triggers_is_evaluated_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a Verilator that leaves signals of the filters in a circle."""
    monkeypatch.setattr(building, "_VERILATOR_FLAGS", (*building._VERILATOR_FLAGS, "-fno-dfg"))
    monkeypatch.setitem(building._DESIGN_FLAGS, "-fno-dfg", 0)  # the compiled runtime is that of all models
    filters = FilterConfig(refractory_us=2)
    config = replace(config_of("cot_array"), filters=filters.registers(1), filter_shape=filters.shape(128, 128))
    device, events = Device(config), traffic(1000)
    assert same(device.stream(events), golden_model(config).feed(events))


class TestDumping:
    def test_the_file_holds_the_clocks_of_the_window_alone(self, tmp_path: Path) -> None:
        events = traffic(400)
        device = bare_device(config_of("cot_array"), stalls=Stalls.random(np.random.default_rng(1)))
        with device.dumping(tmp_path / "w.vcd", 10, 20):
            result, times = device.stream_timed(events)
            assert not (tmp_path / "w.vcd").exists()  # it appears when it is whole
        assert [path.name for path in tmp_path.iterdir()] == ["w.vcd"]
        wave = parse(tmp_path / "w.vcd")
        clock = next(name for name in wave.signals if name.endswith("cot_array.clk"))
        changes = [time for time, _ in wave[clock].tv]
        first, last = 10 * (times.accepted[9] + 1), 10 * times.accepted[20] + 5
        assert changes == list(range(first, last + 1, 5))  # rising edges at 5, 15, 25 …
        assert same(result, bare_device(config_of("cot_array")).stream(events))

    def test_nothing_is_dumped_after_the_block(self, tmp_path: Path) -> None:
        device = bare_device(config_of("cot_array"))
        parts = cut(traffic(200), 100)
        with device.dumping(tmp_path / "w.vcd"):
            device.stream(parts[0])
        size = (tmp_path / "w.vcd").stat().st_size
        device.stream(parts[1])
        assert (tmp_path / "w.vcd").stat().st_size == size

    def test_a_folder_that_is_not_there(self, tmp_path: Path) -> None:
        device = bare_device(config_of("cot_array"))
        path = tmp_path / "absent" / "w.vcd"
        with pytest.raises(OutputError, match=r"absent/w\.vcd: cannot be written: No such file"), device.dumping(path):
            pytest.fail("the block must not run")
        assert len(device.stream(traffic(50)).owner) == 50

    @pytest.mark.parametrize("room", [0, 200_000])  # of the declarations alone, of changes
    def test_a_full_disk_leaves_no_file_and_the_stream_goes_on(self, room: int, tmp_path: Path) -> None:
        device = Device(config_of("cot_array"))
        too_large = pytest.raises(OutputError, match=r"w\.vcd: cannot be written: File too large$")
        with full_disk(room), too_large as said, device.dumping(tmp_path / "w.vcd"):
            assert room
            assert len(device.stream(traffic(5000)).owner) == 5000
        assert isinstance(said.value.__cause__, OSError)
        assert said.value.__cause__.errno == errno.EFBIG
        assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not tell a process's memory this way")
def test_memory_does_not_grow_with_the_stream() -> None:
    script = f"""
import sys
sys.path[:0] = {PATHS!r}
import test_device as t
from pathlib import Path
def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096
device = t.bare_device(t.config_of("cot_array"))
events = t.traffic(50_000)
sizes = []
for _ in range(20):
    device.stream(t.replace(events, ticks=events.ticks + device.now))
    sizes.append(resident())
print(device.seq, sizes[-1] - sizes[4])
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    events, growth = map(int, done.stdout.split())
    assert events == 1_000_000
    assert growth < 1_000_000  # one byte per event would show


def test_a_configuration_of_another_kind_is_refused_in_one_line() -> None:
    """`run_config` returns the configuration of a run, of which that of the hardware is a part."""
    config: Any = run_config(346, 260)
    for make in (Device, Lockstep, golden_model):
        with pytest.raises(ConfigError) as caught:
            make(config)
        assert str(caught.value) == (
            "config is of type RunConfig: must be a MotionConfig or a CotConfig, "
            "as run_config(width, height).device_config() returns it"
        )


@pytest.mark.parametrize("filtered", [False, True])
def test_it_returns_what_the_golden_model_returns(config: CotConfig, blobs: Events, filtered: bool) -> None:
    if filtered:
        config = RunConfig(hardware=config, filters=FilterConfig(refractory_us=20)).device_config(128, 128)
    later = Events(blobs.t_us + 5_000_000, blobs.x, blobs.y, blobs.p)
    hardware, model = DeviceTracker(config), GoldenTracker(config)
    wanted, owners = model.feed(later)
    cuts = [0, 1, 7, 500, 501, 1_999, len(later)]
    got = [hardware.feed(later[begin:end]) for begin, end in pairwise(cuts)]
    assert np.array_equal(np.concatenate([records for records, _ in got]), wanted)
    assert np.array_equal(np.concatenate([owner for _, owner in got]), owners)
    assert len(wanted) > 100
    assert len(hardware.finish()) == 0
    assert hardware.settled == len(later)


def test_a_wait_that_is_too_long_is_refused_and_nothing_was_fed(config: CotConfig, blobs: Events) -> None:
    hardware = DeviceTracker(config)
    hardware.feed(blobs[:100])
    late = Events(blobs.t_us + (1 << 60), blobs.x, blobs.y, blobs.p)
    with pytest.raises(RecordingError, match="clocks of silence"):
        hardware.feed(late)
    assert hardware.settled == 100


CONFIG = MotionConfig(Shape(n_slots=1))


def test_a_shape_that_differs_in_what_motion_does_not_have_is_the_same_hardware() -> None:
    built = build_device(CONFIG)
    assert built.key == build_device(replace(CONFIG, shape=replace(CONFIG.shape, frac=0, nev_w=12))).key
    assert {"FRAC", "NEV_W", "TC_W"}.isdisjoint(built.parameters)


def test_random_runs_have_records_of_every_kind() -> None:
    shape = Shape(n_slots=8, x_w=7, y_w=7, tc_w=12)
    lockstep = run_case(random_case(Design("cot_motion", shape), 7, 4_000))
    assert lockstep.events == 4_000
    assert lockstep.records > 0
    assert lockstep.latency.sum() <= lockstep.records


def test_outlines_stay_on_the_sensor() -> None:
    for seed in range(8):
        events = random_outlines(np.random.default_rng(seed), Shape(n_slots=2, x_w=5, y_w=9), 2_000, 2.0)
        assert events.x.max() < 32
        assert events.y.max() < 512
        assert np.all(np.diff(events.ticks) >= 0)


ROW = np.dtype([("rst", "u1"), ("d", "u1")])
OUT = np.dtype([("q", "u1")])
FLIP_FLOP = Top("dff", (("RESET_TO_COMPLEMENT", 0),), ROW, OUT)
VALUES = np.array([1, 1, 0, 1, 0, 0, 1])


def rows(values: np.ndarray, rst: int = 0) -> np.ndarray:  # type: ignore[type-arg]
    given = np.zeros(len(values), ROW)
    given["rst"], given["d"] = rst, values
    return given


def test_outputs_are_those_before_the_edge_and_a_simulation_goes_on() -> None:
    rtl(FLIP_FLOP, rows(VALUES[:1], rst=1))
    parts = [rtl(FLIP_FLOP, rows(part))["q"] for part in (VALUES[:3], VALUES[3:3], VALUES[3:])]
    assert np.concatenate(parts).tolist() == [0, *VALUES[:-1]]


def test_a_port_that_is_not_valid_is_read_as_zero() -> None:
    never = replace(FLIP_FLOP, valid_with=(("q", "q"),))  # valid only while it is 0
    assert not rtl(never, rows(VALUES))["q"].any()


def test_one_simulation_does_not_touch_another() -> None:
    other = simulation.__wrapped__(FLIP_FLOP)
    rtl(FLIP_FLOP, rows(np.array([0, 0])))
    rtl(FLIP_FLOP, rows(np.array([1])), other)
    assert rtl(FLIP_FLOP, rows(np.array([0])))["q"].tolist() == [0]
    assert rtl(FLIP_FLOP, rows(np.array([0])), other)["q"].tolist() == [1]


NOW_US = 1_700_000_000_000_000  # microseconds since 1970


def events_at(*t_us: int) -> Events:
    n = len(t_us)
    return Events(np.array(t_us, np.int64), np.full(n, 5, np.uint16), np.full(n, 5, np.uint16), np.ones(n, np.uint8))


def narrow(**shape: int) -> CotConfig:
    return CotConfig.uniform(Shape(n_slots=1, **shape), SlotConfig(), module="cot")


def test_the_longest_gap_is_named_with_its_place_and_the_way_out() -> None:
    config = narrow()
    with pytest.raises(RecordingError) as caught:
        check_silence(np.array([3, 4, 4 + (1 << 44) // 1000, NOW_US, NOW_US + 5]), config)
    assert str(caught.value).startswith("event 3: t = 1700000000000000 us follows t = 17592186048 us: a gap of 1.69998e+09 s")
    assert str(caught.value).endswith("must be at most 16777216; take a part without it (--from, --to), or a longer tick_us")


@pytest.mark.parametrize("first", [0, 7])
def test_the_bound_is_exact_and_knows_the_event_before(first: int) -> None:
    config = narrow()
    most_us = (SILENT_CLOCKS_MAX + 1) * ((1 << config.shape.tick_w) - 1) - 1
    check_silence(np.array([most_us]), config, first, 0)
    check_silence(np.array([0, most_us]), config, first)
    check_silence(np.array([NOW_US]), config, first)
    for times, before, index in (([most_us + 1], 0, first), ([0, most_us + 1], None, first + 1)):
        with pytest.raises(RecordingError, match=f"^event {index}: "):
            check_silence(np.array(times), config, first, before)
        with pytest.raises(RecordingError, match=f"^event {index}: tick {most_us + 1} follows tick 0: "):
            check_waits(np.array(times), before or 0, (1 << config.shape.tick_w) - 1, first)


def test_no_drive_begins_a_gap_of_decades() -> None:
    """Each would go on for minutes: that the test ends shows that none begins."""
    events, config = events_at(0, 1, NOW_US), RunConfig(hardware=narrow())
    with pytest.raises(RecordingError, match=r"^story: event 2: t = 1700000000000000 us follows t = 1 us"):
        run_cosim(Recording(events, 64, 64, "story"), config)
    ticked = TickedEvents.of(events)
    for device in (Device(config.hardware), FilterDevice("filter_polarity", ports={"enable": 0})):
        with pytest.raises(RecordingError, match=r"^event 2: tick 1700000000000000 follows tick 1: "):
            device.stream(ticked)
        assert device.now == device.cycle == 0
    with Lockstep(config.hardware) as lockstep:
        lockstep.feed(events[:2])
        clocks = lockstep.device.cycle
        with pytest.raises(RecordingError, match=r"^event 2: t = "):
            lockstep.feed(events[2:])
        assert lockstep.device.cycle == clocks


def test_a_day_of_silence_is_driven() -> None:
    with Lockstep(narrow()) as lockstep:
        lockstep.feed(events_at(0, 1, 86_400_000_000))
        assert lockstep.device.now == 86_400_000_000
        assert lockstep.device.cycle > 82_000


def test_addresses_must_reach_the_whole_sensor() -> None:
    cot = fit(preset("dvs128"), 64, 64).hardware
    check_addresses((64, 64), cot, "blob")
    with pytest.raises(ConfigError, match=r"^shape.y_w = 6: too few bits for 65 pixels of blob$"):
        check_addresses((64, 65), cot, "blob")

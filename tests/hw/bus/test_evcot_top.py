# SPDX-License-Identifier: Apache-2.0
"""Everything between standard buses, in lock-step with the golden model: streams, commits on the way, counters, interrupts."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ToolchainError
from evcot.events import Events
from evcot.filters.contract import Filter, FilterShape, mask_word
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, Mode
from evcot.hardware.cot import CotModel
from evcot.hardware.lfsr_event_source import LfsrEventSource
from evcot.hardware.model import Decisions
from evcot.hardware.register_access import Registers
from evcot.hardware.streams import pack_events
from evcot.recordings.files import read_recording
from evcot.ticks import TickedEvents
from evcot.tracks.log import DROPPED, Kind
from evcot_cosim.devices.top_device import (
    Command,
    Pace,
    TopDevice,
    TopRun,
    address_of,
    configuration,
    filter_address,
    poll,
    read,
    slot_address,
    write,
)
from evcot_cosim.rtl.files import rtl_files
from shared import SHARED
from support.top import BUILDS, DVS128, EVERY, SMALL, device_of, traffic_of
from support.trials import random_config

TRACKERS = ("array behind filters", "array", "chain")
STATUS, CONTROL = address_of("status"), address_of("control")
PENDING = 2


def words_of(traffic: TickedEvents) -> NDArray[np.uint64]:
    """The traffic as a camera sends it, whose microseconds are the ticks."""
    return pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p)


def assert_same(hardware: Decisions, golden: Decisions, chain: bool = False) -> None:
    for field in Decisions._fields:
        mine, theirs = getattr(hardware, field), getattr(golden, field)
        if field == "records" and chain:
            order = np.lexsort((theirs["slot"], theirs["time"], theirs["kind"] != Kind.LOST, theirs["seq"]))
            theirs = theirs[order]
        assert np.array_equal(mine, theirs), f"{field} differs first at {first_difference(mine, theirs)}"


def first_difference(a: NDArray[Any], b: NDArray[Any]) -> str:
    n = min(len(a), len(b))
    at = int(np.argmax(a[:n] != b[:n])) if n and np.any(a[:n] != b[:n]) else n
    return f"{at} of {len(a)} and {len(b)}: {a[at : at + 1]} and {b[at : at + 1]}"


@pytest.mark.parametrize("name", TRACKERS)
def test_random_registers_traffic_and_stalls_are_exact(name: str) -> None:
    build, chain = BUILDS[name], name == "chain"
    print("seed 31")
    kinds = dict.fromkeys(Kind, 0)
    for run in range(5):
        rng = np.random.default_rng([31, run])
        config = replace(random_config(rng, build.shape, build.module), filter_shape=build.filter_shape)
        if build.parameters.get("HAS") == 255 and run % 2:
            config = replace(
                config, filters=FilterRegisters(enable=1 << Filter.REFRACTORY, refractory_ticks=int(rng.integers(1, 30)))
            )
        device = device_of(name, config, pace=Pace.random(rng) if run else None)
        device.configure()
        model = CotModel(config)
        since, first, zero = 0, 0, -1
        for _ in range(2):
            traffic = traffic_of(rng, build, 8_000, since)
            zero = int(traffic.ticks[0]) if zero < 0 else zero
            events = replace(traffic, ticks=traffic.ticks - zero)
            played = device.run(words_of(traffic))
            assert_same(played.decisions(first, 8_000, chain), model.feed(events), chain)
            since, first = int(traffic.ticks[-1]), first + 8_000
            for kind in Kind:
                kinds[kind] += int(np.count_nonzero(played.records["kind"] == kind))
            slots = played.decisions(first - 8_000, 8_000, chain).owner
            assert np.array_equal(played.user, (played.owned >> np.uint64(28) & np.uint64(63)).astype(np.uint8))
            assert len(played.owned) == np.count_nonzero(slots >= 0)
    print(kinds)
    assert min(count for kind, count in kinds.items() if kind != Kind.MERGED or not chain) > 20


def test_a_recording_gives_the_log_of_the_golden_model() -> None:
    path = SHARED / "hand_dvs128.aedat4"
    if not path.exists():
        pytest.skip(f"{path} is not there")
    events = read_recording(path).events[:150_000]
    config = replace(DVS128.hardware, filter_shape=FilterShape(128, 128))
    device = device_of("array", config)
    device.configure()
    played = device.run(pack_events(events.t_us, events.x, events.y, events.p))
    golden = CotModel(config).feed(TickedEvents.of(events, config.tick_us))
    assert len(golden.records) > 1_000
    assert_same(played.decisions(0, len(events)), golden)


class Change(NamedTuple):
    """A commit on the way: what is written to which slot, and whether `mode` is."""

    slot: int
    registers: SlotConfig
    restart: bool

    def commands(self, rng: np.random.Generator, after: int) -> list[Command]:
        """The writes in any order while events flow, the commit, and what number it took effect at."""
        names = [name for name in REGISTERS if name != "mode" or self.restart]
        writes = [
            write(slot_address(self.slot, name), int(getattr(self.registers, name)), after) for name in rng.permutation(names)
        ]
        return [*writes, write(slot_address(self.slot), 1), poll(STATUS, PENDING, 0), read(slot_address(self.slot))]


def changes_of(rng: np.random.Generator, config: CotConfig, n: int) -> list[Change]:
    """Random changes, half of which restart their slot."""
    shape, slots = config.shape, config.shape.n_slots
    drawn = ((int(rng.integers(slots)), random_config(rng, shape).slots[0]) for _ in range(n))
    return [Change(slot, registers, bool(rng.integers(2))) for slot, registers in drawn]


def changed_in_flow(
    device: TopDevice,
    name: str,
    config: CotConfig,
    traffic: TickedEvents,
    changes: list[Change],
    afters: NDArray[np.int64],
    rng: np.random.Generator,
) -> tuple[TopRun, NDArray[np.int64], dict[str, int]]:
    """A run with commits after so many events, held against the model that is changed at the events at which they took effect.

    Returns the run, these events' numbers, and a count of what happened.
    """  # fmt: skip
    chain, n = name == "chain", len(traffic.ticks)
    census = {"changes": 0, "lives that went on": 0, "lives that ended": 0}
    lists = [change.commands(rng, int(after)) for change, after in zip(changes, afters, strict=True)]
    played = device.run(words_of(traffic), [command for commands in lists for command in commands])
    assert not played.commands["response"].any()
    ends = np.cumsum([len(commands) for commands in lists]) - 1
    seqs = played.commands["result"][ends].astype(np.int64)
    began = played.commands["began"][ends - 2]  # the commit was written at this clock, the events before it were taken
    assert np.all(seqs <= np.searchsorted(played.accepted, played.commands["ended"][ends]))
    assert np.all(seqs + 64 >= np.searchsorted(played.accepted, began))

    model = CotModel(config)
    events = replace(traffic, ticks=traffic.ticks - traffic.ticks[0])
    parts, at = [], 0
    for change, seq in zip(changes, seqs, strict=True):
        parts.append(model.feed(events[at:seq]))
        active = alive(np.concatenate([part.records for part in parts]), change.slot)
        ended = model.write_registers(change.slot, change.registers, restart=change.restart)
        parts.append(Decisions(ended, *(column[:0] for column in parts[-1][1:])))
        at = seq
        census["changes"] += 1
        census["lives that went on"] += active and not change.restart
        census["lives that ended"] += len(ended)
        assert len(ended) == (active and change.restart)
    parts.append(model.feed(events[at:]))
    golden = Decisions(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    assert_same(played.decisions(0, n, chain), golden, chain)
    return played, seqs, census


@pytest.mark.parametrize("name", TRACKERS)
def test_registers_change_between_two_events_and_lives_go_on(name: str) -> None:
    """The hardware says at which event a commit took effect; the model, changed at that event, gives the same bits."""
    build = BUILDS[name]
    print("seed 77")
    total = {"changes": 0, "lives that went on": 0, "lives that ended": 0}
    for run in range(4):
        rng = np.random.default_rng([77, run])
        config = replace(random_config(rng, build.shape, build.module), filter_shape=build.filter_shape)
        device = device_of(name, config, pace=Pace.random(rng) if run else None)
        device.configure()
        n, count = 12_000, 40
        traffic = traffic_of(rng, build, n)
        changes = changes_of(rng, config, count)
        afters = np.sort(rng.integers(0, n - 500, count))
        _, _, census = changed_in_flow(device, name, config, traffic, changes, afters, rng)
        total = {what: total[what] + census[what] for what in total}
    print(total)
    assert total["lives that went on"] > 8
    assert total["lives that ended"] > 8


LAST_RUNS = 24  # of each build


@pytest.mark.parametrize("name", TRACKERS)
def test_the_last_events_of_a_run_are_exact_where_registers_change_among_them(name: str) -> None:
    """Short runs, each from reset, with commits at the last events and behind them."""
    build = BUILDS[name]
    behind = owned = 0
    for run in range(LAST_RUNS):
        rng = np.random.default_rng([78, run])
        config = replace(random_config(rng, build.shape, build.module), filter_shape=build.filter_shape)
        device = device_of(name, config, pace=Pace.random(rng) if run % 4 else None)
        device.configure()
        n, count = int(rng.integers(60, 400)), int(rng.integers(1, 5))
        traffic = traffic_of(rng, build, n)
        afters = np.sort(rng.integers(n - 12, n + 1, count))
        played, seqs, _ = changed_in_flow(device, name, config, traffic, changes_of(rng, config, count), afters, rng)
        behind += int((seqs == n).any())
        owned += int(played.decisions(0, n, name == "chain").owner[-1] >= 0)
    print(f"{behind} runs with a commit behind the last event, {owned} whose last event has an owner")
    assert behind > LAST_RUNS // 8
    assert owned > LAST_RUNS // 8


def alive(records: NDArray[np.void], slot: int) -> bool:
    """Whether a track lives in the slot after these records."""
    mine = records[records["slot"] == slot]
    return bool(len(mine) and mine[-1]["kind"] in (Kind.BORN, Kind.MOVED))


def test_commits_that_wait_together_take_effect_at_one_event() -> None:
    rng = np.random.default_rng(5)
    device = device_of("array", random_config(rng, BUILDS["array"].shape))
    device.configure()
    traffic = traffic_of(rng, BUILDS["array"], 4_000)
    commits = [write(slot_address(slot), 1, 1_000) for slot in (2, 5, 7)]
    # The gate stays closed from the first commit until nothing is under way: the others come before that.
    played = device.run(
        words_of(traffic), [*commits, poll(STATUS, PENDING, 0), *(read(slot_address(slot)) for slot in (2, 5, 7))]
    )
    seqs = played.commands["result"][-3:]
    assert len(set(seqs.tolist())) == 1
    registers = Registers(device)
    assert registers.commit_seq == seqs[0]
    assert registers.commits == 8 + 1  # each slot's when it was configured, and these three together


@pytest.mark.parametrize("seed", range(3))
def test_filters_change_between_two_events(seed: int) -> None:
    rng = np.random.default_rng([9, seed])
    build = BUILDS["array"]
    config = replace(
        random_config(rng, build.shape, build.module),
        filter_shape=build.filter_shape,
        filters=FilterRegisters(enable=1, region_x1=90),
    )
    device = device_of("array", config, pace=Pace.random(rng))
    device.configure()
    traffic = traffic_of(rng, build, 6_000)
    played = device.run(
        words_of(traffic),
        [
            write(filter_address("region_x1"), 40, 2_000), write(filter_address("region_x0"), 20), write(filter_address(), 1),
            poll(STATUS, PENDING, 0), read(filter_address()),
        ],
    )  # fmt: skip
    seq = int(played.commands["result"][-1])
    assert 1_900 < seq < 3_000
    keep = np.where(np.arange(6_000) < seq, traffic.x <= 90, (traffic.x >= 20) & (traffic.x <= 40))
    model = CotModel(replace(config, filters=FilterRegisters()))
    assert_same(played.decisions(0, 6_000), model.feed(replace(traffic, ticks=traffic.ticks - traffic.ticks[0]), keep))
    counters = Registers(device).counters()
    assert counters["filtered"] == np.count_nonzero(~keep)


def test_counters_add_up() -> None:
    rng = np.random.default_rng(12)
    build = BUILDS["array behind filters"]
    config = replace(random_config(rng, build.shape, build.module), filters=FilterRegisters(enable=1, region_x1=30))
    device = device_of("array behind filters", config)
    device.configure()
    traffic = traffic_of(rng, build, 5_000)
    words = words_of(traffic)
    bad = np.concatenate([words[:10] | np.uint64(63 << 32), words[:7] | np.uint64(63 << 47)])  # beyond 60 x 50
    keeps = np.full(5_017, 255, np.uint8)
    keeps[3] = 127
    played = device.run(np.concatenate([words, bad]), keeps=keeps)
    registers = Registers(device)
    found = registers.counters()
    owner = played.decisions(0, 4_999).owner
    assert found == {
        "events_in": 4_999,
        "events_dropped": 0,
        "malformed": 18,
        "events": 4_999,
        "filtered": np.count_nonzero(owner == DROPPED),
        "owned": np.count_nonzero(owner >= 0),
        "passed": np.count_nonzero(owner == -1),
        "records": len(played.records),
        "stalls": found["stalls"],
        "backward": 0,
    }
    assert found["filtered"] > 100
    device.run(words[:100])
    assert registers.events_in == 4_999  # as they were when latched
    assert registers.counters()["events_in"] == 5_099


def test_waiting_for_enable_is_no_stall_and_time_that_runs_back_is_counted() -> None:
    device = device_of("array behind filters", CotConfig.uniform(SMALL, EVERY))
    registers = Registers(device)
    nine = np.full(6, 9)
    device.run(pack_events(np.array([10, 5, 6, 20, 19, 21]), nine, nine, 0 * nine))
    found = registers.counters()
    assert (found["events_in"], found["backward"], found["stalls"]) == (6, 3, 0)


def assert_prompt(run: TopRun) -> None:
    """No access waited for more than 64 clocks."""
    waited = run.commands["ended"] - run.commands["began"]
    assert waited.max() <= 64, run.commands[np.argmax(waited)]


@pytest.mark.parametrize("name", ["array behind filters", "array"])
def test_no_access_waits_longer_than_64_clocks(name: str) -> None:
    """Once the shadow is filled, and while all banks are copied at once; the next one, at every clock in turn, meets that."""
    build = BUILDS[name]
    config = replace(CotConfig.uniform(build.shape, EVERY), filter_shape=build.filter_shape, filters=FilterRegisters(enable=1))
    slots = build.shape.n_slots
    for late in range(40):
        device = device_of(name, config)
        device.run(clocks=32 * (slots + 1) + late)
        first = device.run(commands=configuration(config), quiet_clocks=1)
        assert_prompt(first)
        assert not first.commands["response"].any()
    device.run(commands=[poll(STATUS, PENDING, 0), write(CONTROL, 1)])
    commits = [write(address, 1, after=20) for address in (*map(slot_address, range(slots)), filter_address())]
    rng, longest, together = np.random.default_rng(8), [], 0
    for late in range(12):
        # Nobody takes what comes out, so the commits wait; then they take effect together, while the bus is busy.
        words = words_of(traffic_of(rng, build, 24 + late % 8, 1_000 * late))
        assert_prompt(device.run(words, commits, take_outputs=False, quiet_clocks=200))
        together += Registers(device).status.pending
        played = device.run(commands=[read(slot_address(0, "mode"))] * 120)
        assert_prompt(played)
        longest.append(int((played.commands["ended"] - played.commands["began"]).max()))
        assert Registers(device).status.pending == 0
    assert together > 3
    assert max(longest) > 12  # some did meet a copy


@pytest.mark.parametrize("reset", ["power", "soft"])
def test_hot_pixels_are_refused_at_once_until_the_filters_are_cleared_and_marked_from_then_on(reset: str) -> None:
    """The filters need thousands of clocks to become empty; the bus waits for none of them, software polls."""
    rng = np.random.default_rng(31)
    x, y = rng.permutation(60)[:12], rng.permutation(50)[:12]
    build = BUILDS["array behind filters"]
    hot = FilterRegisters(enable=1 << Filter.MASK, hot_pixels=tuple(zip(x.tolist(), y.tolist(), strict=True)))
    config = replace(CotConfig.uniform(SMALL, EVERY), filters=hot, filter_shape=build.filter_shape)
    device = device_of("array behind filters", config)
    if reset == "soft":
        device.run(quiet_clocks=8_000)
        device.run(commands=[write(CONTROL, 1 << 9)], quiet_clocks=1)
    else:
        device.read(0)  # waits until the shadow is filled
    early = device.run(commands=[write(filter_address("mask"), mask_word(59, 49)), read(STATUS)], quiet_clocks=1)
    assert early.commands["response"].tolist() == [0, 0]
    assert_prompt(early)
    registers = Registers(device)
    assert (registers.fault.pending, registers.status.cleared) == (1, 0)
    device.configure()
    assert registers.status.cleared == 1
    device.run(pack_events(np.arange(24), np.tile(x, 2), np.tile(y, 2), np.zeros(24, np.int64)))
    assert Registers(device).counters()["filtered"] == 24


def test_nothing_is_taken_during_a_soft_reset() -> None:
    """Whatever is taken from the clock on in which its answer comes goes through."""
    device = device_of("array behind filters", CotConfig.uniform(SMALL, EVERY))
    played = device.run(pack_events(np.arange(400), *np.full((3, 400), 1)), [write(CONTROL, 1 << 9 | 2, after=20)])
    after = np.count_nonzero(played.accepted >= played.commands["ended"][0])
    assert 100 < after < 390
    assert Registers(device).counters()["events_in"] == after


@pytest.mark.parametrize("name", ["array behind filters", "array"])
def test_a_soft_reset_cuts_no_record_and_withdraws_no_event(name: str) -> None:
    """What had reached the outputs comes out whole, at any pace; the drive sees to it that no beat is taken back."""
    build = BUILDS[name]
    rng = np.random.default_rng(11)
    config = replace(CotConfig.uniform(build.shape, EVERY), filter_shape=build.filter_shape)
    traffic = traffic_of(rng, build, 300)
    golden = CotModel(config).feed(replace(traffic, ticks=traffic.ticks - traffic.ticks[0])).records
    waited = 0
    for at in range(20, 220, 20):
        device = device_of(name, config, pace=Pace.random(rng))
        device.configure()
        played = device.run(words_of(traffic), [write(CONTROL, 1 << 9 | 1, after=at)])
        assert len(played.records) < len(golden)
        assert np.array_equal(played.records, golden[: len(played.records)])
        waited += np.count_nonzero(played.recorded > played.commands["ended"][0] + 8)
    assert waited > 0  # the reset did meet records that waited


def test_what_nobody_took_before_a_soft_reset_is_taken_after_it() -> None:
    device = device_of("array behind filters", CotConfig(SMALL, (EVERY,) + (replace(EVERY, mode=Mode.OFF),) * 3))
    device.configure()
    device.run(pack_events(np.arange(4), np.array([10, 10, 50, 50]), np.full(4, 10), np.zeros(4, np.int64)), take_outputs=False)
    registers = Registers(device)
    assert registers.status.idle == 0
    device.run(commands=[write(CONTROL, 1 << 9)], take_outputs=False)
    played = device.run()
    assert len(played.records) > 0
    assert len(played.owned) > 0
    assert len(played.passed) > 0
    assert registers.status.idle == 1


def test_a_soft_reset_lets_an_aer_chip_finish_and_reads_no_word_twice() -> None:
    device = device_of("sources")
    registers, io = Registers(device), device.sim.io
    registers.source.select = 2
    io.aer_req, io.aer_data = 1, 5 << 9 | 7 << 1  # active low, so no request
    registers.control.soft_reset = 1
    device.run(clocks=20)

    def given() -> tuple[int, int]:
        device.run(clocks=20)
        return int(io.aer_ack), registers.counters()["events_in"]

    assert given() == (1, 0)
    io.aer_req = 0
    assert given() == (0, 1)
    registers.control.soft_reset = 1
    assert given() == (0, 0)
    io.aer_req = 1
    assert given() == (1, 0)
    io.aer_req = 0
    assert given() == (0, 1)
    registers.source.select = 3
    registers.control.soft_reset = 1
    assert given() == (0, 0)
    io.aer_req = 1
    assert given() == (1, 0)
    io.aer_req = 0
    assert given() == (1, 0)  # it is not listened to


class TestOverload:
    """A closed gate fills the input FIFO: the source waits, or events are dropped and time goes on."""

    def test_without_drop_the_source_waits_and_nothing_is_lost(self) -> None:
        device = device_of("array behind filters")
        words = pack_events(np.arange(200), np.full(200, 9), np.full(200, 9), np.zeros(200, np.int64))
        played = device.run(words, [write(CONTROL, 1)], clocks=0)
        assert len(played.passed) == 200

    def test_with_drop_events_are_counted_and_the_rest_keeps_its_time(self) -> None:
        config = CotConfig(SMALL, (EVERY,) * 4)
        device = device_of("array behind filters", config)
        registers = Registers(device)
        registers.control.drop = 1
        registers.irq_enable = 8
        played = device.run(pack_events(7 * np.arange(200), np.full(200, 9), np.full(200, 9), np.zeros(200, np.int64)))
        assert played.irq_clock > 0
        assert registers.irq_status.overflow == 1
        held = registers.status.held
        found = registers.counters()
        assert found["events_in"] == 200
        assert found["events_dropped"] == 200 - held
        assert 40 <= held <= 48  # and a few on their way out
        device.run(commands=[write(slot_address(0, name), int(getattr(EVERY, name))) for name in REGISTERS])
        commands = [write(slot_address(0), 1), poll(STATUS, PENDING, 0), write(CONTROL, 3)]
        assert len(device.run(commands=commands).records) == held
        last = device.run(pack_events(np.array([1_400]), np.array([9]), np.array([9]), np.array([0]))).records[0]
        assert last["seq"] == held
        assert last["time"] == 1_400  # that of the dropped events has passed


def test_interrupts_say_what_has_happened() -> None:
    device = device_of("array behind filters", CotConfig(SMALL, (replace(EVERY, max_ticks=500),) * 4))
    device.configure()
    registers = Registers(device)

    def after(*events: tuple[int, int]) -> tuple[int, ...]:
        t, x = np.array(events).T
        played = device.run(pack_events(t, x, np.full(len(t), 20), np.zeros(len(t), np.int64)))
        status = registers.irq_status
        found = status.birth, status.loss, status.merge, status.overflow, status.commit, int(played.irq_clock >= 0)
        registers.irq_clear = 31
        return found

    registers.irq_clear = 31
    assert after((0, 10)) == (1, 0, 0, 0, 0, 0)  # nothing is enabled
    registers.irq_enable = 2
    assert after((1, 10)) == (0, 0, 0, 0, 0, 0)  # a move
    assert after((1_000, 40)) == (1, 1, 0, 0, 0, 1)
    registers.irq_enable = 4
    assert after((1_001, 30), (1_002, 35), (1_003, 35), (1_004, 36)) == (1, 0, 1, 0, 0, 1)
    registers.irq_enable = 16
    played = device.run(commands=[write(slot_address(0), 1), poll(STATUS, PENDING, 0)])
    assert played.irq_clock > 0
    assert (registers.irq_status.commit, registers.irq_status.loss) == (1, 0)  # its life goes on


def test_the_self_test_source_gives_what_its_twin_in_python_gives() -> None:
    rng = np.random.default_rng(4)
    config = CotConfig.uniform(SMALL, replace(EVERY, clust_nev=3, nev_max=5, detect_ticks=4_000))
    runs = []
    for pace in (None, Pace.random(rng)):
        device = device_of("array behind filters", config, pace=pace)
        registers = Registers(device)
        registers.source.select = 1
        registers.lfsr_seed, registers.lfsr_gap = 0xC0FFEE, 20
        registers.lfsr_x.min, registers.lfsr_x.span = 3, 40
        registers.lfsr_y.min, registers.lfsr_y.span = 2, 30
        registers.control.soft_reset = 1
        device.run(commands=[*configuration(config), poll(STATUS, PENDING, 0)])
        played = device.run(commands=[write(CONTROL, 1)], clocks=300_000, most=30_000)
        runs.append(played)
        n = registers.counters()["events"]
        assert n > 500
        source = LfsrEventSource(x_w=6, y_w=6, seed=0xC0FFEE, gap=20, x_min=3, x_span=40, y_min=2, y_span=30)
        events = source.events(n)
        golden = CotModel(config).feed(TickedEvents.of(events))
        same = min(len(golden.records), len(played.records)) - 20
        assert same > 200
        assert np.array_equal(played.records[:same], golden.records[:same])
    assert np.array_equal(runs[0].records[:200], runs[1].records[:200])  # stalls change nothing


def test_another_source_takes_over_with_the_next_reset() -> None:
    device = device_of("array behind filters")
    registers = Registers(device)
    registers.control.enable = registers.source.select = 1
    events = pack_events(np.arange(20), np.full(20, 9), np.full(20, 9), np.zeros(20, np.int64))
    assert len(device.run(events, clocks=15_000, most=15_000).passed) == 20
    registers.control.soft_reset = 1
    assert len(device.run(clocks=15_000, most=15_000).passed) > 1_000


def test_idle_when_the_last_event_has_been_taken() -> None:
    device = device_of("array behind filters")
    registers = Registers(device)
    registers.control.enable = 1
    device.run(pack_events(*np.array([[0], [9], [9], [0]])), take_outputs=False)
    assert registers.status.idle == 0
    assert len(device.run().passed) == 1
    assert registers.status.idle == 1


def test_soft_reset_keeps_what_was_written_and_starts_over() -> None:
    rng = np.random.default_rng(8)
    build = BUILDS["array behind filters"]
    config = replace(random_config(rng, SMALL), filter_shape=build.filter_shape)
    config = replace(config, slots=tuple(replace(slot, mode=Mode.SEEDED) for slot in config.slots))
    device = device_of("array behind filters", config)
    device.configure()
    traffic = traffic_of(rng, build, 3_000)
    first = device.run(words_of(traffic))
    assert len(first.records) > 100
    registers = Registers(device)
    registers.control.soft_reset = 1
    device.run(quiet_clocks=8_000)
    assert len(device.run(words_of(traffic)).passed) == 3_000  # slots are off
    registers.control.soft_reset = 1
    device.run(commands=[*(write(slot_address(slot), 1) for slot in range(4)), poll(STATUS, PENDING, 0)])
    again = device.run(words_of(traffic))
    assert np.array_equal(again.records, first.records)
    assert registers.counters()["events"] == 3_000


def test_ticks_of_several_microseconds() -> None:
    rng = np.random.default_rng(15)
    build = BUILDS["chain"]
    config = random_config(rng, build.shape, build.module)
    device = device_of("chain", config)
    registers = Registers(device)
    registers.tick_us = 50
    registers.control.soft_reset = 1
    device.configure(config)
    traffic = traffic_of(rng, build, 4_000)
    events = Events(1_000_000 + traffic.ticks * 37, traffic.x, traffic.y, traffic.p)
    played = device.run(pack_events(events.t_us, events.x, events.y, events.p))
    golden = CotModel(config).feed(TickedEvents.of(events, 50))
    assert_same(played.decisions(0, 4_000, True), golden, chain=True)


def latency(name: str) -> int:
    """Clocks from the beat of an event that moves a centre to the first beat of its record."""
    build = BUILDS[name]
    config = CotConfig(build.shape, (EVERY,) * build.shape.n_slots)
    device = device_of(name, config)
    device.configure()
    for t in range(3):
        played = device.run(pack_events(np.array([t]), np.array([20]), np.array([20]), np.array([0])))
    return int(played.recorded[0] - played.accepted[0])


def test_clocks_from_an_event_to_its_record_are_those_of_the_header() -> None:
    found = {name: latency(name) for name in TRACKERS}
    print(found)
    own = re.search(r"a record after (\d+)", rtl_files()["cot_array.v"].read_text())
    assert own is not None
    assert found == {"array behind filters": 14 + 6 + 52 + int(own[1]), "array": 13 + 2 + 2 + int(own[1]), "chain": 13 + 12 + 7}


def test_refuses_a_source_that_was_not_built() -> None:
    with pytest.raises(ToolchainError, match="SOURCE must be one of SOURCES"):
        TopDevice(replace(DVS128.hardware, filter_shape=BUILDS["array"].filter_shape), {"SOURCES": 1, "SOURCE": 3})

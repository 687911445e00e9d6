# SPDX-License-Identifier: Apache-2.0
"""evcot_top with cot_motion: its records, registers and resets, in lock-step with the golden model."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.filters.contract import Filter
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, MotionConfig, with_module
from evcot.hardware.contract import REGISTERS, Mode
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RULES, MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import BusError, register_map
from evcot.hardware.streams import pack_events
from evcot.ticks import TickedEvents
from evcot.tracks.log import DROPPED, Kind
from evcot_cosim.devices.top_device import (
    Pace,
    TopDevice,
    address_of,
    bank_address,
    configuration,
    filter_address,
    poll,
    read,
    slot_address,
    write,
)
from evcot_cosim.lockstep.random_runs import random_motion, random_outlines
from evcot_cosim.lockstep.top_runs import rewritten
from support.moving import QUICK, scene
from support.top import BUILDS, device_of

BUILD = BUILDS["motion"]
SHAPE, SENSOR = BUILD.shape, BUILD.filter_shape
STATUS, CONTROL, FAULT = address_of("status"), address_of("control"), address_of("fault")
SETTLED = poll(STATUS, 2, 0)
CLAMPED, REFUSED, LOCKED, UNMAPPED = 1, 2, 4, 8
CONFIG = MotionConfig(SHAPE, QUICK, filter_shape=SENSOR)
BANK_OF = {name: bank for bank, registers in MOTION_BANKS.items() for name in registers}


def started(traffic: TickedEvents) -> TickedEvents:
    """The ticks of the hardware: 0 at the first event."""
    return replace(traffic, ticks=traffic.ticks - traffic.ticks[0])


def words_of(traffic: TickedEvents) -> np.ndarray[Any, np.dtype[np.uint64]]:
    return pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p)


def assert_same(hardware: Decisions, golden: Decisions) -> None:
    for field in Decisions._fields:
        mine, theirs = getattr(hardware, field), getattr(golden, field)
        assert np.array_equal(mine, theirs), f"{field}: {len(mine)} and {len(theirs)}"


def fault(device: TopDevice) -> tuple[int, int]:
    """Which faults have happened and where the last one was; clears them."""
    word = device.read(FAULT)
    device.write(FAULT, 15)
    return word & 15, word >> 16


def refuses(device: TopDevice, address: int, value: int) -> bool:
    """Whether `fault` records a write; nobody takes an output meanwhile."""
    device.write(address, value)
    return bool(device.read(FAULT) & 15)


@pytest.mark.parametrize("seed", range(5))
def test_scenes_random_registers_and_stalls_are_exact(seed: int) -> None:
    rng = np.random.default_rng([40, seed])
    config = CONFIG if seed < 2 else replace(random_motion(rng, SHAPE), filter_shape=SENSOR)
    if seed % 2:
        filters = FilterRegisters(enable=1 << Filter.REFRACTORY, refractory_ticks=int(rng.integers(20, 200)))
        config = replace(config, filters=filters)
    traffic = scene(seed) if seed < 2 else random_outlines(rng, SHAPE, 5_000, 2.0)
    device = device_of("motion", config, pace=Pace.random(rng) if seed else None)
    device.configure()
    model, half = MotionModel(config), len(traffic) // 2
    for begin, part in ((0, traffic[:half]), (half, traffic[half:])):
        played = device.run(words_of(part), quiet_clocks=100_000)  # steps of a pause
        golden = model.feed(started(traffic)[begin : begin + len(part)])
        assert_same(played.decisions(begin, len(part)), golden)
        assert np.array_equal(played.user, (played.owned >> np.uint64(28) & np.uint64(63)).astype(np.uint8))
    assert (DROPPED in golden.owner) == bool(seed % 2)
    if seed < 2:
        assert set(golden.records["kind"]) >= {Kind.BORN, Kind.MOVED, Kind.LOST}
        assert min(golden.records["v_x"].min(), golden.records["v_y"].min()) < 0  # signs reach the stream


def test_registers_change_between_two_events_and_lives_go_on() -> None:
    """The hardware says at which event each commit took effect; the model, changed at that event, gives the same bits."""
    print("seed 41")
    ended = births = 0
    for run in range(6):
        rng = np.random.default_rng([41, run])
        config = replace(CONFIG, registers=replace(QUICK, birth_support=8, birth_ticks=20))
        device = device_of("motion", config, pace=Pace.random(rng) if run else None)
        done = rewritten(device, config, scene(10 + run), rng, 24)
        assert len(set(done.at.tolist())) > 15
        ended += done.ended
        births += int(np.count_nonzero(done.model.records["kind"] == Kind.BORN))
        assert_same(done.hardware, done.model)
    print(ended, births)
    assert ended > 2
    assert births > 15


def test_a_commit_leaves_the_steps_where_they_are() -> None:
    """They are at multiples of their length: a commit of the same values changes nothing."""
    traffic = scene(5)[:2_000]
    device = device_of("motion", CONFIG)
    device.configure()
    commits = [write(bank_address("motion"), 1, after) for after in range(40, 1_900, 37)]
    played = device.run(words_of(traffic), [command for commit in commits for command in (commit, SETTLED)])
    assert_same(played.decisions(0, len(traffic)), MotionModel(CONFIG).feed(started(traffic)))


@pytest.mark.parametrize("rule", MOTION_RULES, ids=lambda rule: str(rule.less))
def test_a_commit_of_values_that_contradict_each_other_is_refused_as_a_whole(rule: Any) -> None:
    device = device_of("motion", CONFIG)
    device.configure()
    bank, commits = BANK_OF[rule.less], device.read(address_of("commits"))
    other = next(name for name in MOTION_BANKS[bank] if name not in (rule.less, rule.more))
    high = getattr(QUICK, rule.more) // rule.times
    device.write(bank_address(bank, other), MOTION_BANKS[bank][other].high)  # legal, but in no effect
    device.write(bank_address(bank, rule.less), high + 1)
    assert refuses(device, bank_address(bank), 1)
    assert fault(device) == (REFUSED, bank_address(bank))
    traffic = scene(6)[:1_500]
    played = device.run(words_of(traffic))
    assert_same(played.decisions(0, len(traffic)), MotionModel(CONFIG).feed(started(traffic)))
    assert device.read(address_of("commits")) == commits
    assert device.read(bank_address(bank, rule.less)) == high + 1  # what was written is there to be mended
    device.write(bank_address(bank, rule.less), high)
    device.write(bank_address(bank), 1)
    assert device.read(address_of("commits")) == commits + 1


def test_after_reset_the_registers_have_their_defaults_and_contradict_nothing() -> None:
    device = device_of("motion", CONFIG)
    for bank, registers in MOTION_BANKS.items():
        for name, register in registers.items():
            assert device.read(bank_address(bank, name)) == register.start == getattr(MotionRegisters(), name)
    untouched = replace(CONFIG, registers=MotionRegisters())
    device = device_of("motion", untouched)
    slots = [write(slot_address(slot, name), 2 if name == "mode" else 1) for slot in range(5) for name in ("mode", "commit")]
    device.run(commands=[*slots, *(write(bank_address(bank), 1) for bank in MOTION_BANKS), SETTLED, write(CONTROL, 1)])
    traffic = scene(7)
    golden = MotionModel(untouched).feed(started(traffic))
    assert np.count_nonzero(golden.owner >= 0) > 1_000
    assert_same(device.run(words_of(traffic)).decisions(0, len(traffic)), golden)


def test_each_register_clamps_what_is_illegal_and_a_flag_refuses() -> None:
    device = device_of("motion", CONFIG)
    for bank, registers in MOTION_BANKS.items():
        for name, register in registers.items():
            address, held = bank_address(bank, name), register.start
            for value in (register.low, register.high, register.high + 1, 0xFFFF_FFFF, register.low - 1):
                if value >= 0:
                    legal = min(max(value, register.low), register.high)
                    kind = 0 if legal == value else REFUSED if name == "keep_older" else CLAMPED
                    held = held if kind == REFUSED else legal
                    assert refuses(device, address, value) == bool(kind), name
                    assert (device.read(address), fault(device)[0]) == (held, kind), name


def test_of_a_slot_there_is_mode_alone_and_it_has_no_fixed_start() -> None:
    device = device_of("motion", CONFIG)
    known = {word.address for word in register_map().words if word.built not in ("SOURCES_32[1]", "CLASSIFY != 0")}
    known |= {slot_address(slot, name) for slot in range(SHAPE.n_slots) for name in ("mode", "commit")}
    known |= {filter_address(name) for name in (*register_map().banks["filter"].registers, "commit")}
    known |= {bank_address(bank, name) for bank, registers in MOTION_BANKS.items() for name in (*registers, "commit")}
    device.write(CONTROL, 4)  # answer with SLVERR
    found = device.run(commands=[read(address) for address in range(0, 1 << register_map().address_w, 4)]).commands
    assert {4 * i for i, response in enumerate(found["response"]) if not response} == known
    device.write(CONTROL, 0)
    assert fault(device)[0] == UNMAPPED
    mode = slot_address(3, "mode")
    device.write(mode, Mode.SEEDED)
    assert refuses(device, mode, Mode.FIXED)
    assert fault(device) == (REFUSED, mode)
    assert device.read(mode) == Mode.SEEDED
    assert not refuses(device, slot_address(3), 1)  # a commit of 1 is none
    device.run(commands=[SETTLED])
    modes = [device.read(slot_address(slot, "mode")) for slot in range(SHAPE.n_slots)]
    assert modes == [Mode.SEEDED if slot == 3 else Mode.OFF for slot in range(SHAPE.n_slots)]


@pytest.mark.parametrize("name", ["array", "chain"])
def test_other_hardware_does_not_have_the_registers_and_says_what_builds_them(name: str) -> None:
    device = device_of(name)
    for bank, registers in MOTION_BANKS.items():
        for register in (*registers, "commit"):
            assert refuses(device, bank_address(bank, register), 1)
            assert fault(device) == (UNMAPPED, bank_address(bank, register))
        with pytest.raises(ConfigError) as caught:
            getattr(Registers(device), bank)
        tracker = register_map().trackers.index(name)
        assert str(caught.value) == (
            f"the hardware has no registers {bank}: it was built with TRACKER = {tracker}; TRACKER = 2 builds cot_motion"
        )


def test_registers_by_name() -> None:
    device = device_of("motion", CONFIG)
    registers = Registers(device)
    assert (registers.build.tracker, registers.shape.n_slots) == (2, 5)
    registers.motion.side_max, registers.motion.seed_px = 20, 10
    registers.tracks.join_px = 7
    registers.motion.commit()
    registers.tracks.commit()
    device.run(commands=[SETTLED])
    assert (registers.motion.side_max, registers.tracks.join_px, registers.commits) == (20, 7, 1)  # both waited
    registers.motion.seed_px = 11
    with pytest.raises(BusError, match="write of 0x1 at 0x02fc: a value was refused"):
        registers.motion.commit()
    with pytest.raises(ConfigError, match=r"gap_share = 16: must be an integer from 1 to 15 \(a bin with at most"):
        registers.tracks.gap_share = 16
    assert registers.motion.commit_seq == registers.tracks.commit_seq == 0


def test_a_bank_is_locked_while_its_commit_waits() -> None:
    device = device_of("motion", CONFIG)
    device.configure()
    device.run(words_of(scene(1)[:12]), quiet_clocks=50, take_outputs=False)
    device.write(bank_address("tracks"), 1)
    assert Registers(device).status.pending == 1
    for address in (bank_address("tracks", "join_px"), bank_address("tracks")):
        assert refuses(device, address, 1)
        assert fault(device) == (LOCKED, address)
    assert not refuses(device, bank_address("motion", "ring_px"), 1)
    device.run(commands=[SETTLED])
    assert not refuses(device, bank_address("tracks", "join_px"), 1)


def test_no_access_waits_longer_than_64_clocks() -> None:
    """Once the shadow is filled after a reset, and while all banks are copied."""
    longest = 0
    for late in range(0, 40, 3):
        device = device_of("motion", CONFIG)
        device.run(clocks=32 * (SHAPE.n_slots + 3) + late)
        commits = [write(bank_address(bank), 1) for bank in MOTION_BANKS]
        early = device.run(commands=[*commits, *configuration(CONFIG)], quiet_clocks=1).commands
        waited = early["ended"] - early["began"]
        assert waited.max() <= 64
        longest = max(longest, int(waited.max()))
    assert longest >= 9 + 8  # a commit compares registers


def test_a_soft_reset_cuts_no_record_and_keeps_what_was_written() -> None:
    traffic = scene(3)[:2_000]
    golden = MotionModel(CONFIG).feed(started(traffic))
    rng, cut = np.random.default_rng(12), 0
    for at in range(800, 1_800, 250):
        device = device_of("motion", CONFIG, pace=Pace.random(rng))
        device.configure()
        played = device.run(words_of(traffic), [write(CONTROL, 1 << 9 | 1, after=at)])
        assert 0 < len(played.records) < len(golden.records)
        assert np.array_equal(played.records, golden.records[: len(played.records)])
        cut += 1
        assert len(device.run(words_of(traffic)).owned) == 0  # slots are off
        device.write(CONTROL, 1 << 9)
        banks = [slot_address(slot) for slot in range(SHAPE.n_slots)] + [bank_address(bank) for bank in MOTION_BANKS]
        device.run(commands=[*(write(address, 1) for address in banks), SETTLED, write(CONTROL, 1)])
        assert_same(device.run(words_of(traffic)).decisions(0, len(traffic)), golden)
    assert cut == 4


def test_interrupts_and_counters() -> None:
    traffic = scene(2)
    device = device_of("motion", CONFIG)
    device.configure()
    registers = Registers(device)
    registers.irq_clear = 31
    registers.irq_enable = 1
    played = device.run(words_of(traffic))
    status, kinds = registers.irq_status, set(played.records["kind"])
    expected = tuple(int(kind in kinds) for kind in (Kind.BORN, Kind.LOST, Kind.MERGED))
    assert (status.birth, status.loss, status.merge) == expected
    assert played.irq_clock > 0
    found = registers.counters()
    assert (found["records"], found["owned"], found["passed"]) == (len(played.records), len(played.owned), len(played.passed))


def test_a_device_is_what_its_configuration_asks_for() -> None:
    array = CotConfig(SHAPE, filter_shape=SENSOR)
    with pytest.raises(ConfigError, match=r"^TRACKER = 1: must be 2, that of cot_motion$"):
        TopDevice(CONFIG, {"TRACKER": 1})
    with pytest.raises(ConfigError, match=r"^TRACKER = 2: must be 0, that of cot_array$"):
        TopDevice(array, {"TRACKER": 2})
    with pytest.raises(ConfigError, match=r"^module = 'cot': must be one of cot_array, cot_chain, cot_motion for evcot_top$"):
        TopDevice(with_module(array, "cot"))
    with pytest.raises(ConfigError, match=r"^shape.time_w = 31: must be from 32 to 48 for cot_motion$"):
        replace(CONFIG, shape=replace(SHAPE, time_w=31, tc_w=17))
    with pytest.raises(ConfigError, match=r"^module = 'cot_array': must be 'cot_motion', as it was built$"):
        device_of("motion", CONFIG).configure(array)
    assert not {slot_address(0, name) for name in REGISTERS if name != "mode"} & {
        address for _, _, address, _, _ in configuration(CONFIG)
    }

# SPDX-License-Identifier: Apache-2.0
"""axi_lite_regs.v in evcot_top: what each address of the banks does, what is refused or clamped, and how that shows.

The words outside the banks are tested in test_axi_lite_slave.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.filters.config import DEFAULT_FILTERS
from evcot.filters.contract import FILTER_REGISTERS, mask_word
from evcot.hardware.contract import REGISTERS
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RULES, Rule
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import BusError, register_map
from evcot.hardware.streams import pack_events
from evcot_cosim.devices.base import reset
from evcot_cosim.devices.top_device import (
    Pace,
    TopDevice,
    TopRun,
    address_of,
    bank_address,
    filter_address,
    poll,
    read,
    slot_address,
    write,
)
from evcot_cosim.rtl.build import load
from support.top import BUILDS, device_of

BUILD = BUILDS["array behind filters"]
OKAY, SLVERR = 0, 2
FAULT = address_of("fault")
CLAMPED, REFUSED, LOCKED, UNMAPPED = 1, 2, 4, 8


@pytest.fixture
def device() -> TopDevice:
    """Answers faults with SLVERR."""
    device = device_of("array behind filters")
    device.write(address_of("control"), 4)
    return device


def answers(run: TopRun) -> list[tuple[int, int]]:
    return [(int(command["response"]), int(command["result"])) for command in run.commands]


def fault(device: TopDevice) -> tuple[int, int]:
    """Which faults have happened and where the last one was; clears them."""
    word = device.read(FAULT)
    device.write(FAULT, 15)
    return word & 15, word >> 16


def test_the_hardware_says_what_it_is(device: TopDevice) -> None:
    registers = Registers(device)
    assert registers.id.to_bytes(4, "big") == b"EVCT"
    assert (registers.version.major, registers.version.minor) == (register_map().version[0], 0)
    assert (registers.shape, registers.filter_shape) == (BUILD.shape, BUILD.filter_shape)
    assert (registers.build.filters, registers.build.sources, registers.build.tracker) == (255, 3, 0)
    assert registers.memory.fifo_depth == 40
    assert len(registers.slot) == 4


def test_reset_gives_every_register_of_the_banks_its_reset_value(device: TopDevice) -> None:
    for slot in range(4):
        for name, register in REGISTERS.items():
            assert device.read(slot_address(slot, name)) == register.low
    for name, entry in FILTER_REGISTERS.items():
        default = 0 if name == "mask" else getattr(DEFAULT_FILTERS.registers(1), name)
        high = entry.limits(BUILD.filter_shape)[1]
        assert device.read(filter_address(name)) == (default if default <= high else entry.low)


def test_every_address_is_known_or_answers_with_an_error(device: TopDevice) -> None:
    known = {word.address for word in register_map().words if "CLASSIFY" not in word.built}
    known |= {slot_address(slot, name) for slot in range(4) for name in (*REGISTERS, "commit")}
    known |= {filter_address(name) for name in (*FILTER_REGISTERS, "commit")}
    end = 1 << register_map().address_w
    run = device.run(commands=[read(address) for address in range(0, end, 4)])
    found = {4 * i for i, (response, _) in enumerate(answers(run)) if response == OKAY}
    assert found == known
    assert all(result == 0 for response, result in answers(run) if response)
    assert fault(device) == (UNMAPPED, end - 4)


def test_faults_are_answered_okay_after_reset_and_recorded() -> None:
    device = device_of("array behind filters")
    nowhere = 0x0FFC
    for command, result, kind in (
        (read(nowhere), 0, UNMAPPED), (write(nowhere, 1), 0, UNMAPPED), (write(0, 1), 0, UNMAPPED),
        (write(slot_address(0, "mode"), 3), 0, REFUSED), (write(slot_address(0, "radix_max"), 99), 0, CLAMPED),
    ):  # fmt: skip
        assert answers(device.run(commands=[command])) == [(OKAY, result)]
        assert fault(device) == (kind, command[2])
    assert device.read(slot_address(0, "radix_max")) == REGISTERS["radix_max"].limits(BUILD.shape)[1]


def test_a_read_only_word_answers_a_write_with_an_error_and_stays(device: TopDevice) -> None:
    for word in register_map().words:
        if not word.writable:
            assert answers(device.run(commands=[write(word.address, 0xFFFF_FFFF)])) == [(SLVERR, 0)], word.name
            assert fault(device) == (UNMAPPED, word.address)
    assert device.read(0) == register_map().id


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [(name, *register.limits(BUILD.shape)) for name, register in REGISTERS.items() if name != "mode"],
)
def test_a_slots_register_clamps_what_is_illegal(device: TopDevice, name: str, low: int, high: int) -> None:
    address = slot_address(2, name)
    for value, stored in ((low, low), (high, high), (high + 1, high), (0xFFFF_FFFF, high), (low - 1, low)):
        if value < 0:
            continue
        response = answers(device.run(commands=[write(address, value)]))[0][0]
        assert (response, device.read(address)) == (OKAY if value == stored else SLVERR, stored)
        assert fault(device)[0] == (0 if value == stored else CLAMPED)
    assert device.read(slot_address(1, name)) == low


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        (name, *r.limits(BUILD.filter_shape))
        for name, r in FILTER_REGISTERS.items()
        if name not in ("mask", "enable", "polarity")
    ],
)
def test_a_filters_register_clamps_what_is_illegal(device: TopDevice, name: str, low: int, high: int) -> None:
    address = filter_address(name)
    for value, stored in ((low, low), (high, high), (high + 1, high), (low - 1, low)):
        if value < 0:
            continue
        response = answers(device.run(commands=[write(address, value)]))[0][0]
        assert (response, device.read(address)) == (OKAY if value == stored else SLVERR, stored)
        assert fault(device)[0] == (0 if value == stored else CLAMPED)


@pytest.mark.parametrize(
    ("address", "legal", "illegal"),
    [
        (slot_address(3, "mode"), 2, 3),
        (filter_address("enable"), 255, 256),
        (filter_address("polarity"), 1, 2),
        (address_of("source"), 1, 2),  # AER is not built
    ],
    ids=["mode", "enable", "polarity", "source"],
)
def test_what_has_no_nearest_legal_value_is_refused(device: TopDevice, address: int, legal: int, illegal: int) -> None:
    device.write(address, legal)
    assert answers(device.run(commands=[write(address, illegal)])) == [(SLVERR, 0)]
    assert device.read(address) == legal
    assert fault(device) == (REFUSED, address)


@pytest.mark.parametrize(("x", "y"), [(60, 0), (0, 50), (65_535, 32_767)])
def test_a_mark_beyond_the_sensor_is_refused(device: TopDevice, x: int, y: int) -> None:
    address = filter_address("mask")
    assert answers(device.run(commands=[write(address, mask_word(x, y))])) == [(SLVERR, 0)]
    assert fault(device) == (REFUSED, address)
    cleared = poll(address_of("status"), 8, 8)
    assert answers(
        device.run(commands=[cleared, write(address, mask_word(x, y)), write(address, mask_word(59, 49)), read(address)])
    )[1:] == [(SLVERR, 0), (OKAY, 0), (OKAY, 0)]


def test_words_outside_the_banks_clamp_too(device: TopDevice) -> None:
    for name, value, stored in (
        ("tick_us", 0, 1), ("tick_us", 0xF_FFFF, 1_000_000), ("tick_us", 2_000_000, 1_000_000), ("tick_us", 1 << 20, 1_000_000),
        ("lfsr_gap", 1 << 16, 0xFFFF), ("lfsr_seed", 0xFFFF_FFFF, 0xFFFF_FFFE),
        ("lfsr_x", 0x0040_003F, 0x003F_003F), ("prescale", 0x0005_0000, 0x0005_0001),
    ):  # fmt: skip
        assert answers(device.run(commands=[write(address_of(name), value)])) == [(SLVERR, 0)]
        assert device.read(address_of(name)) == stored
        assert fault(device) == (CLAMPED, address_of(name))


def test_bytes_without_strobe_keep_their_value(device: TopDevice) -> None:
    address = slot_address(0, "max_ticks")
    device.write(address, 0xABC)
    for strb, data, stored in (
        (1, 0xFFFF_FF12, 0xA12),
        (2, 0xFFFF_03FF, 0x312),
        (0, 0xFFFF_FFFF, 0x312),
        (12, 0x0000_FFFF, 0x312),
    ):
        assert answers(device.run(commands=[write(address, data, strb=strb)])) == [(OKAY, 0)]
        assert device.read(address) == stored
    device.write(address_of("lfsr_x"), 0x0010_0020)
    device.run(commands=[write(address_of("lfsr_x"), 0x0005_0006, strb=4)])
    assert device.read(address_of("lfsr_x")) == 0x0005_0020
    device.run(commands=[write(address_of("irq_clear"), 31, strb=14), write(slot_address(0), 1, strb=0)])
    assert fault(device)[0] == 0
    assert device.read(address_of("commits")) == 0  # a commit without a strobe is none


def test_nothing_takes_effect_before_its_commit_and_all_of_it_then(device: TopDevice) -> None:
    registers = Registers(device)
    registers.slot[1].radix_max = 12
    registers.slot[1].commit()
    run = device.run(commands=[poll(address_of("status"), 2, 0)])
    assert answers(run)[0][0] == OKAY
    assert (registers.commits, registers.slot[1].commit_seq, registers.commit_seq) == (1, 0, 0)


def test_a_bank_is_locked_while_its_commit_waits(device: TopDevice) -> None:
    """An output that is not read holds the trackers up, so the commit waits, and the bus goes on."""
    device.configure()
    registers = Registers(device)
    words = pack_events(np.arange(8), np.full(8, 5), np.full(8, 5), np.zeros(8, np.int64))
    device.run(words, quiet_clocks=50, take_outputs=False)
    registers.slot[0].commit()
    assert registers.status.pending == 1
    for address in (slot_address(0, "radix_max"), slot_address(0)):
        device.write(address, 1)  # `configure` has written control: answered OKAY
        assert fault(device) == (LOCKED, address)
    registers.slot[1].radix_max = 5  # another bank is free
    assert registers.slot[0].radix_max != 1
    device.run(commands=[poll(address_of("status"), 2, 0)])  # now the outputs are taken
    registers.slot[0].radix_max = 5


@pytest.mark.parametrize("seed", range(4))
def test_random_accesses_at_any_pace_read_what_was_written(seed: int) -> None:
    """Address before data and after it, reads between writes, responses that wait."""
    rng = np.random.default_rng([21, seed])
    device = device_of("array behind filters", pace=Pace({"bus": int(rng.integers(20, 257))}, 1 + seed))
    held: dict[int, int] = {}
    commands, wanted = [], []
    for _ in range(600):
        name = str(rng.choice([name for name in REGISTERS if name != "mode"]))
        address = slot_address(int(rng.integers(4)), name)
        low, high = REGISTERS[name].limits(BUILD.shape)
        if rng.random() < 0.5:
            held[address] = int(rng.integers(low, high, endpoint=True))
            commands.append(write(address, held[address]))
            wanted.append((OKAY, 0))
        else:
            commands.append(read(address))
            wanted.append((OKAY, held.get(address, low)))
    assert answers(device.run(commands=commands)) == wanted


def test_what_happens_in_the_clock_that_clears_it_interrupts_again() -> None:
    """Here it happens in every clock: so the interrupt never falls."""
    sim = load("axi_lite_regs", {"N": 1})
    io = sim.io
    reset(sim)
    io.happened, io.s_axil_bready, io.s_axil_wdata, io.s_axil_wstrb = 1, 1, 1, 1
    seen = []
    for name in ("irq_enable", "irq_clear"):
        io.s_axil_awaddr, io.s_axil_awvalid, io.s_axil_wvalid = address_of(name), 1, 1
        for _ in range(100):
            taken = io.s_axil_awready
            sim.clock.tick()
            io.s_axil_awvalid = io.s_axil_wvalid = io.s_axil_awvalid and not taken
            seen.append(int(io.irq))
    assert seen[99:] == [1] * 101


WHOLE = {"N": 2, "TRACKER": 2, "CLASSIFY": 1}  # with the banks of cot_motion and of the classifier


class Alone:
    """axi_lite_regs without the rest of the top: a test drives its ports; `response` is that of the last access."""

    def __init__(self, parameters: dict[str, int]) -> None:
        self.sim = load("axi_lite_regs", parameters)
        self.io, self.response = self.sim.io, OKAY
        self.io.core_rst = 1
        reset(self.sim)
        self.io.core_rst = 0
        self.io.s_axil_bready = self.io.s_axil_rready = 1

    def _access(self, channels: tuple[str, ...], answer: str) -> None:
        """Offer an access on its channels and clock until its answer is valid."""
        for channel in channels:
            self.io[f"s_axil_{channel}valid"] = 1
        for _ in range(400):
            if self.io[f"s_axil_{answer}valid"]:
                break
            taken = [channel for channel in channels if self.io[f"s_axil_{channel}ready"]]
            self.sim.clock.tick()
            for channel in taken:
                self.io[f"s_axil_{channel}valid"] = 0
        assert self.io[f"s_axil_{answer}valid"], "no answer"
        self.response = int(self.io[f"s_axil_{answer}resp"])

    def write(self, address: int, value: int) -> None:
        self.io.s_axil_awaddr, self.io.s_axil_wdata, self.io.s_axil_wstrb = address, value, 15
        self._access(("aw", "w"), "b")
        self.sim.clock.tick()

    def read(self, address: int) -> int:
        self.io.s_axil_araddr = address
        self._access(("ar",), "r")
        value = int(self.io.s_axil_rdata)
        self.sim.clock.tick()
        return value

    def copied(self) -> list[tuple[str, int, int]]:
        """Let the bank that is committed take effect; returns what each port says: its name, address and value."""
        io, found = self.io, []
        io.apply = 1
        for _ in range(100):
            if not io.busy:
                break
            self.sim.clock.tick()
            if io.cfg_valid:
                found.append((f"slot {int(io.cfg_slot)}", int(io.cfg_addr), int(io.cfg_data)))
            if io.filter_cfg_valid:
                found.append(("filter", int(io.filter_cfg_addr), int(io.filter_cfg_data)))
            if io.classifier_cfg_valid:
                found.append(("classifier", int(io.cfg_addr), int(io.cfg_data)))
        assert not io.busy
        io.apply = 0
        return found


def values_of(alone: Alone, bank: str, number: int = 0) -> list[tuple[int, int]]:
    """Address and value of each register of a bank, in order, without `mask`, which takes effect when it is written."""
    registers = register_map().banks[bank].registers.items()
    rows = sorted((register.address, name) for name, register in registers if name != "mask")
    return [(address, alone.read(bank_address(bank, name, number))) for address, name in rows]


def test_a_commit_copies_its_slot_with_mode_last_and_only_if_it_was_written() -> None:
    alone = Alone({"N": 3})
    for name in REGISTERS:
        alone.write(slot_address(2, name), REGISTERS[name].low + 1)
    mode, *rest = values_of(alone, "slot", 2)
    assert mode == (0, 1)
    alone.write(slot_address(2), 1)
    assert alone.copied() == [("slot 2", *each) for each in (*rest, mode)]
    alone.write(slot_address(2), 1)
    assert alone.copied() == [("slot 2", *each) for each in rest]
    alone.write(slot_address(1), 1)
    assert alone.copied()[-1] == ("slot 1", 0, 0), "after a reset, each mode counts as written"


@pytest.mark.parametrize("parameters", [{"N": 3}, WHOLE], ids=["array", "motion"])
def test_a_commit_copies_the_filters_without_their_mask_and_enable_last(parameters: dict[str, int]) -> None:
    alone = Alone(parameters)
    alone.write(filter_address("enable"), 0b101)
    alone.write(filter_address(), 1)
    enable, *rest = values_of(alone, "filter")
    assert enable == (0, 0b101)
    assert alone.copied() == [("filter", *each) for each in (*rest, enable)]


def test_a_commit_copies_the_banks_of_motion_and_of_the_classifier_to_their_ports() -> None:
    alone = Alone(WHOLE)
    alone.io.weights_loaded = 2_736
    alone.write(slot_address(1, "mode"), 2)
    alone.write(slot_address(1), 1)
    assert alone.copied() == [("slot 1", 0, 2)]
    alone.write(slot_address(1), 1)
    assert alone.copied() == []
    for bank, first in (("motion", 0), ("tracks", 32)):
        alone.write(bank_address(bank), 1)
        wanted = [(first + address, value) for address, value in values_of(alone, bank)]
        found = alone.copied()
        assert [(address, value) for _, address, value in found] == wanted
        assert {port.partition(" ")[0] for port, _, _ in found} == {"slot"}
    alone.write(bank_address("classifier", "enable"), 1)
    alone.write(bank_address("classifier"), 1)
    assert alone.copied() == [("classifier", *each) for each in values_of(alone, "classifier")]


def test_the_classifier_is_enabled_when_all_of_its_weights_are_loaded() -> None:
    alone, commit, enable = Alone(WHOLE), bank_address("classifier"), bank_address("classifier", "enable")
    alone.write(address_of("control"), 4)
    for loaded, value, response in ((0, 0, OKAY), (0, 1, SLVERR), (2_735, 1, SLVERR), (2_736, 1, OKAY), (2_735, 0, OKAY)):
        alone.io.weights_loaded = loaded
        alone.write(enable, value)
        alone.write(commit, 1)
        assert (alone.response, int(alone.io.busy)) == (response, int(response == OKAY)), (loaded, value)
        alone.copied()
    alone.io.weights_loaded = 0
    alone.write(enable, 1)
    for other in (slot_address(0), filter_address(), bank_address("motion"), bank_address("tracks")):
        alone.write(other, 1)
        assert alone.response == OKAY, "the commit of another bank"


@pytest.mark.parametrize("rule", MOTION_RULES, ids=lambda rule: str(rule.less))
def test_registers_of_motion_that_contradict_each_other_are_not_committed(rule: Rule) -> None:
    alone = Alone(WHOLE)
    bank = next(name for name, registers in MOTION_BANKS.items() if rule.less in registers)
    alone.write(address_of("control"), 4)
    most = alone.read(bank_address(bank, rule.more)) // rule.times
    for value, response in ((most, OKAY), (most + 1, SLVERR)):
        alone.write(bank_address(bank, rule.less), value)
        alone.write(bank_address(bank), 1)
        assert (alone.response, int(alone.io.busy)) == (response, int(response == OKAY))
        alone.copied()


def test_every_address_is_known_with_motion_and_the_classifier_or_answers_with_an_error() -> None:
    alone = Alone(WHOLE)
    alone.write(address_of("control"), 4)
    banks = {name: bank.registers for name, bank in register_map().banks.items() if name != "slot"}
    known = {word.address for word in register_map().words if word.built != "SOURCES_32[1]"}
    known |= {slot_address(slot, name) for slot in range(2) for name in ("mode", "commit")}
    known |= {bank_address(bank, name) for bank, registers in banks.items() for name in (*registers, "commit")}
    found = set()
    for address in range(0, 1 << register_map().address_w, 4):
        alone.read(address)
        found |= {address} if alone.response == OKAY else set()
    assert found == known


def test_counters_read_as_they_were_at_the_last_latch() -> None:
    alone = Alone({"N": 1})

    def count(first: int) -> dict[str, int]:
        """Give each counter a number of its own."""
        given = {word.name: first + i for i, word in enumerate(register_map().counters)}
        for name, value in given.items():
            alone.io["seq" if name == "events" else f"n_{name}"] = value
        return given

    def found() -> dict[str, int]:
        return {word.name: alone.read(word.address) for word in register_map().counters}

    then = count(100)
    assert set(found().values()) == {0}
    alone.write(address_of("control"), 1 << 8)
    later = count(200)
    assert found() == then
    alone.write(address_of("control"), 1 << 8)
    count(300)
    assert found() == later


def test_an_access_takes_the_clocks_of_the_header(device: TopDevice) -> None:
    device.read(0)  # what lies between the buses is reset a few clocks longer
    first, again = write(slot_address(0, "radix_max"), 3), write(slot_address(0, "radix_min"), 1)
    run = device.run(commands=[read(0), first, again, read(slot_address(3))])
    assert (run.commands["ended"] - run.commands["began"]).tolist() == [7, 9, 9, 7]


def test_accesses_wait_while_the_shadow_is_filled_after_reset() -> None:
    device = device_of("array behind filters")
    run = device.run(commands=[read(0)])
    banks = BUILD.shape.n_slots + 1
    assert 32 * banks - 8 <= int(run.commands["ended"][0]) <= 32 * banks + 16


class TestPython:
    """The access class, against the hardware."""

    def test_refuses_what_the_hardware_would(self, device: TopDevice) -> None:
        registers = Registers(device)
        with pytest.raises(ConfigError, match="radix_max = 32: must be an integer from 0 to 31 \\(largest g\\)"):
            registers.slot[0].radix_max = 32
        with pytest.raises(ConfigError, match="min = 64: must be an integer from 0 to 63"):
            registers.lfsr_x.min = 64
        with pytest.raises(AttributeError, match="held is read-only"):
            registers.status.held = 1
        with pytest.raises(AttributeError, match="radix_mux"):
            registers.slot[0].radix_mux = 1  # type: ignore[attr-defined]

    def test_raises_what_fault_records_of_its_own_accesses(self) -> None:
        device = device_of("array behind filters")
        registers = Registers(device)
        device.write(slot_address(1, "mode"), 3)  # a fault of somebody else
        registers.slot[0].mode = 2
        assert registers.fault.refused == 1
        registers.fault.refused = 1
        device.write(slot_address(0, "radix_max"), 99)
        with pytest.raises(BusError, match=r"read at 0x0284: .*any access to one that does not exist"):
            _ = registers._motion.step_log2
        assert device.read(FAULT) & 15 == 0

    def test_a_field_leaves_its_neighbours_alone(self, device: TopDevice) -> None:
        registers = Registers(device)
        registers.lfsr_y.min, registers.lfsr_y.span = 3, 40
        registers.control.drop = 1
        registers.control.latch = 1
        assert (registers.lfsr_y.min, registers.lfsr_y.span, registers.control.drop, registers.control.enable) == (3, 40, 1, 0)

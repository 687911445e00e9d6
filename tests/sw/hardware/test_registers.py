# SPDX-License-Identifier: Apache-2.0
"""The register map is consistent, and its Python classes work with any transport."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.filters.contract import FILTER_REGISTERS, FilterShape
from evcot.hardware.classifier import CLASSIFIER_REGISTERS
from evcot.hardware.contract import RECORD, REGISTERS, Register, Shape
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RANGES, MOTION_RULES
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import Access, map_of, motion_addresses, register_map
from support.refusals import refused

BANKS = {"slot": REGISTERS, "filter": FILTER_REGISTERS, **MOTION_BANKS, "classifier": CLASSIFIER_REGISTERS}


class Memory:
    """A transport: words that stay as they are written, but for those that tell what was built."""

    def __init__(self, **told: int) -> None:
        shape = Shape(n_slots=3, x_w=7, radix_w=6)
        values = {
            "id": register_map().id, "version": register_map().version[0] << 16,
            "sensor": 127 << 16 | 345, "memory": 15 << 8 | 12,
            "shape0": shape.n_slots | shape.frac << 8 | shape.x_w << 16 | shape.y_w << 24,
            "shape1": shape.tick_w | shape.radix_w << 8 | shape.nev_w << 16 | shape.tc_w << 24,
            "shape2": shape.sup_w | shape.id_w << 8 | shape.seq_w << 16 | shape.time_w << 24,
        } | told  # fmt: skip
        self.shape = shape
        self.words = {register_map().word(name).address: value for name, value in values.items()}
        self.accesses: list[tuple[str, int]] = []

    def read(self, address: int) -> int:
        self.accesses.append(("read", address))
        return self.words.get(address, 0)

    def write(self, address: int, value: int) -> None:
        self.accesses.append(("write", address))
        self.words[address] = value


def test_there_is_room_for_more_registers_and_for_every_slot() -> None:
    banks = register_map().banks
    assert banks["slot"].registers == REGISTERS
    assert banks["filter"].registers == FILTER_REGISTERS
    assert all(bank.words == 32 and bank.commit == 31 for bank in banks.values())
    assert (banks["slot"].count, banks["slot"].bytes) == (64, 64 * 32 * 4)


def toml() -> dict[str, Any]:
    return tomllib.loads(files("evcot.hardware").joinpath("registers.toml").read_text(encoding="utf-8"))


def word_of(data: dict[str, Any], name: str) -> dict[str, Any]:
    found: dict[str, Any] = next(word for word in data["word"] if word["name"] == name)
    return found


def field_of(data: dict[str, Any], word: str, name: str) -> dict[str, Any]:
    found: dict[str, Any] = next(field for field in word_of(data, word)["fields"] if field["name"] == name)
    return found


# What is changed in registers.toml -> what is said of it.
BROKEN: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "two words at one address": (
        lambda data: word_of(data, "sensor").update(address=0x14), "sensor = 0x14: lies in build, which has 0x14 to 0x17"),
    "a counter at the address of a word": (
        lambda data: data["counters"].update(base=0x5C), "events_in = 0x5c: lies in commits, which has 0x5c to 0x5f"),
    "a bank over words": (
        lambda data: data["bank"]["filter"].update(base=0x80),
        "bank.filter = 0x80: lies in events_in, which has 0x80 to 0x83"),
    "a word in a bank": (
        lambda data: word_of(data, "memory").update(address=0x204),
        "memory = 0x204: lies in bank.filter, which has 0x200 to 0x27f"),
    "a bank over another": (
        lambda data: data["bank"]["filter"].update(base=0x2080),
        "bank.filter = 0x2080: lies in bank.slot, which has 0x2000 to 0x3fff"),
    "a bank in the middle of what it takes": (
        lambda data: data["bank"]["slot"].update(base=0x1000),
        "bank.slot = 0x1000: must be a multiple of 0x2000, which it takes"),
    "a bank beyond the addresses": (
        lambda data: data.update(address_w=13), "bank.slot = 0x2000 to 0x3fff: must lie in 13 bits of address (address_w)"),
    "a word beyond the addresses": (
        lambda data: word_of(data, "memory").update(address=0x4000),
        "memory = 0x4000 to 0x4003: must lie in 14 bits of address (address_w)"),
    "an address between words": (
        lambda data: word_of(data, "memory").update(address=0x1E),
        "memory = 0x1e: an address must be a multiple of 4"),
    "a bank of an odd number of words": (lambda data: data.update(bank_words=24), "bank_words = 24: must be a power of 2"),
    "a bank too short for its registers": (
        lambda data: data.update(bank_words=8), "bank.filter.activity_ticks = word 7: is the word commit"),
    "fields over one another": (
        lambda data: field_of(data, "control", "drop").update(lsb=0),
        "control_drop: bit 0 is that of control_enable, too"),
    "a field beyond its word": (
        lambda data: field_of(data, "lfsr_x", "span").update(bits=17), "lfsr_x_span = bits 32:16: must lie in 32 bits"),
    "a field without bits": (
        lambda data: field_of(data, "control", "drop").update(bits=0), "control_drop = bits 0:1: must lie in 32 bits"),
    "a word twice": (
        lambda data: data["word"].append(word_of(data, "commits") | {"address": 0x60}),
        "the name commits is that of commits and of commits"),
    "a field twice": (
        lambda data: field_of(data, "control", "drop").update(name="enable"),
        "the name control_enable is that of control and of control"),
    "a word called like a field of another": (
        lambda data: word_of(data, "commits").update(name="status_held"),
        "the name status_held is that of status and of status_held"),
    "a refusal of no register": (
        lambda data: data["bank"]["slot"].update(refuse=["moed"]), "bank.slot.refuse: no register is called moed"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_refuses_a_map_that_does_not_hold_together(name: str) -> None:
    breaks, said = BROKEN[name]
    data = toml()
    breaks(data)
    with refused(ConfigError, start=f"registers.toml: {said}"):
        map_of(data, BANKS)


@pytest.mark.parametrize(
    ("name", "address", "said"),
    [
        ("gain", 3, "bank.slot: word 3 is that of init_radix and of gain"),
        ("gain", 31, "bank.slot.gain = word 31: is the word commit"),
        ("gain", 32, "bank.slot.gain = word 32: must lie from 0 to 30 (bank_words)"),
        ("gain", -1, "bank.slot.gain = word -1: must lie from 0 to 30 (bank_words)"),
        ("commit", 30, "bank.slot: the name commit is that of the last word and of a register"),
        ("mode", 30, "bank.slot.mode = word 30: must be word 0, which takes effect last"),
    ],
)
def test_refuses_a_register_where_another_is(name: str, address: int, said: str) -> None:
    more = REGISTERS | {name: Register(address, 8, 0, None, "", "one more")}
    with refused(ConfigError, f"registers.toml: {said}"):
        map_of(toml(), BANKS | {"slot": more})


def test_takes_registers_up_to_the_last_place() -> None:
    more = REGISTERS | {f"more_{i}": Register(i, 8, 0, None, "", "one more") for i in range(len(REGISTERS), 31)}
    assert map_of(toml(), BANKS | {"slot": more}).banks["slot"].last == 30


def test_every_register_of_motion_is_in_one_bank_and_starts_legal() -> None:
    names = [name for bank in MOTION_BANKS.values() for name in bank]
    assert sorted(names) == sorted(MOTION_RANGES)
    for bank in MOTION_BANKS.values():
        assert all(entry.low <= entry.start <= entry.high for entry in bank.values())
    for rule in MOTION_RULES:  # the two registers of a rule are committed together
        (bank,) = [bank for bank in MOTION_BANKS.values() if rule.less in bank]
        assert rule.times * bank[rule.less].start <= bank[rule.more].start
    addresses = motion_addresses()
    assert addresses["mode"] == 0
    assert len(set(addresses.values())) == len(addresses) == 1 + len(MOTION_RANGES)


def test_registers_of_motion_are_where_the_hardware_says_that_it_has_them() -> None:
    registers = Registers(Memory(build=2 << 16))
    registers.motion.side_max = 99
    assert registers.motion.side_max == 99
    for tracker in (0, 1):
        with pytest.raises(
            ConfigError, match=f"no registers tracks: it was built with TRACKER = {tracker}; TRACKER = 2 builds"
        ):
            _ = Registers(Memory(build=tracker << 16)).tracks


def test_values_after_reset_are_legal() -> None:
    for word in register_map().words:
        for field in word.fields:
            if field.access is Access.RW and isinstance(field.reset, int):
                high = (1 << field.bits) - 1 if field.high is None or isinstance(field.high, str) else field.high
                assert field.low <= field.reset <= high, word.port(field)


def test_the_classes_know_what_hardware_they_speak_to() -> None:
    memory = Memory()
    registers = Registers(memory)
    assert registers.shape == memory.shape
    assert registers.filter_shape == FilterShape(346, 128, 12, 16)
    assert len(registers.slot) == 3
    assert RECORD.itemsize % 4 == 0, "a record fills whole beats of 32 bits"
    with pytest.raises(ConfigError, match="the hardware says that it is 0x00000007: must be 0x45564354, an evcot_top"):
        Registers(Memory(id=7))
    with pytest.raises(ConfigError, match=r"the hardware has version 9\.0 of the registers: must be 3\.x"):
        Registers(Memory(version=9 << 16))


def test_a_slots_register_is_checked_and_then_written_to_its_own_place() -> None:
    memory = Memory()
    registers = Registers(memory)
    memory.accesses.clear()
    registers.slot[2].radix_max = 12
    registers.slot[2].commit()
    bank = register_map().banks["slot"]
    slot = bank.base + 2 * 4 * bank.words
    check = ("read", register_map().word("fault").address)
    places = slot + 4 * REGISTERS["radix_max"].address, slot + 4 * bank.commit
    assert memory.accesses == [("write", places[0]), check, ("write", places[1]), check]
    assert registers.slot[2].radix_max == 12
    memory.words[places[1]] = 7
    assert (registers.slot[2].commit_seq, registers.slot[1].commit_seq) == (7, 0)
    memory.accesses.clear()
    for wrong in (64, -1, 1.5):
        with pytest.raises(ConfigError, match=f"radix_max = {wrong}: must be an integer from 0 to 63 \\(largest g\\)"):
            registers.slot[2].radix_max = wrong  # type: ignore[assignment]
    assert memory.accesses == []


def test_a_field_is_written_with_its_neighbours_as_they_were_and_no_pulse_twice() -> None:
    memory = Memory()
    registers = Registers(memory)
    control, fault = register_map().word("control").address, register_map().word("fault").address
    memory.words[control] = 1 | 1 << 8
    registers.control.drop = 1
    assert memory.words[control] == 3
    memory.words[fault] = 15
    registers.fault.refused = 1
    assert memory.words[fault] == 2  # the others are not cleared


def test_refuses_unknown_names_and_read_only_fields() -> None:
    registers = Registers(Memory())
    with pytest.raises(AttributeError):
        registers.control.enabled = 1  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match="idle is read-only"):
        registers.status.idle = 1

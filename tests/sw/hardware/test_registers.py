# SPDX-License-Identifier: Apache-2.0
"""The register map holds together, and its Python classes speak to any transport."""

from __future__ import annotations

import pytest

from evcot.errors import ConfigError
from evcot.filters.contract import FILTER_REGISTERS, FilterShape
from evcot.hardware.contract import RECORD, REGISTERS, Shape
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import Access, register_map


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


def test_banks_hold_the_registers_of_the_contract_and_lie_apart() -> None:
    banks = register_map().banks
    assert sorted(register.address for register in REGISTERS.values()) == list(range(banks["slot"].commit))
    assert sorted(register.address for register in FILTER_REGISTERS.values()) == list(range(banks["filter"].commit))
    assert set(banks["slot"].refuse) < REGISTERS.keys()
    assert set(banks["filter"].refuse) < FILTER_REGISTERS.keys()
    assert banks["filter"].base + 4 * banks["filter"].words <= banks["slot"].base
    assert banks["slot"].base + 4 * banks["slot"].words * 64 == 1 << register_map().address_w


def test_values_after_reset_are_legal() -> None:
    for word in register_map().words:
        for field in word.fields:
            if field.access is Access.RW and isinstance(field.reset, int):
                high = (1 << field.bits) - 1 if field.high is None or isinstance(field.high, str) else field.high
                assert field.low <= field.reset <= high, word.port(field)


def test_a_record_fills_whole_beats_of_32_bits() -> None:
    assert RECORD.itemsize % 4 == 0


def test_the_classes_know_what_hardware_they_speak_to() -> None:
    memory = Memory()
    registers = Registers(memory)
    assert registers.shape == memory.shape
    assert registers.filter_shape == FilterShape(346, 128, 12, 16)
    assert len(registers.slot) == 3


def test_a_slots_register_is_checked_and_then_written_to_its_own_place() -> None:
    memory = Memory()
    registers = Registers(memory)
    memory.accesses.clear()
    registers.slot[2].radix_max = 12
    registers.slot[2].commit()
    assert memory.accesses == [("write", 0x1000 + 2 * 64 + 7 * 4), ("write", 0x1000 + 2 * 64 + 60)]
    assert registers.slot[2].radix_max == 12
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


def test_refuses_other_hardware() -> None:
    with pytest.raises(ConfigError, match="the hardware says that it is 0x00000007: must be 0x45564354, an evcot_top"):
        Registers(Memory(id=7))
    with pytest.raises(ConfigError, match=r"the hardware has version 9\.0 of the registers: must be 1\.x"):
        Registers(Memory(version=9 << 16))

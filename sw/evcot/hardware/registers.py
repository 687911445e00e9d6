# SPDX-License-Identifier: Apache-2.0
"""The register map of `evcot_top.v`, and access to it from Python.

The map is defined in registers.toml; the registers of a slot and of the filters come from `contract`. The classes of
`register_access` are generated from the two descriptors here, `Bits` and `BankRegister`, by
`python -m evcot.hardware.generate`.
"""

from __future__ import annotations

import tomllib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from importlib.resources import files
from itertools import pairwise
from typing import Any, Protocol, overload

from ..errors import ConfigError
from ..filters.contract import FILTER_REGISTERS, FilterRegister, FilterShape
from ..ranges import check_integer
from .classifier import CLASSIFIER_REGISTERS
from .contract import REGISTERS, SLOTS_MAX, Register, Shape
from .motion.contract import MOTION_BANKS, MotionRegister

__all__ = [
    "Access",
    "Bank",
    "BankGroup",
    "BankRegister",
    "Bits",
    "BusError",
    "Field",
    "Group",
    "Listed",
    "RegisterMap",
    "Transport",
    "Word",
    "map_of",
    "motion_addresses",
    "register_map",
]

Listed = Register | FilterRegister | MotionRegister
"""A register of a bank."""


class Access(StrEnum):
    """Access rights of software to a field."""

    RO = "ro"
    RW = "rw"
    PULSE = "pulse"
    W1C = "w1c"
    PORT = "port"


class BusError(ConfigError):
    """The hardware refused or clamped a value, or the address does not exist: a bus error, or a bit of `fault`."""


class Transport(Protocol):
    """Interface to the registers: a simulation, a serial line, mapped memory. Addresses are in bytes.

    `read` and `write` raise BusError if the hardware returns an error.
    """

    def read(self, address: int) -> int:
        """Read the 32-bit word at an address."""

    def write(self, address: int, value: int) -> None:
        """Write the 32-bit word at an address."""


@dataclass(frozen=True)
class Field:
    """A field of a word; `name` is empty if the field is the whole word.

    Attributes:
        reset: value after reset, or the Verilog parameter that defines it.
        low, high: smallest and largest legal value; a high of "X_W" is the maximum of X_W bits, None is all ones.
        allowed: Verilog parameter with a bit for every legal value, or empty.
        refuses: a write of an illegal value is ignored; else the value is clamped.
        built: Verilog condition under which the field is not 0, of a constant; empty if it may always differ from 0.
    """

    name: str
    lsb: int
    bits: int
    access: Access
    meaning: str
    reset: int | str = 0
    low: int = 0
    high: int | str | None = None
    allowed: str = ""
    refuses: bool = False
    built: str = ""

    @property
    def mask(self) -> int:
        """The field's bit mask in the word."""
        return ((1 << self.bits) - 1) << self.lsb


@dataclass(frozen=True)
class Word:
    """One 32-bit word of the map, outside the banks.

    Attributes:
        built: Verilog condition under which the word exists; empty if it always does.
        where: the same in words.
    """

    name: str
    address: int
    meaning: str
    fields: tuple[Field, ...]
    built: str = ""
    where: str = ""

    @property
    def writable(self) -> bool:
        """Whether a write has any effect."""
        return any(field.access is not Access.RO for field in self.fields)

    @property
    def constant(self) -> bool:
        """Whether the word depends on parameters only."""
        return self.address < 0x20

    @property
    def kept(self) -> int:
        """Mask of the bits that a write to another field must preserve."""
        return sum(field.mask for field in self.fields if field.access in (Access.RW, Access.PORT))

    def port(self, field: Field) -> str:
        """The field's name in Verilog and C."""
        return f"{self.name}_{field.name}" if field.name else self.name


@dataclass(frozen=True)
class Bank:
    """A bank of registers that take effect together when its word `commit` is written.

    Attributes:
        base: address of the first word of the first bank of this kind, in bytes.
        refuse: names of the registers that refuse an illegal value; the others clamp it.
        words: distance from one bank to the next, in words.
        count: maximum number of consecutive banks of this kind.
        registers: its registers, by name.
    """

    name: str
    base: int
    refuse: tuple[str, ...]
    words: int
    count: int
    registers: Mapping[str, Listed]

    @property
    def commit(self) -> int:
        """Index of the word `commit`: the last of the bank."""
        return self.words - 1

    @property
    def word_w(self) -> int:
        """Width of a word's index in the bank, in bits."""
        return self.commit.bit_length()

    @property
    def last(self) -> int:
        """The highest word index of a register."""
        return max(register.address for register in self.registers.values())

    @property
    def bytes(self) -> int:
        """Address space of all banks of this kind, in bytes."""
        return 4 * self.words * self.count


@dataclass(frozen=True)
class RegisterMap:
    """registers.toml, checked."""

    id: int
    version: tuple[int, int]
    address_w: int
    sources: tuple[str, ...]
    trackers: tuple[str, ...]
    banks: dict[str, Bank]
    words: tuple[Word, ...]
    counters: tuple[Word, ...]
    streams: tuple[Word, ...]

    def word(self, name: str) -> Word:
        """The word of this name."""
        return next(word for word in self.words if word.name == name)


def _fields(entries: list[dict[str, Any]], address_w: int) -> tuple[Field, ...]:
    found = []
    for entry in entries:
        values: dict[str, Any] = {"name": "", "lsb": 0, "access": "ro"} | entry
        refuses = values.pop("illegal", "clamp") == "refuse"
        bits = address_w if values["bits"] == "address_w" else values["bits"]
        found.append(Field(**values | {"access": Access(values["access"]), "bits": bits}, refuses=refuses))
    return tuple(found)


def map_of(data: Mapping[str, Any], registers: Mapping[str, Mapping[str, Listed]], slots: int = SLOTS_MAX) -> RegisterMap:
    """Build the map from registers.toml and the registers of each kind of bank, by name.

    Raises:
        ConfigError: a name or an address is used twice, or an entry lies outside its address range.
    """
    address_w = data["address_w"]
    counters = tuple(
        Word(name, data["counters"]["base"] + 4 * i, meaning, (Field("", 0, 32, Access.RO, ""),))
        for i, (name, meaning) in enumerate(data["counters"]["words"].items())
    )
    words = (*(Word(**entry | {"fields": _fields(entry["fields"], address_w)}) for entry in data["word"]), *counters)
    streams = tuple(Word(**entry | {"address": 0, "fields": _fields(entry["fields"], address_w)}) for entry in data["stream"])
    banks = {}
    for name, entry in data["bank"].items():
        count, refuse = slots if name == "slot" else 1, tuple(entry.get("refuse", ()))
        banks[name] = Bank(name, entry["base"], refuse, data["bank_words"], count, registers[name])
    found = RegisterMap(
        data["id"], tuple(data["version"]), address_w, tuple(data["sources"]), tuple(data["trackers"]),
        banks, words, counters, streams,
    )  # fmt: skip
    for problem in _problems(found):
        raise ConfigError(f"registers.toml: {problem}")
    return found


@cache
def register_map() -> RegisterMap:
    """The register map of `evcot_top.v`.

    Raises:
        ConfigError: as for `map_of`.
    """
    data = tomllib.loads(files("evcot.hardware").joinpath("registers.toml").read_text(encoding="utf-8"))
    return map_of(data, {"slot": REGISTERS, "filter": FILTER_REGISTERS, **MOTION_BANKS, "classifier": CLASSIFIER_REGISTERS})


def motion_addresses() -> dict[str, int]:
    """Word addresses on the register port of cot_motion.v: a slot's `mode`, then those of the banks of motion, one behind the
    other."""
    found = {"mode": REGISTERS["mode"].address}
    for number, name in enumerate(MOTION_BANKS):
        bank = register_map().banks[name]
        found |= {register: bank.words * number + entry.address for register, entry in bank.registers.items()}
    return found


def _problems(found: RegisterMap) -> Iterator[str]:
    """Inconsistencies of the map, one line each."""
    for kind, width in ((found.words, 32), (found.streams, 64)):
        yield from _twice("the name", ((word.port(field), word.name) for word in kind for field in word.fields))
        yield from _twice("the name", ((word.name, f"word {i}") for i, word in enumerate(kind)))
        for word in kind:
            yield from _field_problems(word, width)
    for bank in found.banks.values():
        yield from _bank_problems(bank)

    places = [(word.address, word.address + 4, word.name) for word in found.words]
    places += [(bank.base, bank.base + bank.bytes, f"bank.{bank.name}") for bank in found.banks.values()]
    for begin, end, name in places:
        if begin % 4:
            yield f"{name} = {begin:#x}: an address must be a multiple of 4"
        if not 0 <= begin < end <= 1 << found.address_w:
            yield f"{name} = {begin:#x} to {end - 1:#x}: must lie in {found.address_w} bits of address (address_w)"
    for (begin, end, name), (other_begin, _, other) in pairwise(sorted(places)):
        if other_begin < end:
            yield f"{other} = {other_begin:#x}: lies in {name}, which has {begin:#x} to {end - 1:#x}"


def _twice(what: str, entries: Iterable[tuple[object, str]]) -> Iterator[str]:
    """Keys that are used by two owners."""
    owners: dict[object, str] = {}
    for key, owner in entries:
        if key in owners:
            yield f"{what} {key} is that of {owners[key]} and of {owner}"
        owners[key] = owner


def _field_problems(word: Word, width: int) -> Iterator[str]:
    taken: dict[int, str] = {}
    for field in word.fields:
        name = word.port(field)
        if field.bits < 1 or field.lsb < 0 or field.mask >> width:
            yield f"{name} = bits {field.lsb + field.bits - 1}:{field.lsb}: must lie in {width} bits"
        for bit in range(field.lsb, field.lsb + field.bits):
            if bit in taken:
                yield f"{name}: bit {bit} is that of {taken[bit]}, too"
            taken[bit] = name


def _bank_problems(bank: Bank) -> Iterator[str]:
    if bank.words < 2 or bank.words & bank.commit:
        yield f"bank_words = {bank.words}: must be a power of 2, at least 2"
    room = 1 << (bank.bytes - 1).bit_length()
    if bank.base % room:
        yield f"bank.{bank.name} = {bank.base:#x}: must be a multiple of {room:#x}, which it takes"
    yield from _twice(f"bank.{bank.name}: word", ((register.address, name) for name, register in bank.registers.items()))
    for name, register in bank.registers.items():
        if name == "commit":
            yield f"bank.{bank.name}: the name commit is that of the last word and of a register"
        if register.address == bank.commit:
            yield f"bank.{bank.name}.{name} = word {register.address}: is the word commit"
        elif not 0 <= register.address < bank.commit:
            yield f"bank.{bank.name}.{name} = word {register.address}: must lie from 0 to {bank.commit - 1} (bank_words)"
    if "mode" in bank.registers and bank.registers["mode"].address != 0:
        yield f"bank.{bank.name}.mode = word {bank.registers['mode'].address}: must be word 0, which takes effect last"
    for name in bank.refuse:
        if name not in bank.registers:
            yield f"bank.{bank.name}.refuse: no register is called {name}"


class Group:
    """Named words at a base address on a transport.

    Raises:
        BusError: on access, if the register `fault` records the access. The read of a word outside the banks is not checked.
    """

    __slots__ = ("_base", "_transport", "filter_shape", "shape")

    def __init__(self, transport: Transport, base: int, shape: Shape, filter_shape: FilterShape) -> None:
        self._transport = transport
        self._base = base
        self.shape = shape
        self.filter_shape = filter_shape

    def _read(self, address: int) -> int:
        value = self._transport.read(self._base + address)
        if self._base:
            self._check_fault("read", self._base + address)
        return value

    def _write(self, address: int, value: int) -> None:
        self._transport.write(self._base + address, value)
        self._check_fault(f"write of {value:#x}", self._base + address)

    def _check_fault(self, what: str, address: int) -> None:
        """Raise if the last fault was at this address; clears `fault` first."""
        fault = register_map().word("fault")
        found = self._transport.read(fault.address)
        *flags, place = fault.fields
        kinds = [flag for flag in flags if found & flag.mask]
        if kinds and (found & place.mask) >> place.lsb == address:
            self._transport.write(fault.address, sum(flag.mask for flag in kinds))
            raise BusError(f"{what} at {address:#06x}: {'; '.join(flag.meaning for flag in kinds)}")


class BankGroup(Group):
    """Registers with shadows: what is written takes effect at a commit."""

    __slots__ = ()

    def commit(self) -> None:
        """Make all values written take effect, at one point between two events.

        Raises:
            BusError: they contradict each other; nothing has changed.
        """
        self._write(_commit_address(), 1)

    @property
    def commit_seq(self) -> int:
        """Low 32 bits of the number of the first event processed with the values committed last."""
        return self._read(_commit_address())


def _commit_address() -> int:
    """Address of the word commit in its bank, the same in all."""
    return 4 * register_map().banks["slot"].commit


class _Value(ABC):
    """Descriptor of a number on the bus: reading the attribute reads the hardware, setting it writes the hardware."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, group: None, owner: type) -> _Value: ...
    @overload
    def __get__(self, group: Group, owner: type) -> int: ...
    def __get__(self, group: Group | None, owner: type) -> _Value | int:
        return self if group is None else self._get(group)

    def __set__(self, group: Group, value: int) -> None:
        self._set(group, value)

    @abstractmethod
    def _get(self, group: Group) -> int:
        """Read the value from the hardware."""

    @abstractmethod
    def _set(self, group: Group, value: int) -> None:
        """Write the value if it is legal."""

    def _check(self, value: int, low: int, high: int, meaning: str) -> int:
        """The value as an int; raises before any bus access if it is illegal."""
        check_integer(self.name, value, low, high, meaning)
        return int(value)


class Bits(_Value):
    """A field of a word outside the banks, by the names of both in the map."""

    def __init__(self, word: str, field: str = "") -> None:
        self.word = register_map().word(word)
        self.field = next(entry for entry in self.word.fields if entry.name == field)
        self.__doc__ = self.field.meaning or self.word.meaning

    def _get(self, group: Group) -> int:
        return (group._read(self.word.address) & self.field.mask) >> self.field.lsb

    def _set(self, group: Group, value: int) -> None:
        field = self.field
        if field.access is Access.RO:
            raise AttributeError(f"{self.name} is read-only ({self.__doc__})")
        high = field.high
        if isinstance(high, str):
            high = (1 << getattr(group.shape, high.lower())) - 1
        new = self._check(value, field.low, field.mask >> field.lsb if high is None else high, str(self.__doc__)) << field.lsb
        kept = self.word.kept & ~field.mask
        group._write(self.word.address, new | (group._read(self.word.address) & kept if kept else 0))


class BankRegister(_Value):
    """A register of a bank: written to the bank's shadow register, in effect after `commit`."""

    def __init__(self, bank: str, name: str) -> None:
        entry = register_map().banks[bank].registers[name]
        self.address = 4 * entry.address
        self.meaning = entry.meaning
        self.limits: Callable[[Any], tuple[int, int]] = entry.limits
        self.of_filters = bank == "filter"
        self.__doc__ = entry.meaning

    def _get(self, group: Group) -> int:
        return group._read(self.address)

    def _set(self, group: Group, value: int) -> None:
        low, high = self.limits(group.filter_shape if self.of_filters else group.shape)
        group._write(self.address, self._check(value, low, high, self.meaning))

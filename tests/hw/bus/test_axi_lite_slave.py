# SPDX-License-Identifier: Apache-2.0
"""The five channels of AXI4-Lite become one access at a time."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping
from itertools import chain

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware.registers import Access, Field, Word, register_map
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load


class Slave:
    """The slave, with someone behind it who answers after a few clocks and notes what it was asked."""

    def __init__(self, answers_after: int = 1) -> None:
        self.sim: PyVerilator = load("axi_lite_slave", {"ADDR_W": 8})
        reset(self.sim)
        self.answers_after = answers_after
        self.waited = 0
        self.asked: list[tuple[str, int]] = []
        self.given: list[tuple[str, int]] = []

    def clocks(self, n: int, **inputs: int) -> None:
        """Clocks with these inputs; an address or a word on offer is taken back when it has been taken."""
        io = self.sim.io
        for port, value in inputs.items():
            io[port] = value
        for _ in range(n):
            answers = bool(io.request_valid) and self.waited >= self.answers_after
            io.answer, io.answer_data, io.answer_error = int(answers), 0x100 + int(io.request_word), int(io.request_word) == 7
            if answers:
                self.asked.append(("write" if io.request_write else "read", int(io.request_word)))
            self.waited = 0 if answers else self.waited + int(io.request_valid)
            taken = [channel for channel in ("aw", "w", "ar") if io[f"s_axil_{channel}valid"] and io[f"s_axil_{channel}ready"]]
            if io.s_axil_bvalid and io.s_axil_bready:
                self.given.append(("b", int(io.s_axil_bresp)))
            if io.s_axil_rvalid and io.s_axil_rready:
                self.given.append(("r", int(io.s_axil_rdata) << 2 | int(io.s_axil_rresp)))
            self.sim.clock.tick()
            for channel in taken:
                io[f"s_axil_{channel}valid"] = 0


READY = {"s_axil_bready": 1, "s_axil_rready": 1}


def test_address_and_data_of_a_write_come_in_any_order() -> None:
    for first, second in ((("aw", {"s_axil_awaddr": 20}), ("w", {})), (("w", {}), ("aw", {"s_axil_awaddr": 20}))):
        slave = Slave()
        slave.clocks(6, s_axil_wdata=0x1234, s_axil_wstrb=5, **{f"s_axil_{first[0]}valid": 1}, **first[1], **READY)
        assert slave.asked == []
        slave.clocks(6, **{f"s_axil_{second[0]}valid": 1}, **second[1])
        assert (slave.asked, slave.given) == ([("write", 5)], [("b", 0)])
        assert (slave.sim.io.request_data, slave.sim.io.request_strb) == (0x1234, 5)


def test_an_error_is_slverr_and_a_read_brings_its_word() -> None:
    slave = Slave()
    slave.clocks(6, s_axil_arvalid=1, s_axil_araddr=4 * 7, **READY)
    slave.clocks(6, s_axil_arvalid=1, s_axil_araddr=4 * 9 + 3)
    slave.clocks(6, s_axil_awvalid=1, s_axil_awaddr=4 * 7, s_axil_wvalid=1)
    assert slave.given == [("r", 0x107 << 2 | 2), ("r", 0x109 << 2), ("b", 2)]


def test_reads_and_writes_that_wait_take_turns() -> None:
    slave = Slave(answers_after=0)
    for _ in range(12):
        slave.clocks(1, s_axil_arvalid=1, s_axil_araddr=4, s_axil_awvalid=1, s_axil_awaddr=8, s_axil_wvalid=1, **READY)
    assert slave.asked[:4] in ([("read", 1), ("write", 2)] * 2, [("write", 2), ("read", 1)] * 2)


def test_a_response_waits_and_holds_up_its_own_kind_alone() -> None:
    slave = Slave()
    slave.clocks(8, s_axil_awvalid=1, s_axil_awaddr=8, s_axil_wvalid=1, s_axil_rready=1)
    assert slave.sim.io.s_axil_bvalid == 1
    slave.clocks(8, s_axil_awvalid=1, s_axil_awaddr=12, s_axil_wvalid=1, s_axil_arvalid=1, s_axil_araddr=16)
    assert slave.asked == [("write", 2), ("read", 4)]
    slave.clocks(8, s_axil_bready=1)
    assert slave.asked[2:] == [("write", 3)]
    assert slave.given == [("r", 0x104 << 2), ("b", 0), ("b", 0)]


def test_a_word_that_was_read_waits_and_holds_up_its_own_kind_alone() -> None:
    slave = Slave()
    slave.clocks(8, s_axil_arvalid=1, s_axil_araddr=8, s_axil_bready=1)
    assert slave.sim.io.s_axil_rvalid == 1
    slave.clocks(8, s_axil_arvalid=1, s_axil_araddr=12, s_axil_awvalid=1, s_axil_awaddr=16, s_axil_wvalid=1)
    assert slave.asked == [("read", 2), ("write", 4)]
    slave.clocks(8, s_axil_rready=1)
    assert slave.asked[2:] == [("read", 3)]
    assert slave.given == [("b", 0), ("r", 0x102 << 2), ("r", 0x103 << 2)]


def test_an_access_stands_until_answered() -> None:
    slave = Slave(answers_after=50)
    slave.clocks(40, s_axil_arvalid=1, s_axil_araddr=8, **READY)
    assert (slave.sim.io.request_valid, slave.sim.io.request_word, slave.asked) == (1, 2, [])
    slave.clocks(20)
    assert slave.asked == [("read", 2)]


TOP = "axi_lite_words"
WITH_ALL = {"X_W": 6, "Y_W": 16, "SOURCE": 3, "SOURCES": 0b101011, "TICKS": 3, "CLASSIFY": 1}
WITH_LEAST = {"X_W": 9, "Y_W": 8, "SOURCE": 0, "SOURCES": 0b001001, "TICKS": 0, "CLASSIFY": 0}
WORDS = register_map().words
FIELDS = [(word, field) for word in WORDS for field in word.fields]


def value_of(number: int | str, parameters: Mapping[str, int]) -> int:
    """A number of the map, or what it says of the parameters."""
    if number in ("X_W", "Y_W"):
        return (1 << parameters[str(number)]) - 1
    if number == "TICKS_32[1] ? 3 : 1":
        return 3 if parameters["TICKS"] & 2 else 1
    return parameters[str(number)] if isinstance(number, str) else number


def is_built(word: Word, parameters: Mapping[str, int]) -> bool:
    """Whether a word exists with these parameters."""
    if "CLASSIFY" in word.built:
        return bool(parameters["CLASSIFY"])
    bits = re.findall(r"(SOURCES|TICKS)_32\[(\d)\]", word.built)
    return not word.built or any(parameters[name] >> int(bit) & 1 for name, bit in bits)


def port(word: Word, field: Field) -> str:
    """Of the field's value, or of the pulse that clears or writes it."""
    return word.port(field) + {Access.W1C: "_clear", Access.PORT: "_write"}.get(field.access, "")


class Model:
    """The map by itself.

    Attributes:
        kept: port of each field that software writes -> its value.
        pulses: port of each field that lasts a clock -> its value in this one.
        new: port of a value that is written into other hardware in this clock -> that value.
    """

    def __init__(self, parameters: Mapping[str, int]) -> None:
        self.parameters = parameters
        self.kept = {
            port(word, field): value_of(field.reset, parameters) for word, field in FIELDS if field.access is Access.RW
        }
        self.pulses = {port(word, field): 0 for word, field in FIELDS if field.access not in (Access.RO, Access.RW)}

    def asked(self, word: Word | None, data: int, inputs: Mapping[str, int] | None = None) -> dict[str, int]:
        """What an access reads, with these values of what software only reads."""
        fields = word.fields if word else ()
        result = defaultdict(int, inputs or {}) | self.kept
        shut = any(f.access is Access.PORT and not result[f"{word.port(f)}_ready"] for f in fields if word)
        return {
            "known": int(word is not None),
            "writable": int(word is not None and word.writable),
            "value": sum(
                result[word.port(f)] << f.lsb
                for f in fields
                if word and f.access is not Access.PULSE and (not f.built or self.parameters["CLASSIFY"])
            ),
            "keeps": int(word is None or not word.writable or word.kept != 0),
            "clamped": int(any(legal(f, data, self.parameters) not in (None, written(f, data)) for f in fields)),
            "refused": int(shut or any(legal(f, data, self.parameters) is None for f in fields)),
        }

    def write(self, word: Word | None, data: int, inputs: Mapping[str, int]) -> None:
        """The clock after a write, or after none."""
        self.pulses = dict.fromkeys(self.pulses, 0)
        self.new: dict[str, int] = {}
        if word is None or self.asked(word, data, inputs)["refused"]:
            return
        for field in word.fields:
            if field.access is Access.PORT:
                self.pulses[port(word, field)] = 1
                self.new[f"{word.port(field)}_new"] = legal(field, data, self.parameters) or 0
            elif field.access is not Access.RO:
                (self.kept if field.access is Access.RW else self.pulses)[port(word, field)] = (
                    legal(field, data, self.parameters) or 0
                )


def written(field: Field, data: int) -> int:
    """What a write says of a field: its bits of the data, but all 32 where the field is the whole word and has limits."""
    limited = field.access in (Access.RW, Access.PORT) and (field.low or field.high is not None)
    return data if limited and not field.name else (data & field.mask) >> field.lsb


def legal(field: Field, data: int, parameters: Mapping[str, int]) -> int | None:
    """What a write makes of a field: the nearest legal value, or None where it is refused."""
    value = written(field, data)
    if field.access not in (Access.RW, Access.PORT):
        return value
    if field.allowed:
        return value if value_of(field.allowed, parameters) >> value & 1 else None
    return min(max(value, field.low), (1 << field.bits) - 1 if field.high is None else value_of(field.high, parameters))


@pytest.mark.parametrize("parameters", [WITH_ALL, WITH_LEAST], ids=["all", "least"])
def test_every_access_does_what_the_map_says(parameters: dict[str, int]) -> None:
    """All addresses, then 6,000 random accesses to those that there are; reset gives every field its reset value."""
    rng, model, sim = np.random.default_rng(82), Model(parameters), load(TOP, parameters)
    io = sim.io
    reset(sim)
    inputs = {word.port(field): field.bits for word, field in FIELDS if field.access not in (Access.RW, Access.PULSE)}
    inputs |= {f"{word.port(field)}_ready": 1 for word, field in FIELDS if field.access is Access.PORT}
    known = {word.address // 4: word for word in WORDS if is_built(word, parameters)}
    seen = dict.fromkeys(("clamped", "refused"), 0)
    for number in chain(range(1 << 11), rng.choice(list(known), 6_000).tolist()):
        word, writes = known.get(number), bool(rng.random() < 0.7)
        data = int(
            rng.choice([0, 1, 1 << 20, 0xFFFF_FFFF, int(rng.integers(1 << 32)), int(rng.integers(1 << 32)) & 0x003F_003F])
        )
        io.word, io.data = number, data
        given = {name: int(rng.integers(1 << bits)) for name, bits in inputs.items() if word and name.startswith(word.name)}
        for name, value in given.items():
            io[name] = value
        reads = model.asked(word, data, given)
        for _ in range(2):
            sim.clock.tick()
        assert {name: int(io[name]) for name in reads} == reads, f"word {number:#x}, data {data:#x}"
        io.write = int(writes)
        sim.clock.tick()
        io.write = 0
        model.write(word if writes else None, data, given)
        assert {name: int(io[name]) for name in model.new} == model.new
        for name in [port(word, field) for field in word.fields if field.access is not Access.RO] if word else []:
            assert io[name] == (model.kept | model.pulses)[name], f"{name}, data {data:#x}"
        seen = {name: count + reads[name] for name, count in seen.items()}
    assert {name: int(io[name]) for name in model.kept | model.pulses} == model.kept | model.pulses
    assert seen["refused"] > 30
    assert seen["clamped"] > 50 or parameters is WITH_LEAST
    reset(sim)
    assert {name: int(io[name]) for name in Model(parameters).kept} == Model(parameters).kept

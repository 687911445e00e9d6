# SPDX-License-Identifier: Apache-2.0
"""A compiled `evcot_top` as a Python object: streams words through it while its registers are read and written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.errors import ConfigError
from evcot.filters.contract import FILTER_SHAPE_RANGES, mask_word
from evcot.hardware.classifier import CLASSIFIER_REGISTERS, VERDICT_KIND, VERDICT_RECORD
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import RECORD, REGISTERS
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RECORD
from evcot.hardware.registers import BusError, register_map
from evcot.hardware.streams import unpack, whole_numbers
from evcot.recognition.model import Network
from evcot.recognition.weight_memory import memory_words
from evcot.tracks.log import DROPPED

from ..rtl.build import PORTS_ONLY_FLAGS, RANDOM_INITIAL_FLAGS, build
from .base import Drive, Ending, HardwareError, pointer, reset
from .device import order_of
from .driver import PARAMETERS

__all__ = [
    "COMMAND",
    "Command",
    "Op",
    "Pace",
    "TopDevice",
    "TopRun",
    "address_of",
    "bank_address",
    "classifier_weights",
    "classifier_writes",
    "configuration",
    "filter_address",
    "parameters_of",
    "poll",
    "poll_status",
    "read",
    "slot_address",
    "write",
]


class Op(IntEnum):
    """What a command does."""

    READ = 0
    WRITE = 1
    POLL = 2  # read until the masked word is `data`


class _Status(Ending):
    """Return codes of a run."""

    DONE = ""
    UNFINISHED = "was in the middle of a transfer when its clocks were over"
    STUCK = "stands still: no handshake for a million clocks"
    RECORDS_CHANGED = "withdrew or changed a beat of m_axis_records that waited"
    RECORD_CUT = "gave a record of another length, or a tkeep with holes"
    OWNED_CHANGED = "withdrew or changed a beat of m_axis_owned that waited, or set its tkeep or tlast wrong"
    PASSED_CHANGED = "withdrew or changed a beat of m_axis_passed that waited, or set its tkeep or tlast wrong"
    BUS_CHANGED = "withdrew or changed a response that waited"
    BUS_INVENTED = "gave a response without a request"
    TOO_MANY_RECORDS = "gave more records than its events can cause"
    TOO_MANY_EVENTS = "gave more events than went in"


# An access to the registers: it begins when the previous one is complete and `after` input words have been accepted.
COMMAND = np.dtype(
    [
        ("after", "<i8"), ("began", "<i8"), ("ended", "<i8"), ("op", "<u4"), ("address", "<u4"), ("data", "<u4"),
        ("mask", "<u4"), ("result", "<u4"), ("response", "<u4"), ("accesses", "<u4"), ("_pad", "<u4"),
    ]
)  # fmt: skip
_C_TYPES = {"i8": "int64_t", "u4": "uint32_t"}
Command = tuple[int, int, int, int, int]
"""after, operation, address, data, mask: made by `read`, `write` and `poll`."""

_SEQ_BITS = next(field.bits for field in register_map().streams[1].fields if field.name == "seq")


def read(address: int, after: int = 0) -> Command:
    """A command that reads a word."""
    return after, Op.READ, address, 0, 0


def write(address: int, data: int, after: int = 0, strb: int = 15) -> Command:
    """A command that writes the bytes `strb` of a word."""
    return after, Op.WRITE, address, data, strb


def poll(address: int, mask: int, data: int, after: int = 0) -> Command:
    """A command that reads a word until its masked bits are `data`."""
    return after, Op.POLL, address, data, mask


def poll_status(field: str, value: int, after: int = 0) -> Command:
    """A command that reads the status until a field of one bit has a value."""
    word = register_map().word("status")
    mask = next(one.mask for one in word.fields if one.name == field)
    return poll(word.address, mask, mask * value, after)


def address_of(name: str) -> int:
    """Address of a word outside the banks."""
    return register_map().word(name).address


def bank_address(bank: str, register: str = "commit", number: int = 0) -> int:
    """Address of a register of a bank, or of the word that commits it; `number` counts the banks of this kind."""
    found = register_map().banks[bank]
    word = found.commit if register == "commit" else found.registers[register].address
    return found.base + 4 * (found.words * number + word)


def slot_address(slot: int, register: str = "commit") -> int:
    """Address of a slot's register, or of the word that commits it."""
    return bank_address("slot", register, slot)


def filter_address(register: str = "commit") -> int:
    """Address of a register of the filters, or of the word that commits them."""
    return bank_address("filter", register)


def parameters_of(config: CotConfig | MotionConfig) -> dict[str, int]:
    """The Verilog parameters of `evcot_top` that a configuration decides; HAS and the sources are not among them.

    Raises:
        ConfigError: a module that `evcot_top` does not contain.
    """
    trackers, module = register_map().trackers, config.module.removeprefix("cot_")
    if module not in trackers:
        raise ConfigError(f"module = {config.module!r}: must be one of cot_{', cot_'.join(trackers)} for evcot_top")
    found = {verilog_name: getattr(config.shape, name) for name, verilog_name in PARAMETERS.items()}
    found |= {name.upper(): getattr(config.filter_shape, name) for name in FILTER_SHAPE_RANGES if name != "cell_stamp_w"}
    return {"TRACKER": trackers.index(module), **found}


def configuration(config: CotConfig | MotionConfig) -> list[Command]:
    """The accesses that write and commit a configuration."""
    found = []
    if isinstance(config, MotionConfig):
        for slot, mode in enumerate(config.modes):
            found += [write(slot_address(slot, "mode"), int(mode)), write(slot_address(slot), 1)]
        for bank, listed in MOTION_BANKS.items():
            found += [write(bank_address(bank, name), int(getattr(config.registers, name))) for name in listed]
            found.append(write(bank_address(bank), 1))
    else:
        for slot, registers in enumerate(config.slots):
            found += [write(slot_address(slot, name), int(getattr(registers, name))) for name in REGISTERS]
            found.append(write(slot_address(slot), 1))
    if config.filtered:
        if config.filters.hot_pixels:
            found.append(poll_status("cleared", 1))
            found += [write(filter_address("mask"), mask_word(x, y)) for x, y in config.filters.hot_pixels]
        names = sorted(register_map().banks["filter"].registers.keys() - {"mask"})
        found += [write(filter_address(name), int(getattr(config.filters, name))) for name in names]
        found.append(write(filter_address(), 1))
    return found


def classifier_weights(network: Network, after: int = 0) -> list[Command]:
    """The accesses that turn the classifier off and write all of its weights."""
    off = [*classifier_writes({"enable": 0}, after), poll_status("pending", 0)]
    words = [write(address_of("weight_data"), word) for word in memory_words(network).tolist()]
    return [*off, write(address_of("weight_address"), 0), *words]


def classifier_writes(values: Mapping[str, int], after: int = 0) -> list[Command]:
    """The accesses that write registers of the classifier and commit them."""
    unknown = sorted(values.keys() - CLASSIFIER_REGISTERS)
    if unknown:
        raise ConfigError(f"classifier.{unknown[0]}: must be one of {', '.join(CLASSIFIER_REGISTERS)}")
    writes = [write(bank_address("classifier", name), int(value), after) for name, value in values.items()]
    return [*writes, write(bank_address("classifier"), 1, after)]


_GOES = ("in", "records", "owned", "passed", "bus")
_DRIVE = Drive(
    "evcot_top_run",
    "top.cpp.j2",
    {
        "n": "int64_t",
        "next": "int64_t",
        "words": "const uint64_t*",
        "keeps": "const uint8_t*",
        "accepted": "int64_t*",
        "commands": "Command*",
        "n_commands": "int64_t",
        "most_polls": "int64_t",
        "records": "uint8_t*",
        "recorded": "int64_t*",
        "record_capacity": "int64_t",
        "n_records": "int64_t",
        "owned": "uint64_t*",
        "user": "uint8_t*",
        "n_owned": "int64_t",
        "passed": "uint64_t*",
        "n_passed": "int64_t",
        "event_capacity": "int64_t",
        "clocks": "int64_t",  # length of the run; 0: until everything has been processed
        "quiet_clocks": "int64_t",
        "step_clocks": "int64_t",  # that motion steps may take between two handshakes
        **{f"go_{name}": "int64_t" for name in _GOES},  # of 256
        "random": "uint64_t",
        "clock": "int64_t",
        "irq_clock": "int64_t",
        "fault": "int64_t",
    },
    _Status,
    structures={"Command": {name: _C_TYPES[COMMAND[name].str[1:]] for name in COMMAND.names or ()}},
)


@cache
def _source(data_w: int, record_bytes: int) -> str:
    ops = [op.name for op in Op]
    return _DRIVE.source("evcot_top", data_w=data_w, record_bytes=record_bytes, command_bytes=COMMAND.itemsize, ops=ops)


@dataclass(frozen=True)
class Pace:
    """Probability in 256ths that each channel goes at a clock: the input, the three outputs, and the channels of the bus."""

    goes: Mapping[str, int] = field(default_factory=dict)
    seed: int = 1

    @classmethod
    def random(cls, rng: np.random.Generator) -> Pace:
        """A random probability of at least 0.15 for each channel."""
        return cls({name: int(rng.integers(40, 257)) for name in _GOES}, int(rng.integers(1, 1 << 62)))


class TopRun(NamedTuple):
    """Results of a run.

    Attributes:
        records: (m,) RECORD, of cot_motion MOTION_RECORD, in the order received.
        owned, passed: words, uint64: see `evcot.hardware.streams`.
        user: (k,) uint8, tuser of each owned event.
        commands: (c,) COMMAND, with result and response.
        accepted: clock at which each input word was accepted.
        recorded: clock of each record's first beat.
        verdicts: (v,) VERDICT_RECORD, those of the classifier, which are not among `records`.
        irq_clock: clock at which the interrupt was first high, or -1.
        seq_bits: how many low bits of an event's number its word holds.
    """

    records: NDArray[np.void]
    owned: NDArray[np.uint64]
    passed: NDArray[np.uint64]
    user: NDArray[np.uint8]
    commands: NDArray[np.void]
    accepted: NDArray[np.int64]
    recorded: NDArray[np.int64]
    irq_clock: int
    seq_bits: int
    verdicts: NDArray[np.void]

    def decisions(self, first: int, n: int, chain: bool = False) -> Decisions:
        """Decisions on events `first` to `first + n - 1`, which must be those of this run, in the model's format.

        The records of a chain are sorted chronologically.

        Raises:
            HardwareError: an event was sent twice or out of order.
        """
        owner, rel = np.full(n, DROPPED, np.int16), np.zeros((2, n), np.uint16)
        for stream, words in (("owned", self.owned), ("passed", self.passed)):
            found = unpack(stream, words)
            index = whole_numbers(found["seq"], self.seq_bits, first) - first
            if len(index) and (index.min() < 0 or index.max() >= n or np.any(owner[index] != DROPPED)):
                raise HardwareError(f"evcot_top gave {stream} events twice, or events that never went in", first)
            if len(np.unique(index)) < len(index) or (not chain and np.any(np.diff(index) < 0)):
                raise HardwareError(f"evcot_top gave {stream} events twice, or out of order", first)
            owner[index] = found["slot"] if stream == "owned" else -1
            if stream == "owned":
                rel[:, index] = found["x"], found["y"]
        return Decisions(self.records[order_of(self.records)] if chain else self.records, owner, *rel)


class TopDevice:
    """One simulated `evcot_top`; a transport for `evcot.hardware.register_access.Registers`.

    Every output is checked to hold its word until accepted, whatever the back-pressure.

    Args:
        config: gives the shapes; its registers are written over the bus by `configure`.
        parameters: values for other Verilog parameters, such as SOURCES; TRACKER follows from the module of `config`.
        pace: stalls at the other end of every channel.
        initial_seed: registers begin with random values by this seed; 0: with zeros.

    Raises:
        ConfigError: a TRACKER that is not the module of `config`.
        ToolchainError: it cannot be built.
    """

    def __init__(
        self,
        config: CotConfig | MotionConfig,
        parameters: Mapping[str, int] | None = None,
        *,
        pace: Pace | None = None,
        verilog: Path | None = None,
        initial_seed: int = 0,
    ) -> None:
        self.config = config
        self.pace = pace or Pace()
        needed = parameters_of(config)
        chosen = needed | dict(parameters or {})
        if chosen["TRACKER"] != needed["TRACKER"]:
            raise ConfigError(f"TRACKER = {chosen['TRACKER']}: must be {needed['TRACKER']}, that of {config.module}")
        self.record: np.dtype[np.void] = MOTION_RECORD if isinstance(config, MotionConfig) else RECORD
        drive = _source(chosen.get("DATA_W", 64), self.record.itemsize)
        flags = (*PORTS_ONLY_FLAGS, *(RANDOM_INITIAL_FLAGS if initial_seed else ()))
        self.model = build("evcot_top", chosen, {"top.cpp": drive}, extra_flags=flags, verilog=verilog)
        self.sim: PyVerilator = self.model.load(initial_seed)
        self.reset()

    def reset(self) -> None:
        """Reset the hardware."""
        reset(self.sim, 4)
        self.clock = 0
        self._random = self.pace.seed

    def configure(self, config: CotConfig | MotionConfig | None = None) -> None:
        """Write all registers of a configuration of the same shape, commit them, and enable the event input.

        Raises:
            ConfigError: a configuration of another module.
        """
        if config is not None and config.module != self.config.module:
            raise ConfigError(f"module = {config.module!r}: must be {self.config.module!r}, as it was built")
        self.run(commands=[*configuration(config or self.config), poll_status("pending", 0), write(address_of("control"), 1)])

    def run(
        self,
        words: NDArray[np.uint64] | None = None,
        commands: Sequence[Command] = (),
        *,
        keeps: NDArray[np.uint8] | None = None,
        clocks: int = 0,
        quiet_clocks: int = 10_000,
        most: int | None = None,
        take_outputs: bool = True,
        step_clocks: int = 0,
        cut: bool = False,
    ) -> TopRun:
        """Stream words and access registers until there was no handshake for `quiet_clocks`, or for `clocks` clocks.

        Args:
            words: input words.
            commands: made by `read`, `write` and `poll`; each begins when the previous one is complete.
            keeps: tkeep of each word; all ones if None.
            quiet_clocks: must exceed the time a filter needs to clear its memory, if the run is to wait for that.
            most: maximum number of output events (default: the number of input words).
            take_outputs: accept outputs; otherwise they wait for the next run.
            step_clocks: what motion steps may take between two handshakes, beyond a million clocks (`device.step_clocks`).
            cut: the clocks may end in the middle of a transfer; a reset must follow.

        Raises:
            HardwareError: the hardware violated the protocol of a channel, or made no progress.
        """
        words = np.ascontiguousarray(np.empty(0) if words is None else words, np.uint64)
        keeps = None if keeps is None else np.ascontiguousarray(keeps, np.uint8)
        n = len(words) + 64 if most is None else most
        table = np.zeros(max(1, len(commands)), COMMAND)
        for row, (after, op, address, data, mask) in zip(table, commands, strict=False):
            row["after"], row["op"], row["address"], row["data"], row["mask"] = after, op, address, data, mask
        accepted = np.zeros(max(1, len(words)), np.int64)
        # With motion each step moves every slot, so that there is no limit.
        most_records = 3 * n + 1024 if self.record == RECORD else 40 * n + 65_536
        records, recorded = np.zeros(most_records, self.record), np.zeros(most_records, np.int64)
        owned, passed = np.zeros(n + 1024, np.uint64), np.zeros(n + 1024, np.uint64)
        user = np.zeros(n + 1024, np.uint8)
        job = _DRIVE.job(
            n=len(words), words=pointer(words), keeps=pointer(keeps), accepted=pointer(accepted),
            commands=pointer(table), n_commands=len(commands), most_polls=1 << 20,
            records=pointer(records), recorded=pointer(recorded), record_capacity=len(records),
            owned=pointer(owned), user=pointer(user), passed=pointer(passed), event_capacity=len(owned),
            clocks=clocks, quiet_clocks=quiet_clocks, step_clocks=step_clocks,
            random=self._random, clock=self.clock, irq_clock=-1,
            **{f"go_{name}": self.pace.goes.get(name, 256) for name in ("in", "bus")},
            **{f"go_{name}": take_outputs * self.pace.goes.get(name, 256) for name in ("records", "owned", "passed")},
        )  # fmt: skip
        status = _DRIVE.call(self.sim, job)
        self.clock, self._random = job.clock, job.random
        if status != _Status.DONE and not (cut and status == _Status.UNFINISHED):
            raise HardwareError(f"evcot_top {status.fault} (clock {job.fault}, word {job.next})", job.next)
        records, recorded = records[: job.n_records], recorded[: job.n_records]
        of_tracks = records["kind"] != VERDICT_KIND
        verdicts = records[~of_tracks].view(VERDICT_RECORD) if not of_tracks.all() else np.zeros(0, VERDICT_RECORD)
        return TopRun(
            records[of_tracks], owned[: job.n_owned], passed[: job.n_passed], user[: job.n_owned],
            table[: len(commands)], accepted[: len(words)], recorded[of_tracks], job.irq_clock,
            min(_SEQ_BITS, self.config.shape.seq_w), verdicts,
        )  # fmt: skip

    def _access(self, command: Command) -> int:
        done = self.run(commands=[command], quiet_clocks=1, take_outputs=False).commands[0]
        if done["response"]:
            kind = "write" if command[1] == Op.WRITE else "read"
            raise BusError(f"{kind} at {command[2]:#06x}: the hardware answers with an error")
        return int(done["result"])

    def read(self, address: int) -> int:
        """See `Transport`."""
        return self._access(read(address))

    def write(self, address: int, value: int) -> None:
        """See `Transport`."""
        self._access(write(address, value))

# SPDX-License-Identifier: Apache-2.0
"""Random runs of `evcot_top` beside the golden model: registers are rewritten, and the hardware is reset, while events flow.

The hardware says at which event each commit took effect; the model is changed at that event.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.golden import golden_model
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RECORD, MOTION_RULES, MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.hardware.registers import register_map
from evcot.hardware.streams import pack_events, unpack, whole_numbers
from evcot.ticks import TickedEvents

from ..devices.base import HardwareError
from ..devices.device import order_of, step_clocks
from ..devices.top_device import (
    Command,
    Pace,
    TopDevice,
    TopRun,
    address_of,
    bank_address,
    poll_status,
    read,
    slot_address,
    write,
)
from .lockstep import difference_of
from .mismatch import Mismatch, MismatchError
from .random_runs import Design, random_config, random_motion

__all__ = ["ALONE", "Rewritten", "TopTotals", "random_top_run", "rewritten"]

ALONE = 300  # events at the end before which no change is asked for: it takes effect some events later
_EVENTS_A_CHANGE = 400
_CHANGES_MOST = 200
_CONTROL = {field.name: 1 << field.lsb for field in register_map().word("control").fields}


class _Change(NamedTuple):
    """The writes before a commit, its address, and what it does to the model, which returns the tracks that it ended.

    Attributes:
        step_log2: of cot_motion, the length of a motion step from then on.
    """

    writes: list[Command]
    commit: int
    apply: Callable[[Any], NDArray[np.void]]
    step_log2: int = 0


class Rewritten(NamedTuple):
    """What hardware and model decided; the event before which each change took effect; how many tracks were ended by one; and
    the clock at the end."""

    hardware: Decisions
    model: Decisions
    at: NDArray[np.int64]
    ended: int


class TopTotals(NamedTuple):
    """What a random run had: events, records, and clocks from its reset to its end."""

    events: int
    records: int
    cycles: int


def random_top_run(design: Design, seed: int, events: int) -> TopTotals:
    """Run `evcot_top` and model on registers, traffic, stalls, changes and a reset in flow that a seed determines.

    Raises:
        MismatchError: they differ, or the hardware made no progress or violated a protocol.
    """
    rng = np.random.default_rng(seed)
    config, traffic = design.config(rng), design.traffic(rng, max(events, ALONE + 1))
    device = TopDevice(config, design.top, pace=Pace.random(rng) if rng.random() < 0.75 else None)
    try:
        if rng.random() < 0.5:
            _reset_in_flow(device, traffic, rng)
        both = rewritten(device, config, traffic, rng, min(len(traffic) // _EVENTS_A_CHANGE, _CHANGES_MOST))
    except HardwareError as error:
        at = min(max(error.seq, 0), len(traffic) - 1)
        mismatch = Mismatch(at, int(traffic.ticks[at]), "stream", str(error), "in order", seed, config)
        raise MismatchError(mismatch) from error
    found = difference_of(both.hardware, both.model)
    if found is not None:
        tick = int(traffic.ticks[min(max(found.event_index, 0), len(traffic) - 1)])
        raise MismatchError(Mismatch(found.event_index, tick, found.field, found.hardware, found.model, seed, config))
    return TopTotals(len(traffic), len(both.model.records), device.clock)


def _reset_in_flow(device: TopDevice, traffic: TickedEvents, rng: np.random.Generator) -> None:
    """Reset the hardware, by its input or over the bus, at a random clock of a run."""
    device.configure()
    words = pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p)
    if rng.random() < 0.5:
        device.run(words, clocks=int(rng.integers(1, 4_000)), cut=True)
        device.reset()
    else:
        device.run(
            words[:1_000],
            [write(address_of("control"), _CONTROL["enable"] | _CONTROL["soft_reset"], int(rng.integers(1, 300)))],
        )


def rewritten(
    device: TopDevice, config: CotConfig | MotionConfig, traffic: TickedEvents, rng: np.random.Generator, changes: int
) -> Rewritten:
    """Run both from reset on traffic, with so many changes of random registers at random events.

    Args:
        device: of the configuration's shape.
        traffic: more than `ALONE` events.
        changes: of slots, and of cot_motion of two banks of motion, as likely.

    Raises:
        HardwareError: the hardware refused a change, made no progress, changed an event, or violated a protocol.
    """
    # From 0, as the hardware counts, and without silences of several tokens: a commit within one has no place among events.
    steps = np.minimum(np.diff(traffic.ticks, prepend=traffic.ticks[:1]), (1 << config.shape.tick_w) - 1)
    traffic = replace(traffic, ticks=np.cumsum(steps))
    n = len(traffic)
    after_all = np.sort(rng.integers(0, n - ALONE, changes))
    made = _changes(rng, config, after_all)
    commands: list[Command] = []
    asks: list[int] = []
    for change, after in zip(made, after_all.tolist(), strict=True):
        commands += [*change.writes, write(change.commit, 1, after), poll_status("pending", 0), read(change.commit)]
        asks.append(len(commands) - 1)
    commands.append(poll_status("idle", 1, n))  # all is through, however long motion steps take
    device.reset()
    device.configure(config)
    longest = 0
    if isinstance(config, MotionConfig):
        shortest = min([config.registers.step_log2, *(change.step_log2 for change in made)])
        longest = step_clocks(config.shape.n_slots, int(steps.max()), shortest)
    played = device.run(pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p), commands, step_clocks=longest)
    if played.commands["response"].any():
        refused = int(np.flatnonzero(played.commands["response"])[0])
        raise HardwareError(f"evcot_top refused access {refused}, {commands[refused]}", int(commands[refused][0]))
    _check_events(played, traffic)
    # Of the numbers with these low bits, the one nearest to where the change was asked for.
    half = 1 << (played.seq_bits - 1)
    at = after_all + (played.commands["result"][asks].astype(np.int64) - after_all + half) % (2 * half) - half
    model, begin, ended, parts = golden_model(config), 0, 0, []
    for change, seq in zip(made, at.tolist(), strict=True):
        parts.append(model.feed(traffic[begin:seq]))
        begin = seq
        lost = change.apply(model)
        parts.append(Decisions(lost, np.empty(0, np.int16), np.empty(0, np.uint16), np.empty(0, np.uint16)))
        ended += len(lost)
    parts.append(model.feed(traffic[begin:]))
    decided = Decisions(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    decided.records["seq"] %= 1 << config.shape.seq_w  # the numbers of cot_motion's model do not wrap
    chain = config.module == "cot_chain"
    if chain:
        decided = decided._replace(records=decided.records[order_of(decided.records)])
    return Rewritten(played.decisions(0, n, chain), decided, at, ended)


def _changes(rng: np.random.Generator, config: CotConfig | MotionConfig, after_all: NDArray[np.int64]) -> list[_Change]:
    """A random change of registers for each of these events."""
    if isinstance(config, CotConfig):
        return [_slot_change(rng, config, after) for after in after_all.tolist()]
    found, motion = [], config.registers
    for after in after_all.tolist():
        bank = str(rng.choice(["slot", *MOTION_BANKS]))
        if bank == "slot":
            found.append(_mode_change(rng, config.shape.n_slots, after, motion.step_log2))
            continue
        old, motion = motion, _drawn(rng, config.shape, motion, bank)
        names = [name for name in MOTION_BANKS[bank] if getattr(motion, name) != getattr(old, name)]
        writes = [write(bank_address(bank, name), getattr(motion, name), after) for name in rng.permutation(names)]
        found.append(_Change(writes, bank_address(bank), partial(_write_motion, motion), motion.step_log2))
    return found


def _slot_change(rng: np.random.Generator, config: CotConfig, after: int) -> _Change:
    """All registers of a slot, half of the times with its mode, which restarts it."""
    slot, restart = int(rng.integers(config.shape.n_slots)), bool(rng.integers(2))
    registers = random_config(rng, config.shape).slots[0]
    names = rng.permutation([name for name in REGISTERS if name != "mode" or restart])
    writes = [write(slot_address(slot, name), int(getattr(registers, name)), after) for name in names]
    return _Change(writes, slot_address(slot), lambda model: model.write_registers(slot, registers, restart=restart))


def _mode_change(rng: np.random.Generator, slots: int, after: int, step_log2: int) -> _Change:
    slot, mode = int(rng.integers(slots)), int(rng.choice([Mode.OFF, Mode.SEEDED], p=[0.2, 0.8]))
    writes = [write(slot_address(slot, "mode"), mode, after)]
    return _Change(writes, slot_address(slot), lambda model: model.write_mode(slot, mode), step_log2)


def _write_motion(registers: MotionRegisters, model: MotionModel) -> NDArray[np.void]:
    model.write_registers(registers)
    return np.empty(0, MOTION_RECORD)


def _drawn(rng: np.random.Generator, shape: Shape, now: MotionRegisters, bank: str) -> MotionRegisters:
    """Other registers of one bank: a few of them, which do not contradict each other."""
    other = random_motion(rng, shape).registers
    names = {str(name) for name in rng.choice(list(MOTION_BANKS[bank]), 6, replace=False)}
    for rule in MOTION_RULES:  # those of a rule together
        names |= {rule.less, rule.more} if rule.less in names or rule.more in names else set()
    return replace(now, **{name: getattr(other, name) for name in names})


def _check_events(played: TopRun, traffic: TickedEvents) -> None:
    """Raise HardwareError where an event left with another polarity, or passed with another address."""
    for stream, words, fields in (("owned", played.owned, "p"), ("passed", played.passed, "pxy")):
        found = unpack(stream, words)
        index = whole_numbers(found["seq"], played.seq_bits)
        for field in fields:
            other = np.flatnonzero(found[field] != getattr(traffic, field)[index])
            if len(other):
                raise HardwareError(f"evcot_top changed {field} of {stream} event {index[other[0]]}", int(index[other[0]]))

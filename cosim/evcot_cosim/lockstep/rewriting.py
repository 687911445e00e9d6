# SPDX-License-Identifier: Apache-2.0
"""cot_motion in `evcot_top`, whose registers are rewritten while events flow, beside the golden model.

The hardware says at which event each commit took effect; the model is changed at that event.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.model import Decisions
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RULES, MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.hardware.streams import pack_events
from evcot.ticks import TickedEvents

from ..devices.base import HardwareError
from ..devices.device import step_clocks
from ..devices.top_device import Command, TopDevice, bank_address, poll_status, read, slot_address, write
from .random_runs import random_motion

__all__ = ["ALONE", "Rewritten", "rewritten"]

ALONE = 300  # events at the end before which no change is asked for: it takes effect some events later


class _Change(NamedTuple):
    """Registers of a bank, or of a slot, which begins anew."""

    motion: MotionRegisters | None
    slot: int
    mode: int


class Rewritten(NamedTuple):
    """What hardware and model decided; the event before which each change took effect; how many tracks were ended by one."""

    hardware: Decisions
    model: Decisions
    at: NDArray[np.int64]
    ended: int


def rewritten(
    device: TopDevice, config: MotionConfig, traffic: TickedEvents, rng: np.random.Generator, changes: int
) -> Rewritten:
    """Run both from reset on traffic, with so many changes of random registers at random events.

    Args:
        device: of the configuration's shape, without filters.
        traffic: more than `ALONE` events.
        changes: of two banks of motion, and of slots, as likely.

    Raises:
        HardwareError: the hardware refused a change, made no progress, or violated a protocol.
    """
    traffic = replace(traffic, ticks=traffic.ticks - traffic.ticks[0])  # those of the hardware: 0 at the first event
    n, motion = len(traffic), config.registers
    made: list[_Change] = []
    commands: list[Command] = []
    asks: list[int] = []
    for after in np.sort(rng.integers(0, n - ALONE, changes)).tolist():
        change, writes, address = _change(rng, config.shape, motion, after)
        motion = change.motion or motion
        made.append(change)
        commands += [*writes, write(address, 1, after), poll_status("pending", 0), read(address)]
        asks.append(len(commands) - 1)
    commands.append(poll_status("idle", 1, n))  # all is through, however long motion steps take
    device.reset()
    device.configure(config)
    steps = min(registers.step_log2 for registers in (config.registers, *(one.motion for one in made if one.motion)))
    longest = step_clocks(config.shape.n_slots, int(np.diff(traffic.ticks).max()), steps)
    played = device.run(pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p), commands, step_clocks=longest)
    if played.commands["response"].any():
        refused = int(np.flatnonzero(played.commands["response"])[0])
        raise HardwareError(f"evcot_top refused access {refused}, {commands[refused]}", int(commands[refused][0]))
    at = played.commands["result"][asks].astype(np.int64)
    model, begin, ended, parts = MotionModel(config), 0, 0, []
    for change, seq in zip(made, at.tolist(), strict=True):
        parts.append(model.feed(traffic[begin:seq]))
        begin = seq
        if change.motion is not None:
            model.write_registers(change.motion)
        else:
            lost = model.write_mode(change.slot, change.mode)
            parts.append(Decisions(lost, np.empty(0, np.int16), np.empty(0, np.uint16), np.empty(0, np.uint16)))
            ended += len(lost)
    parts.append(model.feed(traffic[begin:]))
    decided = Decisions(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    return Rewritten(played.decisions(0, n), decided, at, ended)


def _change(rng: np.random.Generator, shape: Shape, motion: MotionRegisters, after: int) -> tuple[_Change, list[Command], int]:
    """A change, the writes before its commit, and the address of that."""
    bank = str(rng.choice(["motion", "tracks", "slot"]))
    if bank == "slot":
        slot, mode = int(rng.integers(shape.n_slots)), int(rng.choice([Mode.OFF, Mode.SEEDED], p=[0.2, 0.8]))
        return _Change(None, slot, mode), [write(slot_address(slot, "mode"), mode, after)], slot_address(slot)
    new = _drawn(rng, shape, motion, bank)
    names = [name for name in MOTION_BANKS[bank] if getattr(new, name) != getattr(motion, name)]
    writes = [write(bank_address(bank, name), getattr(new, name), after) for name in rng.permutation(names)]
    return _Change(new, 0, 0), writes, bank_address(bank)


def _drawn(rng: np.random.Generator, shape: Shape, now: MotionRegisters, bank: str) -> MotionRegisters:
    """Other registers of one bank: a few of them, which do not contradict each other."""
    other = random_motion(rng, shape).registers
    names = {str(name) for name in rng.choice(list(MOTION_BANKS[bank]), 6, replace=False)}
    for rule in MOTION_RULES:  # those of a rule together
        names |= {rule.less, rule.more} if rule.less in names or rule.more in names else set()
    return replace(now, **{name: getattr(other, name) for name in names})

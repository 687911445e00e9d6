# SPDX-License-Identifier: Apache-2.0
"""Random registers and traffic for the trackers, and a run of hardware and model on them.

Register values cover their whole legal ranges, small values as often as large ones; traffic has bursts around moving targets,
noise, equal ticks and long gaps.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.hardware.motion.contract import MOTION_BANKS, MOTION_RANGES, MOTION_RULES, MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.hardware.streams import pack_events
from evcot.ticks import TickedEvents

from ..devices.base import HardwareError
from ..devices.device import step_clocks
from ..devices.top_device import Command, TopDevice, bank_address, poll_status, read, slot_address, write
from ..rtl.build import BuiltModel
from .cosim import stalls_from
from .lockstep import Lockstep, chunks

__all__ = [
    "ALONE",
    "RATES",
    "Rewritten",
    "random_config",
    "random_motion",
    "random_motion_run",
    "random_motion_traffic",
    "random_outlines",
    "random_run",
    "random_traffic",
    "rewritten",
]


RATES = (0.3, 2.0, 10.0)
"""Ticks from one event to the next within a burst."""


def random_config(rng: np.random.Generator, shape: Shape, module: Module = "cot_array") -> CotConfig:
    """Random register values over their whole legal ranges, drawn separately for each slot."""
    return CotConfig(shape, tuple(_random_slot(rng, shape) for _ in range(shape.n_slots)), module=module)


def _random_slot(rng: np.random.Generator, shape: Shape) -> SlotConfig:
    values = {name: _draw(rng, *register.limits(shape)) for name, register in REGISTERS.items()}
    values["mode"] = int(rng.choice([Mode.OFF, Mode.FIXED, Mode.SEEDED], p=[0.05, 0.25, 0.7]))
    for axis in ("init_cm_x", "init_cm_y"):  # anywhere, as likely in the middle as near 0
        values[axis] = int(rng.integers(0, REGISTERS[axis].limits(shape)[1], endpoint=True))
    for names in (("radix_min", "init_radix", "radix_max"), ("nev_min", "clust_nev", "nev_max")):
        values.update(zip(names, sorted(values[name] for name in names), strict=True))
    return SlotConfig(**values)


_LIVELY = MotionRegisters(
    step_log2=5, side_step=900, detect_ticks=300, life_ticks=400, coast_ticks=2_000, birth_support=30, birth_px=2,
    birth_ticks=100, birth_travel=5, nev_low=4, nev_high=40, side_max=40, seed_px=3, gap_corrections=4, join_steps=3,
    report_steps=2, ring_max=10,
)  # fmt: skip


def random_motion(rng: np.random.Generator, shape: Shape) -> MotionConfig:
    """Random registers of cot_motion: any share of them over their whole legal ranges, the others such that objects
    become visible, meet and end within thousands of events. A few slots are off."""
    share = rng.choice([0.02, 0.05, 0.1, 0.2, 1.0], p=[0.3, 0.3, 0.2, 0.1, 0.1])
    values = {}
    for name, (low, high, _) in MOTION_RANGES.items():
        values[name] = _draw(rng, int(low), int(high)) if rng.random() < share else getattr(_LIVELY, name)
    values["step_log2"] = min(values["step_log2"], 12)  # or there is none
    values["seed_px"] = min(values["seed_px"], max(1, values["side_max"] // 2))
    values["side_max"] = max(values["side_max"], 2)
    for names in (("nev_low", "nev_high"), ("ring_px", "ring_max"), ("life_ticks", "coast_ticks")):
        values.update(zip(names, sorted(values[name] for name in names), strict=True))
    modes = rng.choice([Mode.OFF, Mode.SEEDED], shape.n_slots, p=[0.1, 0.9])
    return MotionConfig(shape, MotionRegisters(**values), modes=tuple(modes.tolist()))


def _draw(rng: np.random.Generator, low: int, high: int) -> int:
    """An integer from low to high: sometimes a limit, else with a uniformly distributed bit length, often a short one."""
    if rng.random() < 0.08:
        return int(rng.choice([low, high]))
    bits = rng.uniform(0, math.log2(high - low + 2))
    if rng.random() < 0.5:
        bits = min(bits, rng.uniform(0, 6))
    return min(high, low + int(2**bits) - 1)


def random_traffic(rng: np.random.Generator, shape: Shape, n: int, ticks_per_event: float, first_tick: int = 0) -> TickedEvents:
    """Bursts around moving targets, noise between them, equal ticks, pauses and long silences.

    Args:
        rng: the only source of randomness.
        shape: address widths, and how long a timer can run.
        n: events.
        ticks_per_event: about how many ticks pass from one event to the next within a burst.
        first_tick: tick before the first event.
    """
    n_targets = int(rng.integers(1, 2 * shape.n_slots + 2))
    burst = rng.geometric(1 / rng.uniform(2, 40), n)
    target = np.repeat(rng.integers(0, n_targets, n), burst)[:n]
    noisy = rng.random(n) < rng.choice([0.02, 0.1, 0.4])
    axes = []
    for width in (shape.x_w, shape.y_w):
        size = 1 << width
        span = min(size, 128)  # where the targets are: a part of a large sensor
        speed = rng.normal(0, rng.choice([0.0, 0.5, 5.0]) * span / n * 8, n_targets)
        path = rng.uniform(0, span, n_targets)[target] + speed[target] * np.arange(n)
        path += rng.normal(0, rng.choice([0.3, 1.0, 3.0]), n)
        folded = np.minimum(np.abs((path + span) % (2 * span) - span), span - 1)  # reflected at the borders
        corner = rng.integers(0, size - span, endpoint=True)
        noise = rng.integers(0, size, n) if rng.random() < 0.5 else corner + rng.integers(0, span, n)
        axes.append(np.where(noisy, noise, corner + folded).astype(np.uint16))
    steps = rng.poisson(ticks_per_event, n).astype(np.int64)
    pauses = rng.random(n) < 0.003
    steps[pauses] += rng.integers(0, max(2, int(60 * ticks_per_event)), np.count_nonzero(pauses))
    silences = rng.random(n) < 2e-4
    steps[silences] += rng.integers(0, 1 << min(shape.tc_w + 1, 34), np.count_nonzero(silences))
    return TickedEvents(first_tick + np.cumsum(steps), axes[0], axes[1], rng.integers(0, 2, n, np.uint8))


def random_outlines(rng: np.random.Generator, shape: Shape, n: int, ticks_per_event: float) -> TickedEvents:
    """Outlines of boxes of every size and speed that bounce off the borders and run through each other, with noise, pauses and
    a hot pixel: what becomes visible, meets and hides in cot_motion.

    Args:
        rng, shape, n, ticks_per_event: as for `random_traffic`.
    """
    count = int(rng.integers(1, shape.n_slots + 3))
    size = np.array([[1 << shape.x_w], [1 << shape.y_w]])
    span = np.minimum(size, 128) - 1
    corner = rng.integers(0, size - span)
    ticks = np.cumsum(rng.poisson(ticks_per_event, n) + np.where(rng.random(n) < 0.002, rng.integers(0, 3_000, n), 0))
    which, side = rng.integers(0, count, n), rng.integers(0, 4, n)
    half = np.minimum(rng.uniform(1, rng.choice([4, 9, 20]), (2, count)), span / 3)[:, which]
    room = span - 2 * half
    speed, start = rng.normal(0, rng.choice([0.0, 0.004, 0.02]), (2, count)), rng.uniform(0, 60, (2, count))
    if rng.random() < 0.5:  # in pairs that move together, side by side
        pairs = np.arange(count) // 2 * 2
        speed, start = speed[:, pairs], start[:, pairs] + (np.arange(count) % 2) * rng.uniform(-15, 15, (2, 1))
    way = start[:, which] + speed[:, which] * ticks
    middle = half + np.abs((way + room) % (2 * room) - room)
    along = rng.uniform(-1, 1, n) * half
    sign = np.where(side % 2, 1, -1)
    place = middle + np.where(side < 2, np.stack((sign * half[0], along[1])), np.stack((along[0], sign * half[1])))
    noise = rng.random(n) < rng.choice([0.0, 0.06, 0.3])
    place[:, noise] = rng.uniform(0, 1, (2, np.count_nonzero(noise))) * span
    place[:, rng.random(n) < 0.02] = span // 2
    x, y = (corner + np.clip(np.rint(place), 0, span)).astype(np.uint16)
    return TickedEvents(ticks.astype(np.int64), x, y, rng.integers(0, 2, n, np.uint8))


def random_run(shape: Shape, module: Module, seed: int, events: int, model: BuiltModel | None = None) -> Lockstep:
    """Run hardware and model in lock-step on registers, traffic and stalls that a seed determines; three runs in four stall.

    Args:
        model: what `build_device` returned for the shape, to avoid the look-up.

    Raises:
        MismatchError: they differ.
    """
    rng = np.random.default_rng(seed)
    config = random_config(rng, shape, module)
    return _run(rng, config, random_traffic(rng, shape, events, float(rng.choice(RATES))), seed, model)


def random_motion_traffic(rng: np.random.Generator, shape: Shape, events: int) -> TickedEvents:
    """Outlines three times in four, else bursts and noise; every fourth time, events of a period all come at one tick."""
    traffic = (random_traffic if rng.random() < 0.25 else random_outlines)(rng, shape, events, float(rng.choice(RATES)))
    period = int(rng.integers(2, 1_000)) if rng.random() < 0.25 else 1
    return replace(traffic, ticks=traffic.ticks // period * period)


def random_motion_run(shape: Shape, seed: int, events: int, model: BuiltModel | None = None) -> Lockstep:
    """The same for cot_motion, on `random_motion_traffic`.

    Raises:
        MismatchError: they differ.
    """
    rng = np.random.default_rng(seed)
    config = random_motion(rng, shape)
    return _run(rng, config, random_motion_traffic(rng, shape, events), seed, model)


def _run(
    rng: np.random.Generator, config: CotConfig | MotionConfig, traffic: TickedEvents, seed: int, model: BuiltModel | None
) -> Lockstep:
    stream = Events(traffic.ticks, traffic.x, traffic.y, traffic.p)
    stalls = stalls_from(seed if rng.random() < 0.75 else None)
    with Lockstep(config, stalls=stalls, seed=seed, model=model) as lockstep:
        for chunk in chunks(stream):
            lockstep.feed(chunk)
    return lockstep


# cot_motion in `evcot_top`, whose registers are rewritten while events flow, beside the golden model.
#
# The hardware says at which event each commit took effect; the model is changed at that event.

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
    # From 0, as the hardware counts, and without silences of several tokens: a commit within one has no place among events.
    steps = np.minimum(np.diff(traffic.ticks, prepend=traffic.ticks[:1]), (1 << config.shape.tick_w) - 1)
    traffic = replace(traffic, ticks=np.cumsum(steps))
    n, motion = len(traffic), config.registers
    made: list[_Change] = []
    commands: list[Command] = []
    asks: list[int] = []
    after_all = np.sort(rng.integers(0, n - ALONE, changes))
    for after in after_all.tolist():
        change, writes, address = _change(rng, config.shape, motion, after)
        motion = change.motion or motion
        made.append(change)
        commands += [*writes, write(address, 1, after), poll_status("pending", 0), read(address)]
        asks.append(len(commands) - 1)
    commands.append(poll_status("idle", 1, n))  # all is through, however long motion steps take
    device.reset()
    device.configure(config)
    shortest = min(registers.step_log2 for registers in (config.registers, *(one.motion for one in made if one.motion)))
    longest = step_clocks(config.shape.n_slots, int(steps.max()), shortest)
    played = device.run(pack_events(traffic.ticks, traffic.x, traffic.y, traffic.p), commands, step_clocks=longest)
    if played.commands["response"].any():
        refused = int(np.flatnonzero(played.commands["response"])[0])
        raise HardwareError(f"evcot_top refused access {refused}, {commands[refused]}", int(commands[refused][0]))
    # Of the numbers with these low bits, the one nearest to where the change was asked for.
    half = 1 << (played.seq_bits - 1)
    at = after_all + (played.commands["result"][asks].astype(np.int64) - after_all + half) % (2 * half) - half
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
    decided.records["seq"] %= 1 << config.shape.seq_w  # the model's numbers do not wrap
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

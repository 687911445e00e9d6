# SPDX-License-Identifier: Apache-2.0
"""The streaming drive: the 8-slot array, alone and checked, against a bare C++ main; cot_motion against it; 32 slots alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bare
import streams
from evcot.events import Events
from evcot.trackers.presets import PRESETS, fit
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.lockstep import Lockstep, Step, chunks
from measure import Clock, Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

_RATE_GOAL_M = 5.0
_MANY = 32
_MANY_GOAL_M = 2.1


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """stream_rate_8, stream_vs_bare, checked_vs_bare, motion_rate_8, array_rate_32."""
    config = streams.config().hardware
    model = build_device(config, waves=False)
    events = streams.joined(200_000 if quick else 1_000_000)
    outcomes: dict[bool, bare.Outcome] = {}

    def drive(check: bool) -> Timing:
        steps: list[Step] = []
        with Lockstep(config, check=check, model=model) as lockstep:
            timing = timed(lambda: steps.extend(map(lockstep.feed, chunks(events))))
            owner_sum = sum(int(step.hardware.owner.sum()) for step in steps)
            outcomes[check] = bare.Outcome(lockstep.records, owner_sum)
            return timing

    with bare.running(model, config, events, folder / "bare") as main:
        turns = take_turns(
            {"bare": main.run, "stream": lambda: drive(False), "checked": lambda: drive(True)}, 5 if quick else 15
        )
        for outcome in outcomes.values():
            if outcome != main.outcome:
                raise RuntimeError(f"the drives disagree: bare main {main.outcome}, streaming {outcome}")

    def rate(name: str, clock: Clock) -> float:
        return len(events) / turns.seconds(name, clock) / 1e6

    yield Result(
        "stream_rate_8", rate("stream", Clock.CPU), "M events/s", _RATE_GOAL_M, "goal", goal=Goal(1),
        how=f"chunks of 65,536, no check, CPU time; wall: {rate('stream', Clock.WALL):.2f}",
    )  # fmt: skip
    yield Result(
        "stream_vs_bare", rate("stream", Clock.CPU), "M events/s", rate("bare", Clock.CPU), "bare C++ main",
        ratio=turns.speed_ratio("stream", "bare"), goal=Goal(0.95),
        how=f"CPU time; wall ratio: {turns.speed_ratio('stream', 'bare', Clock.WALL):.3f}",
    )  # fmt: skip
    yield Result(
        "checked_vs_bare", rate("checked", Clock.WALL), "M events/s", rate("bare", Clock.WALL), "bare C++ main",
        ratio=turns.speed_ratio("checked", "bare", Clock.WALL), goal=Goal(0.7),
        how=f"two threads, wall time; CPU ratio of the thread that drives: {turns.speed_ratio('checked', 'bare'):.3f}",
    )  # fmt: skip
    yield _motion(events, 3 if quick else 9)
    yield _many_slots(100_000 if quick else 500_000, 3 if quick else 9)


def _motion(events: Events, rounds: int) -> Result:
    """cot_motion and cot_array, on the same stream."""
    configs = {
        "cot_array": streams.config().hardware,
        "cot_motion": fit(PRESETS["motion"], streams.WIDTH, streams.HEIGHT, streams.SLOTS).hardware,
    }
    models = {name: build_device(config, waves=False) for name, config in configs.items()}
    clocks = {}

    def drive(name: str) -> Timing:
        with Lockstep(configs[name], check=False, model=models[name]) as lockstep:
            timing = timed(lambda: list(map(lockstep.feed, chunks(events))))
            clocks[name] = lockstep.device.cycle / len(events)
            return timing

    turns = take_turns({name: lambda name=name: drive(name) for name in configs}, rounds)  # type: ignore[misc]
    rates_m = {name: len(events) / turns.seconds(name, Clock.CPU) / 1e6 for name in configs}
    return Result(
        "motion_rate_8", rates_m["cot_motion"], "M events/s", rates_m["cot_array"], "cot_array",
        ratio=turns.speed_ratio("cot_motion", "cot_array"), how=f"{clocks['cot_motion']:.2f} clocks an event, CPU time",
    )  # fmt: skip


def _many_slots(count: int, rounds: int) -> Result:
    """As many discs as slots."""
    config = streams.config(_MANY).hardware
    model = build_device(config, waves=False)
    events = streams.joined(count, _MANY)

    clocks = 0

    def drive() -> Timing:
        nonlocal clocks
        with Lockstep(config, check=False, model=model) as lockstep:
            timing = timed(lambda: list(map(lockstep.feed, chunks(events))))
            clocks = lockstep.device.cycle
            return timing

    rate_m = count / take_turns({"stream": drive}, rounds).seconds("stream", Clock.CPU) / 1e6
    how = f"{clocks / count:.2f} clocks an event; chunks of 65,536, no check, CPU time"
    return Result(f"array_rate_{_MANY}", rate_m, "M events/s", _MANY_GOAL_M, "goal", goal=Goal(1), how=how)

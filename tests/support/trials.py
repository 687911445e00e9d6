# SPDX-License-Identifier: Apache-2.0
"""Support for tests of the trackers: short stories run through both hardware and model, and random traffic and registers.

A story is a list of events (tick, x, y). Random register values cover their whole legal ranges, small values as often as
large ones; random traffic has bursts around moving targets, noise, equal ticks and long gaps.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.cot import Arrangement, CotModel, Decisions
from evcot.ticks import TickedEvents
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.names import Top

from .ticked import ticked

__all__ = [
    "ENGINES",
    "OLD_AND_YOUNG",
    "Engine",
    "Outcome",
    "compare_random_runs",
    "random_config",
    "random_traffic",
    "run_story",
]

Engine = Literal["model", "rtl"]
ENGINES: tuple[Engine, ...] = ("model", "rtl")


@dataclass(frozen=True)
class Outcome:
    """An engine's decisions on a story in a form that tests can compare: one tuple per record, one owner per event."""

    config: CotConfig
    decisions: Decisions

    @property
    def owners(self) -> list[int]:
        """The slot that owns each event, -1 for events that were passed on."""
        return [int(slot) for slot in self.decisions.owner]

    @property
    def rel(self) -> list[tuple[int, int]]:
        """Each event's address relative to its owner's window."""
        return [(int(x), int(y)) for x, y in zip(self.decisions.rel_x, self.decisions.rel_y, strict=True)]

    def records(self, *fields: str) -> list[tuple[object, ...]]:
        """The chosen fields of every record; `kind` is a `Kind`, `x` and `y` are the centre in pixels."""
        scale = 1 << self.config.shape.frac
        return [
            tuple(
                Kind(record["kind"])
                if field == "kind"
                else float(record[f"cm_{field}"]) / scale
                if field in ("x", "y")
                else int(record[field])
                for field in fields
            )
            for record in self.decisions.records
        ]

    @property
    def kinds(self) -> list[Kind]:
        """The kind of every record."""
        return [Kind(kind) for kind in self.decisions.records["kind"]]


def run_story(
    story: Iterable[tuple[int, int, int]], config: CotConfig, top: Top = "cot_array", engine: Engine = "rtl"
) -> Outcome:
    """Run a story through the hardware `top`, or through the golden model in the same arrangement."""
    ticks, x, y = np.array(list(story), np.int64).reshape(-1, 3).T
    events = ticked(ticks, x, y, (x ^ y) & 1)
    if engine == "model":
        arrangement = Arrangement.ARRAY if top == "cot_array" else Arrangement.CHAIN
        return Outcome(config, CotModel(config, arrangement).feed(events))
    return Outcome(config, Device(config, top).stream(events))


# Slot 1 starts track 1 and keeps it; slot 0 starts one track after another, the last of them track 8, whose id in three bits
# is 0. Then slot 0 moves into the window of slot 1, whose track is older although its id is larger.
_LIVES = SlotConfig(
    mode=Mode.SEEDED, init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=4, hist_avg=0,
    max_ticks=4000, clust_nev=1, nev_min=1, nev_max=8, nev_th=4000, detect_ticks=100,
)  # fmt: skip
OLD_AND_YOUNG: tuple[list[tuple[int, int, int]], CotConfig] = (
    [(0, 40, 64), (0, 20, 64), *((200 * life, 40, 64) for life in range(1, 8)), (1401, 34, 64), (1401, 31, 64)],
    CotConfig(
        Shape(n_slots=2, x_w=7, y_w=7, frac=1, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=3, seq_w=16, time_w=20),
        (replace(_LIVES, max_ticks=100), _LIVES),
    ),
)
"""A story and a configuration in which ids wrap around during a track's life."""


def random_config(rng: np.random.Generator, shape: Shape) -> CotConfig:
    """Random register values over their whole legal ranges, drawn separately for each slot."""
    return CotConfig(shape, tuple(_random_slot(rng, shape) for _ in range(shape.n_slots)))


def _random_slot(rng: np.random.Generator, shape: Shape) -> SlotConfig:
    values = {name: _draw(rng, *register.limits(shape)) for name, register in REGISTERS.items()}
    values["mode"] = int(rng.choice([Mode.OFF, Mode.FIXED, Mode.SEEDED], p=[0.05, 0.25, 0.7]))
    for axis in ("init_cm_x", "init_cm_y"):  # anywhere, as likely in the middle as near 0
        values[axis] = int(rng.integers(0, REGISTERS[axis].limits(shape)[1], endpoint=True))
    for names in (("radix_min", "init_radix", "radix_max"), ("nev_min", "clust_nev", "nev_max")):
        values.update(zip(names, sorted(values[name] for name in names), strict=True))
    return SlotConfig(**values)


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


def compare_random_runs(
    shape: Shape,
    top: Top,
    seed: int,
    runs: int,
    events_per_run: int,
    *,
    parts: int = 2,
    rates: tuple[float, ...] = (0.3, 2, 10),
) -> dict[Kind, int]:
    """Run random registers, traffic and stalls through hardware and model `runs` times, comparing all decisions bit for bit.

    Returns the number of records of each kind.

    Raises:
        AssertionError: they differ; the message names run and seed.
    """
    print(f"{top}, {shape.n_slots} slots, frac {shape.frac}, seed {seed}:", end=" ")
    built = None
    census = dict.fromkeys(Kind, 0)
    for run in range(runs):
        rng = np.random.default_rng([seed, run])
        config = random_config(rng, shape)
        built = built or build_device(config, top)
        device = Device(config, top, model=built, stalls=Stalls.random(rng) if run % 4 else None)
        model = CotModel(config, device.arrangement)
        for _ in range(parts):
            rate = float(rng.choice(rates))
            traffic = random_traffic(rng, shape, events_per_run // parts, rate, device.now)
            # Now and then behind a filter that takes out a third; a single tracker has its events numbered outside.
            keep = None if top == "cot" or run % 2 else rng.random(len(traffic)) < 2 / 3
            hardware, golden = device.stream(traffic, keep), model.feed(traffic, keep)
            for field in Decisions._fields:
                theirs, ours = getattr(hardware, field), getattr(golden, field)
                assert np.array_equal(theirs, ours), f"seed {seed}, run {run}: {field} differs"
            for kind in Kind:
                census[kind] += int(np.count_nonzero(golden.records["kind"] == kind))
    print(", ".join(f"{count} {kind.name}" for kind, count in census.items()))
    return census

# SPDX-License-Identifier: Apache-2.0
"""Support for tests of the trackers: short stories run through both hardware and model, and random traffic and registers.

A story is a list of events (tick, x, y). Random registers and traffic are those of `evcot_cosim.lockstep.random_runs`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.lockstep.random_runs import random_config, random_traffic

from .tokens import ticked

__all__ = [
    "ENGINES",
    "OLD_AND_YOUNG",
    "Engine",
    "Outcome",
    "bare_device",
    "compare_random_runs",
    "random_config",
    "random_traffic",
    "run_story",
]

Engine = Literal["model", "rtl"]
ENGINES: tuple[Engine, ...] = ("model", "rtl")

bare_device = partial(Device, waves=False)
"""A `Device` whose model has no signals below the top, which most tests look at none of: it builds in less time."""


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
    story: Iterable[tuple[int, int, int]], config: CotConfig, module: Module = "cot_array", engine: Engine = "rtl"
) -> Outcome:
    """Run a story through a hardware module, or through its golden model."""
    config = replace(config, module=module)
    ticks, x, y = np.array(list(story), np.int64).reshape(-1, 3).T
    events = ticked(ticks, x, y, (x ^ y) & 1)
    if engine == "model":
        return Outcome(config, CotModel(config).feed(events))
    return Outcome(config, bare_device(config).stream(events))


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


def compare_random_runs(
    shape: Shape,
    module: Module,
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
    print(f"{module}, {shape.n_slots} slots, frac {shape.frac}, seed {seed}:", end=" ")
    built = None
    census = dict.fromkeys(Kind, 0)
    for run in range(runs):
        rng = np.random.default_rng([seed, run])
        config = random_config(rng, shape, module)
        built = built or build_device(config, waves=False)
        device = Device(config, model=built, stalls=Stalls.random(rng) if run % 4 else None)
        model = CotModel(config)
        for _ in range(parts):
            rate = float(rng.choice(rates))
            traffic = random_traffic(rng, shape, events_per_run // parts, rate, device.now)
            # Now and then behind a filter that takes out a third; a single tracker has its events numbered outside.
            keep = None if module == "cot" or run % 2 else rng.random(len(traffic)) < 2 / 3
            hardware, golden = device.stream(traffic, keep), model.feed(traffic, keep)
            for field in Decisions._fields:
                theirs, ours = getattr(hardware, field), getattr(golden, field)
                assert np.array_equal(theirs, ours), f"seed {seed}, run {run}: {field} differs"
            for kind in Kind:
                census[kind] += int(np.count_nonzero(golden.records["kind"] == kind))
    print(", ".join(f"{count} {kind.name}" for kind, count in census.items()))
    return census

# SPDX-License-Identifier: Apache-2.0
"""Support for tests of the published tracker and its cascade: stories and their results, random registers and port values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.published.model import REGISTERS, Played, PublishedConfig, PublishedTracker, decode
from evcot_cosim.devices.published_device import TRACKER, Event, at, equal, quiet, rtl, simulation

__all__ = ["CONFIG", "centres", "every", "n_evs", "noise", "one", "reset_tracker", "some_registers", "wandering"]

# A window from 91 to 109 (exclusive) around (100, 100) that never expires; every fourth event moves the centre.
CONFIG = PublishedConfig(
    init_cm_low=100, init_cm_high=100, radix_th=2, init_radix=7, radix_step=1, radix_max=9, radix_min=5,
    nev_th=4, hist_avg=1, max_time=10_000_000,
)  # fmt: skip


def every(gap: int, n: int, high: int = 100, low: int = 100, first: int = 0) -> list[Event]:
    """n events at one place, `gap` clocks apart."""
    return at(range(first, first + n * gap, gap), high, low)


def centres(result: Played) -> list[tuple[int, int]]:
    """(high, low) of every centre that the cascade sent."""
    words = decode(result.word)
    return [(int(word["high"]), int(word["low"])) for word in words[~words["event"]]]


def n_evs(result: Played) -> list[int]:
    """Number of events behind each centre, where no event was rejected."""
    is_centre = np.flatnonzero(~decode(result.word)["event"])
    return [int(n) - 1 for n in np.diff(is_centre, prepend=-1)]


def reset_tracker(config: PublishedConfig) -> None:
    """Set the register ports of the single tracker and reset it."""
    for name in REGISTERS.keys() - {"enable"}:
        simulation(TRACKER).io[name] = int(getattr(config, name))
    rows = quiet(TRACKER, 1)
    rows["rst"] = 1
    rtl(TRACKER, rows)


def one(config: PublishedConfig, inputs: NDArray[np.void]) -> NDArray[np.void]:
    """The single tracker's output ports at each clock from InitCell on, in hardware and model alike."""
    reset_tracker(config)
    outputs = rtl(TRACKER, inputs)
    equal(outputs, PublishedTracker(config).clocks(inputs), inputs)
    return outputs


def some_registers(rng: np.random.Generator) -> PublishedConfig:
    """Random legal register values: often the limits of their ranges, and often small, which makes more happen."""

    def value(top: int) -> int:
        return int(rng.choice(np.array([0, 1, top, rng.integers(top + 1), min(top, int(rng.integers(24)))])))

    return PublishedConfig(
        init_cm_low=value(255), init_cm_high=value(255), radix_th=value(7), init_radix=value(255), radix_step=value(7),
        radix_max=value(255), radix_min=value(255), nev_th=value(255), hist_avg=int(rng.integers(1, 9)),
        max_time=int(rng.choice(np.array([rng.integers(2000), rng.integers(1 << 32), 2**32 - 1, 10_000_000]))),
        enable=bool(rng.random() < 0.8),
    )  # fmt: skip


def wandering(rng: np.random.Generator, n: int, start: int) -> NDArray[np.int64]:
    """(n,) coordinates around a centre that drifts and sometimes jumps."""
    steps = rng.integers(-1, 2, n) + (rng.random(n) < 0.01) * rng.integers(-40, 41, n)
    return np.clip(start + np.cumsum(steps) + rng.integers(-12, 13, n), 0, 255)


def noise(rng: np.random.Generator, n: int) -> NDArray[np.uint8]:
    """(n,) values of a port that toggles at random, ignoring the protocol."""
    return (np.cumsum(rng.random(n) < rng.choice([0.05, 0.3, 0.7])) & 1).astype(np.uint8)

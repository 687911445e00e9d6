# SPDX-License-Identifier: Apache-2.0
"""Random shapes, registers, filters and traffic for the trackers, and a run of hardware and model on them.

Register values cover their whole legal ranges, small values as often as large ones; traffic has bursts around moving targets,
noise, equal ticks and long gaps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.filters.contract import CELL_PX, LEVEL_MAX, NOISE_SUPPORTS, Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, SHAPE_RANGES, Mode, Shape
from evcot.hardware.modules import DEFAULT_MODULE, MODULES, Module
from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.ticks import TickedEvents

from ..devices.base import Stalls
from ..rtl.build import BuiltModel
from .lockstep import Lockstep, chunks

__all__ = [
    "RATES",
    "TOP",
    "Case",
    "Design",
    "random_case",
    "random_config",
    "random_filters",
    "random_motion",
    "random_outlines",
    "random_traffic",
    "run_case",
]

TOP = "evcot_top"


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


def random_filters(rng: np.random.Generator, shape: FilterShape, enable: int) -> FilterRegisters:
    """Random registers of the filters that are on: most of them such that much stays, so that there is something to track."""
    oldest = min(400, shape.units_max - 1 if shape.cell_px else (1 << (shape.stamp_w - 1)) - 1)
    hot = {(int(x), int(y)) for x, y in zip(rng.integers(0, shape.width, 20), rng.integers(0, shape.height, 20), strict=True)}

    def low(size: int) -> int:
        return int(rng.integers(0, 1 + size // 8))

    lively = {
        "region_x0": low(shape.width), "region_x1": shape.width - low(shape.width),
        "region_y0": low(shape.height), "region_y1": shape.height - low(shape.height),
        "polarity": int(rng.integers(2)), "refractory_ticks": int(rng.integers(1, 1 + min(20, oldest))),
        "activity_ticks": int(rng.integers(0, 1 + oldest)), "activity_support": int(rng.integers(0 if shape.cell_px else 1, 3)),
        "recent_ticks": int(rng.integers(0, 1 + oldest)), "recent_radius": int(rng.integers(3, 15)),
        "decay_rate": int(rng.integers(1 << 12, 1 << 20)), "decay_epsilon": int(rng.integers(0, 20)),
        "decay_support": int(rng.integers(1, 60)), "rowcol_ticks": int(rng.integers(0, 1 + oldest)),
        "rowcol_radius": int(rng.integers(3, 15)), "noise_log2": int(rng.integers(6, 15)),
    }  # fmt: skip
    lively |= {f"noise_{supports}": int(rng.integers(0, LEVEL_MAX, endpoint=True)) for supports in NOISE_SUPPORTS}
    return FilterRegisters(enable, **lively, hot_pixels=tuple(sorted(hot)))


@dataclass(frozen=True)
class Design:
    """What is compiled for a random run.

    Attributes:
        module: the tracker.
        shape: its widths.
        enable: bit mask of the filters in front of it.
        filter_shape: theirs.
        top: Verilog parameters of `evcot_top` around it; None: without.

    Raises:
        ConfigError: a shape that the module cannot have.
    """

    module: Module
    shape: Shape = field(default_factory=Shape)
    enable: int = 0
    filter_shape: FilterShape = field(default_factory=FilterShape)
    top: Mapping[str, int] | None = None

    def __post_init__(self) -> None:
        self.config(np.random.default_rng(0))  # a configuration checks its shape

    @classmethod
    def random(cls, rng: np.random.Generator, module: str) -> Design:
        """A random one of a module, or of `TOP`: half of all widths are the defaults, half of the trackers have filters."""
        tracker = str(rng.choice([name for name in MODULES if name != "cot"])) if module == TOP else module
        most = {"x_w": 11, "y_w": 11} if module == TOP else {}  # the widest that its filters and sources take
        least = {"seq_w": 16} if module == TOP else {}  # or the numbers in its streams would be ambiguous
        while True:
            widths = {"n_slots": 1 if tracker == "cot" else int(rng.choice(_SLOTS, p=_SLOTS_P))}
            for name, (low, high, _) in SHAPE_RANGES.items():
                if name not in widths and rng.random() < 0.5:
                    widths[name] = int(rng.integers(least.get(name, low), most.get(name, high), endpoint=True))
            enable = int(rng.integers(1, 1 << len(Filter))) if tracker != "cot" and rng.random() < 0.5 else 0
            top = {
                "DATA_W": int(rng.choice([32, 64, 128, 256])),
                "FIFO_DEPTH": int(rng.integers(1, 65)),
                "RECORD_DEPTH": int(rng.integers(1, 17)),
                "HAS": enable,
            }
            try:
                shape = Shape(**widths)
                sensor = _random_filter_shape(rng, shape) if enable or module == TOP else FilterShape()
                return cls(tracker, shape, enable, sensor, top if module == TOP else None)  # type: ignore[arg-type]
            except ConfigError:  # widths that contradict each other
                continue

    @classmethod
    def of(cls, module: str, shape: Shape) -> Design:
        """A shape of a module without filters; of `TOP` around the default tracker.

        Raises:
            ConfigError: the module cannot have it.
        """
        if module != TOP:
            return cls(module, shape)  # type: ignore[arg-type]
        return cls(DEFAULT_MODULE, shape, filter_shape=FilterShape(1 << shape.x_w, 1 << shape.y_w), top={})

    def to_tables(self) -> dict[str, Any]:
        """Plain values: what differs from the defaults."""
        shape = {name: value for name, value in asdict(self.shape).items() if value != getattr(Shape(), name)}
        found: dict[str, Any] = {"module": self.module, "shape": shape}
        if self.enable or self.top is not None:
            found |= {"enable": self.enable, "filter_shape": asdict(self.filter_shape)}
        return found if self.top is None else found | {"top": dict(self.top)}

    @classmethod
    def from_tables(cls, tables: Mapping[str, Any]) -> Design:
        """The design of `to_tables`.

        Raises:
            ConfigError: a shape that the module cannot have.
        """
        shapes = {"shape": Shape(**tables["shape"]), "filter_shape": FilterShape(**tables.get("filter_shape", {}))}
        return cls(**{**tables, **shapes})

    def config(self, rng: np.random.Generator) -> CotConfig | MotionConfig:
        """Random registers for it."""
        own = random_motion(rng, self.shape) if self.module == "cot_motion" else random_config(rng, self.shape, self.module)
        if not self.enable and self.top is None:
            return own
        return replace(own, filters=random_filters(rng, self.filter_shape, self.enable), filter_shape=self.filter_shape)

    def traffic(self, rng: np.random.Generator, events: int) -> TickedEvents:
        """Random events on its sensor: of cot_motion outlines three times in four, else bursts and noise; every fourth time,
        events of a period all come at one tick. No silence is longer than 2^10 tokens."""
        shape = replace(self.shape, tc_w=min(self.shape.tc_w, self.shape.tick_w + _SILENCE_LOG2))
        motion = self.module == "cot_motion"
        if motion:
            shape = replace(shape, tc_w=min(shape.tc_w, _MOTION_SILENCE_LOG2))
        outlines = motion and rng.random() < 0.75
        traffic = (random_outlines if outlines else random_traffic)(rng, shape, events, float(rng.choice(RATES)))
        period = int(rng.integers(2, 1_000)) if rng.random() < 0.25 else 1
        traffic = replace(traffic, ticks=traffic.ticks // period * period)
        if not self.enable and self.top is None:
            return traffic
        return replace(traffic, x=traffic.x % self.filter_shape.width, y=traffic.y % self.filter_shape.height)


_SLOTS = (1, 2, 3, 4, 5, 8, 12, 16, 32, 64)
_SLOTS_P = (0.15, 0.15, 0.15, 0.1, 0.1, 0.15, 0.08, 0.08, 0.02, 0.02)  # many slots take long to compile and to simulate
_SILENCE_LOG2 = 10  # of the tokens in the longest silence
_MOTION_SILENCE_LOG2 = 16  # of its ticks: there may be a motion step in each


def _random_filter_shape(rng: np.random.Generator, shape: Shape) -> FilterShape:
    width, height = (int(rng.integers(1, min(1 << bits, 160), endpoint=True)) for bits in (shape.x_w, shape.y_w))
    return FilterShape(width, height, int(rng.integers(4, 24)), int(rng.integers(1, 41)), int(rng.choice(CELL_PX)))


class Case(NamedTuple):
    """All that a run in lock-step depends on.

    Attributes:
        events: their times are ticks.
        stalls: seed of the stall patterns; None: none.
    """

    config: CotConfig | MotionConfig
    events: Events
    stalls: int | None


def random_case(design: Design, seed: int, events: int) -> Case:
    """Registers, traffic and stalls that a seed determines; three cases in four stall."""
    rng = np.random.default_rng(seed)
    config, traffic = design.config(rng), design.traffic(rng, events)
    return Case(config, Events(traffic.ticks, traffic.x, traffic.y, traffic.p), seed if rng.random() < 0.75 else None)


def run_case(case: Case, model: BuiltModel | None = None) -> Lockstep:
    """Run hardware and model in lock-step.

    Args:
        model: what `build_device` returned for the shape, to avoid the look-up.

    Raises:
        MismatchError: they differ.
    """
    with Lockstep(case.config, stalls=Stalls.seeded(case.stalls), seed=case.stalls, model=model) as lockstep:
        for chunk in chunks(case.events):
            lockstep.feed(chunk)
    return lockstep

# SPDX-License-Identifier: Apache-2.0
"""Named configurations: the default, the paper's two situations, one per common sensor size, and two for a kind of scene."""

from __future__ import annotations

from dataclasses import replace

from ..errors import ConfigError, meant
from ..filters.config import DEFAULT_FILTERS, FilterConfig
from ..hardware.config import CotConfig, MotionConfig, SlotConfig, with_module
from ..hardware.contract import Shape
from ..hardware.modules import DEFAULT_MODULE, Module
from .config import RunConfig
from .rct.config import PRESETS as RCT_PRESETS
from .rct.config import RctConfig

__all__ = ["MOTION", "PRESETS", "fit", "for_sensor", "preset", "presets_of", "run_config"]


def _paper(name: str, n_ev: int, max_ticks: int) -> RunConfig:
    """Table 2: the initial N_ev and the timer TC that ends a cluster, counted in ticks of one millisecond."""
    slot = SlotConfig(
        init_radix=8,
        radix_th=4,
        radix_min=6,
        radix_max=14,
        hist_avg=1,
        max_ticks=max_ticks,
        clust_nev=n_ev,
        nev_min=max(1, n_ev // 2),
        nev_max=2 * n_ev,
        nev_th=2,
        detect_ticks=5,
    )
    rct = RctConfig(radius_px=14.0, visible_events=48, lifetime_us=1_000 * max_ticks)
    return RunConfig(name, CotConfig.uniform(Shape(), slot, tick_us=1_000), rct)


def _sensor(name: str, radius_px: int, n_ev: int, lifetime_us: int) -> RunConfig:
    """A configuration with windows of about `radius_px` and ticks of a microsecond.

    A window should reach from one edge of an object to the other, so that a cluster on one edge covers both.
    """
    ring = max(2, radius_px // 4)
    inner = radius_px - ring
    slot = SlotConfig(
        init_radix=inner,
        radix_th=ring,
        radix_step=1,
        radix_min=inner - max(1, inner // 6),
        radix_max=inner + max(1, inner // 6),
        hist_avg=3,
        max_ticks=lifetime_us,
        clust_nev=n_ev,
        nev_min=n_ev // 2,
        nev_max=n_ev * 2,
        nev_th=lifetime_us // 8,
        detect_ticks=lifetime_us // 3,
    )
    # The software tracker has no time limit for detection: it asks for more events instead.
    rct = RctConfig(radius_px=float(radius_px), visible_events=2 * n_ev, lifetime_us=lifetime_us)
    return RunConfig(name, CotConfig.uniform(Shape(), slot), rct)


def _traffic() -> RunConfig:
    """Cars seen from a bridge, on a sensor of about 346x260; docs/defaults.md says how it was tuned.

    With events of one polarity a car is one edge instead of two, which fits into a window.
    """
    slot = SlotConfig(
        init_radix=19,
        radix_th=3,
        radix_min=2,
        radix_max=50,
        max_ticks=40_000,
        clust_nev=24,
        nev_min=24,
        nev_max=48,
        nev_th=100,
        detect_ticks=7_000,
    )
    filters = FilterConfig(refractory_us=2_000, polarity="off")
    return RunConfig("traffic", CotConfig.uniform(Shape(n_slots=12), slot), RCT_PRESETS["traffic"], filters)


def _discs() -> RunConfig:
    """Objects of about 9 px radius and constant size; N_ev is constant, as recommended in docs/table2.md."""
    slot = SlotConfig(
        init_radix=10,
        radix_th=4,
        radix_min=6,
        radix_max=12,
        max_ticks=10_000,
        clust_nev=6,
        nev_min=6,
        nev_max=6,
        detect_ticks=10_000,
    )
    return RunConfig("discs", CotConfig.uniform(Shape(), slot), RCT_PRESETS["discs"], FilterConfig(refractory_us=500))


MOTION = RunConfig(
    "motion",
    MotionConfig(Shape(n_slots=16)),
    filters=DEFAULT_FILTERS,
    software="adaptive",
    software_filters=FilterConfig(),
)
"""The default of every command: objects of any size that move (docs/motion.md), behind a filter that follows the noise."""

PRESETS: dict[str, RunConfig] = {
    config.name: config
    for config in (
        MOTION,
        _paper("slow", 8, 20),
        _paper("fast", 3, 7),
        _paper("fast5", 5, 7),
        _sensor("dvs128", 10, 16, 30_000),
        _sensor("davis346", 16, 24, 15_000),
        _sensor("vga", 24, 32, 12_000),
        _sensor("hd", 32, 48, 10_000),
        _traffic(),
        _discs(),
    )
}

# Maximum sensor width for each preset.
_WIDTHS = {"dvs128": 128, "davis346": 346, "vga": 640, "hd": 1280}


def preset(name: str) -> RunConfig:
    """The preset of that name.

    Raises:
        ConfigError: unknown name; the message lists the presets.
    """
    if name not in PRESETS:
        raise ConfigError(f"preset {name!r}: must be one of {', '.join(PRESETS)}{meant(name, PRESETS)}")
    return PRESETS[name]


def for_sensor(width: int) -> RunConfig:
    """The preset of cot_array for a sensor of this width: the first that is wide enough, else the widest."""
    return PRESETS[next((name for name, widest in _WIDTHS.items() if width <= widest), "hd")]


def presets_of(module: Module) -> dict[str, RunConfig]:
    """name -> preset, of those that configure a module; a single `cot` has one slot and no filters."""
    if module == "cot_motion":
        return {MOTION.name: MOTION}
    return {name: _for_module(config, module) for name, config in PRESETS.items() if config is not MOTION}


def _for_module(config: RunConfig, module: str) -> RunConfig:
    filters = FilterConfig() if module == "cot" else config.filters
    return replace(config, hardware=with_module(config.hardware, module), filters=filters)


def run_config(
    width: int, height: int, name: str | None = None, n_slots: int | None = None, *, hardware: str | None = None
) -> RunConfig:
    """The configuration of a co-simulation for a sensor.

    Args:
        width, height: of the sensor, in pixels.
        name: of a preset; None: `motion` for cot_motion, the one for such a sensor for the other modules.
        n_slots: number of tracker slots; None: the preset's.
        hardware: the module; None: the preset's, without a preset cot_motion.

    Raises:
        ConfigError: no such preset or module, a preset of another module, or a number of slots outside its range.
    """
    by_default = MOTION if hardware in (None, DEFAULT_MODULE) else for_sensor(width)
    chosen = by_default if name is None else preset(name)
    if hardware is not None:
        try:
            chosen = _for_module(chosen, hardware)
        except ConfigError as error:
            raise ConfigError(f"{error} with preset {chosen.name}" if name else str(error)) from error
    return fit(chosen, width, height, n_slots)


def fit(config: RunConfig, width: int, height: int, n_slots: int | None = None) -> RunConfig:
    """The same configuration with addresses just wide enough for a sensor, and another number of slots if given.

    Added slots repeat the last one's registers.
    """
    own = config.hardware
    n = own.shape.n_slots if n_slots is None else n_slots
    shape = replace(own.shape, x_w=_bits(width), y_w=_bits(height), n_slots=n)
    if isinstance(own, MotionConfig):
        fitted: CotConfig | MotionConfig = replace(own, shape=shape, modes=(own.modes + own.modes[-1:] * n)[:n])
    else:
        fitted = replace(own, shape=shape, slots=(own.slots + own.slots[-1:] * n)[:n])
    return replace(config, hardware=fitted, sensor=(width, height))


def _bits(size: int) -> int:
    return max(1, (size - 1).bit_length())

# SPDX-License-Identifier: Apache-2.0
"""The array with motion (docs/motion.md) in hardware: its module, the configurations it refuses, its register writes."""

from __future__ import annotations

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.motion.contract import MotionRegisters
from evcot.hardware.registers import motion_addresses, register_map

from ..names import Top

__all__ = ["MOTION_PARAMETERS", "check_motion", "check_top", "motion_writes"]

MOTION_PARAMETERS = frozenset({"n_slots", "x_w", "y_w", "tick_w", "radix_w", "sup_w", "id_w", "seq_w", "time_w"})
"""The fields of a shape that cot_motion.v has as parameters."""


def check_motion(config: CotConfig, top: Top) -> None:
    """Raise ConfigError for a configuration with motion that no RTL has: to be called before anything is built."""
    if not config.motion.enable:
        return
    if top != "cot_array":
        raise ConfigError(f"motion.enable = {config.motion.enable}: must be 0 for {top}; only cot_array has motion")
    _check_time(config.shape)


def check_top(config: CotConfig, tracker: int) -> None:
    """Raise ConfigError for an evcot_top that cannot have a configuration: to be called before anything is built."""
    names = register_map().trackers
    motion = names.index("motion")
    if config.motion.enable and tracker != motion:
        raise ConfigError(
            f"motion.enable = 1: must be 0 for an evcot_top with TRACKER = {tracker} ({names[tracker]}); "
            f"TRACKER = {motion} has motion"
        )
    if tracker == motion:
        if not config.motion.enable:
            raise ConfigError(f"motion.enable = 0: must be 1 for an evcot_top with TRACKER = {motion} (motion)")
        _check_time(config.shape)


def _check_time(shape: Shape) -> None:
    if shape.time_w < 32:
        raise ConfigError(f"shape.time_w = {shape.time_w}: must be from 32 to 48 with motion.enable = 1")
    if shape.time_w == shape.tick_w:
        raise ConfigError(f"shape.time_w = {shape.time_w}: must be more than tick_w = {shape.tick_w} with motion.enable = 1")


def motion_writes(registers: MotionRegisters) -> list[tuple[int, int]]:
    """Address and value of each register that holds for the whole array."""
    return [(address, int(getattr(registers, name))) for name, address in motion_addresses().items() if name != "mode"]

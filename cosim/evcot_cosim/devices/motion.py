# SPDX-License-Identifier: Apache-2.0
"""The array with motion, docs/motion.md, in hardware: its module, what it cannot be, and the writes of its registers."""

from __future__ import annotations

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig
from evcot.hardware.motion.contract import MotionRegisters, motion_addresses

from ..names import Top

__all__ = ["MOTION_PARAMETERS", "check_motion", "motion_writes", "refuse_motion"]

MOTION_PARAMETERS = frozenset({"n_slots", "x_w", "y_w", "tick_w", "radix_w", "sup_w", "id_w", "seq_w", "time_w"})
"""The fields of a shape that cot_motion.v has as parameters."""


def check_motion(config: CotConfig, top: Top) -> None:
    """Raise ConfigError for a configuration with motion that no RTL has: to be called before anything is built."""
    if not config.motion.enable:
        return
    if top != "cot_array":
        raise ConfigError(f"motion.enable = {config.motion.enable}: must be 0 for {top}; only cot_array has motion")
    shape = config.shape
    if shape.time_w < 32:
        raise ConfigError(f"shape.time_w = {shape.time_w}: must be from 32 to 48 with motion.enable = 1")
    if shape.time_w == shape.tick_w:
        raise ConfigError(f"shape.time_w = {shape.time_w}: must be more than tick_w = {shape.tick_w} with motion.enable = 1")


def refuse_motion(config: CotConfig) -> None:
    """Raise ConfigError for a configuration with motion, where the hardware has no registers for it."""
    if config.motion.enable:
        raise ConfigError(f"motion.enable = {config.motion.enable}: must be 0 in evcot_top: it does not have cot_motion yet")


def motion_writes(registers: MotionRegisters) -> list[tuple[int, int]]:
    """Address and value of each register that holds for the whole array."""
    return [(address, int(getattr(registers, name))) for name, address in motion_addresses().items() if name != "mode"]

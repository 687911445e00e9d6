# SPDX-License-Identifier: Apache-2.0
"""The configuration of a run from estimates about the scene: registers and filters of the hardware, without any preset."""

from __future__ import annotations

from .auto.estimates import Estimates
from .auto_motion import motion_config
from .auto_paper import paper_config
from .config import RunConfig
from .presets import AUTO, AUTO_PAPER, for_sensor

__all__ = ["auto_config", "told"]


def auto_config(seen: Estimates, name: str = AUTO) -> RunConfig:
    """The configuration for a scene: registers and filters of the hardware, and the automatic software tracker beside it.

    Args:
        seen: of the scene.
        name: `AUTO` or `AUTO_PAPER`.
    """
    return (paper_config if name == AUTO_PAPER else motion_config)(seen, name)


def told(seen: Estimates, config: RunConfig) -> str:
    """A line on what was seen, and what became of it."""
    cot, slot = config.cot, config.cot.slots[0]
    chosen = [f"{cot.shape.n_slots} slots{' with motion' if cot.motion.enable else ''}"]
    if not cot.motion.enable:
        chosen += [f"radius {slot.init_radix + slot.radix_th} px", f"N_ev {slot.clust_nev}"]
        chosen.append(f"lifetime {slot.max_ticks * cot.tick_us / 1e3:g} ms")
        if not seen.objects:
            chosen.insert(0, f"preset {for_sensor(seen.sensor[0]).name} assumed")
    chosen += [f"{which.name.lower()} filter" for which in config.filters.filters]
    return f"{seen} -> {', '.join(chosen)}"

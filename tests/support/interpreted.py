# SPDX-License-Identifier: Apache-2.0
"""Steps of trackers as Python functions: tests call each by itself, without waiting for a compiler."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

from evcot.trackers.adaptive import bins, births, boxes, life, look, restless, tracker
from evcot.trackers.adaptive.config import AdaptiveConfig
from evcot.trackers.adaptive.layout import Rules, World, make_rules, make_world

__all__ = ["HEIGHT", "WIDTH", "interpret", "scene"]

WIDTH, HEIGHT = 200, 120


_ADAPTIVE: tuple[ModuleType, ...] = (births, bins, boxes, life, look, restless, tracker)


def interpret(patch: pytest.MonkeyPatch, *modules: ModuleType) -> None:
    """Replace the compiled functions in modules, of the adaptive tracker unless others are given, by what was compiled."""
    for module in modules or _ADAPTIVE:
        for name, value in vars(module).copy().items():
            if hasattr(value, "py_func"):
                patch.setattr(module, name, value.py_func)
        # What works on words of a compiled function's types.
        patch.setattr(module, "count", lambda word: int(word).bit_count(), raising=False)
        patch.setattr(module, "lowest", lambda word: (int(word) & -int(word)).bit_length() - 1, raising=False)


def scene(*objects: dict[str, Any], **config: float) -> tuple[Rules, World]:
    """Rules, and a world of visible objects at (100, 60) with half sides of 10 px, or as given.

    The state is given as `x`, `vx`, `hx`, `gx` (centre, velocity, half side, growth) and likewise for y, everything else by
    the names of `layout.OBJECT`. Nothing is uncertain.
    """
    n = len(objects)
    rules = make_rules(AdaptiveConfig(max_objects=max(n, 1), **config), WIDTH, HEIGHT)  # type: ignore[arg-type]
    plain = make_world(max(n, 1), WIDTH, HEIGHT)
    world = plain._replace(run=plain.run.view(np.recarray), objects=plain.objects.view(np.recarray))
    world.run["live"], world.slots[:n] = n, np.arange(n)
    state = [f"{of}{axis}" for axis in "xy" for of in ("", "v", "h", "g")]
    for i, given in enumerate(objects):
        values = {"": 0, "x": 100, "y": 60, "hx": 10, "hy": 10, "vx": 0, "vy": 0, "gx": 0, "gy": 0} | given
        world.state[i] = np.array([values[name] for name in state], float).reshape(2, 4)
        row = {"alive": True, "track_id": i, "name": -1, "away": -1, "inside": -1, "edge": -1, "speed": 20.0, "gate": 2.0}
        for name, value in (row | {name: value for name, value in given.items() if name not in state}).items():
            world.objects[name][i] = value
    return rules, world

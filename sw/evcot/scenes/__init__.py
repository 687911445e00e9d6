# SPDX-License-Identifier: Apache-2.0
"""Simulated scenes: events, and the ground truth of the objects that cause them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._lazy import lazily
from .registry import SCENES, simulate_scene

if TYPE_CHECKING:
    from .boxes import BoxExperiment, simulate
    from .pixel import PixelCamera, PixelModel
    from .truth import TRUTH, Box, Scene, Truth

__all__ = [
    "SCENES",
    "TRUTH",
    "Box",
    "BoxExperiment",
    "PixelCamera",
    "PixelModel",
    "Scene",
    "Truth",
    "simulate",
    "simulate_scene",
]

__getattr__, __dir__ = lazily(
    __name__,
    {
        "boxes": ("BoxExperiment", "simulate"),
        "pixel": ("PixelCamera", "PixelModel"),
        "truth": ("TRUTH", "Box", "Scene", "Truth"),
    },
)

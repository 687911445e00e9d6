# SPDX-License-Identifier: Apache-2.0
"""Simulated scenes: events, and the ground truth of the objects that cause them."""

from __future__ import annotations

from .boxes import BoxExperiment, simulate
from .pixel import PixelCamera, PixelModel
from .registry import SCENES, simulate_scene
from .scene import Scene
from .truth import TRUTH, Box, Truth

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

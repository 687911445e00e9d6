# SPDX-License-Identifier: Apache-2.0
"""Simulated scenes: events and, beside them, the truth about the objects that cause them."""

from __future__ import annotations

from .boxes import BoxExperiment, Scene, simulate
from .truth import TRUTH, Box, Truth

__all__ = ["TRUTH", "Box", "BoxExperiment", "Scene", "Truth", "simulate"]

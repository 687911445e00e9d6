# SPDX-License-Identifier: Apache-2.0
"""Figures for a paper: tracks over events, places over time, how many were alive, and their lives."""

from .figure import KINDS, plot
from .material import Log, Material, density

__all__ = ["KINDS", "Log", "Material", "density", "plot"]

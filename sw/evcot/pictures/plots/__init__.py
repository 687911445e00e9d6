# SPDX-License-Identifier: Apache-2.0
"""Figures for publications: tracks over events, positions over time, number of tracks alive, and lifetimes."""

from .figure import KINDS, plot
from .material import Log, Material, density

__all__ = ["KINDS", "Log", "Material", "density", "plot"]

# SPDX-License-Identifier: Apache-2.0
"""Figures for publications: tracks over events, positions over time, number of tracks alive, and lifetimes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._lazy import lazily
from ..style import KINDS

if TYPE_CHECKING:
    from .figure import figure_of, plot
    from .material import Log, Material, density

__all__ = ["KINDS", "Log", "Material", "density", "figure_of", "plot"]

__getattr__, __dir__ = lazily(__name__, {"figure": ("figure_of", "plot"), "material": ("Log", "Material", "density")})

# SPDX-License-Identifier: Apache-2.0
"""The report of a run: one HTML file that a person opens and explores, without a network.

Data flows one way: `Material` (what ran) → `collect` (columns of numbers) → `pack` (one text) → `page` (the file).
"""

from .material import Material, Side, Truth
from .page import write_report

__all__ = ["Material", "Side", "Truth", "write_report"]

# SPDX-License-Identifier: Apache-2.0
"""The report of a run: a self-contained, interactive HTML file.

Data flows one way: `Material` (logs and figures) → `collect` (columns of numbers) → `pack` (one text) → `page` (the file).
"""

from ..lockstep.truth import Truth, truth_of
from .comparison import ComparedRun, comparison_of
from .material import Material, Side
from .page import render, write_report

__all__ = ["REPORT", "ComparedRun", "Material", "Side", "Truth", "comparison_of", "render", "truth_of", "write_report"]

REPORT = "report.html"  # its name in the folder of a run

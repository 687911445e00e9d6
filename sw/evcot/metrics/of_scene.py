# SPDX-License-Identifier: Apache-2.0
"""The truth of a simulated scene as a ground truth, rounded as in its file."""

from __future__ import annotations

import tempfile
from pathlib import Path

from ..scenes.truth import Truth
from .rule import Rule
from .truth import GroundTruth, read_truth

__all__ = ["ground_truth_of"]


def ground_truth_of(truth: Truth, rule: Rule) -> GroundTruth:
    """What `read_truth` makes of the file beside the scene's recording; errors as of it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "truth.csv"
        truth.save(path)
        return read_truth(path, rule)

# SPDX-License-Identifier: Apache-2.0
"""Evaluation of tracks against ground truth: CLEAR, ID scores, HOTA, errors of position and velocity, latency."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._lazy import lazily
from .rule import RULES, Rule, load_rule

if TYPE_CHECKING:
    from .scores import Scores, evaluate
    from .truth import GroundTruth, read_truth, rule_for

__all__ = ["RULES", "GroundTruth", "Rule", "Scores", "evaluate", "load_rule", "read_truth", "rule_for"]

__getattr__, __dir__ = lazily(__name__, {"scores": ("Scores", "evaluate"), "truth": ("GroundTruth", "read_truth", "rule_for")})

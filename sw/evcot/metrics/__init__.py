# SPDX-License-Identifier: Apache-2.0
"""Evaluation of tracks against ground truth: CLEAR, ID scores, HOTA, errors of position and velocity, latency."""

from .evaluate import Scores, evaluate
from .rule import RULES, Rule, load_rule
from .truth import GroundTruth, read_truth, rule_for

__all__ = ["RULES", "GroundTruth", "Rule", "Scores", "evaluate", "load_rule", "read_truth", "rule_for"]

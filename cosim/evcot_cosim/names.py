# SPDX-License-Identifier: Apache-2.0
"""Names that the command line offers, in a module that is cheap to import."""

from __future__ import annotations

from typing import Literal

__all__ = ["DEFAULT_TOP", "MOMENTS", "Top"]

Top = Literal["cot", "cot_chain", "cot_array"]
"""The hardware module."""

DEFAULT_TOP: Top = "cot_array"

MOMENTS = "birth:N, move:N, merge:N, loss:N (the N-th, 1 without it), mismatch, event:N (from 0) or time:MS"
"""Moments of a run, for people."""

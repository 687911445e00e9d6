# SPDX-License-Identifier: Apache-2.0
"""Names that the command line offers, in a module that is cheap to import."""

from __future__ import annotations

__all__ = ["MOMENTS"]

MOMENTS = "birth:ID, move:ID, merge:ID, loss:ID (of that track; without ID the first), mismatch, event:N (from 0) or time:MS"
"""Moments of a run, for people."""

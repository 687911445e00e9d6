# SPDX-License-Identifier: Apache-2.0
"""Names that the command line offers, in a module that is cheap to import."""

from __future__ import annotations

__all__ = ["MOMENTS"]

MOMENTS = "birth:N, move:N, merge:N, loss:N (the N-th, 1 without it), mismatch, event:N (from 0) or time:MS"
"""Moments of a run, for people."""

# SPDX-License-Identifier: Apache-2.0
"""Hardware and golden model in lock-step, and whole runs: hardware, model and software tracker on one recording."""

MOMENTS = "birth:ID, move:ID, merge:ID, loss:ID (of that track; without ID the first), mismatch, event:N (from 0) or time:MS"
"""Moments of a run, for people."""

# SPDX-License-Identifier: Apache-2.0
"""Tracker output: the TrackLog, the interface of a tracker, timelines, and comparison of two logs."""

from __future__ import annotations

__all__ = ["CSV", "LOG_SUFFIXES", "NPZ", "PARQUET"]

# Suffixes of the files of a track log.
NPZ, PARQUET, CSV = ".npz", ".parquet", ".csv"
LOG_SUFFIXES = (NPZ, PARQUET, CSV)  # CSV has the records alone, and is not read

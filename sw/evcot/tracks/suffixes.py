# SPDX-License-Identifier: Apache-2.0
"""Suffixes of the files of a track log."""

from __future__ import annotations

__all__ = ["CSV", "LOG_SUFFIXES", "NPZ", "PARQUET"]

NPZ, PARQUET, CSV = ".npz", ".parquet", ".csv"
LOG_SUFFIXES = (NPZ, PARQUET, CSV)  # CSV has the records alone, and is not read

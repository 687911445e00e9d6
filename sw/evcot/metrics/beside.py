# SPDX-License-Identifier: Apache-2.0
"""Where the truth of a recording is found: in a file beside it."""

from __future__ import annotations

from pathlib import Path

__all__ = ["TRUTH_SUFFIXES", "truth_beside"]

TRUTH_SUFFIXES = (".truth.csv", "_gt.csv")  # behind a recording's stem: as `evcot simulate` writes it, and as data sets name it


def truth_beside(recording: Path) -> Path | None:
    """The truth beside a recording, None if there is none."""
    paths = (recording.with_name(f"{recording.stem}{suffix}") for suffix in TRUTH_SUFFIXES)
    return next((path for path in paths if path.is_file()), None)

# SPDX-License-Identifier: Apache-2.0
"""The folder of the real recordings, beside the checkout; it may be missing."""

from __future__ import annotations

from pathlib import Path

__all__ = ["SHARED"]

SHARED = Path(__file__).parents[2] / "shared" / "data"

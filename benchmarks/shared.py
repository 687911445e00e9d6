# SPDX-License-Identifier: Apache-2.0
"""Where the real recordings are, if they are at hand: in a folder beside the checkout."""

from __future__ import annotations

from pathlib import Path

__all__ = ["SHARED"]

SHARED = Path(__file__).parents[2] / "shared" / "data"

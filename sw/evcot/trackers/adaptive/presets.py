# SPDX-License-Identifier: Apache-2.0
"""Named settings of the adaptive tracker: one for all."""

from __future__ import annotations

from .config import AdaptiveConfig

__all__ = ["PRESETS"]

PRESETS: dict[str, AdaptiveConfig] = {"auto": AdaptiveConfig()}

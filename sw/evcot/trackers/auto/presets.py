# SPDX-License-Identifier: Apache-2.0
"""Named settings of the automatic tracker: one for all."""

from __future__ import annotations

from .config import AutoConfig

__all__ = ["PRESETS"]

PRESETS: dict[str, AutoConfig] = {"auto": AutoConfig()}

# SPDX-License-Identifier: Apache-2.0
"""Films of tracks over events: MP4 (the extra `video`), GIF, and Rerun's recordings (the extra `rerun`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._lazy import lazily
from .look import Look

if TYPE_CHECKING:
    from .draw import Side, side_of
    from .film import render

__all__ = ["Look", "Side", "render", "side_of"]

__getattr__, __dir__ = lazily(__name__, {"film": ("render",), "draw": ("Side", "side_of")})

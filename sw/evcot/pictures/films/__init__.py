# SPDX-License-Identifier: Apache-2.0
"""Films of tracks over events: MP4 (the extra `video`), GIF, and Rerun's recordings (the extra `rerun`)."""

from .film import Look, render
from .states import Side, side_of

__all__ = ["Look", "Side", "render", "side_of"]

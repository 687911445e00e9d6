# SPDX-License-Identifier: Apache-2.0
"""Films of tracks over events: MP4 (the extra `video`), GIF, and Rerun's recordings (the extra `rerun`)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..._lazy import lazily
from ...errors import ConfigError

if TYPE_CHECKING:
    from .draw import Side, side_of
    from .film import render

__all__ = ["FADE_CONSTANTS", "GIF", "MP4", "RERUN", "SUFFIXES", "Look", "Side", "render", "side_of"]

MP4, GIF, RERUN = SUFFIXES = (".mp4", ".gif", ".rrd")

FADE_CONSTANTS = 5.0
"""Time constants after which an event is invisible."""

_RANGES = {"speed": (1e-4, 1e3), "fps": (1.0, 100.0), "decay_ms": (1e-3, 1e5), "width_px": (64, 4096)}


@dataclass(frozen=True)
class Look:
    """How a film looks.

    Attributes:
        speed: seconds of the recording per second of the film.
        fps: pictures per second.
        decay_ms: of the film: after it an event shows at 1/e of its strength.
        width_px: the picture is at least so wide; a wider sensor is shown as it is.

    Raises:
        ConfigError: a value outside its range.
    """

    speed: float = 1.0
    fps: float = 30.0
    decay_ms: float = 30.0
    width_px: int = 640

    @property
    def fade_us(self) -> int:
        """Time of the recording after which an event is invisible."""
        return math.ceil(FADE_CONSTANTS * self.decay_ms * 1e3 * self.speed)

    def __post_init__(self) -> None:
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise ConfigError(f"{name} = {value:g}: must be from {low:g} to {high:g}")


__getattr__, __dir__ = lazily(__name__, {"film": ("render",), "draw": ("Side", "side_of")})

# SPDX-License-Identifier: Apache-2.0
"""What every simulated scene is."""

from __future__ import annotations

from dataclasses import dataclass

from ..events import Recording
from .truth import Truth

__all__ = ["Scene"]


@dataclass(frozen=True, eq=False)
class Scene:
    """A simulated recording, the truth about it, and the seed that made it."""

    recording: Recording
    truth: Truth
    seed: int

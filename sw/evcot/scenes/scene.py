# SPDX-License-Identifier: Apache-2.0
"""The result of a simulated scene."""

from __future__ import annotations

from dataclasses import dataclass

from ..events import Recording
from .truth import Truth

__all__ = ["Scene"]


@dataclass(frozen=True, eq=False)
class Scene:
    """A simulated recording, its ground truth, and the seed."""

    recording: Recording
    truth: Truth
    seed: int

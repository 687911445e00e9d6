# SPDX-License-Identifier: Apache-2.0
"""Mirror addresses from an origin at the bottom, or at the right, to the origin at the top left."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["mirrored"]


def mirrored(address: NDArray[Any], size: int) -> NDArray[np.uint16]:
    """Mirror (n,) addresses; one beyond `size` is returned unchanged, and refused by the later validation."""
    return np.where(address < size, size - 1 - address, address).astype(np.uint16)

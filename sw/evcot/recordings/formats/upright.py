# SPDX-License-Identifier: Apache-2.0
"""From an origin at the bottom, or at the right, to the origin at the top left."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["mirrored"]


def mirrored(address: NDArray[Any], size: int) -> NDArray[np.uint16]:
    """(n,) addresses counted from the other side; one beyond `size` stays as it is, for whoever refuses it."""
    return np.where(address < size, size - 1 - address, address).astype(np.uint16)

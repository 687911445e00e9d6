# SPDX-License-Identifier: Apache-2.0
"""Freed memory in long runs: the C library keeps tens of megabytes of it, unless it is asked to return them.

Both functions do nothing where the library is not glibc.
"""

from __future__ import annotations

import ctypes
import os
from typing import Any

__all__ = ["give_back", "keep_little"]

_MMAP_THRESHOLD, _ARENA_MAX = -3, -8  # of malloc.h


def keep_little(large_bytes: int = 1 << 20) -> None:
    """Return blocks of at least so many bytes to the system as soon as they are freed, from now on: arrays leave no holes.

    All threads share one heap: with one each, `evcot cosim` over 4 M events takes 30 MB more, and no less time.
    """
    adjust = _function("mallopt")
    if adjust is not None:
        adjust(_MMAP_THRESHOLD, large_bytes)
        adjust(_ARENA_MAX, 1)


def give_back() -> None:
    """Return what has been freed so far."""
    trim = _function("malloc_trim")
    if trim is not None:
        trim(0)


def _function(name: str) -> Any:
    return getattr(ctypes.CDLL(None), name, None) if os.name == "posix" else None

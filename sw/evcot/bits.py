# SPDX-License-Identifier: Apache-2.0
"""Sets as words of 64 bits: their members one after the other, for compiled functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._numba_private import njit, step, trailing_zeros

__all__ = ["BYTES", "bits_between", "count", "lowest", "without_lowest"]

BYTES = np.uint64(0x0101010101010101)  # the lowest bit of each byte

_PAIRS, _NIBBLES, _BYTES = (np.uint64(word) for word in (0x5555555555555555, 0x3333333333333333, 0x0F0F0F0F0F0F0F0F))
_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)


@njit(cache=True, nogil=True, inline="always")
def lowest(word: Any) -> Any:
    """Index of the lowest set bit."""
    return np.uint64(trailing_zeros(word))  # type: ignore[call-arg]


@njit(cache=True, nogil=True, inline="always")
def without_lowest(word: Any) -> Any:
    """The word with its lowest set bit cleared."""
    return word & (word - np.uint64(1))


@step
def bits_between(first: int, last: int) -> Any:
    """A word with its bits from `first` to `last` set; none if there are none."""
    if last < first:
        return np.uint64(0)
    return (_ALL >> np.uint64(63 - last + first)) << np.uint64(first)


@step
def count(word: Any) -> int:
    """Number of set bits: sums of pairs, of fours, of bytes."""
    pairs = word - ((word >> np.uint64(1)) & _PAIRS)
    fours = (pairs & _NIBBLES) + ((pairs >> np.uint64(2)) & _NIBBLES)
    return int((((fours + (fours >> np.uint64(4))) & _BYTES) * BYTES) >> np.uint64(56))

# SPDX-License-Identifier: Apache-2.0
"""The AXI4-Stream words of `evcot_top.v`, packed and unpacked with NumPy; their layout is defined in registers.toml.

Records need no unpacking: they are `contract.RECORD`, byte for byte, so `np.frombuffer(data, RECORD)` reads a stream of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from .registers import Word, register_map

__all__ = ["pack", "pack_events", "unpack", "whole_numbers"]

_LOW_BITS = ("t", "seq")  # fields that hold the low bits of a longer number


def _word(name: str) -> Word:
    return next(word for word in register_map().streams if word.name == name)


def pack(stream: str, columns: Mapping[str, NDArray[np.integer[Any]]]) -> NDArray[np.uint64]:
    """Pack columns, one (n,) for each field, to words of the stream "event", "owned" or "passed", (n,) uint64.

    Of times and of event numbers only the low bits are kept.

    Raises:
        RecordingError: an address, a slot or a polarity outside the range of its field.
    """
    fields = _word(stream).fields
    words = np.zeros(len(columns[fields[0].name]), np.uint64)
    for field in fields:
        values = np.asarray(columns[field.name]).astype(np.int64)
        top = (1 << field.bits) - 1
        if field.name not in _LOW_BITS and len(beyond := np.flatnonzero((values < 0) | (values > top))):
            raise RecordingError(f"event {beyond[0]}: {field.name} = {values[beyond[0]]}: must be from 0 to {top}")
        words |= (values & top).astype(np.uint64) << np.uint64(field.lsb)
    return words


def pack_events(
    t_us: NDArray[np.integer[Any]], x: NDArray[np.integer[Any]], y: NDArray[np.integer[Any]], p: NDArray[np.integer[Any]]
) -> NDArray[np.uint64]:
    """Pack events to words of the input stream, (n,) uint64; of the time in microseconds only the low bits are kept.

    Raises:
        RecordingError: an address or a polarity outside the range of its field.
    """
    return pack("event", {"t": t_us, "x": x, "y": y, "p": p})


def unpack(stream: str, words: NDArray[np.uint64]) -> NDArray[np.void]:
    """Unpack words of the stream "event", "owned" or "passed" to a structured array, (n,), with a uint32 for each field."""
    fields = _word(stream).fields
    found = np.empty(len(words), [(field.name, np.uint32) for field in fields])
    for field in fields:
        found[field.name] = words >> np.uint64(field.lsb) & np.uint64((1 << field.bits) - 1)
    return found


def whole_numbers(low: NDArray[np.integer[Any]], bits: int, first: int = 0) -> NDArray[np.int64]:
    """Unwrap event numbers from their low bits, (n,): each is the nearest to the previous one, the first to `first`."""
    values = np.concatenate([[first], np.asarray(low, np.int64)])
    half, span = 1 << (bits - 1), 1 << bits
    steps = (np.diff(values) + half) % span - half
    return first + np.cumsum(steps)

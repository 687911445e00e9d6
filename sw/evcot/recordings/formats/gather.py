# SPDX-License-Identifier: Apache-2.0
"""From a file's own packets to blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from ...errors import RecordingError
from ...events import Events
from .source import BLOCK_EVENTS

__all__ = ["batches", "gathered"]

_Part = TypeVar("_Part")


def batches(parts: Iterable[_Part], size: int, size_of: Callable[[_Part], int]) -> Iterator[list[_Part]]:
    """Parts in lists of about `size` in all; those before a RecordingError are given before it."""
    waiting: list[_Part] = []
    held = 0
    try:
        for part in parts:
            waiting.append(part)
            held += size_of(part)
            if held >= size:
                batch, waiting, held = waiting, [], 0
                yield batch
    except RecordingError:
        yield waiting
        raise
    yield waiting


def gathered(parts: Iterable[Events]) -> Iterator[Events]:
    """Small parts joined into blocks of `BLOCK_EVENTS` or a little more; those before a RecordingError are given before it."""
    return map(Events.joined, batches(parts, BLOCK_EVENTS, len))

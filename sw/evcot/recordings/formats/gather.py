# SPDX-License-Identifier: Apache-2.0
"""Gather a file's packets into blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from ...errors import RecordingError
from ...events import Events
from .source import BLOCK_EVENTS

__all__ = ["batches", "gathered"]

_Part = TypeVar("_Part")


def batches(parts: Iterable[_Part], size: int, size_of: Callable[[_Part], int]) -> Iterator[list[_Part]]:
    """Lists of parts with a total size of about `size`; the parts before a RecordingError are yielded before it is raised."""
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
    """Small parts joined into blocks of about `BLOCK_EVENTS`; the parts before a RecordingError are yielded before it."""
    return map(Events.joined, batches(parts, BLOCK_EVENTS, len))

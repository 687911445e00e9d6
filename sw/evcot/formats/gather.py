# SPDX-License-Identifier: Apache-2.0
"""From a file's own packets to blocks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..errors import RecordingError
from ..events import Events
from .source import BLOCK_EVENTS

__all__ = ["gathered"]


def gathered(parts: Iterable[Events]) -> Iterator[Events]:
    """Small parts joined into blocks of `BLOCK_EVENTS` or a little more; those before a RecordingError are given before it."""
    waiting: list[Events] = []
    count = 0
    try:
        for part in parts:
            waiting.append(part)
            count += len(part)
            if count >= BLOCK_EVENTS:
                block, waiting, count = Events.joined(waiting), [], 0
                yield block
    except RecordingError:
        yield Events.joined(waiting)
        raise
    yield Events.joined(waiting)

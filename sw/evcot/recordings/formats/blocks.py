# SPDX-License-Identifier: Apache-2.0
"""From packets of a file to blocks of events, and read-ahead."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

from ...errors import RecordingError
from ...events import Events
from .source import BLOCK_EVENTS

__all__ = ["batches", "gathered", "in_order"]


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


# Enough for reading to be faster than what consumes the events.
_WORKERS = min(2, os.cpu_count() or 1)
_PIECES_AHEAD = 4

_Piece = TypeVar("_Piece")
_Result = TypeVar("_Result")


def in_order(decode: Callable[[_Piece], _Result], pieces: Iterable[_Piece], workers: int = _WORKERS) -> Iterator[_Result]:
    """`map(decode, pieces)` on other threads, a few pieces ahead; `pieces` is iterated on the caller's thread.

    Useful where `decode` releases the GIL, as compiled kernels and decompression do. The first piece is decoded by the caller:
    a short file, or the look at a file's first event, needs no thread. An exception of `pieces` or `decode` is raised in order,
    after the results of all pieces before it, and ends the iteration. With one worker, pieces are decoded one by one.
    """
    source = iter(pieces)
    yield from map(decode, islice(source, 1))
    waiting: deque[Future[_Result]] = deque()
    failure: Exception | None = None
    with ThreadPoolExecutor(workers, "decode") as pool:
        try:
            while failure is None:
                try:
                    waiting.append(pool.submit(decode, next(source)))
                except StopIteration:
                    break
                except Exception as error:
                    failure = error
                if len(waiting) > _PIECES_AHEAD:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for each in waiting:
                each.cancel()
    if failure is not None:
        raise failure

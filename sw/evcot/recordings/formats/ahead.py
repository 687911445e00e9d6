# SPDX-License-Identifier: Apache-2.0
"""Read-ahead: while the caller processes one block, other threads decode the next ones."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

__all__ = ["in_order"]

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

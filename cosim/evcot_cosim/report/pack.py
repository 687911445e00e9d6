# SPDX-License-Identifier: Apache-2.0
"""What makes a report small: columns of integers compressed to one text for browsers, and subsampling of long runs."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.log import Kind

__all__ = [
    "EVENTS_MAX",
    "LIVES_MAX",
    "RECORDS_MAX",
    "Column",
    "Packed",
    "longest_lives",
    "pack",
    "thinned_events",
    "thinned_records",
]


@dataclass(frozen=True)
class Column:
    """Integers, (n,), and how to compress them.

    Attributes:
        values: of magnitude below 2^52, so that a browser's numbers hold them.
        delta: pack the differences from one to the next.
        scale: value of one unit, by which the browser multiplies.
        noise: incompressible by matching: use entropy coding only.
    """

    values: NDArray[Any]
    delta: bool = False
    scale: float = 1.0
    noise: bool = False


@dataclass(frozen=True)
class Packed:
    """`directory`: how to unpack each column; `text`: all columns in base64, which needs no escaping in HTML."""

    directory: dict[str, dict[str, Any]]
    text: str


def pack(columns: Mapping[str, Column]) -> Packed:
    """Pack columns, on two threads."""
    with ThreadPoolExecutor(2) as threads:
        packed = list(threads.map(_packed, columns.values()))
    directory, at = {}, 0
    for name, (entry, content) in zip(columns, packed, strict=True):
        directory[name] = {**entry, "at": at, "bytes": len(content)}
        at += len(content)
    return Packed(directory, base64.b64encode(b"".join(content for _, content in packed)).decode("ascii"))


def _packed(column: Column) -> tuple[dict[str, Any], bytes]:
    values = np.asarray(column.values).astype(np.int64)
    if column.delta:
        values = np.diff(values, prepend=0)
    signed = bool(len(values)) and int(values.min()) < 0
    if signed:
        values = (values << 1) ^ (values >> 63)
    planes = max(1, -(-int(values.max()).bit_length() // 8)) if len(values) else 1
    content = np.ascontiguousarray(values.view(np.uint8).reshape(-1, 8)[:, :planes].T).tobytes()
    strategy = zlib.Z_RLE if column.noise else zlib.Z_DEFAULT_STRATEGY
    deflate = zlib.compressobj(6, zlib.DEFLATED, 15, 9, strategy)
    entry = {"n": len(values), "planes": planes, "signed": signed, "delta": column.delta, "scale": column.scale}
    return entry, deflate.compress(content) + deflate.flush()


EVENTS_MAX = 2_000_000
LIVES_MAX = 4_000  # per side
RECORDS_MAX = 200_000  # per side

_SEED = 1


def thinned_events(n: int, most: int) -> NDArray[np.int64]:
    """At most `most` of the numbers 0 to n - 1, ascending: one random number from each of `most` equal intervals."""
    if n <= most:
        return np.arange(n)
    edges = np.linspace(0, n, most + 1).astype(np.int64)
    at = np.random.default_rng(_SEED).random(most)
    return edges[:-1] + (at * np.diff(edges)).astype(np.int64)


def longest_lives(lives: NDArray[np.void], most: int, among: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Select the `most` longest rows of dtype `timeline.LIFE`, of those that `among` has; (k,) bool."""
    candidates = np.flatnonzero(among)
    lengths_us = (lives["end_us"] - lives["birth_us"])[candidates]
    keep = np.zeros(len(lives), np.bool_)
    keep[candidates[np.argsort(-lengths_us, kind="stable")[:most]]] = True
    return keep


def thinned_records(kind: NDArray[np.uint8], most: int = RECORDS_MAX) -> NDArray[np.bool_]:
    """Select records of a log: every birth and end, and an even selection of moves up to the limit."""
    moved = kind == Kind.MOVED
    room = max(most - int(np.count_nonzero(~moved)), 0)
    keep: NDArray[np.bool_] = ~moved
    keep[np.flatnonzero(moved)[thinned_events(int(moved.sum()), room)]] = True
    return keep

# SPDX-License-Identifier: Apache-2.0
"""Columns of integers as one short text that a browser unpacks: differences, planes of bytes, deflate, 13 bits in a pair of
characters."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["ALPHABET", "Column", "Packed", "decode_text", "encode_text", "pack"]

# All printable characters but those that mean something in HTML: 91 of them, 91 * 91 >= 2^13.
ALPHABET = "".join(chr(code) for code in range(33, 127) if chr(code) not in "<>&")
_GROUP = 13  # bytes, in 8 pairs of characters
_BITS = 13


@dataclass(frozen=True)
class Column:
    """Integers, (n,), and how they are best packed.

    Attributes:
        values: of magnitude below 2^52, so that a browser's numbers hold them.
        delta: pack the differences from one to the next.
        scale: what one unit stands for; the browser multiplies.
        noise: hardly anything repeats: do not look for it.
    """

    values: NDArray[Any]
    delta: bool = False
    scale: float = 1.0
    noise: bool = False


@dataclass(frozen=True)
class Packed:
    """`directory`: how to unpack each column; `text`: all of them."""

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
    return Packed(directory, encode_text(b"".join(content for _, content in packed)))


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


def encode_text(content: bytes) -> str:
    """Bytes as characters of `ALPHABET`, a pair of them for every 13 bits, lowest first; filled up with zeros."""
    padded = np.zeros(-(-len(content) // _GROUP) * _GROUP + 2, np.uint8)
    padded[: len(content)] = np.frombuffer(content, np.uint8)
    groups = len(padded) // _GROUP
    letters = np.frombuffer(ALPHABET.encode(), np.uint8)
    pairs = np.empty((groups, 8, 2), np.uint8)
    for k in range(8):
        first, shift = divmod(_BITS * k, 8)
        words = sum(padded[first + i :][: groups * _GROUP : _GROUP].astype(np.uint32) << (8 * i) for i in range(3))
        value = (np.asarray(words, np.uint32) >> shift) & ((1 << _BITS) - 1)
        pairs[:, k, 0], pairs[:, k, 1] = letters[value // len(letters)], letters[value % len(letters)]
    return pairs.tobytes().decode("ascii")


def decode_text(text: str) -> bytes:
    """What `encode_text` was given, and zeros up to a whole group."""
    number = np.zeros(128, np.uint32)
    number[np.frombuffer(ALPHABET.encode(), np.uint8)] = np.arange(len(ALPHABET))
    pairs = number[np.frombuffer(text.encode("ascii"), np.uint8)].reshape(-1, 2)
    values = pairs[:, 0] * len(ALPHABET) + pairs[:, 1]
    bits = np.unpackbits(values.astype("<u2").view(np.uint8).reshape(-1, 2), axis=1, bitorder="little")[:, :_BITS]
    return np.packbits(bits.ravel(), bitorder="little").tobytes()

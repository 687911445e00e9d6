# SPDX-License-Identifier: Apache-2.0
"""Compression of integer columns to one text for browsers: differences, byte planes, deflate, base64."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Column", "Packed", "pack"]


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

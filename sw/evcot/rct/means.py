# SPDX-License-Identifier: Apache-2.0
"""Means of a cluster that share a mixing factor lie side by side and are mixed at once, as one vector."""

from __future__ import annotations

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .state import MEANS

__all__ = ["mix_means"]

_LANE = ir.IntType(32)
_VECTOR = ir.VectorType(ir.DoubleType(), len(MEANS))


def _vector(builder: Any, values: list[Any]) -> Any:
    vector = ir.Constant(_VECTOR, ir.Undefined)
    for lane, value in enumerate(values):
        vector = builder.insert_element(vector, value, _LANE(lane))
    return vector


def _mix_means(_: Any, cluster: Any, mix: Any, values: Any) -> Any:
    """m <- (1 - mix) m + mix v, for each of `MEANS` and its value."""

    def build(_: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        record, alpha, news = arguments
        offset = signature.args[0].offset(MEANS[0])
        first = cgutils.get_record_member(builder, record, offset, ir.DoubleType())  # type: ignore[no-untyped-call]
        place = builder.bitcast(first, _VECTOR.as_pointer())
        keep = builder.fsub(alpha.type(1.0), alpha)
        old = builder.fmul(_vector(builder, len(MEANS) * [keep]), builder.load(place, align=8))
        values = cgutils.unpack_tuple(builder, news)  # type: ignore[no-untyped-call]
        new = builder.fmul(_vector(builder, len(MEANS) * [alpha]), _vector(builder, values))
        builder.store(builder.fadd(old, new), place, align=8)

    return types.void(cluster, mix, values), build


mix_means: Any = intrinsic(_mix_means)

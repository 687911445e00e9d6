# SPDX-License-Identifier: Apache-2.0
"""Means of a cluster that share a mixing factor lie side by side and are mixed at once, as vectors."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["mix_means"]

_LANE = ir.IntType(32)


def _vector(builder: Any, values: list[Any]) -> Any:
    vector = ir.Constant(ir.VectorType(ir.DoubleType(), len(values)), ir.Undefined)
    for lane, value in enumerate(values):
        vector = builder.insert_element(vector, value, _LANE(lane))
    return vector


def _mix_means(_: Any, cluster: Any, first: Any, mix: Any, values: Any) -> Any:
    """m <- (1 - mix) m + mix v, for the field named `first` and those after it, as many as there are values."""

    def build(_: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        record, _, alpha, news = arguments
        offset = cluster.offset(first.literal_value)
        place = cgutils.get_record_member(builder, record, offset, ir.DoubleType())  # type: ignore[no-untyped-call]
        new = _vector(builder, cgutils.unpack_tuple(builder, news))  # type: ignore[no-untyped-call]
        place = builder.bitcast(place, new.type.as_pointer())
        alphas = _vector(builder, len(values) * [alpha])
        keeps = builder.fsub(new.type([1.0] * len(values)), alphas)
        mixed = builder.fadd(builder.fmul(keeps, builder.load(place, align=8)), builder.fmul(alphas, new))
        builder.store(mixed, place, align=8)

    return types.void(cluster, first, mix, values), build


mix_means: Any = intrinsic(prefer_literal=True)(_mix_means)

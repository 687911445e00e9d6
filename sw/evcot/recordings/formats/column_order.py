# SPDX-License-Identifier: Apache-2.0
"""The order of four columns without names, judged by their first values.

It is t, x, y, p unless these values cannot be that, and can be one of the other orders in use: x, y, t, p; x, y, p, t
(Metavision, eDVS); p, t, x, y; p, x, y, t.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SAMPLED_ROWS", "column_order"]

Order = tuple[int, int, int, int]  # the columns of t, x, y, p

SAMPLED_ROWS = 256
_FEWEST_ROWS = 16  # with less, nothing is concluded
_USUAL: Order = (0, 1, 2, 3)
_OTHERS: tuple[Order, ...] = ((2, 0, 1, 3), (3, 0, 1, 2), (1, 2, 3, 0), (3, 1, 2, 0))


def column_order(sample: NDArray[Any]) -> Order:
    """The columns of t, x, y, p in (n, 4) numbers, the first `SAMPLED_ROWS` rows."""
    with np.errstate(invalid="ignore", over="ignore"):
        columns = np.asarray(sample, np.float64).T
        if columns.shape[1] < _FEWEST_ROWS or _can_be(columns, _USUAL):
            return _USUAL
        return next((order for order in _OTHERS if _can_be(columns, order) and _is_time(columns, order)), _USUAL)


def _can_be(columns: NDArray[np.float64], order: Order) -> bool:
    t, p = columns[order[0]], columns[order[3]]
    places = columns[list(order[1:3])]
    is_address = bool(((places >= 0) & (places <= 65535) & (places == np.rint(places))).all())
    return bool((np.diff(t) >= 0).all()) and is_address and bool(np.isin(p, (-1, 0, 1)).all())


def _is_time(columns: NDArray[np.float64], order: Order) -> bool:
    """Whether the times go on, and are not what x or y could be: further apart than these, or fractions of seconds."""
    t, x, y, _ = columns[list(order)]
    return bool(np.ptp(t) > max(np.ptp(x), np.ptp(y)) or (np.ptp(t) > 0 and (t != np.rint(t)).any()))

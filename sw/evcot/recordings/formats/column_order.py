# SPDX-License-Identifier: Apache-2.0
"""The order of four columns without names, judged by their first values.

The orders in use are t, x, y, p; x, y, t, p; x, y, p, t (Metavision, eDVS); p, t, x, y; and p, x, y, t. An order is possible if
its x and y can be addresses and its p can be a polarity. Of the possible ones:

1. A time that cannot be an address (fractions, or above 65535) settles the order, however few the rows are.
2. Else, with 16 rows or more, times hardly ever run back. Of several such orders it is the one whose times do not all stand
   still, then the one whose times run back least. Addresses of one frame, pixel by pixel, do not count as times.
3. With fewer rows it is t, x, y, p.
4. If times run back in more than a quarter of the rows in every order, the columns are in none of these.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError

__all__ = ["SAMPLED_ROWS", "Order", "column_order", "order_text"]

Order = tuple[int, int, int, int]  # the columns of t, x, y, p

SAMPLED_ROWS = 4096  # more than a row of pixels: events of a whole frame, pixel by pixel, may all have one time
_FEWEST_ROWS = 16  # with less, how times go on says nothing
_ORDERS: tuple[Order, ...] = ((0, 1, 2, 3), (2, 0, 1, 3), (3, 0, 1, 2), (1, 2, 3, 0), (3, 1, 2, 0))
_POLARITIES = (-1, 0, 1, *(float((1 << bits) - 1) for bits in (8, 16, 32, 64)))  # the last four are -1 without its sign
_DISORDER = 0.05  # share of rows that may run back in a recording: drivers and mergers swap neighbours
_NO_TIME = 0.25  # share of rows that run back, from which on a column is no time; of an address it is about a half


def column_order(sample: NDArray[Any]) -> Order:
    """The columns of t, x, y, p among the first four of (n, 4 or more) numbers, the first `SAMPLED_ROWS` rows.

    Raises:
        RecordingError: in every possible order, times run back in more than a quarter of the rows.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        columns = np.asarray(sample, np.float64).T
        possible = [order for order in _ORDERS if _is_possible(columns, order)]
        settled = [order for order in possible if _is_no_address(columns[order[0]])]
        enough = columns.shape[1] >= _FEWEST_ROWS
        back = [_back(column) for column in columns]

        def rank(order: Order) -> tuple[bool, bool, bool, float]:
            t, x, y, _ = (columns[i] for i in order)
            scanned = (_range(y) <= 1 and _is_scan(t, x)) or (_range(x) <= 1 and _is_scan(t, y))
            return back[order[0]] > _DISORDER, scanned, _range(t) == 0, back[order[0]]

        among = settled or (possible if enough else [_ORDERS[0]]) or [_ORDERS[0]]
        found = min(among, key=rank)
        if enough and possible and back[found[0]] > _NO_TIME:
            times = [f"column {i + 1}" for i, share in enumerate(back) if share <= _DISORDER and _range(columns[i]) > 0]
            looks = f"; {' or '.join(times)} goes on as a time does" if times else ""
            share = f"{100 * back[found[0]]:.0f} %"
            raise RecordingError(
                f"columns without names: as {order_text(found)}, times would run back in {share} of the first rows{looks}: "
                "must be t,x,y,p, x,y,t,p, x,y,p,t, p,t,x,y or p,x,y,t, or be named in a first line such as y,x,other,p,t"
            )
        return found


def order_text(order: Order) -> str:
    """An order as text, such as "x, y, t, p"."""
    return ", ".join(name for _, name in sorted(zip(order, "txyp", strict=True)))


def _is_address(column: NDArray[np.float64]) -> bool:
    return bool(((column >= 0) & (column <= 65535) & (column == np.rint(column))).all())


def _is_no_address(column: NDArray[np.float64]) -> bool:
    """Whether values are above all addresses, or most of them fractions."""
    return bool((column > 65535).any()) or bool((column != np.rint(column)).mean() > 0.5 if len(column) else False)


def _is_possible(columns: NDArray[np.float64], order: Order) -> bool:
    _, x, y, p = (columns[i] for i in order)
    return _is_address(x) and _is_address(y) and bool(np.isin(p, _POLARITIES).all())


def _range(column: NDArray[np.float64]) -> float:
    return float(np.ptp(column)) if len(column) else 0.0


def _is_scan(column: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether two columns are addresses of frames, pixel by pixel along rows or columns, but for a few steps: `column` is the
    slow one and has equal values, or the fast one and starts again."""
    step, other_step = np.diff(column), np.diff(other)
    slow = _mostly((step > 0) | ((step == 0) & (other_step > 0))) and bool((step == 0).any())
    fast = _mostly((other_step > 0) | ((other_step == 0) & (step > 0))) and bool((step < 0).any())
    return slow or fast


def _mostly(steps: NDArray[np.bool_]) -> bool:
    return bool(steps.mean() >= 1 - _DISORDER) if len(steps) else True


def _back(column: NDArray[np.float64]) -> float:
    """The share of rows whose value is below that of the row before."""
    return float((np.diff(column) < 0).mean()) if len(column) > 1 else 0.0

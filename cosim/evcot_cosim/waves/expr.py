# SPDX-License-Identifier: Apache-2.0
"""Expressions over sampled signals: one value per cycle, computed for all cycles at once.

A value is unknown in a cycle if a bit on which it depends is x or z. Conditions follow the usual three-valued logic:
false & x is false, true | x is true, everything else with x is x.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from .errors import PropertyError
from .vcd import INT64_BITS

if TYPE_CHECKING:
    from .wave import Samples

__all__ = ["Expr"]


class Expr:
    """A condition or a number per cycle.

    `&`, `|`, `^`, `~` combine conditions (one-bit signals are conditions); `==`, `!=`, `<`, `<=`, `>`, `>=`, `+`, `-`, `&`
    take numbers. Python binds `&` more tightly than `==`: write `(s["a"] == 3) & s["b"]`.

    Attributes:
        samples: the samples to which it belongs.
        values: (n,) bool for a condition, else int64 or Python integers; 0 where unknown.
        unknown: (n,) bool.
        text: the expression as written.
        paths: the signals in it.
        since: the first cycle with enough history for `previous`.
    """

    def __init__(
        self,
        samples: Samples,
        values: NDArray[Any],
        unknown: NDArray[np.bool_],
        text: str,
        paths: tuple[str, ...],
        since: int = 0,
    ) -> None:
        self.samples = samples
        self.values = values
        self.unknown = unknown
        self.text = text
        self.paths = paths
        self.since = since

    @property
    def is_condition(self) -> bool:
        """Whether its values are true and false."""
        return self.values.dtype == np.bool_

    @property
    def true(self) -> NDArray[np.bool_]:
        """(n,) bool: known to be true, in cycles with enough history.

        Raises:
            PropertyError: it is a number.
        """
        return self._condition() & self._begun

    @property
    def false(self) -> NDArray[np.bool_]:
        """(n,) bool: known to be false, in cycles with enough history.

        Raises:
            PropertyError: it is a number.
        """
        return ~self._condition() & ~self.unknown & self._begun

    # ---- conditions ----------------------------------------------------------------------------------------------------

    def __invert__(self) -> Expr:
        return self._derived(~self._condition() & ~self.unknown, self.unknown, f"~{_grouped(self.text)}")

    def __and__(self, other: Expr | int) -> Expr:
        return self._logic("&", other)

    def __or__(self, other: Expr | int) -> Expr:
        return self._logic("|", other)

    def __xor__(self, other: Expr | int) -> Expr:
        return self._logic("^", other)

    def __eq__(self, other: Expr | int) -> Expr:  # type: ignore[override]
        return self._compare("==", operator.eq, other)

    def __ne__(self, other: Expr | int) -> Expr:  # type: ignore[override]
        return self._compare("!=", operator.ne, other)

    def __lt__(self, other: Expr | int) -> Expr:
        return self._compare("<", operator.lt, other)

    def __le__(self, other: Expr | int) -> Expr:
        return self._compare("<=", operator.le, other)

    def __gt__(self, other: Expr | int) -> Expr:
        return self._compare(">", operator.gt, other)

    def __ge__(self, other: Expr | int) -> Expr:
        return self._compare(">=", operator.ge, other)

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__
    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> NoReturn:
        raise PropertyError(f"{self.text}: has no single truth value: write &, | and ~ for and, or and not, and no a < b < c")

    # ---- numbers -------------------------------------------------------------------------------------------------------

    def __add__(self, other: Expr | int) -> Expr:
        return self._calculate("+", operator.add, other)

    __radd__ = __add__

    def __sub__(self, other: Expr | int) -> Expr:
        return self._calculate("-", operator.sub, other)

    def bit(self, i: int) -> Expr:
        """Bit i, counted from the low end, as a condition."""
        return self._derived(self._part(i, i) != 0, self.unknown, f"{_grouped(self.text)}.bit({i})")

    def bits(self, high: int, low: int) -> Expr:
        """Bits high to low as a number."""
        return self._derived(self._part(high, low), self.unknown, f"{_grouped(self.text)}.bits({high}, {low})")

    # ---- time ----------------------------------------------------------------------------------------------------------

    def previous(self, cycles: int = 1) -> Expr:
        """The value some cycles ago; checks skip the first cycles, which have no such history.

        Raises:
            PropertyError: `cycles` is less than 1.
        """
        if cycles < 1:
            raise PropertyError(f"{self.text}.previous({cycles}): must look back at least 1 cycle")
        text = f"{_grouped(self.text)}.previous({'' if cycles == 1 else cycles})"
        values, unknown = _delayed(self.values, cycles), _delayed(self.unknown, cycles)
        return Expr(self.samples, values, unknown, text, self.paths, self.since + cycles)

    @property
    def changed(self) -> Expr:
        """Differs from the cycle before."""
        return self._named(self != self.previous(), "changed")

    @property
    def rose(self) -> Expr:
        """True after false in the cycle before."""
        return self._named(self & ~self.previous(), "rose")

    @property
    def fell(self) -> Expr:
        """False after true in the cycle before."""
        return self._named(~self & self.previous(), "fell")

    @property
    def is_unknown(self) -> Expr:
        """Whether a bit is x or z; this is never unknown itself."""
        return self._derived(self.unknown.copy(), np.zeros_like(self.unknown), f"{_grouped(self.text)}.is_unknown")

    # ---- implementation ------------------------------------------------------------------------------------------------------

    @property
    def _begun(self) -> NDArray[np.bool_]:
        return np.arange(len(self.values)) >= self.since

    def _condition(self) -> NDArray[np.bool_]:
        if not self.is_condition:
            raise PropertyError(f"{self.text}: is a number: must be a condition, so compare it with something")
        return self.values

    def _derived(self, values: NDArray[Any], unknown: NDArray[np.bool_], text: str, other: Expr | None = None) -> Expr:
        paths, since = self.paths, self.since
        if other is not None:
            paths, since = tuple(dict.fromkeys(paths + other.paths)), max(since, other.since)
        return Expr(self.samples, values, unknown, text, paths, since)

    def _named(self, expr: Expr, name: str) -> Expr:
        expr.text = f"{_grouped(self.text)}.{name}"
        return expr

    def _operand(self, other: Expr | int) -> Expr:
        if isinstance(other, Expr):
            if other.samples is not self.samples:
                raise PropertyError(f"{self.text} and {other.text}: must be sampled together, on one clock of one waveform")
            return other
        if not isinstance(other, (int, np.integer, np.bool_)):
            raise PropertyError(f"{self.text}: cannot be combined with {other!r}: must be an integer or an expression")
        text = f"{type(other).__name__}.{other.name}" if isinstance(other, IntEnum) else str(other)
        value = bool(other) if isinstance(other, (bool, np.bool_)) else int(other)
        wide = isinstance(value, int) and not -(1 << 63) <= value < 1 << 63
        values = np.full(len(self.values), value, np.object_ if wide else None)
        return Expr(self.samples, values, np.zeros(len(values), np.bool_), text, ())

    def _logic(self, symbol: str, other: Expr | int) -> Expr:
        b = self._operand(other)
        text = f"{_grouped(self.text)} {symbol} {_grouped(b.text)}"
        if self.is_condition != b.is_condition:
            raise PropertyError(f"{text}: one side is a number and one a condition: compare the number first, in brackets")
        unknown = self.unknown | b.unknown
        if symbol == "&":
            values = self.values & b.values
            if self.is_condition:
                unknown = unknown & ~(~self.values & ~self.unknown) & ~(~b.values & ~b.unknown)
        elif symbol == "|":
            values = self.values | b.values
            if self.is_condition:
                unknown = unknown & ~values
        else:
            values = self.values ^ b.values
        return self._derived(_zeroed(values, unknown), unknown, text, b)

    def _compare(self, symbol: str, compare: Callable[[Any, Any], Any], other: Expr | int) -> Expr:
        b = self._operand(other)
        unknown = self.unknown | b.unknown
        values = np.asarray(compare(self.values, b.values), np.bool_)
        return self._derived(_zeroed(values, unknown), unknown, f"{_grouped(self.text)} {symbol} {_grouped(b.text)}", b)

    def _calculate(self, symbol: str, calculate: Callable[[Any, Any], Any], other: Expr | int) -> Expr:
        b = self._operand(other)
        unknown = self.unknown | b.unknown
        values = calculate(_numbers(self.values), _numbers(b.values))
        return self._derived(_zeroed(values, unknown), unknown, f"{_grouped(self.text)} {symbol} {_grouped(b.text)}", b)

    def _part(self, high: int, low: int) -> NDArray[Any]:
        if not high >= low >= 0:
            raise PropertyError(f"{self.text}: bits {high} to {low}: must count downwards to 0 or more")
        numbers = _numbers(self.values)
        if numbers.dtype != np.object_:  # all of them below 2^62
            low, high = min(low, INT64_BITS), min(high, INT64_BITS)
        part = (numbers >> low) & ((1 << (high - low + 1)) - 1)
        return part.astype(np.int64) if high - low < INT64_BITS else part


def _numbers(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(np.int64) if values.dtype == np.bool_ else values


def _zeroed(values: NDArray[Any], unknown: NDArray[np.bool_]) -> NDArray[Any]:
    values[unknown] = 0
    return values


def _delayed(values: NDArray[Any], cycles: int) -> NDArray[Any]:
    delayed = np.zeros_like(values)
    delayed[cycles:] = values[:-cycles]
    return delayed


def _grouped(text: str) -> str:
    depth = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        if character == " " and not depth:
            return f"({text})"
    return text

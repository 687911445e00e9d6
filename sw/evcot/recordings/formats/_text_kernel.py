# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels of the text formats: lines of bytes to columns of events, and back.

Digits are parsed eight at a time in one 64-bit word: located, shifted to its upper end, and combined in pairs.
"""

from __future__ import annotations

import numpy as np

from ..._numba_private import njit, step

__all__ = ["LINE_BYTES", "PADDING_BYTES", "SHORTEST_LINE_BYTES", "UNUSED", "P", "T", "X", "Y", "format_lines", "parse_lines"]

# What a column holds; UNUSED columns are skipped.
T, X, Y, P, UNUSED = 0, 1, 2, 3, -1

LINE_BYTES = len("-9223372036854775808,65535,65535,255\n")
SHORTEST_LINE_BYTES = len("0 0 0 0\n")
PADDING_BYTES = 16  # readable after the text, because it is read in 8-byte words

_TAB, _NEWLINE, _RETURN, _BLANK, _HASH, _PERCENT, _PLUS, _COMMA, _MINUS, _POINT, _0, _E = (ord(c) for c in "\t\n\r #%+,-.0e")
_SMALLEST, _LARGEST = int(np.iinfo(np.int64).min), int(np.iinfo(np.int64).max)
_TRUE, _FALSE = int.from_bytes(b"true", "big"), int.from_bytes(b"false", "big")
_POWERS = 10 ** np.arange(19, dtype=np.int64)
_LONGEST = 19  # digits: with more, the sign of an int64 would not reveal an overflow
_LARGEST_EXPONENT = 99
_LIMITS = ((_SMALLEST, _LARGEST), (0, 65535), (0, 65535), (-1, 255))  # of T, X, Y, P

_U = np.uint64
_ALL_0, _EACH_1, _EACH_TOP = _U(0x3030303030303030), _U(0x0101010101010101), _U(0x8080808080808080)
_EACH_ABOVE_9 = _U(0x7676767676767676)  # added to a byte, sets its top bit from 10 on
_NIBBLES, _BYTES, _HALVES = _U(0x0F0F0F0F0F0F0F0F), _U(0x00FF00FF00FF00FF), _U(0x0000FFFF0000FFFF)
_PAIRS, _FOURS, _EIGHT = _U(10 << 8 | 1), _U(100 << 16 | 1), _U(10_000 << 32 | 1)


@njit(cache=True, nogil=True, inline="always")
def _digits(words, at):  # type: ignore[no-untyped-def]
    """The value of up to eight digits at byte `at`, and their number."""
    i, shift = _U(at) >> _U(3), (_U(at) & _U(7)) << _U(3)
    word = (words[i] >> shift | words[i + _U(1)] << _U(1) << (_U(63) - shift)) ^ _ALL_0
    others = (word + _EACH_ABOVE_9 | word) & _EACH_TOP
    lowest = others & (~others + _U(1))
    count = (((lowest >> _U(7)) - _U(1)) & _EACH_1) * _EACH_1 >> _U(56)
    if count == _U(0):
        return np.int64(0), np.int64(0)
    word <<= _U(64) - (count << _U(3))
    word = (word & _NIBBLES) * _PAIRS >> _U(8)
    word = (word & _BYTES) * _FOURS >> _U(16)
    return np.int64((word & _HALVES) * _EIGHT >> _U(32)), np.int64(count)


@njit(cache=True, nogil=True, inline="always")
def _append_digits(words, at, value):  # type: ignore[no-untyped-def]
    """All digits from byte `at` on, appended to a value, modulo 2**64; and the offset after them."""
    part, count = _digits(words, at)
    value = value * _POWERS[count] + part
    at += count
    while count == 8:
        part, count = _digits(words, at)
        value = value * _POWERS[count] + part
        at += count
    return value, at


@step
def _scaled(mantissa, power, exact):  # type: ignore[no-untyped-def]
    """mantissa * 10**power for a mantissa >= 0, rounded to nearest, halves up; -1 on overflow, or if `exact` and not whole."""
    if mantissa == 0:
        return np.int64(0)
    if power >= 0:
        if power >= len(_POWERS) or mantissa > _LARGEST // _POWERS[power]:
            return np.int64(-1)
        return mantissa * _POWERS[power]
    if power <= -len(_POWERS):
        return np.int64(-1) if exact else np.int64(0)
    unit = _POWERS[-power]
    quotient = mantissa // unit
    rest = mantissa - quotient * unit
    if exact and rest:
        return np.int64(-1)
    return quotient + (rest >= unit - rest)


@step
def _decimal(text, words, at, power, exact):  # type: ignore[no-untyped-def]
    """A number with optional sign, point and exponent, times 10**power; and the offset after it, -1 on overflow."""
    failed = np.int64(0), np.int64(-1)
    sign = -1 if text[at] == _MINUS else 1
    if text[at] == _MINUS or text[at] == _PLUS:
        at += 1
    begin = at
    value, at = _append_digits(words, at, np.int64(0))
    digits = at - begin
    if digits > _LONGEST or value < 0:
        return failed
    if text[at] == _POINT:
        at += 1
        begin = at
        while _0 <= text[at] < _0 + 10:
            if digits + at - begin < _LONGEST - 1:
                value = value * 10 + (np.int64(text[at]) - _0)
                power -= 1
            elif exact and text[at] != _0:
                return failed
            at += 1
        digits += at - begin
    if digits == 0:
        return failed
    if text[at] | 32 == _E:
        at += 1
        exponent_sign = -1 if text[at] == _MINUS else 1
        if text[at] == _MINUS or text[at] == _PLUS:
            at += 1
        begin = at
        exponent, at = _append_digits(words, at, np.int64(0))
        if not 0 < at - begin <= _LONGEST:
            return failed
        power += exponent_sign * min(exponent, _LARGEST_EXPONENT)
    value = _scaled(value, power, exact)
    return (sign * value, at) if value >= 0 else failed


@step
def _truth(text, at):  # type: ignore[no-untyped-def]
    """1 for "true", 0 for "false", in any case of letters, -1 for anything else; and the offset after it."""
    word = np.int64(0)
    for i in range(5):
        word = word << 8 | np.int64(text[at + i] | 32)
    if word >> 8 == _TRUE:
        return np.int64(1), np.int64(at + 4)
    if word == _FALSE:
        return np.int64(0), np.int64(at + 5)
    return np.int64(-1), np.int64(at)


@step
def _line(text, words, at, separator, columns, power, exact, n, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Parse any line into entry n; returns the offset after it, -1 if a cell is invalid, and the index of that cell."""
    last = len(columns) - 1
    for k in range(len(columns)):
        column = columns[k]
        if column == UNUSED:
            c = text[at]
            while c != separator and (c > _BLANK or (separator != _BLANK and c in (_BLANK, _TAB))):
                at += 1
                c = text[at]
        else:
            scale, whole = (power, exact) if column == T else (0, True)
            truth, end = _truth(text, at) if column == P else (np.int64(-1), np.int64(at))
            value, at = (truth, end) if truth >= 0 else _decimal(text, words, at, scale, whole)
            if at < 0:
                return at, k
            if column == P and (value == 65535 or value == 4294967295):
                value = 255  # as any -1 without its sign
            low, high = _LIMITS[column]
            if value < low or value > high:
                return -1, k
            if column == T:
                t_us[n] = value
            elif column == X:
                x[n] = value
            elif column == Y:
                y[n] = value
            else:
                p[n] = max(value, 0)
        begin = at
        at = _past_blanks(text, at, separator)
        c = text[at]
        if c in (_NEWLINE, _RETURN):
            return (at, k) if k == last else (-1, k + 1)
        if c == separator and k < last:
            at = _past_blanks(text, at + 1, separator)
        elif c < _BLANK or k == last or separator != _BLANK or at == begin:
            return -1, k
    return -1, 0


@step
def _past_blanks(text, at, separator):  # type: ignore[no-untyped-def]
    while text[at] == _BLANK or (text[at] == _TAB and separator != _TAB):
        at += 1
    return at


@step
def _past_text(text, at):  # type: ignore[no-untyped-def]
    """Offset of the line's newline; -1 if a control character other than tab, or a lone carriage return, precedes it."""
    while text[at] >= _BLANK or text[at] == _TAB:
        at += 1
    if text[at] == _RETURN:
        at += 1
    return at if text[at] == _NEWLINE else -1


@njit(cache=True, nogil=True)
def parse_lines(text, length, separator, columns, power, exact, t_us, x, y, p):  # type: ignore[no-untyped-def]
    """Parse whole lines of numbers; blank lines and those that begin with # or % are skipped.

    Args:
        text: (m,) uint8, m a multiple of 8 and at least length + PADDING_BYTES; the last of `length` bytes is a newline.
        separator: byte between cells; a space stands for any number of spaces and tabs.
        columns: (k,) int8, the field in each cell of a line: each of T, X, Y, P once.
        power, exact: times are in units of 10**power us; if `exact` they must be whole, else they are rounded to nearest.
        t_us, x, y, p: output arrays, with room for one event every SHORTEST_LINE_BYTES.

    Returns:
        Events parsed, lines consumed, and the index of the invalid cell in the next line, -1 if there is none.
    """
    words = text.view(np.uint64)
    at, n, lines, last = 0, 0, 0, len(columns) - 1
    while at < length:
        # Fast path for the common line: digits, at most a point in the time, one separator between cells. Written out here:
        # as a separate function, inlined or not, it runs at half the speed.
        line, plain = at, False
        for k in range(len(columns)):
            column, scale = columns[k], power
            digit, after = np.int64(text[_U(at)]) - _0, text[_U(at + 1)]
            if after in (separator, _NEWLINE, _RETURN) and 0 <= digit <= 9:
                value, at = digit, at + 1  # speculative: the next cell need not wait for the length of this one
            elif column == P and text[_U(at)] == _MINUS and after == _0 + 1:
                value, at = np.int64(0), at + 2
            else:
                begin = at
                value, at = _append_digits(words, at, np.int64(0))
                if column == T and text[_U(at)] == _POINT:
                    point, begin = at, begin + 1
                    value, at = _append_digits(words, at + 1, value)
                    scale -= at - point - 1
                if value < 0 or not 0 < at - begin <= _LONGEST:
                    break
            if column == T:
                if scale != 0:
                    value = _scaled(value, scale, exact)
                    if value < 0:
                        break
                t_us[n] = value
            elif value > 65535:
                break
            elif column == X:
                x[n] = value
            elif column == Y:
                y[n] = value
            else:
                p[n] = value
                if value > 255 or column == UNUSED:
                    break
            c = text[_U(at)]
            if c != separator:
                if c == _RETURN:
                    at += 1
                    c = text[_U(at)]
                plain = k == last and c == _NEWLINE
                break
            at += 1
        if plain:
            n += 1
            lines += 1
            at += 1
            continue
        at = _past_blanks(text, line, separator)
        c, fault = text[at], 0
        if c not in (_NEWLINE, _RETURN, _HASH, _PERCENT):
            at, fault = _line(text, words, at, separator, columns, power, exact, n, t_us, x, y, p)
            if at < 0:
                return n, lines, fault
            n += 1
        at = _past_text(text, at)
        if at < 0:
            return n, lines, fault
        at += 1
        lines += 1
    return n, lines, -1


@njit(cache=True, nogil=True, inline="always")
def _write_number(out, at, value):  # type: ignore[no-untyped-def]
    """Append the digits of a uint64; returns the offset after them."""
    count = 1
    while count < 19 and value >= _U(_POWERS[count]):
        count += 1
    end = at + count
    i = end
    while i > at:
        i -= 1
        rest = value // _U(10)
        out[i] = _0 + np.int64(value - rest * _U(10))
        value = rest
    return end


@njit(cache=True, nogil=True)
def format_lines(t_us, x, y, p, out):  # type: ignore[no-untyped-def]
    """Write `t,x,y,p` lines into `out`, (LINE_BYTES * events,) uint8; returns the number of bytes written."""
    at = 0
    for i in range(len(t_us)):
        t = t_us[i]
        if t < 0:
            out[at] = _MINUS
            at += 1
        at = _write_number(out, at, _U(-t if t < 0 else t))
        out[at] = _COMMA
        at = _write_number(out, at + 1, _U(x[i]))
        out[at] = _COMMA
        at = _write_number(out, at + 1, _U(y[i]))
        out[at] = _COMMA
        at = _write_number(out, at + 1, _U(p[i]))
        out[at] = _NEWLINE
        at += 1
    return at

# SPDX-License-Identifier: Apache-2.0
"""Make text from files and libraries fit into a one-line message."""

from __future__ import annotations

__all__ = ["printable", "reason", "shortened", "whole_number"]

_SHOWN = 60  # characters of a value in a message
_MOST_DIGITS = 18  # any number with this many digits fits into 64 bits


def printable(text: str) -> str:
    """The text in one line, with `?` for unprintable characters."""
    line = " ".join(text.split())
    return line if line.isprintable() else "".join(each if each.isprintable() else "?" for each in line)


def reason(error: BaseException) -> str:
    """The message of a library's exception, or its type if the message is empty."""
    return printable(str(error)) or type(error).__name__


def shortened(text: str) -> str:
    """The printable start of a value, short enough for a message."""
    return printable(text[:_SHOWN]) + ("..." if len(text) > _SHOWN else "")


def whole_number(text: str) -> int | None:
    """Parse up to 18 decimal digits; None for any other text: Python refuses to parse thousands of digits."""
    return int(text) if text.isdecimal() and text.isascii() and len(text) <= _MOST_DIGITS else None

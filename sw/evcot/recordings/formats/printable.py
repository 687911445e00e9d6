# SPDX-License-Identifier: Apache-2.0
"""What files and libraries say, made fit for a message of one line."""

from __future__ import annotations

__all__ = ["printable", "reason", "shortened", "whole_number"]

_SHOWN = 60  # characters of a value in a message
_MOST_DIGITS = 18  # of a number that fits into 64 bits, whatever its digits


def printable(text: str) -> str:
    """The text in one line, with `?` for what cannot be printed."""
    return "".join(each if each.isprintable() else "?" for each in " ".join(text.split()))


def reason(error: BaseException) -> str:
    """What a library's error says; its name, where it says nothing."""
    return printable(str(error)) or type(error).__name__


def shortened(text: str) -> str:
    """As much of a value as fits into a message, printable."""
    return printable(text[:_SHOWN]) + ("..." if len(text) > _SHOWN else "")


def whole_number(text: str) -> int | None:
    """The number that a text of up to 18 decimal digits is; None for any other: Python refuses to read thousands of digits."""
    return int(text) if text.isdecimal() and text.isascii() and len(text) <= _MOST_DIGITS else None

# SPDX-License-Identifier: Apache-2.0
"""What files and libraries say, made fit for a message of one line."""

from __future__ import annotations

__all__ = ["printable", "reason"]


def printable(text: str) -> str:
    """The text in one line, with `?` for what cannot be printed."""
    return "".join(each if each.isprintable() else "?" for each in " ".join(text.split()))


def reason(error: BaseException) -> str:
    """What a library's error says; its name, where it says nothing."""
    return printable(str(error)) or type(error).__name__

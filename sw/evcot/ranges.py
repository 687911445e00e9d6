# SPDX-License-Identifier: Apache-2.0
"""Validation of settings: the fields of a settings class have limits, used for checks, messages and searches."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field, fields
from typing import Any

from .errors import ConfigError

__all__ = ["Range", "check_integer", "check_range", "check_ranges", "ranges_of", "read_pair", "read_value", "setting", "span"]

Range = tuple[float, float, str]
"""Lowest, highest, meaning; two integer limits mark an integer setting."""


def span(low: float, high: float) -> str:
    """Limits as text for messages: integers with all digits."""
    return " to ".join(str(limit) if isinstance(limit, int) else f"{limit:g}" for limit in (low, high))


def setting(default: Any, low: float, high: float, meaning: str) -> Any:
    """A field of a settings dataclass with its limits."""
    return field(default=default, metadata={"range": (low, high, meaning)})


def ranges_of(settings: Any) -> dict[str, Range]:
    """The limits of all fields, of a settings dataclass or an instance of one, that have any."""
    return {each.name: each.metadata["range"] for each in fields(settings) if "range" in each.metadata}


def check_ranges(name: str, settings: Any, ranges: Mapping[str, Range] | None = None) -> None:
    """Raise ConfigError for the first field of `settings` outside its limits, or its entry in `ranges`, or of another type."""
    for key, limits in (ranges_of(settings) if ranges is None else ranges).items():
        check_range(f"{name}.{key}", getattr(settings, key), *limits)


def check_integer(name: str, value: object, low: int, high: int, meaning: str = "") -> None:
    """Raise ConfigError for a value that is not an integer, or outside its limits."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        what = f" ({meaning})" if meaning else ""
        raise ConfigError(f"{name} = {value!r}: must be an integer from {low} to {high}{what}")


def check_range(name: str, value: object, low: float, high: float, meaning: str) -> None:
    """Raise ConfigError for a value outside its limits, or of another type."""
    wanted = int if isinstance(low, int) else (int, float)
    if isinstance(value, bool) or not isinstance(value, wanted) or not low <= value <= high:
        raise ConfigError(f"{name} = {value!r}: must be from {span(low, high)} ({meaning})")


def read_pair(option: str, text: str, rule: str = "") -> tuple[str, str]:
    """Parse KEY=VALUE of an option; returns key and value, without surrounding spaces.

    Args:
        rule: text about the keys to append to the message.

    Raises:
        ConfigError: there is no equals sign.
    """
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals:
        raise ConfigError(f"{option} {text}: must be KEY=VALUE{rule}")
    return key, value


def read_value(name: str, text: str, default: Any) -> Any:
    """Parse a setting from text, as a value of the type of its default.

    Raises:
        ConfigError: the text is not a value of that type.
    """
    if isinstance(default, str):
        return text
    kind: Callable[[str], Any]
    if isinstance(default, bool):
        kind, meaning = {"true": True, "false": False}.__getitem__, "true or false"
    else:
        kind, meaning = (int, "a whole number") if isinstance(default, int) else (float, "a number")
    try:
        return kind(text)
    except (ValueError, KeyError) as error:
        raise ConfigError(f"{name} = {text!r}: must be {meaning}") from error

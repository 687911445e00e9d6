# SPDX-License-Identifier: Apache-2.0
"""Reads TOML files of users in bounded time and memory."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from .errors import ConfigError

__all__ = ["BYTES_MAX", "KEY_PARTS_MAX", "read_toml", "toml_tables"]

BYTES_MAX = 1 << 24  # a configuration with 100,000 hot pixels has 1 MB
KEY_PARTS_MAX = 16  # of a dotted key: tomllib's memory grows with the square of their number
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*\.[ \t]*{_PART}){{{KEY_PARTS_MAX}}}")


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or is beyond a limit of this module. The message does not name the
            file; the caller does.
    """
    try:
        with path.open("rb") as file:
            content = file.read(BYTES_MAX + 1)
        if len(content) > BYTES_MAX:
            raise ConfigError(f"has more than {BYTES_MAX >> 20} MiB: must be smaller")
        return toml_tables(content.decode())
    except OSError as error:
        raise ConfigError(f"cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"is not TOML: {error}") from error


def toml_tables(text: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Raises:
        ConfigError: as for `read_toml`.
    """
    text = text.replace("\r\n", "\n")
    if found := _LONG_KEY.search(text):
        line = text.count("\n", 0, found.start()) + 1
        raise ConfigError(f"line {line}: a key has too many parts: must have at most {KEY_PARTS_MAX}")
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise ConfigError("is nested too deeply: must have fewer brackets within brackets") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"is not TOML: {error}") from error
    _check_strings(tables)
    return tables


def _check_strings(tables: dict[str, Any]) -> None:
    """Raise ConfigError for a string with a null character, which no name of a file has."""
    waiting: list[Any] = [tables]
    while waiting:
        value = waiting.pop()
        if isinstance(value, str) and "\0" in value:
            raise ConfigError(f"{value[:60]!r}: has a null character: must have none")
        if isinstance(value, dict):
            waiting += [*value, *value.values()]
        elif isinstance(value, list):
            waiting += value

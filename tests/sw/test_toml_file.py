# SPDX-License-Identifier: Apache-2.0
"""A TOML file of a user is read whole or refused in one line, in little time and memory."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot.toml_file import BYTES_MAX, KEY_PARTS_MAX, read_toml
from support.refusals import refused

REFUSED = {
    "brackets": ("a = " + "[" * 100_000, "is nested too deeply: must have fewer brackets within brackets"),
    "key": ("[x]\n" + ".".join("a" * 20_000) + " = 1\n", "line 2: a key has too many parts: must have at most 16"),
    "quoted key": (" . ".join(["'a'", '"b"'] * 9) + " = 1", "line 1: a key has too many parts: must have at most 16"),
    "header": ("[" + ".".join("a" * 17) + "]", "line 1: a key has too many parts: must have at most 16"),
    "size": ("#" * (BYTES_MAX + 1), "has more than 16 MiB: must be smaller"),
    "null": ('[x]\na = ["b", {c = "d\\u0000"}]', "'d\\x00': has a null character: must have none"),
    "null in a key": ('"a\\u0000" = 1', "'a\\x00': has a null character: must have none"),
    "text": ("a = = 1", "is not TOML: Invalid value (at line 1, column 5)"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case: str, tmp_path: Path) -> None:
    content, message = REFUSED[case]
    (tmp_path / "a.toml").write_text(content)
    with refused(ConfigError, message):
        read_toml(tmp_path / "a.toml")


def test_bytes_that_are_no_text_and_missing_files(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_bytes(b'a = "\xff"')
    with pytest.raises(ConfigError, match=r"^is not TOML: 'utf-8' codec"):
        read_toml(tmp_path / "a.toml")
    with pytest.raises(ConfigError, match=r"^cannot be read: No such file or directory$"):
        read_toml(tmp_path / "b.toml")


def test_what_configurations_hold_is_read(tmp_path: Path) -> None:
    key = ".".join("a" * KEY_PARTS_MAX)
    values = ", ".join(["0.5"] * 10_000)
    (tmp_path / "a.toml").write_text(f'{key} = 1\r\nb = [{values}]\r\nc = "{"x" * 1_000_000}"\r\n')
    found = read_toml(tmp_path / "a.toml")
    assert (len(found["b"]), len(found["c"])) == (10_000, 1_000_000)

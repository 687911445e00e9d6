# SPDX-License-Identifier: Apache-2.0
"""Every module lints clean with the parameters that it accepts, and refuses others by the name of the broken rule."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from evcot_cosim.rtl.files import rtl_files
from support.testing import lint

TABLE: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_name("parameters.toml").read_text(encoding="utf-8"))


def test_the_table_has_every_module() -> None:
    modules = {path.stem for path in rtl_files().values() if path.suffix == ".v"}
    assert set(TABLE) == modules - {"parameter_check"}


@pytest.mark.parametrize("module", TABLE)
def test_accepted(module: str) -> None:
    for parameters in TABLE[module]["accepts"]:
        assert lint(module, **parameters) == (0, ""), parameters


@pytest.mark.parametrize("module", [module for module in TABLE if "refuses" in TABLE[module]])
def test_refused(module: str) -> None:
    for rule, broken in TABLE[module]["refuses"].items():
        for parameters in broken:
            code, log = lint(module, **parameters)
            assert code != 0, (rule, parameters)
            assert f".{rule}" in log, (rule, parameters)

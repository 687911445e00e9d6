# SPDX-License-Identifier: Apache-2.0
"""Columns come back as they went in, from a text that is safe in HTML."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.report.pack import Column, pack
from evcot_cosim.report.page import inline_modules

SEED = 5


def columns() -> dict[str, Column]:
    random = np.random.default_rng(SEED)
    return {
        "nothing": Column(np.empty(0, np.int64)),
        "bytes": Column(random.integers(0, 256, 5_000, np.uint8)),
        "words": Column(random.integers(0, 1 << 16, 5_000, np.uint16), noise=True),
        "times": Column(np.cumsum(random.integers(0, 9, 5_000)), delta=True),
        "signed": Column(random.integers(-1_000, 1_000, 5_000)),
        "places": Column(random.integers(-30_000, 30_000, 5_000), delta=True, scale=1 / 16),
        "wide": Column(random.integers(-(1 << 50), 1 << 50, 100), delta=True),
        "minus one": Column(np.full(10, -1, np.int16)),
    }


def naive(text: str, entry: dict[str, Any]) -> list[float]:
    """One column out of the text, value by value."""
    content = zlib.decompress(base64.b64decode(text, validate=True)[entry["at"] : entry["at"] + entry["bytes"]])
    values, last = [], 0
    for i in range(entry["n"]):
        value = sum(content[plane * entry["n"] + i] << (8 * plane) for plane in range(entry["planes"]))
        if entry["signed"]:
            value = value >> 1 if value % 2 == 0 else -((value + 1) >> 1)
        if entry["delta"]:
            value = last = last + value
        values.append(value * entry["scale"])
    return values


def test_columns_survive() -> None:
    given = columns()
    packed = pack(given)
    for name, column in given.items():
        assert naive(packed.text, packed.directory[name]) == (column.values * column.scale).tolist(), name


def test_a_browser_reads_what_python_wrote(browser: Any) -> None:
    given = columns()
    packed = pack(given)
    page = browser.new_page()
    page.add_script_tag(content=inline_modules(("unpack",)))
    script = "([text, directory]) => unpack(text, directory, {words: Uint16Array}).then((found) => Object.fromEntries("
    script += "Object.entries(found).map(([name, values]) => [name, Array.from(values)])))"
    found: dict[str, list[float]] = page.evaluate(script, [packed.text, packed.directory])
    page.close()
    for name, column in given.items():
        assert found[name] == (column.values * column.scale).tolist(), name


@pytest.mark.parametrize("noise", [False, True])
def test_even_time_costs_next_to_nothing(noise: bool) -> None:
    times: NDArray[np.int64] = np.arange(100_000) * 7
    assert len(pack({"t": Column(times, delta=True, noise=noise)}).text) < 1_000

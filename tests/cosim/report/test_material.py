# SPDX-License-Identifier: Apache-2.0
"""Columns of integers for browsers, subsampling, and the colours of heat maps."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import matplotlib
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.tracks.log import Kind
from evcot.tracks.timeline import LIFE
from evcot_cosim.report.heat_maps import CIVIDIS
from evcot_cosim.report.pack import Column, longest_lives, pack, thinned_events, thinned_records
from evcot_cosim.report.page import inline_modules


def test_it_is_matplotlibs_table() -> None:
    colours = matplotlib.colormaps["cividis"](np.arange(256))[:, :3]
    assert (colours * 255).astype(np.uint8).tobytes() == CIVIDIS


def test_few_events_all_stay() -> None:
    assert thinned_events(5, 9).tolist() == [0, 1, 2, 3, 4]
    assert thinned_events(0, 9).tolist() == []


def test_of_many_events_one_in_each_stretch_stays() -> None:
    kept = thinned_events(100_000, 1_000)
    assert len(kept) == 1_000
    assert (np.diff(kept) > 0).all()
    assert (kept // 100).tolist() == list(range(1_000))
    assert len(np.unique(kept % 100)) > 50  # no comb
    assert thinned_events(100_000, 1_000).tolist() == kept.tolist()


def test_no_room_keeps_nothing() -> None:
    assert thinned_events(100, 0).tolist() == []


def test_births_and_ends_stay_whatever_the_room() -> None:
    kind = np.array([Kind.BORN, *[Kind.MOVED] * 97, Kind.MERGED, Kind.LOST], np.uint8)
    kept = thinned_records(kind, 13)
    assert kept[[0, 98, 99]].all()
    assert kept.sum() == 13
    assert thinned_records(kind, 2).sum() == 3
    assert thinned_records(kind, 100).all()


def test_the_longest_lives_stay_in_order_of_birth() -> None:
    lives = np.zeros(4, LIFE)
    lives["track_id"], lives["birth_us"], lives["end_us"] = range(4), [0, 10, 20, 30], [5, 500, 21, 300]
    every = np.ones(4, np.bool_)
    assert lives[longest_lives(lives, 2, every)]["track_id"].tolist() == [1, 3]
    assert lives[longest_lives(lives, 4, every)]["track_id"].tolist() == [0, 1, 2, 3]
    assert lives[longest_lives(lives, 2, lives["track_id"] != 1)]["track_id"].tolist() == [0, 3]


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
    page.add_script_tag(content=inline_modules(("columns",)))
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

# SPDX-License-Identifier: Apache-2.0
"""The small modules of the array: hits, copies, products, ORs, the lowest bit, shifts."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import evaluate

PORTS = ("not_left", "not_right", "not_above", "not_below", "counts")


def test_every_combination_in_every_bit() -> None:
    every = np.array(list(product((0, 1), repeat=5)))
    words = {name: int((every[:, i] << np.arange(32)).sum()) for i, name in enumerate(PORTS)}  # bit i: combination i
    result = evaluate("array_hits", {"N": 32}, {name: np.array([word]) for name, word in words.items()}, ["hits"])["hits"]
    assert result.tolist() == [1 << every.tolist().index([1, 1, 1, 1, 1])]


def test_a_value_comes_a_clock_later() -> None:
    sim = load("array_copy", {"W": 6})
    for value in np.random.default_rng(1).integers(0, 64, 20).tolist():
        before = sim.io.m
        sim.io.s = value
        assert sim.io.m == before
        sim.clock.tick()
        assert sim.io.m == value


W = 9


@pytest.mark.parametrize("by", [0, 1, 2, 8])
def test_random_words(by: int) -> None:
    rng = np.random.default_rng(by)
    a, b, c = rng.integers(-1 << W - 1, 1 << W - 1, (3, 400))
    c[::3], a[1::3], b[2::3] = 0, 0, 0
    wanted = rng.integers(0, 2, 400)
    mask = (1 << W) - 1
    ports = {"a_not": ~a & mask, "b_not": ~b & mask, "c": c & mask, "wanted": wanted}
    result = evaluate("array_products", {"W": W, "BY": by}, ports, ["y"])["y"]
    assert result.tolist() == (((a >> by | b >> by | c >> by) & mask) * wanted).tolist()


WORDS = ["a", "b", "c", "d", "e"]


@pytest.mark.parametrize("width", [1, 7])
def test_array_or_random_words(width: int) -> None:
    ports = dict(zip(WORDS, np.random.default_rng(width).integers(0, 1 << width, (5, 200)), strict=True))
    result = evaluate("array_or", {"W": width}, ports, ["y"])["y"]
    assert result.tolist() == np.bitwise_or.reduce(list(ports.values())).tolist()


@pytest.mark.parametrize("word", WORDS)
def test_every_word_counts(word: str) -> None:
    ports = {name: np.array([0b1011 if name == word else 0]) for name in WORDS}
    assert evaluate("array_or", {"W": 4}, ports, ["y"])["y"].tolist() == [0b1011]


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (5, 3), (8, 3), (12, 4)])
def test_every_set_of_bits(n: int, slot_w: int) -> None:
    among = np.arange(1 << n)
    result = evaluate(
        "array_lowest", {"N": n, "SLOT_W": slot_w}, {"among": among, "asked": np.ones_like(among)}, ["any", "lowest"]
    )
    lowest = [next((i for i in range(n) if one >> i & 1), 0) for one in among.tolist()]
    np.testing.assert_array_equal(result["any"], among > 0)
    np.testing.assert_array_equal(result["lowest"][1:], lowest[1:])


@pytest.mark.parametrize("n", [32, 62])
def test_each_bit_with_others_above_it(n: int) -> None:
    rng = np.random.default_rng(n)
    place = rng.integers(0, n, 500)
    among = [1 << at | int(rng.integers(1 << 62)) << at + 1 & (1 << n) - 1 for at in place.tolist()]
    result = evaluate(
        "array_lowest", {"N": n, "SLOT_W": (n - 1).bit_length()}, {"among": among, "asked": [1] * 500}, ["lowest"]
    )
    np.testing.assert_array_equal(result["lowest"], place)


@pytest.mark.parametrize(("w", "copy"), [(14, 0), (5, 1), (25, 1), (2, 0)])
def test_every_k(w: int, copy: int) -> None:
    sim = load("array_shift", {"W": w, "COPY": copy})
    io, rng = sim.io, np.random.default_rng(w)
    ones = (1 << w) - 1
    reset(sim)
    for k in rng.permutation(9).tolist():
        io.k, io.load = k, 1
        sim.clock.tick()
        io.k, io.load = 8 - k, 0  # nobody looks
        sim.clock.tick()
        assert io.odd == k % 2
        extremes = [(value, 0, 0) for value in (1 << w - 1, (1 << w - 1) - 1, 0, ones)]
        for a, b, c in [*rng.integers(0, 1 << w, (40, 3)).tolist(), *extremes]:
            io.a_not, io.b_not, io.c = a ^ ones, b ^ ones, c
            value = a | b | c
            signed = value - (value >> w - 1 << w)
            assert io.evenly == ((signed << 1) >> k - k % 2) % (2 << w), (k, signed)

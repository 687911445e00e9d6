# SPDX-License-Identifier: Apache-2.0
"""Expressions: values, their past, and bits that are x or z."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evcot.hardware.contract import State
from evcot_cosim.waves import PropertyError, Samples, Wave, WaveformError, after, always, never

Open = Callable[..., Samples]
VcdText = Callable[..., str]


def test_expressions_are_computed_for_all_cycles_at_once(sampled: Open) -> None:
    s = sampled(a="0101", b="0011", n=[3, 4, 4, 9])
    cases = {
        "~a": (~s["a"], "1010"),
        "a & b": (s["a"] & s["b"], "0001"),
        "a | b": (s["a"] | s["b"], "0111"),
        "a ^ b": (s["a"] ^ s["b"], "0110"),
        "a == 1": (s["a"] == 1, "0101"),
        "n == 4": (s["n"] == 4, "0110"),
        "n != 4": (s["n"] != 4, "1001"),
        "n < 4": (s["n"] < 4, "1000"),
        "n <= 4": (s["n"] <= 4, "1110"),
        "n > 4": (s["n"] > 4, "0001"),
        "n >= 4": (s["n"] >= 4, "0111"),
        "n.bit(0)": (s["n"].bit(0), "1001"),
        "n.bits(3, 2) == 1": (s["n"].bits(3, 2) == 1, "0110"),
        "(n - a) == 3": (s["n"] - s["a"] == 3, "1100"),
        "(n + 1) == 5": (s["n"] + 1 == 5, "0110"),
        "n == State.IDLE": (s["n"] == State.IDLE, "0000"),
    }
    for text, (expr, wanted) in cases.items():
        assert expr.text == text
        assert "".join(str(int(value)) for value in expr.values) == wanted, text


def test_the_past_begins_where_there_is_one(sampled: Open) -> None:
    s = sampled(a="1101", n=[3, 4, 4, 9])
    assert s["n"].previous().values[1:].tolist() == [3, 4, 4]
    assert s["n"].previous(2).since == 2
    assert s["n"].changed.true.tolist() == [False, True, False, True]
    assert s["a"].rose.true.tolist() == [False, False, False, True]
    assert s["a"].fell.true.tolist() == [False, False, True, False]
    assert s["a"].rose.text == "a.rose"
    with pytest.raises(PropertyError, match="must look back at least 1 cycle"):
        s["a"].previous(0)


def test_unknown_bits_make_a_value_unknown_but_false_and_x_is_false(sampled: Open) -> None:
    s = sampled(a=["0", "1", "x", "z"], n=["1", "1x", "zz", "11"])
    a, one, zero = s["a"] == 1, s["n"] == s["n"], s["n"] != s["n"]
    assert a.unknown.tolist() == [False, False, True, True]
    assert s["n"].is_unknown.values.tolist() == [False, True, True, False]
    assert (a & (s["n"] == 1)).unknown.tolist() == [False, True, True, False]
    assert (a & ~a).unknown.tolist() == [False, False, True, True]
    assert (zero & a).unknown.tolist() == [False, True, True, False]
    assert (one | a).unknown.tolist() == [False, False, True, False]
    assert not (~a).true[2]
    assert not a.true[2]


def test_signals_wider_than_a_machine_word(tmp_path: Path, vcd_text: VcdText) -> None:
    path = tmp_path / "wide.vcd"
    path.write_text(vcd_text({"lfsr": [0, 1, (1 << 72) - 1]}, width=72))
    s = Wave.open(path).sampled()
    assert s["lfsr"].values.tolist() == [0, 1, (1 << 72) - 1]
    assert (s["lfsr"] == (1 << 72) - 1).values.tolist() == [False, False, True]
    assert s["lfsr"].bits(71, 68).values.tolist() == [0, 0, 15]
    assert s["lfsr"].bits(71, 68).values.dtype == np.int64
    with pytest.raises(WaveformError, match="0xffffffffffffffffff"):
        never(s["lfsr"] == (1 << 72) - 1)


@pytest.mark.parametrize(
    ("misuse", "message"),
    [
        (lambda s: s["a"] and s["a"], "write &, | and ~ for and, or and not"),
        (lambda s: 1 < s["n"] < 3, "no a < b < c"),
        (lambda s: s["n"] == 3 & s["a"], "one side is a number and one a condition"),
        (lambda s: ~s["n"], "n: is a number: must be a condition"),
        (lambda s: always(s["n"]), "n: is a number: must be a condition"),
        (lambda s: s["n"] == "IDLE", "cannot be combined with 'IDLE'"),
        (lambda s: s["a"] & s.wave.sampled()["a"], "must be sampled together"),
        (lambda s: always(s["a"], where=s.wave.sampled()["a"]), "must be sampled together"),
        (lambda s: s["n"].bits(0, 3), "must count downwards"),
        (lambda s: after(s["a"]).within(0), "must allow at least 1 cycle"),
    ],
)
def test_what_makes_no_sense_is_refused(sampled: Open, misuse: Callable[[Samples], object], message: str) -> None:
    with pytest.raises(PropertyError) as error:
        misuse(sampled(a="01", n=[1, 2]))
    assert message in str(error.value)

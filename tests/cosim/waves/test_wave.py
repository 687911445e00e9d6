# SPDX-License-Identifier: Apache-2.0
"""Signals of a VCD: how they are found, what is refused, and what a flip-flop would see, wherever the file has white space."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import OutputError
from evcot.hardware.contract import State
from evcot_cosim.waves import PropertyError, Samples, VcdError, Wave, WaveformError, after, always, never
from evcot_cosim.waves import vcd_lines as module
from support.full_disk import full_disk

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


def test_a_value_is_the_one_before_the_edge(tmp_path: Path) -> None:
    """What changes together with the edge shows at the next one, as behind a flip-flop."""
    path = tmp_path / "edge.vcd"
    path.write_text(
        "$timescale 1ps $end\n$scope module TOP $end\n"
        "$var wire 1 ! clk $end\n$var wire 3 d d [2:0] $end\n$upscope $end\n$enddefinitions $end\n"
        "#0\n0!\nb1 d\n#5\n1!\nb10 d\n#10\n0!\nb11 d\n#15\n1!\n#20\n0!\n#25\n1!\nb111 d\n"
    )
    s = Wave.open(path).sampled("clk")
    assert s.times.tolist() == [5, 15, 25]
    assert s["d"].values.tolist() == [1, 3, 3]
    assert Wave.open(path)["d"].values.tolist() == [1, 2, 3, 7]


def test_signals_are_found_by_path_by_a_unique_end_and_by_glob(sampled: Open) -> None:
    s = sampled(valid="01", state=[1, 2], state_next=[2, 3])
    for name in ("TOP.dut.state", "dut.state", "state"):
        assert s[name].values.tolist() == [1, 2]
    assert s.find("state*") == ["TOP.dut.state", "TOP.dut.state_next"]
    assert s.find("TOP.*") == ["TOP.clk", "TOP.dut.valid", "TOP.dut.state", "TOP.dut.state_next"]


def test_elements_of_an_array_have_brackets(sampled: Open) -> None:
    s = sampled(**{"cm[0]": [1, 2], "cm[1]": [3, 4]})
    assert s["cm[1]"].values.tolist() == [3, 4]
    assert s.find("cm[*]") == ["TOP.dut.cm[0]", "TOP.dut.cm[1]"]


def test_an_absent_signal_is_answered_with_those_near_it(sampled: Open) -> None:
    s = sampled(token_valid="01", state=[1, 2])
    with pytest.raises(VcdError, match=r"run\.vcd: no signal TOP\.dut\.stat; near it: TOP\.dut\.state$"):
        s["TOP.dut.stat"]
    with pytest.raises(VcdError, match=r"no signal qqqq; nothing is near it among 3 signals"):
        s["qqqq"]


def test_a_name_for_two_wires_is_refused_and_two_names_for_one_wire_are_not(tmp_path: Path) -> None:
    path = tmp_path / "names.vcd"
    path.write_text(
        "$scope module TOP $end\n$var wire 1 ! clk $end\n$var wire 1 a q $end\n"
        "$scope module one $end\n$var wire 1 a q $end\n$var wire 1 b r $end\n$upscope $end\n"
        "$scope module two $end\n$var wire 1 c r $end\n$upscope $end\n"
        "$upscope $end\n$enddefinitions $end\n#0\n0!\n1a\n0b\n1c\n#5\n1!\n"
    )
    wave = Wave.open(path)
    assert wave.declared("q").path == "TOP.q"
    assert wave.sampled()["one.r"].values.tolist() == [False]
    with pytest.raises(VcdError, match=r"r is ambiguous: TOP\.one\.r, TOP\.two\.r$"):
        wave["r"]


def test_only_some_signals_may_be_read(tmp_path: Path, vcd_text: VcdText) -> None:
    path = tmp_path / "run.vcd"
    path.write_text(vcd_text({"valid": "01", "state": [1, 2]}))
    wave = Wave.open(path, only=("clk", "valid"))
    assert wave.sampled()["valid"].values.tolist() == [False, True]
    with pytest.raises(VcdError, match=r"TOP\.dut\.state has not been read: add it to `only`"):
        wave["state"]
    with pytest.raises(VcdError, match=r"run\.vcd: no signal matches reddy, vallid"):
        Wave.open(path, only=("reddy", "vallid"))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "cannot be read: No such file"),
        (b"", "not a VCD: must begin with declarations"),
        (b"\x89PNG\r\n\x1a\n\xff\xfe", "not a VCD"),
        (
            b"$scope module TOP $end\n$var reg 4 a n [3:0] $end\n$upscope $end\n$enddefinitions $end\n#0\nb101",
            "not a whole VCD",
        ),
    ],
)
def test_what_is_not_a_whole_vcd_is_refused(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "bad.vcd"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(VcdError, match=rf"bad\.vcd: {message}"):
        Wave.open(path)


def test_time_that_runs_backwards_is_refused(tmp_path: Path, vcd_text: VcdText) -> None:
    path = tmp_path / "back.vcd"
    path.write_text(vcd_text({"state": [1, 2]}).replace("#15", "#3"))
    with pytest.raises(VcdError, match=r"back\.vcd: TOP\.clk: time runs backwards"):
        Wave.open(path).sampled()


def test_reading_leaves_the_process_handling_of_broken_pipes_alone(tmp_path: Path, vcd_text: VcdText) -> None:
    path = tmp_path / "run.vcd"
    path.write_text(vcd_text({"valid": "01"}))
    code = (
        "import signal; from evcot_cosim.waves import Wave; "
        f"Wave.open({str(path)!r}); print(signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "True\n"


def test_part_of_the_time_may_be_sampled(sampled: Open) -> None:
    wave = sampled(state=[1, 2, 3, 4, 5]).wave
    assert wave.sampled("clk", begin=15, end=35)["state"].values.tolist() == [2, 3]


def test_the_clock_has_one_bit(sampled: Open) -> None:
    wave = sampled(state=[1, 2]).wave
    with pytest.raises(VcdError, match=r"clock TOP\.dut\.state has 4 bits: must have 1"):
        wave.sampled("state")


def test_a_bundle_is_found_by_its_prefix(sampled: Open) -> None:
    s = sampled(s_x=[1, 2], s_valid="01", s_ready="11", state=[3, 4])
    assert [expr.paths[0] for expr in s.stream("s")] == ["TOP.dut.s_valid", "TOP.dut.s_ready", "TOP.dut.s_x"]


def test_a_bundle_ends_where_its_scope_does(tmp_path: Path) -> None:
    path = tmp_path / "nested.vcd"
    path.write_text(
        "$scope module TOP $end\n$var wire 1 ! clk $end\n$var wire 1 a s_valid $end\n$var wire 1 b s_ready $end\n"
        "$scope module s_fifo $end\n$var wire 1 c full $end\n$upscope $end\n$upscope $end\n$enddefinitions $end\n"
        "#0\n0!\n1a\n1b\n1c\n#5\n1!\n"
    )
    assert [expr.paths[0] for expr in Wave.open(path).sampled().stream("TOP.s")] == ["TOP.s_valid", "TOP.s_ready"]


def test_parts_of_a_vector_that_are_declared_apart_keep_their_ranges(tmp_path: Path) -> None:
    path = tmp_path / "parts.vcd"
    path.write_text(
        "$scope module TOP $end\n$var wire 1 ! clk $end\n$var wire 2 a d [3:2] $end\n$var wire 2 b d [1:0] $end\n"
        "$upscope $end\n$enddefinitions $end\n#0\n0!\nb1 a\nb10 b\n#5\n1!\n"
    )
    s = Wave.open(path).sampled()
    assert (s["d[3:2]"].values.tolist(), s["d[1:0]"].values.tolist()) == ([1], [2])


def test_a_signal_is_unknown_until_it_has_a_value(tmp_path: Path, vcd_text: VcdText) -> None:
    path = tmp_path / "late.vcd"
    path.write_text(vcd_text({"n": [5, 5, 6]}).replace("b101 a\n", ""))
    n = Wave.open(path).sampled()["n"]
    assert n.unknown.tolist() == [True, True, False]
    with pytest.raises(WaveformError, match=r"unknown at 5 ns, cycle 0; 2 of 3 cases") as error:
        always(n == 6)
    assert str(error.value).splitlines()[-1].split() == ["TOP.dut.n", "x", "x", "6"]


HEADER = """$date
    big bang $end
$version Riviera-PRO $end $comment $var wire 1 ? none $end
$timescale
  1
  ns $end
$scope module top $end $var wire 1 ! a $end
$var reg 4 " n [3:0] $end $var real 64 % r $end
$scope module  $end $var wire 1 $auto inner$1 $end $upscope $end
$scope module \\$scopeinfo $end $var wire 1 & $upscope$2 $end $upscope $end
$upscope $end $enddefinitions $end
"""
CHANGES = """#0
$dumpvars
0!
b0 "
r0.5 %
0$auto
1&
$end
#5
1!
b101 "
sred %
#10
0!
b11 "
1$auto
#15
"""
BODIES = {
    "a line each": CHANGES,
    "one line": " ".join(CHANGES.split()),
    "one line with tabs": "\t".join(CHANGES.split()),
    "a word each": "\n".join(CHANGES.split()),
    "carriage returns and tabs": CHANGES.replace("\n", "\r\n").replace(" ", "\t"),
    "times with fractions of zero": CHANGES.replace("#5", "#5.0").replace("#10", "#10.00"),
    "a comment between changes": CHANGES.replace("#5", "$comment b1 0! #99 $end\n#5"),
    "levels of std_logic": CHANGES.replace("1!", "H!").replace("#10\n0!", "#10\nL!"),
    "capital letters": CHANGES.replace("b", "B"),
}


def made(folder: Path, text: str) -> Path:
    (folder / "w.vcd").write_text(text)
    return folder / "w.vcd"


def changes_of(wave: Wave, name: str) -> list[tuple[int, str]]:
    signal = wave[name]
    return [(int(time), signal.text(i)) for i, time in enumerate(signal.times)]


@pytest.mark.parametrize("block", [1 << 20, 7])
@pytest.mark.parametrize("body", BODIES)
def test_white_space_changes_nothing(body: str, block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_BLOCK", block)
    monkeypatch.setattr(module, "_LONGEST", 2 * block + 40)
    wave = Wave.open(made(tmp_path, HEADER + BODIES[body]))
    assert changes_of(wave, "top.a") == [(0, "0"), (5, "1"), (10, "0")]
    assert changes_of(wave, "top.n") == [(0, "0"), (5, "5"), (10, "3")]
    assert changes_of(wave, "top.inner$1") == [(0, "0"), (10, "1")]
    assert changes_of(wave, "top.\\$scopeinfo.$upscope$2") == [(0, "1")]
    assert (wave.end_time, wave.timescale.text(3)) == (15, "3 ns")


def test_a_vector_without_digits_is_unknown(tmp_path: Path) -> None:
    wave = Wave.open(made(tmp_path, HEADER + CHANGES.replace('b101 "', 'b "')))
    assert changes_of(wave, "top.n") == [(0, "0"), (5, "x"), (10, "3")]


def test_a_signal_that_is_left_out_is_named(tmp_path: Path) -> None:
    wave = Wave.open(made(tmp_path, HEADER + CHANGES))
    for name in ("r", "top.r"):
        with pytest.raises(VcdError, match=f"w.vcd: {name} is a real, which is left out: must be a signal of bits"):
            wave[name]


def test_full_temporary_folder_is_not_an_error_of_the_vcd(tmp_path: Path) -> None:
    vcd = made(tmp_path, HEADER + CHANGES)
    with full_disk(10), pytest.raises(OutputError, match=r"^/.*/lines\.vcd: cannot be written: File too large$"):
        Wave.open(vcd)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER.replace("wire 1 !", "port 1 !") + CHANGES, "is an extended VCD"),
        (HEADER + "#0\npD 6 0 !\n", "is an extended VCD"),
        (HEADER + "$dumpports\n", "is an extended VCD"),
        (HEADER + "#0\nq!\n", "'q!': must be a time or a value change"),
        (HEADER + "#1.5\n", "#1.5: must be a whole number of time units, not negative"),
        (HEADER + "#0\nb1", "not a whole VCD: the last value has no code"),
        (HEADER.replace("ns", "nm"), "$timescale 1 nm: must be 1, 10 or 100 s, ms, us, ns, ps or fs"),
        (HEADER.replace("wire 1 ! a", "wire 1 !"), "$var wire 1 !: must have a type, a size, a code and a name"),
        (HEADER.replace("wire 1 ! a", "wire 1 $scope a"), "has a keyword as its code"),
        ("$upscope $end", "$upscope: must close a scope"),
        ("$scope module top $end", "not a VCD: must begin with declarations"),
        ("\x7fELF" * 9, "not a VCD: must begin with declarations"),
        ("x" * 5_000_000, "not a whole VCD: a word has more than 4194304 characters"),
    ],
)
def test_refused_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(VcdError) as caught:
        Wave.open(made(tmp_path, text))
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path}/w.vcd: ")
    assert "\n" not in str(caught.value)

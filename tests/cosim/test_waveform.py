# SPDX-License-Identifier: Apache-2.0
"""The waveform vocabulary: what holds passes, and its broken twin fails and says when, where and with which values."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from enum import IntEnum
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import EvcotError
from evcot_cosim.waveform import (
    PropertyError,
    Samples,
    VcdError,
    Wave,
    WaveformError,
    after,
    always,
    handshake_stable,
    never,
    one_of,
    sometime,
    stable_until,
    transitions,
)
from evcot_cosim.waveform import __all__ as waveform_names

Values = Sequence[int | str]
Open = Callable[..., Samples]


class Light(IntEnum):
    RED = 0
    GREEN = 1
    AMBER = 2


def vcd_text(signals: dict[str, Values], width: int = 4) -> str:
    """One value per cycle for each signal, an integer or the bits as text. Cycle i's edge is at 10 i + 5.

    Text as a whole is a one-bit signal, "0110"; anything else has `width` bits. Unchanged values are not repeated.
    """
    codes = {name: chr(ord("a") + i) for i, name in enumerate(signals)}
    widths = {name: 1 if isinstance(values, str) else width for name, values in signals.items()}
    lines = ["$timescale 1ns $end", "$scope module TOP $end", "$var wire 1 ! clk $end", "$scope module dut $end"]
    for name, code in codes.items():
        bits = widths[name]
        lines.append(f"$var reg {bits} {code} {name} {f'[{bits - 1}:0] ' if bits > 1 else ''}$end")
    lines += ["$upscope $end", "$upscope $end", "$enddefinitions $end"]
    shown: dict[str, int | str] = {}
    for i in range(max((len(values) for values in signals.values()), default=0)):
        lines += [f"#{10 * i}", "0!"]
        for name, values in signals.items():
            if shown.get(name) != values[i]:
                value = shown[name] = values[i]
                text = f"{value:b}" if isinstance(value, int) else value
                lines.append(f"{text}{codes[name]}" if widths[name] == 1 else f"b{text} {codes[name]}")
        lines += [f"#{10 * i + 5}", "1!"]
    return "\n".join(lines) + "\n"


@pytest.fixture
def sampled(tmp_path: Path) -> Open:
    """Sampled signals of a waveform given by one value per cycle."""

    def make(**signals: Values) -> Samples:
        path = tmp_path / "run.vcd"
        path.write_text(vcd_text(signals))
        return Wave.open(path).sampled("clk")

    return make


def table(error: pytest.ExceptionInfo[WaveformError]) -> dict[str, list[str]]:
    """The lines below a message's first, by their first word."""
    return {line.split()[0]: line.split()[1:] for line in str(error.value).splitlines()[1:]}


def first_line(error: pytest.ExceptionInfo[WaveformError]) -> str:
    return str(error.value).splitlines()[0]


# ---- signals -----------------------------------------------------------------------------------------------------------


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


def test_only_some_signals_may_be_read(tmp_path: Path) -> None:
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
        (b"", "not a VCD: must declare at least one signal"),
        (b"\x89PNG\r\n\x1a\n\xff\xfe", "not a whole VCD"),
        (vcd_text({"state": [1, 2]}).encode()[:-20] + b"\nb101\n", "not a whole VCD"),
    ],
)
def test_what_is_not_a_whole_vcd_is_refused(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "bad.vcd"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(VcdError, match=rf"bad\.vcd: {message}"):
        Wave.open(path)


def test_time_that_runs_backwards_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "back.vcd"
    path.write_text(vcd_text({"state": [1, 2]}).replace("#15", "#3"))
    with pytest.raises(VcdError, match=r"back\.vcd: TOP\.clk: time runs backwards"):
        Wave.open(path).sampled()


def test_reading_leaves_the_process_handling_of_broken_pipes_alone(tmp_path: Path) -> None:
    path = tmp_path / "run.vcd"
    path.write_text(vcd_text({"valid": "01"}))
    code = (
        "import signal; from evcot_cosim.waveform import Wave; "
        f"Wave.open({str(path)!r}); print(signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN)"
    )
    assert signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN
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


# ---- expressions -------------------------------------------------------------------------------------------------------


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
        "n == Light.AMBER": (s["n"] == Light.AMBER, "0000"),
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


def test_signals_wider_than_a_machine_word(tmp_path: Path) -> None:
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


# ---- properties: each with its broken twin -----------------------------------------------------------------------------


def test_always(sampled: Open) -> None:
    assert always(sampled(a="1111")["a"]) == 4
    s = sampled(a="11011010", n=[1, 2, 3, 4, 5, 6, 7, 8])
    with pytest.raises(WaveformError) as error:
        always(s["a"] | (s["n"] > 9))
    assert first_line(error) == (
        f"always(a | (n > 9)): not true at 25 ns, cycle 2; 3 of 8 cases fail ({s.wave.path}, rising TOP.clk)"
    )
    assert table(error) == {
        "cycle": ["0", "1", ">2", "3", "4"],
        "ns": ["5", "15", "25", "35", "45"],
        "TOP.dut.a": ["1", "1", "0", "1", "1"],
        "TOP.dut.n": ["1", "2", "3", "4", "5"],
    }
    assert (error.value.cycle, error.value.time, error.value.path) == (2, 25, str(s.wave.path))


def test_always_where(sampled: Open) -> None:
    s = sampled(a="0110", run="0110")
    assert always(s["a"], where=s["run"]) == 2
    s = sampled(a="0100", run="0110")
    with pytest.raises(WaveformError, match=r"always\(a, where=run\): not true at 25 ns, cycle 2; 1 of 2 cases fail"):
        always(s["a"], where=s["run"])


def test_never(sampled: Open) -> None:
    s = sampled(a="0101", b="1010")
    assert never(s["a"] & s["b"]) == 4
    s = sampled(a="0101", b="1011")
    with pytest.raises(WaveformError, match=r"never\(a & b\): not false at 35 ns, cycle 3; 1 of 4 cases fail") as error:
        never(s["a"] & s["b"])
    assert table(error)["TOP.dut.b"] == ["1", "0", "1", "1"]


def test_sometime(sampled: Open) -> None:
    assert sometime(sampled(a="0101")["a"]) == 2
    with pytest.raises(WaveformError, match=r"sometime\(a\): vacuous: it is true nowhere in 4 cycles, 5 ns to 35 ns"):
        sometime(sampled(a="0000")["a"])


def test_a_property_of_an_unknown_value_does_not_hold(sampled: Open) -> None:
    s = sampled(n=["0", "0", "1x", "0"], b="0000")
    for check in (lambda: never(s["n"] == 3), lambda: always(s["n"] != 3), lambda: one_of(s["n"], {0, 2, 3})):
        with pytest.raises(WaveformError, match=r": unknown at 25 ns, cycle 2") as error:
            check()
        assert table(error)["TOP.dut.n"] == ["0", "0", "1x", "0"]
    with pytest.raises(WaveformError, match=r"where is unknown at 25 ns"):
        always(s["b"] == 0, where=s["n"] == 3)
    with pytest.raises(WaveformError, match=r"the trigger is unknown at 25 ns"):
        after(s["n"] == 3).expect(s["b"])


def test_after_within_expect(sampled: Open) -> None:
    good = sampled(req="01000010000", ack="00010000100")
    assert after(good["req"]).within(2).expect(good["ack"]) == 2
    late = sampled(req="01000010000", ack="00010000010")
    with pytest.raises(WaveformError) as error:
        after(late["req"]).within(2).expect(late["ack"])
    assert first_line(error) == (
        "after(req).within(2).expect(ack): triggered, and nothing by cycle 8, at 65 ns, cycle 6; "
        f"1 of 2 cases fail ({late.wave.path}, rising TOP.clk)"
    )
    assert table(error)["TOP.dut.ack"] == ["1", "0", "0", "0", "0", "0"]
    assert table(error)["cycle"] == ["3", "4", "5", ">6", "7", "8"]


def test_after_does_not_count_the_cycle_of_the_trigger(sampled: Open) -> None:
    s = sampled(req="0100", ack="0100")
    with pytest.raises(WaveformError, match="nothing by cycle 2"):
        after(s["req"]).expect(s["ack"])
    s = sampled(req="0100", ack="0010")
    assert after(s["req"]).expect(s["ack"]) == 1


def test_after_shows_as_much_of_a_long_wait_as_fits(sampled: Open) -> None:
    s = sampled(req="0" * 5 + "1" + "0" * 30, ack="0" * 36)
    with pytest.raises(WaveformError) as error:
        after(s["req"]).within(25).expect(s["ack"])
    assert table(error)["cycle"] == ["2", "3", "4", ">5", *map(str, range(6, 14))]


def test_a_trigger_too_near_the_end_is_not_counted(sampled: Open) -> None:
    s = sampled(req="0100010", ack="0010000")
    assert after(s["req"]).within(3).expect(s["ack"]) == 1
    s = sampled(req="0000010", ack="0010000")
    with pytest.raises(WaveformError, match=r"vacuous: the waveform ends too soon after every trigger in 7 cycles"):
        after(s["req"]).within(3).expect(s["ack"])


def test_stable_until(sampled: Open) -> None:
    s = sampled(go="0100010", stop="0001001", n=[1, 5, 5, 5, 7, 3, 3])
    assert stable_until(s["n"], start=s["go"], until=s["stop"]) == 3
    s = sampled(go="0100010", stop="0001001", n=[1, 5, 6, 5, 7, 3, 3], m=[0, 0, 0, 1, 0, 0, 0])
    with pytest.raises(WaveformError) as error:
        stable_until((s["m"], s["n"]), start=s["go"], until=s["stop"])
    assert first_line(error) == (
        "stable_until(m, n, start=go, until=stop): n changes, having been held since cycle 1, at 25 ns, cycle 2; "
        f"2 of 3 cases fail ({s.wave.path}, rising TOP.clk)"
    )
    assert table(error)["TOP.dut.n"] == ["1", "5", "6", "5", "7"]
    assert {"TOP.dut.go", "TOP.dut.stop", "TOP.dut.m"} <= table(error).keys()


def test_stable_until_includes_the_last_cycle(sampled: Open) -> None:
    s = sampled(go="0100", stop="0010", n=[1, 5, 6, 6])
    with pytest.raises(WaveformError, match=r"n changes, .* cycle 2"):
        stable_until(s["n"], start=s["go"], until=s["stop"])


def test_one_of(sampled: Open) -> None:
    assert one_of(sampled(n=[0, 1, 2, 1])["n"], Light) == 4
    s = sampled(n=[0, 1, 3, 2])
    with pytest.raises(WaveformError) as error:
        one_of(s["n"], Light)
    assert first_line(error) == (
        f"one_of(n, {{RED, GREEN, AMBER}}): another value at 25 ns, cycle 2; 1 of 4 cases fail ({s.wave.path}, rising TOP.clk)"
    )
    assert table(error)["TOP.dut.n"] == ["RED", "GREEN", "3", "AMBER"]


LIGHTS = {Light.RED: {Light.GREEN}, Light.GREEN: {Light.AMBER}, Light.AMBER: {Light.RED}}


def test_transitions(sampled: Open) -> None:
    assert transitions(sampled(light=[0, 0, 1, 2, 2, 0, 1])["light"], LIGHTS) == 4
    s = sampled(light=[0, 0, 1, 2, 2, 1, 2])
    with pytest.raises(WaveformError) as error:
        transitions(s["light"], LIGHTS)
    assert first_line(error) == (
        f"transitions(light): AMBER to GREEN at 55 ns, cycle 5; 1 of 4 cases fail ({s.wave.path}, rising TOP.clk)"
    )
    assert table(error)["TOP.dut.light"] == ["GREEN", "AMBER", "AMBER", "GREEN", "AMBER"]


def test_transitions_from_a_value_that_must_not_occur(sampled: Open) -> None:
    with pytest.raises(WaveformError, match="3 to RED at 15 ns"):
        transitions(sampled(light=[3, 0, 1])["light"], LIGHTS)
    with pytest.raises(WaveformError, match="x to GREEN at 15 ns"):
        transitions(sampled(light=["xx", 1, 2])["light"], LIGHTS)


def test_transitions_where(sampled: Open) -> None:
    s = sampled(light=[2, 1, 2, 0], rst="1000")
    assert transitions(s["light"], LIGHTS, where=~s["rst"]) == 2
    s = sampled(light=[2, 1, 0, 0], rst="1000")
    with pytest.raises(WaveformError, match=r"transitions\(light, where=~rst\): GREEN to RED at 25 ns, cycle 2; 1 of 1 cases"):
        transitions(s["light"], LIGHTS, where=~s["rst"])


def test_handshake_stable(sampled: Open) -> None:
    s = sampled(s_valid="0111010", s_ready="1011110", s_x=[0, 5, 5, 6, 9, 7, 8])
    assert handshake_stable(*s.stream("s")) == 1


def test_a_waiting_payload_that_changes_breaks_a_handshake(sampled: Open) -> None:
    s = sampled(s_valid="0111010", s_ready="1001110", s_x=[0, 5, 5, 6, 9, 7, 8])
    with pytest.raises(WaveformError) as error:
        handshake_stable(*s.stream("s"))
    assert first_line(error) == (
        "handshake_stable(TOP.dut.s_valid, TOP.dut.s_ready, TOP.dut.s_x): TOP.dut.s_x changes, having been held since cycle 1, "
        f"at 35 ns, cycle 3; 1 of 2 cases fail ({s.wave.path}, rising TOP.clk)"
    )
    assert table(error)["TOP.dut.s_x"] == ["0", "5", "5", "6", "9", "7"]
    assert table(error)["TOP.dut.s_ready"] == ["1", "0", "0", "1", "1", "1"]


def test_an_offer_that_is_withdrawn_breaks_a_handshake(sampled: Open) -> None:
    s = sampled(s_valid="01001", s_ready="10001", rst="00000")
    with pytest.raises(WaveformError, match=r"s_valid changes, having been held since cycle 1, at 25 ns"):
        handshake_stable(s["s_valid"], s["s_ready"])
    s = sampled(s_valid="01001", s_ready="10001", rst="01000")
    assert handshake_stable(s["s_valid"], s["s_ready"], where=~s["rst"], allow_vacuous=True) == 0


# ---- vacuity -----------------------------------------------------------------------------------------------------------

QUIET: list[tuple[Callable[..., int], str]] = [
    (lambda s, **k: always(s["a"], where=s["a"], **k), "`where` is never true"),
    (lambda s, **k: never(s["a"], where=s["a"], **k), "`where` is never true"),
    (lambda s, **k: one_of(s["n"], {1}, where=s["a"], **k), "`where` is never true"),
    (lambda s, **k: always(s["a"].previous(9), **k), "no cycle has all the past that it asks for"),
    (lambda s, **k: after(s["a"]).within(2).expect(s["a"], **k), "the trigger never happens"),
    (lambda s, **k: stable_until(s["n"], start=s["a"], until=s["a"], **k), "the start never happens"),
    (lambda s, **k: transitions(s["n"], {1: {2}}, **k), "the value never changes"),
    (lambda s, **k: handshake_stable(s["a"], s["a"], s["n"], **k), "what is offered never has to wait"),
]


@pytest.mark.parametrize(("check", "why"), QUIET)
def test_a_property_that_is_never_put_to_the_test_fails_unless_that_is_allowed(
    sampled: Open, check: Callable[..., int], why: str
) -> None:
    s = sampled(a="0000", n=[1, 1, 1, 1])
    with pytest.raises(WaveformError, match=rf": vacuous: {why}.* in 4 cycles, 5 ns to 35 ns \(.*run\.vcd\)"):
        check(s)
    assert check(s, allow_vacuous=True) == 0


@pytest.mark.parametrize("check", [check for check, _ in QUIET])
def test_a_property_of_no_samples_fails_always(sampled: Open, check: Callable[..., int]) -> None:
    nothing = sampled(a="0000", n=[1, 1, 1, 1]).wave.sampled(begin=1000)
    with pytest.raises(WaveformError, match=r": vacuous: no samples: TOP\.clk never rises"):
        check(nothing, allow_vacuous=True)


def test_a_broken_property_is_a_failed_assertion_and_an_error_of_evcot() -> None:
    assert issubclass(WaveformError, AssertionError)
    assert issubclass(WaveformError, EvcotError)


# ---- docs/waveforms.md -------------------------------------------------------------------------------------------------

GUIDE = Path(__file__).parents[2] / "docs" / "waveforms.md"


def test_the_examples_of_the_guide_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    signals: dict[str, Values] = {
        "rst": "1000000000", "req": "0010010000", "ack": "0001001000", "state": [0, 1, 2, 4, 1, 2, 5, 1, 1, 1],
        "count": [0, 1, 2, 3, 4, 5, 6, 7, 8, 12], "s_valid": "0111001100", "s_ready": "1001110100",
        "s_x": [0, 7, 7, 7, 1, 2, 3, 3, 4, 5],
    }  # fmt: skip
    Path("run.vcd").write_text(vcd_text(signals))
    names: dict[str, object] = {}
    examples = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    assert len(examples) == 4
    for example in examples:
        exec(compile(example, str(GUIDE), "exec"), names)
    used = "\n".join(examples)
    for name in waveform_names:
        assert name in used or name[0].isupper(), f"{name} has no example"


def test_the_failure_that_the_guide_shows_is_what_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("run.vcd").write_text(vcd_text({"req": "0010010000", "ack": "0001000000"}))
    s = Wave.open("run.vcd").sampled("clk")
    with pytest.raises(WaveformError) as error:
        after(s["req"].rose).within(3).expect(s["ack"])
    assert f"```text\n{error.value}\n```" in GUIDE.read_text()

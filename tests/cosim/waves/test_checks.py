# SPDX-License-Identifier: Apache-2.0
"""Every property passes where it holds, and fails on a broken waveform with time, signal and values in the message."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

import pytest

from evcot.errors import EvcotError
from evcot_cosim.waves import (
    Samples,
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

Open = Callable[..., Samples]


class Light(IntEnum):
    RED = 0
    GREEN = 1
    AMBER = 2


def table(error: pytest.ExceptionInfo[WaveformError]) -> dict[str, list[str]]:
    """The lines below a message's first, by their first word."""
    return {line.split()[0]: line.split()[1:] for line in str(error.value).splitlines()[1:]}


def first_line(error: pytest.ExceptionInfo[WaveformError]) -> str:
    return str(error.value).splitlines()[0]


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
    s = sampled(req="0001000", ack="0010000")
    with pytest.raises(WaveformError, match=r"triggered, and nothing by cycle 6,"):
        after(s["req"]).within(3).expect(s["ack"])
    s = sampled(req="0000100", ack="0010000")
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


def test_a_reset_ends_every_offer(sampled: Open) -> None:
    s = sampled(s_valid="01110010", s_ready="10000011", rst="00010000")
    assert handshake_stable(s["s_valid"], s["s_ready"], where=~s["rst"]) == 2
    with pytest.raises(WaveformError, match=r"s_valid changes, having been held since cycle 1, at 45 ns"):
        handshake_stable(s["s_valid"], s["s_ready"])


def test_an_offer_begins_after_the_one_before_was_taken(sampled: Open) -> None:
    s = sampled(s_valid="011110", s_ready="110000", s_x=[0, 1, 2, 2, 3, 3])
    with pytest.raises(WaveformError, match=r"s_x changes, having been held since cycle 2, at 45 ns"):
        handshake_stable(*s.stream("s"))


def test_an_unknown_payload_is_no_stable_one(sampled: Open) -> None:
    s = sampled(s_valid="0111", s_ready="0001", s_x=[0, 0, "xxxx", 0])
    with pytest.raises(WaveformError, match=r"s_x changes, .* at 25 ns, cycle 2; 2 of 2 cases"):
        handshake_stable(*s.stream("s"))


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

# SPDX-License-Identifier: Apache-2.0
"""Every property passes where it holds, and fails on a broken waveform with time, signal and values in the message."""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import IntEnum
from typing import Any

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
Check = Callable[[Samples], int]


class Light(IntEnum):
    RED = 0
    GREEN = 1
    AMBER = 2


def ack_within(cycles: int) -> Check:
    return lambda s: after(s["req"]).within(cycles).expect(s["ack"])


def held(s: Samples) -> int:
    return stable_until(s["n"], start=s["go"], until=s["stop"])


LIGHTS = {Light.RED: {Light.GREEN}, Light.GREEN: {Light.AMBER}, Light.AMBER: {Light.RED}}


def lights(s: Samples) -> int:
    return transitions(s["light"], LIGHTS)


def lights_run(s: Samples) -> int:
    return transitions(s["light"], LIGHTS, where=~s["rst"])


def handshake(s: Samples) -> int:
    return handshake_stable(*s.stream("s"))


def offer(s: Samples) -> int:
    return handshake_stable(s["s_valid"], s["s_ready"])


def offer_run(s: Samples) -> int:
    return handshake_stable(s["s_valid"], s["s_ready"], where=~s["rst"])


HANDSHAKE = "handshake_stable(TOP.dut.s_valid, TOP.dut.s_ready, TOP.dut.s_x): "
RESET = "s_valid=01110010 s_ready=10000011 rst=00010000"


def signals_of(text: str) -> dict[str, Any]:
    """One value per cycle: of a bit without commas, of numbers, and of x, with them."""
    return {
        name: [int(value) if value.isdigit() else value for value in values.split(",")] if "," in values else values
        for name, _, values in (word.partition("=") for word in text.split())
    }


@pytest.mark.parametrize(
    ("check", "signals", "cases"),
    [
        (lambda s: always(s["a"]), "a=1111", 4),
        (lambda s: always(s["a"], where=s["run"]), "a=0110 run=0110", 2),
        (lambda s: never(s["a"] & s["b"]), "a=0101 b=1010", 4),
        (lambda s: sometime(s["a"]), "a=0101", 2),
        (ack_within(2), "req=01000010000 ack=00010000100", 2),
        (ack_within(1), "req=0100 ack=0010", 1),
        (ack_within(3), "req=0100010 ack=0010000", 1),  # the second is too near the end
        (held, "go=0100010 stop=0001001 n=1,5,5,5,7,3,3", 3),
        (lambda s: one_of(s["n"], Light), "n=0,1,2,1", 4),
        (lights, "light=0,0,1,2,2,0,1", 4),
        (lights_run, "light=2,1,2,0 rst=1000", 2),
        (handshake, "s_valid=0111010 s_ready=1011110 s_x=0,5,5,6,9,7,8", 1),
        (offer_run, RESET, 2),
    ],
)
def test_a_property_that_holds_says_how_often_it_was_tested(sampled: Open, check: Check, signals: str, cases: int) -> None:
    assert check(sampled(**signals_of(signals))) == cases


@pytest.mark.parametrize(
    ("check", "signals", "message", "rows"),
    [
        (lambda s: always(s["a"] | (s["n"] > 9)), "a=11011010 n=1,2,3,4,5,6,7,8",
         "always(a | (n > 9)): not true at 25 ns, cycle 2; 3 of 8 cases fail",
         "cycle 0 1 >2 3 4; ns 5 15 25 35 45; TOP.dut.a 1 1 0 1 1; TOP.dut.n 1 2 3 4 5"),
        (lambda s: always(s["a"], where=s["run"]), "a=0100 run=0110",
         "always(a, where=run): not true at 25 ns, cycle 2; 1 of 2 cases fail", ""),
        (lambda s: never(s["a"] & s["b"]), "a=0101 b=1011",
         "never(a & b): not false at 35 ns, cycle 3; 1 of 4 cases fail", "TOP.dut.b 1 0 1 1"),
        (lambda s: sometime(s["a"]), "a=0000", "sometime(a): vacuous: it is true nowhere in 4 cycles, 5 ns to 35 ns", ""),
        (ack_within(2), "req=01000010000 ack=00010000010",
         "after(req).within(2).expect(ack): triggered, and nothing by cycle 8, at 65 ns, cycle 6; 1 of 2 cases fail",
         "TOP.dut.ack 1 0 0 0 0 0; cycle 3 4 5 >6 7 8"),
        # The cycle of the trigger does not count. Of a long wait as much is shown as fits.
        (ack_within(1), "req=0100 ack=0100", "after(req).within(1).expect(ack): triggered, and nothing by cycle 2,", ""),
        (ack_within(25), f"req=000001{'0' * 30} ack={'0' * 36}", "after(req).within(25)", "cycle 2 3 4 >5 6 7 8 9 10 11 12 13"),
        (ack_within(3), "req=0001000 ack=0010000", "after(req).within(3).expect(ack): triggered, and nothing by cycle 6,", ""),
        (ack_within(3), "req=0000100 ack=0010000",
         "after(req).within(3).expect(ack): vacuous: the waveform ends too soon after every trigger in 7 cycles", ""),
        (lambda s: stable_until((s["m"], s["n"]), start=s["go"], until=s["stop"]),
         "go=0100010 stop=0001001 n=1,5,6,5,7,3,3 m=0,0,0,1,0,0,0",
         "stable_until(m, n, start=go, until=stop): n changes, having been held since cycle 1, at 25 ns, cycle 2; 2 of 3 cases",
         "TOP.dut.n 1 5 6 5 7; TOP.dut.go 0 1 0 0 0; TOP.dut.stop 0 0 0 1 0; TOP.dut.m 0 0 0 1 0"),
        # The last cycle is included.
        (held, "go=0100 stop=0010 n=1,5,6,6", "stable_until(n, start=go, until=stop): n changes, having been held", ""),
        (lambda s: one_of(s["n"], Light), "n=0,1,3,2",
         "one_of(n, {RED, GREEN, AMBER}): another value at 25 ns, cycle 2; 1 of 4 cases fail", "TOP.dut.n RED GREEN 3 AMBER"),
        (lights, "light=0,0,1,2,2,1,2", "transitions(light): AMBER to GREEN at 55 ns, cycle 5; 1 of 4 cases fail",
         "TOP.dut.light GREEN AMBER AMBER GREEN AMBER"),
        (lights, "light=3,0,1", "transitions(light): 3 to RED at 15 ns", ""),
        (lights, "light=xx,1,2", "transitions(light): x to GREEN at 15 ns", ""),
        (lights_run, "light=2,1,0,0 rst=1000",
         "transitions(light, where=~rst): GREEN to RED at 25 ns, cycle 2; 1 of 1 cases", ""),
        (handshake, "s_valid=0111010 s_ready=1001110 s_x=0,5,5,6,9,7,8",
         f"{HANDSHAKE}TOP.dut.s_x changes, having been held since cycle 1, at 35 ns, cycle 3; 1 of 2 cases fail",
         "TOP.dut.s_x 0 5 5 6 9 7; TOP.dut.s_ready 1 0 0 1 1 1"),
        # An offer is withdrawn; a reset ends no offer unless it is said; one begins after the one before; one is unknown.
        (offer, "s_valid=01001 s_ready=10001 rst=00000",
         "handshake_stable(s_valid, s_ready): s_valid changes, having been held since cycle 1, at 25 ns", ""),
        (offer, RESET, "handshake_stable(s_valid, s_ready): s_valid changes, having been held since cycle 1, at 45 ns", ""),
        (handshake, "s_valid=011110 s_ready=110000 s_x=0,1,2,2,3,3",
         f"{HANDSHAKE}TOP.dut.s_x changes, having been held since cycle 2, at 45 ns", ""),
        (handshake, "s_valid=0111 s_ready=0001 s_x=0,0,xxxx,0",
         f"{HANDSHAKE}TOP.dut.s_x changes, having been held since cycle 1, at 25 ns, cycle 2; 2 of 2 cases", ""),
    ],
)  # fmt: skip
def test_a_property_that_does_not_hold_says_where_with_the_values_around(
    sampled: Open, check: Check, signals: str, message: str, rows: str
) -> None:
    s = sampled(**signals_of(signals))
    with pytest.raises(WaveformError) as error:
        check(s)
    first, *others = str(error.value).splitlines()
    assert first.startswith(message)
    assert first.endswith(f" ({s.wave.path}{'' if 'vacuous' in first else ', rising TOP.clk'})")
    assert set(filter(None, rows.split("; "))) <= {" ".join(line.split()) for line in others}
    assert error.value.path == str(s.wave.path)
    if (at := re.search(r" at (\d+) ns, cycle (\d+)", first)) is not None:
        assert (error.value.time, error.value.cycle) == tuple(map(int, at.groups()))


def test_a_property_of_an_unknown_value_does_not_hold(sampled: Open) -> None:
    s = sampled(n=["0", "0", "1x", "0"], b="0000")
    for check in (lambda: never(s["n"] == 3), lambda: always(s["n"] != 3), lambda: one_of(s["n"], {0, 2, 3})):
        with pytest.raises(WaveformError, match=r": unknown at 25 ns, cycle 2") as error:
            check()
        assert re.search(r"^ *TOP\.dut\.n +0 +0 +1x +0$", str(error.value), re.MULTILINE)
    with pytest.raises(WaveformError, match=r"where is unknown at 25 ns"):
        always(s["b"] == 0, where=s["n"] == 3)
    with pytest.raises(WaveformError, match=r"the trigger is unknown at 25 ns"):
        after(s["n"] == 3).expect(s["b"])


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

# SPDX-License-Identifier: Apache-2.0
"""Properties of the hardware, asserted on the waveforms of real runs; each also shown to fail where the waveform is edited.

An edit puts one wrong value into the VCD, at a clock where the property is put to the test, and lets the signal go on as
recorded from the next clock on. What hw/formal proves of every run is not asked again here.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import State
from evcot.hardware.modules import Module
from evcot_cosim.devices.device import Device
from evcot_cosim.rtl.files import copy_rtl
from evcot_cosim.waves import (
    Expr,
    Samples,
    Wave,
    WaveformError,
    after,
    always,
    handshake_stable,
    never,
    one_of,
    sometime,
    transitions,
)

SLOTS = range(3)
PAIRS = list(itertools.combinations(SLOTS, 2))

STREAMS = {
    "s": "tick event x y p",
    "m_cm": "kind slot id other x y radius n_ev support seq time",
    "m_own": "slot x y p seq",
    "m_pass": "x y p seq",
}  # fmt: skip


# What the comments of the states in cot.v say.
NEXT_STATE = {
    State.INIT_CELL: {State.IDLE},
    State.IDLE: {State.INIT_CELL, State.EV_DISCRI},
    State.EV_DISCRI: {State.INIT_CELL, State.EV_PASS_TH, State.EV_NO_PROC, State.EV_PROC},
    State.EV_PASS_TH: {State.IDLE},
    State.EV_NO_PROC: {State.IDLE},
    State.EV_PROC: {State.IDLE},
}


@dataclass(frozen=True)
class Scope:
    """Signals below one scope, by their short names."""

    samples: Samples
    path: str

    def __getitem__(self, name: str) -> Expr:
        return self.samples[f"{self.path}.{name}"]

    def full(self, name: str) -> str:
        return f"{self.path}.{name}"


@pytest.fixture(scope="module")
def array(vcds: dict[Module, Path]) -> Scope:
    return Scope(Wave.open(vcds["cot_array"], ["TOP.cot_array.*"]).sampled("TOP.cot_array.clk"), "TOP.cot_array")


@pytest.fixture(scope="module", params=SLOTS)
def tracker(vcds: dict[Module, Path], request: pytest.FixtureRequest) -> Scope:
    """Every tracker of the chain in turn."""
    path = f"TOP.cot_chain.tracker[{request.param}].u_cot"
    return Scope(Wave.open(vcds["cot_chain"], [f"{path}.*"]).sampled(f"{path}.clk"), path)


def edited(scope: Scope, cycle: int, values: Mapping[str, int], to: Path) -> Path:
    """The waveform again, with other values of some signals at one clock; all names of the same wire show them."""
    wave = scope.samples.wave
    edge = scope.samples.times[cycle : cycle + 1]
    wrong, right = [], []
    for name, value in values.items():
        signal = wave[scope.full(name)]
        code, width = signal.declared.code, signal.declared.width
        was = int(signal.values[signal.before(edge)[0]])
        assert was != value
        for number, changes in ((value, wrong), (was, right)):
            changes.append(f"{number}{code}\n" if width == 1 else f"b{number:0{width}b} {code}\n")
    lines = wave.path.read_text().splitlines(keepends=True)
    at = lines.index(f"#{edge[0]}\n")
    lines[at : at + 1] = [*wrong, lines[at], *right]  # what the edge itself changes stands below and wins
    to.write_text("".join(lines))
    return to


def broken(
    check: Callable[[Scope], object], scope: Scope, cycle: int, values: Mapping[str, int], to: Path, needs: str = "*"
) -> str:
    """What a check that passes says once the waveform has been edited; it must name that clock and one of the signals.

    Args:
        needs: the signals that the check looks at, as a pattern of short names: the fewer, the sooner they are read.
    """
    check(scope)
    edit = edited(scope, cycle, values, to)
    samples = Wave.open(edit, [f"{scope.path}.{needs}", scope.samples.clock]).sampled(scope.samples.clock)
    with pytest.raises(WaveformError) as error:
        check(Scope(samples, scope.path))
    assert error.value.cycle in (cycle, cycle + 1)
    assert any(scope.full(name) in str(error.value) for name in values)
    return str(error.value)


def clock_of(condition: Expr, which: int = 0) -> int:
    """The cycle in which a condition is true for the (which + 1)-th time."""
    return int(np.flatnonzero(condition.true)[which])


# ---- states --------------------------------------------------------------------------------------------------------------


def states_are_legal(tracker: Scope) -> int:
    one_of(tracker["state"], list(State))
    return transitions(tracker["state"], NEXT_STATE)


def test_every_tracker_of_a_chain_only_ever_goes_where_its_states_lead(tracker: Scope) -> None:
    assert states_are_legal(tracker) > 1_000
    for start, ends in NEXT_STATE.items():
        for end in ends:
            if (start, end) != (State.IDLE, State.INIT_CELL):  # only a register that is written ends a life there
                sometime((tracker["state"] == end) & (tracker["state"] == start).previous())


def test_an_event_is_discriminated_and_then_owned_or_passed(tracker: Scope) -> None:
    discriminated = (tracker["state"] == State.EV_DISCRI) & tracker["token_event"] & ~tracker["expired"]
    takes = discriminated & (tracker["inside_window"] | tracker["free"])
    after(takes).expect(tracker["m_own_valid"])
    after(discriminated & ~takes).expect(tracker["m_pass_valid"] & tracker["m_pass_event"])
    after(takes & tracker["last"]).within(3).expect(tracker["m_cm_valid"])


# ---- streams -------------------------------------------------------------------------------------------------------------


def stream_holds(scope: Scope, prefix: str) -> int:
    payload = [scope[f"{prefix}_{field}"] for field in STREAMS[prefix].split()]
    return handshake_stable(scope[f"{prefix}_valid"], scope[f"{prefix}_ready"], *payload)


@pytest.mark.parametrize("prefix", STREAMS)
@pytest.mark.parametrize("top", ["cot_array", "cot_chain"])
def test_every_stream_holds_its_offer_until_it_is_taken(vcds: dict[Module, Path], top: Module, prefix: str) -> None:
    samples = Wave.open(vcds[top], [f"TOP.{top}.*"]).sampled(f"TOP.{top}.clk")
    assert stream_holds(Scope(samples, f"TOP.{top}"), prefix) > 0


@pytest.mark.parametrize("prefix", STREAMS)
def test_an_offer_that_changes_or_goes_while_it_waits_is_found_out(array: Scope, prefix: str, tmp_path: Path) -> None:
    waits = array[f"{prefix}_valid"] & ~array[f"{prefix}_ready"]
    at = clock_of(waits & waits.previous(), 1)
    for field in (*(["valid"] if prefix == "m_cm" else []), STREAMS[prefix].split()[-1]):
        name = f"{prefix}_{field}"
        wrong = int(array[name].values[at]) ^ 1
        message = broken(partial(stream_holds, prefix=prefix), array, at, {name: wrong}, tmp_path / "x.vcd", f"{prefix}_*")
        assert f"{array.full(name)} changes" in message


# ---- timers --------------------------------------------------------------------------------------------------------------


def timers_count(tracker: Scope) -> None:
    """TC and TC2 count the ticks of every token that a collecting tracker decides, and nothing else moves them."""
    owns = (tracker["state"] == State.EV_DISCRI) & tracker["token_event"] & (tracker["inside_window"] | tracker["free"])
    owns &= ~tracker["expired"]
    takes = (tracker["state"] == State.EV_NO_PROC) | ((tracker["state"] == State.EV_PROC) & ~tracker["updated"])
    moves = (tracker["state"] == State.EV_PROC) & tracker["updated"]
    loads = tracker["state"] == State.INIT_CELL
    counts = (tracker["state"] == State.EV_DISCRI) & tracker["collecting"]
    after(owns).expect(takes)
    for timer, restarts in (("tc", takes), ("tc2", moves)):
        always(tracker[timer] == (tracker[timer] + tracker["token_tick"]).previous(), where=counts.previous())
        after(restarts).expect(tracker[timer] == 0)
        never(tracker[timer].changed, where=(~counts & ~restarts & ~loads).previous())
    always(tracker["last_tc2"] == tracker["tc2"].previous(), where=moves.previous())


def test_timers_count_ticks_and_restart_at_an_owned_event_and_at_a_new_centre(tracker: Scope) -> None:
    timers_count(tracker)
    sometime((tracker["token_tick"] > 1) & (tracker["state"] == State.EV_DISCRI) & tracker["collecting"])


def test_a_timer_that_does_not_restart_in_the_verilog_is_found_out(config: CotConfig, blobs: Events, tmp_path: Path) -> None:
    """Through the whole way: broken source, build, run, waveform."""
    verilog = copy_rtl(tmp_path / "verilog")
    source = (verilog / "cot.v").read_text()
    restart = "collecting <= 1'b1;\n            tc         <= {TC_W{1'b0}};"
    assert source.count(restart) == 1
    (verilog / "cot.v").write_text(source.replace(restart, restart.partition("\n")[0]))
    one = CotConfig.uniform(replace(config.shape, n_slots=1), config.slots[0], module="cot")
    device = Device(one, verilog=verilog)
    with device.dumping(tmp_path / "run.vcd"):
        device.stream(blobs[:200])
    scope = Scope(Wave.open(tmp_path / "run.vcd", ["TOP.cot.*"]).sampled("TOP.cot.clk"), "TOP.cot")
    states_are_legal(scope)
    with pytest.raises(WaveformError, match=r"expect\(TOP\.cot\.tc == 0\)"):
        timers_count(scope)


ONES = (1 << 9) - 1  # of a bound: two bits more than an address


# ---- windows -------------------------------------------------------------------------------------------------------------


def windows_are_apart(array: Scope) -> int:
    """No two active windows share a pixel, but while one changes or is checked. Returns how often two were active."""
    runs = (array["phase"] == array["RUN"]) & array["settled"] & ~array["checks"]

    def axis(a: int, b: int, name: str) -> Expr:
        def reaches(low: int, high: int) -> Expr:  # the lower bound is stored as its complement
            return array[f"u_match.lo_{name}_not[{low}]"] + array[f"u_match.hi_{name}[{high}]"] >= ONES

        return reaches(a, b) & reaches(b, a)

    return sum(
        never(axis(a, b, "x") & axis(a, b, "y"), where=runs & array["active"].bit(a) & array["active"].bit(b)) for a, b in PAIRS
    )


def test_active_windows_never_overlap_but_while_they_merge(array: Scope) -> None:
    assert windows_are_apart(array) > 1_000
    sometime(array["phase"] != array["RUN"])


def test_windows_that_overlap_are_found_out(array: Scope, tmp_path: Path) -> None:
    runs = (array["phase"] == array["RUN"]) & array["settled"] & ~array["checks"]
    at = clock_of(runs & runs.previous() & array["active"].bit(0) & array["active"].bit(1), 150)
    everywhere = {f"u_match.{bound}[{slot}]": ONES for bound in ("lo_x_not", "lo_y_not", "hi_x", "hi_y") for slot in (0, 1)}
    broken(windows_are_apart, array, at, everywhere, tmp_path / "x.vcd")


NEXT_PHASE = {
    "RUN": {"WALK", "FETCH", "REPORT"},
    "WALK": {"RUN", "REPORT"},
    "FETCH": {"REPORT"},
    "REPORT": {"CLEAR"},
    "CLEAR": {"RUN", "SETTLE"},
    "SETTLE": {"WALK", "JOIN"},
    "JOIN": {"RUN"},
}


def phases_are_legal(array: Scope) -> int:
    code = {name: int(array[name].values[0]) for name in NEXT_PHASE}
    return transitions(array["phase"], {code[start]: {code[end] for end in ends} for start, ends in NEXT_PHASE.items()})


def test_a_merge_goes_through_its_phases_in_order(array: Scope, tmp_path: Path) -> None:
    assert phases_are_legal(array) >= 5
    at = clock_of(array["phase"] == array["FETCH"])
    assert "to 4 at" in broken(phases_are_legal, array, at, {"phase": 4}, tmp_path / "x.vcd")

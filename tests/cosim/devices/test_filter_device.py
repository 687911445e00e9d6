# SPDX-License-Identifier: Apache-2.0
"""The drives of filters and of modules of ready/valid streams: small modules that work, and broken ones found out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.base import HardwareError, Stalls
from support.filter_trials import FilterDevice, FilterTraffic, compare_with_reference, filter_traffic
from support.stream_device import Bundle, StreamDevice, random_pattern, random_stalls
from support.testing import broken_copy

# One register deep; keeps events with x >= threshold, which a port or a register write sets. Busy for 100 clocks after reset.
# `fault` breaks one rule of the streams.
ECHO = """
module echo #(parameter TICK_W = 4) (
    input  wire clk, input wire rst,
    input  wire [7:0] above, input wire [3:0] fault,
    input  wire cfg_valid, input wire [3:0] cfg_addr, input wire [31:0] cfg_data,
    input  wire s_valid, output wire s_ready, input wire [TICK_W-1:0] s_tick, input wire s_event, input wire s_skip,
    input  wire [6:0] s_x, input wire [6:0] s_y, input wire s_p,
    output reg  m_valid, input wire m_ready, output reg [TICK_W-1:0] m_tick, output reg m_event, output reg m_skip,
    output reg  [6:0] m_x, output reg [6:0] m_y, output reg m_p,
    output wire idle
);
    reg [7:0] written;
    reg [6:0] busy;
    wire stays = {1'b0, s_x} >= above && {1'b0, s_x} >= written;
    wire seventh = s_y == 7'd7;
    assign s_ready = (m_ready || !m_valid) && busy == 0 && !(fault == 11 && m_y == 7'd7);
    assign idle = !m_valid && busy == 0;
    always @(posedge clk) begin
        if (busy != 0) busy <= busy - 1;
        if (cfg_valid && cfg_addr == 4'd3) written <= cfg_data[7:0];
        if (m_ready || fault == 9) m_valid <= fault == 8 && m_valid && m_y == 7'd7;
        else if (fault == 10) m_p <= !m_p;
        if (s_valid && s_ready) begin
            m_valid <= !(fault == 7 && seventh);
            m_tick <= s_tick ^ (fault == 1 && seventh);
            m_event <= (s_event || (fault == 5 && s_skip) || fault == 6) && stays;
            m_skip <= (s_skip && fault != 4) || (s_event && !stays);
            m_x <= s_x ^ (fault == 2 && seventh);
            m_y <= s_y;
            m_p <= s_p ^ (fault == 3 && seventh);
        end
        if (rst) begin
            m_valid <= 0;
            written <= 0;
            busy <= 100;
        end
    end
endmodule
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "echo.v").write_text(ECHO)
    return tmp_path


def traffic(n: int = 3000, seed: int = 1) -> FilterTraffic:
    return filter_traffic(np.random.default_rng(seed), n, 128, 100, longest_gap=200, gaps=0.05)


def above(threshold: int, events: FilterTraffic) -> NDArray[np.bool_]:
    return np.asarray(events.x >= threshold)


@pytest.mark.parametrize("tick_w", [1, 4, 20])
def test_tells_which_events_stay(folder: Path, tick_w: int) -> None:
    events = traffic()
    device = FilterDevice("echo", {"TICK_W": tick_w}, {"above": 60}, verilog=folder)
    kept = compare_with_reference(device, events, lambda batch: above(60, batch))
    assert 0.3 < kept < 0.7
    assert not device.stream(replace(events, ticks=events.ticks + device.now), events.keep)[~events.keep].any()
    assert device.now == 2 * events.ticks[-1]


def test_stalls_change_nothing(folder: Path) -> None:
    events = traffic()
    for seed in range(4):
        stalls = Stalls.random(np.random.default_rng(seed))
        device = FilterDevice("echo", {"TICK_W": 4}, {"above": 60}, stalls=stalls, verilog=folder)
        compare_with_reference(device, events, lambda batch: above(60, batch))


def test_ports_stay_through_reset_and_registers_are_written(folder: Path) -> None:
    events = traffic()
    device = FilterDevice("echo", {"TICK_W": 4}, ports={"above": 20}, verilog=folder)
    device.write(2, 127)  # another register
    assert np.array_equal(device.stream(events, events.keep), above(20, events) & events.keep)
    device.write(3, 60)
    device.now = 0
    assert np.array_equal(device.stream(events, events.keep), above(60, events) & events.keep)
    device.reset()
    assert (device.now, device.settled_after) == (0, 100)
    assert np.array_equal(device.stream(events, events.keep), above(20, events) & events.keep)
    device.set(above=90)
    device.now = 0
    assert np.array_equal(device.stream(events, events.keep), above(90, events) & events.keep)


def test_times_are_those_of_the_clocks(folder: Path) -> None:
    events = filter_traffic(np.random.default_rng(2), 100, 128, 100, ticks_per_event=0)
    _, times = FilterDevice("echo", {"TICK_W": 4}, verilog=folder).stream_timed(events, events.keep)
    assert times.accepted.tolist() == list(range(100))
    assert times.given.tolist() == list(range(1, 101))


def test_no_events_at_all(folder: Path) -> None:
    assert len(FilterDevice("echo", {"TICK_W": 4}, verilog=folder).stream(traffic(0))) == 0


def test_exact_names_the_first_difference(folder: Path) -> None:
    events = traffic()
    device = FilterDevice("echo", {"TICK_W": 4}, ports={"above": 60}, verilog=folder)
    i = int(np.flatnonzero((events.x == 60) & events.keep)[0])
    with pytest.raises(AssertionError, match=rf"the first is event {i} .*x 60, .*hardware keeps it"):
        compare_with_reference(device, events, lambda batch: above(61, batch))


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (1, "changed the ticks at event"),
        (2, "changed more than whether it stays, at event"),  # the address
        (3, "changed more than whether it stays, at event"),  # the polarity
        (4, "changed more than whether it stays, at event"),  # a skipped event becomes ticks alone
        (5, "changed more than whether it stays, at event"),  # a skipped event comes back
        (6, "changed more than whether it stays, at event"),  # ticks alone become an event
        (7, "changed|gave"),  # a token is lost
        (8, "changed|gave"),  # a token comes twice
        (9, "withdrew or changed word"),
        (10, "withdrew or changed word"),
        (11, "stands still"),
    ],
)
def test_faults_are_named(folder: Path, fault: int, message: str) -> None:
    stalls = Stalls.random(np.random.default_rng(1), (0.7, 1, 1, 0.7))
    device = FilterDevice("echo", {"TICK_W": 4}, {"above": 60, "fault": fault}, stalls=stalls, verilog=folder)
    with pytest.raises(HardwareError, match=f"echo {message}"):
        device.stream(traffic(), traffic().keep)


def test_traffic_is_what_it_says() -> None:
    events = filter_traffic(np.random.default_rng(5), 20_000, 30, 20, longest_gap=1000, gaps=0.02, skips=0.1, beyond=2)
    assert (np.diff(events.ticks) >= 0).all()
    assert 0 < np.count_nonzero(events.x >= 30) < 1000
    assert events.x.max() == 31
    assert events.y.max() == 21
    assert 500 < np.diff(events.ticks).max() < 1100
    assert 0.05 < 1 - events.keep.mean() < 0.15
    inside = (events.x < 30) & (events.y < 20)
    steps = np.maximum(abs(np.diff(events.x.astype(int))), abs(np.diff(events.y.astype(int))))[inside[1:] & inside[:-1]]
    assert (steps <= 1).mean() > 0.3
    assert len(np.unique(events.x.astype(int) * 100 + events.y)) > 500


IN, OUT = Bundle("s_", ("data",)), Bundle("m_", ("data",))


def queue(verilog: Path | None = None) -> StreamDevice:
    return StreamDevice("fifo", {"W": 8, "DEPTH": 5}, inputs=[IN], outputs=[OUT], verilog=verilog)


def test_words_come_out_with_the_clocks_at_which_they_moved() -> None:
    run = queue().run({"s_": [1, 2, 3]})
    assert run.words["m_"].tolist() == [[1], [2], [3]]
    assert run.accepted["s_"].tolist() == [0, 1, 2]
    assert run.given["m_"].tolist() == [1, 2, 3]


def test_any_number_of_words_under_any_stalls() -> None:
    device = queue()
    for seed in range(5):
        rng = np.random.default_rng(seed)
        device.stalls = random_stalls(rng, ("s_", "m_"))
        words = rng.integers(0, 256, 30_000)
        assert np.array_equal(device.run({"s_": words}).words["m_"][:, 0], words)


def test_a_pattern_says_when_a_stream_goes() -> None:
    device = queue()
    device.stalls = {"s_": np.array([0, 0, 1], np.uint8), "m_": np.array([1, 1, 1, 0], np.uint8)}
    run = device.run({"s_": range(100)})
    assert set(run.accepted["s_"] % 3) == {2}
    assert 3 not in run.given["m_"] % 4


def test_a_run_of_so_many_clocks_leaves_the_rest_for_the_next() -> None:
    device = queue()
    device.stalls = {"m_": np.array([0] * 50 + [1] * 50, np.uint8)}
    first = device.run({"s_": range(20)}, clocks=50)
    assert (first.clocks, len(first.accepted["s_"]), len(first.words["m_"])) == (50, 5, 0)
    rest = device.run({"s_": range(5, 20)}, clocks=50)
    assert rest.words["m_"][:, 0].tolist() == list(range(20))
    assert rest.given["m_"].min() == 50


def test_random_patterns_go_at_least_once() -> None:
    rng = np.random.default_rng(1)
    assert random_pattern(rng, 0.0).sum() == 1
    assert 0.4 < random_pattern(rng, 0.5).mean() < 0.6


def test_the_value_of_a_word_that_does_not_fit_is_refused() -> None:
    with pytest.raises(AssertionError, match="more bits than its port"):
        queue().run({"s_": [256]})


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("m_data = memory[read_reg]", "m_data = memory[read_reg] ^ {7'd0, s_valid}", "fifo withdrew or changed word"),
        (
            "m_valid = level_reg != {LEVEL_W{1'b0}}",
            "m_valid = level_reg > {LEVEL_W{1'b0}} && !s_valid",
            "fifo withdrew or changed",
        ),
        ("s_ready = !full_reg", "s_ready = 1'b0", "fifo stands still"),
    ],
)
def test_a_broken_queue_is_found_out(right: str, wrong: str, message: str, tmp_path: Path) -> None:
    device = queue(broken_copy(tmp_path, "fifo.v", right, wrong))
    device.stalls = {"s_": np.array([1, 0, 1, 1, 0], np.uint8), "m_": np.array([0, 1, 1], np.uint8)}
    with pytest.raises(HardwareError, match=message):
        device.run({"s_": range(200)})

# SPDX-License-Identifier: Apache-2.0
"""overload_fifo.v: which events are dropped, ticks that are preserved all the same, counters that add up."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from support.stream_device import StreamDevice, check_reset, random_stalls
from support.testing import PATTERNS, Sink, Source, always, run_streams
from support.tokens import TOKENS_IN, TOKENS_OUT, decode_tokens

TOP = "overload_fifo"
BEHIND = 4  # events on their way out, behind the queue

# depth, tick_w, gap_w
SHAPES = [(1, 1, 20), (4, 8, 16), (64, 20, 40)]  # 4 and BEHIND are a power of two: held needs a bit more


def parameters(depth: int, tick_w: int, gap_w: int) -> dict[str, int]:
    return {"DEPTH": depth, "TICK_W": tick_w, "GAP_W": gap_w, "X_W": 16, "Y_W": 16}


def device_of(depth: int, tick_w: int, gap_w: int, drop_enable: int = 1) -> StreamDevice:
    ports = {"drop_enable": drop_enable}
    return StreamDevice(
        TOP, parameters(depth, tick_w, gap_w), inputs=[TOKENS_IN], outputs=[TOKENS_OUT], ports=ports, has_idle=True
    )  # fmt: skip


def random_tokens(rng: np.random.Generator, n: int, tick_w: int) -> NDArray[np.uint64]:
    """Tokens of events, skipped events and ticks alone; x and y hold the token's number."""
    kind = rng.choice(3, n, p=[0.7, 0.1, 0.2])
    tick = rng.choice([0, 1, (1 << min(tick_w, 4)) - 1], n)
    number = np.arange(n)
    columns = (tick, kind == 0, kind == 1, number & 0xFFFF, number >> 16, number & 1)
    return np.stack([np.asarray(column, np.uint64) for column in columns], axis=1)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("drop_enable", [0, 1])
def test_reset_amid_tokens_leaves_nothing(shape: tuple[int, int, int], drop_enable: int) -> None:
    device = device_of(*shape, drop_enable)
    check_reset(device, {"s_": random_tokens(np.random.default_rng(1), 100, shape[1])})
    assert device.sim.io.held == 0


class TestStories:
    def test_the_newest_event_is_dropped_and_its_ticks_go_with_the_next(self) -> None:
        device = device_of(5, 8, 16)  # enough for an event a clock
        device.stalls = {"m_": np.array([0] * 25 + [1] * 75, np.uint8)}
        run = device.run({"s_": [[k, 1, 0, k, 0, 1] for k in range(1, 16)]})
        device.stalls = {}
        last = device.run({"s_": [[100, 1, 0, 99, 0, 0]]})
        result = [(tick, x) for tick, _, _, x, _, _ in np.concatenate([run.words["m_"], last.words["m_"]]).tolist()]
        kept = 5 + BEHIND
        assert result[:kept] == [(k, k) for k in range(1, kept + 1)]
        assert sum(tick for tick, _ in result) == sum(range(1, 16)) + 100
        assert result[-1][1] == 99
        io = device.sim.io
        assert (io.n_in, io.n_out, io.n_dropped, io.held) == (16, kept + 1, 15 - kept, 0)

    def test_ticks_alone_take_no_place_while_events_wait(self) -> None:
        device = device_of(3, 8, 16)
        device.stalls = {"m_": np.array([0] * 500 + [1] * 500, np.uint8)}
        tokens = [[1, 0, 0, 0, 0, 0]] * 400 + [[1, 1, 0, 7, 0, 0]]
        result = device.run({"s_": tokens}).words["m_"]
        assert device.sim.io.n_dropped == 0
        assert result[:, 0].sum() == 401
        assert result[-1].tolist()[1:4] == [1, 0, 7]

    def test_ticks_alone_pass_when_nothing_waits(self) -> None:
        device = device_of(3, 8, 16)
        run = device.run({"s_": [[9, 0, 0, 0, 0, 0]]})
        assert run.words["m_"][:, :3].tolist() == [[9, 0, 0]]
        assert run.given["m_"] - run.accepted["s_"] == 7

    @pytest.mark.parametrize("drop_enable", [0, 1])
    def test_time_passes_without_tokens_and_while_an_event_waits(self, drop_enable: int) -> None:
        device = device_of(3, 8, 16, drop_enable=drop_enable)
        device.stalls = {"m_": np.array([0] * 60 + [1] * 940, np.uint8)}
        device.set(s_time=1)
        first = device.run({"s_": [[0, 1, 0, k, 0, 0] for k in range(20)]}, clocks=200)
        device.set(s_time=0)
        rest = device.run({}, clocks=100)
        decoded = decode_tokens(np.concatenate([first.words["m_"], rest.words["m_"]]))
        number = decoded.events[:, 2]
        assert np.array_equal(decoded.at, first.accepted["s_"][number] + 1)
        assert decoded.ticks == 200
        assert (len(number) == 20) == (not drop_enable)

    def test_without_drop_enable_the_source_waits(self) -> None:
        device = device_of(3, 8, 16, drop_enable=0)
        device.stalls = {"m_": np.array([0] * 50 + [1] * 50, np.uint8)}
        tokens = [[k, 1, 0, k, 0, 1] for k in range(40)]
        assert device.run({"s_": tokens}).words["m_"].tolist() == tokens
        assert (device.sim.io.n_in, device.sim.io.n_out, device.sim.io.n_dropped) == (40, 40, 0)


@pytest.mark.parametrize("drop_enable", [0, 1])
@pytest.mark.parametrize("shape", SHAPES)
def test_every_event_that_stays_keeps_its_time(shape: tuple[int, int, int], drop_enable: int) -> None:
    """600,000 tokens in all."""
    depth, tick_w, _ = shape
    device = device_of(*shape, drop_enable=drop_enable)
    for run in range(4):
        rng = np.random.default_rng([81, depth, run])
        device.reset()
        device.stalls = {} if run == 0 else random_stalls(rng, ("s_", "m_"))
        tokens = random_tokens(rng, 25_000, tick_w)
        done = device.run({"s_": tokens})
        sent, decoded = decode_tokens(tokens), decode_tokens(done.words["m_"])
        number = decoded.events[:, 2].astype(np.int64) | decoded.events[:, 3].astype(np.int64) << 16
        assert (np.diff(number) > 0).all()  # in order, none twice
        assert np.array_equal(tokens[number, 1:], decoded.events)
        assert np.array_equal(np.cumsum(tokens[:, 0].astype(np.int64))[number], decoded.at)
        assert decoded.ticks == sent.ticks

        stays = np.zeros(len(tokens), np.bool_)
        stays[number] = True
        dropped = (tokens[:, 1] | tokens[:, 2]).astype(np.bool_) & ~stays
        n_in, io = len(sent.at), device.sim.io
        assert (io.n_in, io.n_out, io.n_dropped, io.held) == (n_in, len(decoded.at), n_in - len(decoded.at), 0)
        assert drop_enable or not dropped.any()

        # Nothing is dropped while there is room: at that clock the queue is full, of events or of ticks that wait alone.
        accepted, given = done.accepted["s_"], done.given["m_"][(done.words["m_"][:, 1] | done.words["m_"][:, 2]) == 1]
        at = accepted[dropped]
        inside = np.searchsorted(accepted[stays], at) - np.searchsorted(given, at)
        assert (inside >= depth - 1).all()
        if run == 0 and depth > 1:
            assert not dropped.any()
        if drop_enable:
            assert set(np.diff(accepted)) == {1} or "s_" in device.stalls  # it never makes the source wait
        print(f"{shape}, drop_enable {drop_enable}: {dropped.sum()} of {n_in} dropped")


@pytest.mark.parametrize("shape", SHAPES)
def test_counters_add_up_at_every_clock(shape: tuple[int, int, int]) -> None:
    depth, tick_w, _ = shape
    sim = device_of(*shape).sim
    rng = np.random.default_rng(82)
    tokens = [tuple(token) for token in random_tokens(rng, 1_500, tick_w).tolist()]
    sink = Sink(sim, "m", TOKENS_OUT.fields, PATTERNS["rarely"](rng))
    dropped = taken = 0

    def check(_clock: int) -> None:
        nonlocal dropped, taken
        io = sim.io
        assert io.n_in == io.n_out + io.n_dropped + io.held
        assert io.n_out == taken  # up to the clock before
        taken = sum(token[1] | token[2] for token in sink.words)
        assert io.held <= depth + BEHIND
        assert dropped == io.n_dropped
        dropped += int(io.dropped)

    run_streams(sim, [Source(sim, "s", TOKENS_IN.fields, tokens, always())], [sink], on_clock=check, quiet_clocks=50)
    assert dropped > 100
    assert sim.io.held == 0


@pytest.mark.parametrize(("every", "stall"), [(1, 40), (2, 80), (5, 300)])
def test_fifo_of_the_sizing_rule_drops_nothing(every: int, stall: int) -> None:
    """docs/hardware.md: FIFO_DEPTH >= r * S + 4, with an event every so many clocks, and a stall of S clocks."""
    events = stall // every

    def dropped(depth: int) -> int:
        sim = device_of(depth, 8, 16).sim
        io = sim.io
        for clock in range(100 + stall + 100):
            io.s_valid, io.s_event = int(clock % every == 0), 1
            io.m_ready = int(not 100 <= clock < 100 + stall)
            sim.clock.tick()
        return int(io.n_dropped)

    assert dropped(events + 4) == 0
    assert dropped(events - BEHIND - 2) > 0


def test_clocks() -> None:
    """A token every clock, 6 clocks later."""
    device = device_of(64, 20, 40)
    run = device.run({"s_": [[1, 1, 0, 0, 0, 0]] * 100})
    assert set(np.diff(run.accepted["s_"])) == {1}
    assert set(run.given["m_"] - run.accepted["s_"]) == {6}

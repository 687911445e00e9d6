# SPDX-License-Identifier: Apache-2.0
"""FIFOs in one clock and between two, and the skid buffer."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import rtl_files
from support.testing import PATTERNS, Sink, Source, always, broken_copy, run_streams

DEPTHS = [1, 5]


@pytest.fixture(params=DEPTHS)
def depth(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture(params=[0, 1])
def block(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture
def sim(depth: int, block: int) -> PyVerilator:
    sim = load("fifo", {"W": 8, "DEPTH": depth, "BLOCK": block})
    reset(sim)
    return sim


@pytest.mark.parametrize("block", [0], indirect=True)
def test_fills_up_to_its_depth_then_empties_in_order(sim: PyVerilator, depth: int) -> None:
    assert (sim.io.m_valid, sim.io.s_ready, sim.io.level) == (0, 1, 0)
    sim.io.s_valid = 1
    for k in range(depth):
        sim.io.s_data = 10 + k
        assert sim.io.s_ready == 1
        sim.clock.tick()
        assert (sim.io.m_valid, sim.io.m_data, sim.io.level) == (1, 10, k + 1)  # the first word has fallen through
    sim.io.s_data = 99
    assert sim.io.s_ready == 0
    sim.clock.tick()
    assert sim.io.level == depth
    sim.io.s_valid, sim.io.m_ready = 0, 1
    for k in range(depth):
        assert (sim.io.m_valid, sim.io.m_data, sim.io.level) == (1, 10 + k, depth - k)
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.level) == (0, 0)


@pytest.mark.parametrize("block", [1], indirect=True)
def test_with_block_ram_one_more_than_its_depth_is_on_offer(sim: PyVerilator, depth: int) -> None:
    sim.io.s_valid = 1
    for k in range(depth + 20):
        sim.io.s_data = k
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.m_data, sim.io.level, sim.io.s_ready) == (1, 0, depth, 0)
    reset(sim)
    assert (sim.io.m_valid, sim.io.s_ready, sim.io.level) == (0, 1, 0)


def test_reset_empties_it(sim: PyVerilator, block: int) -> None:
    latency = 4 if block else 1
    sim.io.s_valid, sim.io.s_data = 1, 7
    for _ in range(latency):
        sim.clock.tick()
    assert sim.io.m_valid == 1
    reset(sim)
    assert (sim.io.m_valid, sim.io.s_ready, sim.io.level) == (0, 1, 0)
    sim.io.s_data = 42
    for _ in range(latency):
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.m_data) == (1, 42)
    assert block or sim.io.level == 1


def test_throughput(sim: PyVerilator, depth: int, block: int) -> None:
    """A word every clock, one clock later, with block RAM four; one in so many clocks when only one word fits."""
    latency = 4 if block else 1
    words = [(k,) for k in range(40)]
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Source(sim, "s", ["data"], words, always())], [sink])
    assert sink.words == words
    apart = 1 if depth > 1 else 4 if block else 2
    assert sink.clocks == [latency + k * apart for k in range(40)]


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("idle", PATTERNS)
def test_traffic_arrives_as_sent(sim: PyVerilator, depth: int, block: int, idle: str, stall: str) -> None:
    rng = np.random.default_rng(3)
    words = [(int(word),) for word in rng.integers(256, size=300)]
    source = Source(sim, "s", ["data"], words, PATTERNS[idle](rng))
    sink = Sink(sim, "m", ["data"], PATTERNS[stall](rng))

    def check_level(_clock: int) -> None:
        inside = source.taken - len(sink.words)
        held = inside - sim.io.m_valid if block else inside  # what block RAM has on offer is out of it
        assert (sim.io.level, sim.io.s_ready) == (held, held < depth)
        assert block or sim.io.m_valid == (held > 0)

    run_streams(sim, [source], [sink], on_clock=check_level)
    assert sink.words == words
    assert (sim.io.level, sim.io.m_valid) == (0, 0)


@pytest.fixture
def skid_buffer_sim() -> PyVerilator:
    skid_buffer_sim = load("skid_buffer", {"W": 8})
    reset(skid_buffer_sim)
    return skid_buffer_sim


def test_skid_buffer_reset_empties_it(skid_buffer_sim: PyVerilator) -> None:
    skid_buffer_sim.clock.tick()
    skid_buffer_sim.io.s_valid, skid_buffer_sim.io.s_data = 1, 7
    skid_buffer_sim.clock.tick()
    skid_buffer_sim.clock.tick()
    assert (skid_buffer_sim.io.m_valid, skid_buffer_sim.io.s_ready) == (1, 0)  # one word on offer, one aside
    skid_buffer_sim.io.s_valid = 0
    reset(skid_buffer_sim, clocks=1)
    assert (skid_buffer_sim.io.m_valid, skid_buffer_sim.io.s_ready) == (0, 0)
    skid_buffer_sim.clock.tick()
    assert (skid_buffer_sim.io.m_valid, skid_buffer_sim.io.s_ready) == (0, 1)


def test_no_input_reaches_an_output_before_the_clock(skid_buffer_sim: PyVerilator) -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        before = (int(skid_buffer_sim.io.s_ready), int(skid_buffer_sim.io.m_valid), int(skid_buffer_sim.io.m_data))
        skid_buffer_sim.io.s_valid, skid_buffer_sim.io.m_ready, skid_buffer_sim.io.s_data = (
            int(v) for v in rng.integers((2, 2, 256))
        )
        assert (skid_buffer_sim.io.s_ready, skid_buffer_sim.io.m_valid, skid_buffer_sim.io.m_data) == before
        skid_buffer_sim.clock.tick()


def test_a_word_every_clock_one_clock_later(skid_buffer_sim: PyVerilator) -> None:
    """s_ready rises one clock after reset, so word k enters at clock k + 1 and leaves at clock k + 2."""
    words = [(k,) for k in range(50)]
    sink = Sink(skid_buffer_sim, "m", ["data"], always())
    run_streams(skid_buffer_sim, [Source(skid_buffer_sim, "s", ["data"], words, always())], [sink])
    assert sink.words == words
    assert sink.clocks == list(range(2, 52))


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("idle", PATTERNS)
def test_skid_buffer_traffic_arrives_as_sent(skid_buffer_sim: PyVerilator, idle: str, stall: str) -> None:
    rng = np.random.default_rng(2)
    words = [(int(word),) for word in rng.integers(256, size=300)]
    source = Source(skid_buffer_sim, "s", ["data"], words, PATTERNS[idle](rng))
    sink = Sink(skid_buffer_sim, "m", ["data"], PATTERNS[stall](rng))
    run_streams(skid_buffer_sim, [source], [sink])
    assert sink.words == words


TOP = "async_fifo"
BENCH = Path(__file__).parents[2] / "support" / "async_fifo_tb.v"
needs_icarus = pytest.mark.skipif(shutil.which("iverilog") is None, reason="needs Icarus Verilog")


def run(folder: Path, file: Path | None = None, **parameters: int) -> str:
    """What the bench prints."""
    files = [file or rtl_files()[f"{TOP}.v"], *(rtl_files()[f"{name}.v"] for name in ("synchronizer", "parameter_check"))]
    given = [f"-P{BENCH.stem}.{name}={value}" for name, value in parameters.items()]
    command = ["iverilog", "-g2005", "-Wall", "-s", BENCH.stem, *given, "-o", folder / "bench", BENCH, *files]
    subprocess.run(command, check=True, capture_output=True)
    return subprocess.run([folder / "bench"], check=True, capture_output=True, text=True).stdout


@needs_icarus
@pytest.mark.parametrize(
    ("s_ps", "m_ps"), [(10_000, 10_000), (10_000, 7_301), (7_301, 10_000), (3_000, 31_007), (31_007, 3_000)]
)
@pytest.mark.parametrize("depth_w", [2, 4])
def test_every_word_comes_once_and_in_order(s_ps: int, m_ps: int, depth_w: int, tmp_path: Path) -> None:
    """10,000 words a case, as fast as possible and with random pauses on both sides."""
    for seed, (given, taken) in enumerate(((8, 8), (3, 8), (8, 3), (5, 5))):
        found = run(
            tmp_path, DEPTH_W=depth_w, S_PS=s_ps, M_PS=m_ps, SEED=seed, IN_OF_8=given, OUT_OF_8=taken, WORDS=2_500,
            STAGES=2 + seed % 3, JITTER_PS=min(s_ps, m_ps) // 10,
        )  # fmt: skip
        assert found.startswith("PASS"), found


@needs_icarus
def test_all_places_are_used_when_the_receiver_is_slow(tmp_path: Path) -> None:
    assert run(tmp_path, OUT_OF_8=1, WORDS=500).split()[:3] == ["PASS", "most", "17"]  # 16, and one in the output register


@needs_icarus
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("wire             push       = s_valid && !full;", "wire push = s_valid;"),
        ("write_gray <= write_code;", "write_gray <= write_next;"),
        ("full       <= write_code == {~read_seen[DEPTH_W:DEPTH_W-1], read_seen[DEPTH_W-2:0]};", "full <= 1'b0;"),
        ("empty     <= read_code == write_seen;", "empty <= 1'b0;"),
        ("wire             moves     = m_ready || !valid_reg;", "wire moves = 1'b1;"),
    ],
)
def test_the_bench_notices_what_is_broken(right: str, wrong: str, tmp_path: Path) -> None:
    broken = broken_copy(tmp_path / "rtl", f"{TOP}.v", right, wrong) / f"{TOP}.v"
    assert run(tmp_path, broken, OUT_OF_8=5).startswith("FAIL")

# SPDX-License-Identifier: Apache-2.0
"""async_fifo.v: every word once and in order between two clocks with jitter, whatever stalls."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from evcot_cosim.rtl.files import rtl_files
from support.testing import broken_copy, lint

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


@pytest.mark.parametrize("depth_w", [2, 4, 9, 16])
def test_lints_clean(depth_w: int) -> None:
    assert lint(TOP, DEPTH_W=depth_w) == (0, "")


@pytest.mark.parametrize(
    ("given", "rule"),
    [
        ({"W": 0}, "W_must_be_at_least_1"),
        ({"DEPTH_W": 1}, "DEPTH_W_must_be_2_to_16"),
        ({"STAGES": 1}, "STAGES_must_be_2_to_4"),
    ],
)
def test_refuses_parameters(given: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **given)
    assert code != 0
    assert rule in log


@needs_icarus
@pytest.mark.parametrize(
    ("s_ps", "m_ps"), [(10_000, 10_000), (10_000, 7_301), (7_301, 10_000), (3_000, 31_007), (31_007, 3_000)]
)
@pytest.mark.parametrize("depth_w", [2, 4])
def test_every_word_comes_once_and_in_order(s_ps: int, m_ps: int, depth_w: int, tmp_path: Path) -> None:
    """20,000 words a case, as fast as possible and with random pauses on both sides."""
    for seed, (given, taken) in enumerate(((8, 8), (3, 8), (8, 3), (5, 5))):
        found = run(
            tmp_path, DEPTH_W=depth_w, S_PS=s_ps, M_PS=m_ps, SEED=seed, IN_OF_8=given, OUT_OF_8=taken, WORDS=5_000,
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

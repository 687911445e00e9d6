# SPDX-License-Identifier: Apache-2.0
"""Test vectors of `evcot_top`: the Verilog bench that comes with them, in Icarus and Verilator, and what it must notice."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.motion.contract import MOTION_RECORD
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig
from evcot.tracks.log import Kind
from evcot_cosim import Vectors
from evcot_cosim.cli import main
from evcot_cosim.rtl.files import search_flags, verilog_dir
from evcot_cosim.rtl.toolchain import find_toolchain
from support.four_state import needs_icarus
from support.moving import QUICK, SHAPE, scene
from support.testing import broken_copy
from support.top import EVERY, SMALL
from support.trials import random_traffic

PACE = ["+stalls=7"]
MOTION = RunConfig(
    hardware=MotionConfig(SHAPE, replace(QUICK, coast_ticks=500)),
    filters=FilterConfig(refractory_us=60, hot_pixels=((100, 10),)),
)


def recorded(ticked: TickedEvents, width: int, height: int, tick_us: int = 1, t0_us: int = 0) -> Recording:
    """The events with their ticks as times."""
    t_us = t0_us + ticked.ticks * tick_us
    return Recording(Events(t_us, ticked.x % width, ticked.y % height, ticked.p), width, height, "ticks")


@cache
def motion() -> Vectors:
    """Boxes behind filters, one of which is lost; their time wraps in 32 bits on the way."""
    return Vectors.of(recorded(scene(29, 600), 128, 64, t0_us=(1 << 32) - 400), MOTION)


@cache
def array() -> Vectors:
    """A record for every event, ticks of 7 us, and no filters."""
    config = replace(CotConfig.uniform(SMALL, EVERY), tick_us=7)
    traffic = random_traffic(np.random.default_rng(5), SMALL, 800, 0.5)
    return Vectors.of(recorded(traffic, 60, 50, tick_us=7, t0_us=3), RunConfig(hardware=config))


@cache
def silent() -> Vectors:
    """One event, of which nothing comes out but itself."""
    events = Events(np.array([5]), np.array([3], np.uint16), np.array([4], np.uint16), np.array([1], np.uint8))
    off = tuple(replace(EVERY, mode=0) for _ in range(SMALL.n_slots))
    return Vectors.of(Recording(events, 60, 50, "one"), RunConfig(hardware=CotConfig(SMALL, off)))


def written(folder: Path, vectors: Vectors) -> Path:
    """The folder with the files of the vectors."""
    for name, text in vectors.files().items():
        (folder / name).write_text(text)
    return folder


def bench(folder: Path, verilog: Path | None = None) -> Callable[..., list[str]]:
    """Compile the bench in Icarus, with the RTL of `rtl.f` or of a folder; returns what runs it and gives its lines."""
    rtl = ["-f", "rtl.f"] if verilog is None else [*search_flags(verilog), "vectors_tb.v"]
    warnings = ["-Wall", "-Wno-sensitivity-entire-array", "-Wno-timescale"]
    command = ["iverilog", "-g2005", *warnings, *rtl, "-s", "vectors_tb", "-o", "tb"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")

    def run(*plus: str) -> list[str]:
        return subprocess.run(["vvp", "tb", *plus], cwd=folder, capture_output=True, text=True, check=True).stdout.splitlines()

    return run


@needs_icarus
@pytest.mark.parametrize("vectors", [motion, array, silent], ids=["motion", "array", "silent"])
def test_the_rtl_passes_the_bench(tmp_path: Path, vectors: Callable[[], Vectors]) -> None:
    made = vectors()
    run = bench(written(tmp_path, made))
    for plus in ([], PACE):
        assert run(*plus)[0] == f"PASS: {len(made.events)} events, {len(made.records)} records"


def test_vectors_cover_what_the_hardware_can_say() -> None:
    kinds = set(motion().records.view(MOTION_RECORD)["kind"].ravel().tolist())
    assert kinds >= {Kind.BORN, Kind.MOVED, Kind.LOST}
    assert min(len(motion().owned), len(motion().passed)) > 50
    assert len(motion().owned) + len(motion().passed) < len(motion().events) - 40  # the filters drop some
    assert (len(silent().owned), len(silent().passed), silent().records.shape) == (0, 1, (0, 6))
    assert len(array().records) > 200


@needs_icarus
@pytest.mark.parametrize(
    ("file", "right", "wrong", "says"),
    [
        ("axis_records_out.v", "= s_cm_x;", "= s_cm_x ^ 1;", "records["),
        ("axis_passed_out.v", "assign m_axis_tdata = word;", "assign m_axis_tdata = word ^ 1;", "passed["),
        ("axis_owned_out.v", "assign m_axis_tkeep = 8'hff;", "assign m_axis_tkeep = 8'h7f;", "owned[0]"),
    ],
    ids=["records", "passed", "owned"],
)  # fmt: skip
def test_a_fault_in_the_rtl_fails(tmp_path: Path, file: str, right: str, wrong: str, says: str) -> None:
    lines = bench(written(tmp_path, array()), broken_copy(tmp_path / "rtl", file, right, wrong))()
    assert lines[0].startswith(says)
    assert any(line.startswith("FAIL: ") for line in lines)


@needs_icarus
def test_a_vector_with_another_bit_fails(tmp_path: Path) -> None:
    run = bench(written(tmp_path, array()))
    for name, says in ("owned.hex", "owned[0]"), ("passed.hex", "passed[0]"), ("records.hex", "records[0]"), ("events.hex", ""):
        path = tmp_path / name
        text = path.read_text()
        first, rest = text.split("\n", 1)
        path.write_text(f"{int(first, 16) ^ 1 << 40:016x}\n{rest}")
        lines = run()
        assert lines[0].startswith(says), name
        assert any(line.startswith("FAIL: ") for line in lines), name
        path.write_text(text)
    assert run()[0].startswith("PASS: ")


@needs_icarus
def test_a_beat_too_few_or_too_many_fails(tmp_path: Path) -> None:
    (only,) = silent().passed
    for passed, says in ([], "passed[0]"), ([only, only], "n_passed[0]"):
        lines = bench(written(tmp_path, replace(silent(), passed=np.array(passed, np.uint64))))()
        assert lines[0].startswith(says)
        assert any(line.startswith("FAIL: ") for line in lines)


@needs_icarus
def test_a_fault_that_only_back_pressure_shows_fails_with_stalls_alone(tmp_path: Path) -> None:
    verilog = broken_copy(tmp_path / "rtl", "axis_records_out.v", ".out_enable   (moves),", ".out_enable   (1'b1),")
    run = bench(written(tmp_path, array()), verilog)
    assert run()[0].startswith("PASS")
    assert run(*PACE)[0].startswith("records[")


def test_verilator_runs_the_bench(tmp_path: Path) -> None:
    folder = written(tmp_path, array())
    tools = find_toolchain()
    command = [
        str(tools.executable),
        "--binary",
        "--timing",
        "-Wno-fatal",
        "--quiet",
        "-f",
        "rtl.f",
        "--top-module",
        "vectors_tb",
    ]
    # The last three: what the Verilator of the Python package does not find out for itself.
    command += ["-CFLAGS", "-std=c++20 -fcoroutines -O0", "-LDFLAGS", "-pthread", "-MAKEFLAGS", "CFG_CXXFLAGS_PCH_I=-include"]
    environment = dict(os.environ) | dict(tools.environment)
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for plus in ([], PACE):
        printed = subprocess.run(["obj_dir/Vvectors_tb", *plus], cwd=folder, capture_output=True, text=True, check=True).stdout
        assert printed.startswith("PASS: "), printed


def test_files_describe_themselves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["vectors", "boxes", "--to", "20", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    folder = Path(said["folder"])
    described = json.loads((folder / "vectors.json").read_text())
    assert described["parameters"] == said["parameters"]
    counts = described["counts"]
    for name, count in (("accesses", counts["N_ACCESSES"]), ("events", counts["N_EVENTS"]), ("owned", counts["N_OWNED"]),
                        ("passed", counts["N_PASSED"]), ("records", counts["N_RECORDS"] * counts["RECORD_BEATS"])):  # fmt: skip
        assert len((folder / f"{name}.hex").read_text().splitlines()) == count, name
    header = (folder / "vectors.vh").read_text()
    assert all(f"localparam {name} = {value};" in header for name, value in (described["parameters"] | counts).items())
    assert str(verilog_dir()) in (folder / "rtl.f").read_text()
    assert main(["vectors", "boxes", "--to", "20", "-q"]) == 0  # its own folder is replaced
    assert main(["vectors", "--config", str(folder / "run.toml"), "-o", "again", "-q"]) == 0
    assert (folder / "records.hex").read_bytes() == Path("again", "records.hex").read_bytes()


def test_what_has_no_vectors_is_refused() -> None:
    recording = recorded(scene(3, 20), 128, 64)
    chain = RunConfig(hardware=CotConfig.uniform(SHAPE, EVERY, module="cot_chain"))
    with pytest.raises(ConfigError, match=r"^hardware = 'cot_chain': must be cot_array or cot_motion for vectors"):
        Vectors.of(recording, chain)
    with pytest.raises(RecordingError, match=r"^empty: holds no events$"):
        Vectors.of(Recording(Events.empty(), 128, 64, "empty"), MOTION)
    with pytest.raises(ConfigError, match=r"^shape.x_w = 7: too few bits for 200 pixels of ticks$"):
        Vectors.of(replace(recording, width=200), MOTION)
    gap = Events(np.array([0, 3 << 30]), *(np.zeros(2, kind) for kind in (np.uint16, np.uint16, np.uint8)))
    with pytest.raises(RecordingError, match=r"^gap: event 1: a gap of 3221225472 us: must be at most 2147483648 for vectors"):
        Vectors.of(Recording(gap, 128, 64, "gap"), MOTION)

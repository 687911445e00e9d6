# SPDX-License-Identifier: Apache-2.0
"""The command line as a user meets it: what a run leaves behind, and one line for everything that can be mended."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import evcot_cosim.rtl.build
from evcot.events import Events, Recording
from evcot.recordings.files import write_recording
from evcot.trackers.presets import PRESETS
from evcot.tracks.log import TrackLog
from evcot_cosim.cli import main
from evcot_cosim.rtl.files import copy_rtl
from support.full_disk import full_disk

from .conftest import Refused

Capture = pytest.CaptureFixture[str]
pytestmark = pytest.mark.usefixtures("home")


def blob(n: int = 6_000, seed: int = 3) -> Recording:
    """Two blobs that move towards each other on a 128x128 sensor, an event every 20 us."""
    random = np.random.default_rng(seed)
    t_us = np.arange(n, dtype=np.int64) * 20
    which = random.integers(2, size=n)
    centre = np.where(which == 0, 30 + 30 * t_us / t_us[-1], 100 - 30 * t_us / t_us[-1])
    x = np.clip(centre + random.normal(0, 3, n), 0, 127).astype(np.uint16)
    y = np.clip(64 + random.normal(0, 3, n), 0, 127).astype(np.uint16)
    return Recording(Events(t_us, x, y, random.integers(2, size=n).astype(np.uint8)), 128, 128, "blob")


@pytest.fixture
def recording(home: Path) -> Path:
    path = home / "blob.npz"
    write_recording(blob(), path)
    return path


CODES = ("kind", "mode", "phase")


def view_files(name: str, codes: tuple[str, ...] = CODES) -> set[str]:
    """A waveform in both formats, its view, and the names that the view gives to codes."""
    return {f"{name}.vcd", f"{name}.fst", f"{name}.gtkw", *(f"{name}-{code}.txt" for code in codes)}


@pytest.mark.parametrize(("preset", "merges", "codes"), [("motion", 0, ("kind", "turn")), ("davis346", 1, CODES)])
def test_a_run_leaves_summary_logs_picture_and_waveform(
    recording: Path, preset: str, merges: int, codes: tuple[str, ...], capsys: Capture
) -> None:
    assert main(["cosim", str(recording), "--preset", preset, "--stalls", "5"]) == 0
    folder = Path("build/cosim/blob")
    assert {path.name for path in folder.iterdir()} == {
        "run.toml", "summary.json", "picture.png", "report.html", *view_files("waves", codes),
        *(f"{engine}.{kind}" for engine in ("hardware", "model", "software") for kind in ("npz", "csv")),
    }  # fmt: skip
    assert not list(Path("build/cosim").glob(".*"))
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["exact"] is True
    assert summary["events"] == 6_000
    assert summary["seed"] == 5
    assert summary["slots"] == (16 if preset == "motion" else 8)
    assert summary["recording_s"] == pytest.approx(0.11998)
    assert summary["cycles"] >= summary["events"]
    assert summary["cycles_per_event"] == pytest.approx(summary["cycles"] / 6_000)
    assert summary["realtime_factor"] == pytest.approx(summary["recording_s"] / summary["wall_s"])
    assert summary["events_per_s"] == pytest.approx(6_000 / summary["wall_s"])
    assert summary["merges"]["hardware"] == summary["merges"]["model"] >= merges
    assert summary["lifetimes"]["hardware"]["tracks"] == summary["births"]["hardware"] > 1
    assert summary["agreement"]["tracks_hardware"] == summary["births"]["hardware"]
    assert summary["command"].startswith("evcot cosim ")

    hardware, model = (TrackLog.load_npz(folder / f"{name}.npz") for name in ("hardware", "model"))
    assert hardware.engine == model.engine == summary["hardware"]
    assert np.array_equal(hardware.records, model.records)
    assert len(hardware.records) == summary["records"]
    table = capsys.readouterr().out
    assert re.search(r"hardware = model +exact: [\d,]+ records and every event's owner", table)
    assert re.search(r"^verdict: The tracks ", table, re.MULTILINE)
    assert re.search(r"^  (good|fair|poor)  tracks hardware +[\d,]+ tracks?, about ", table, re.MULTILINE)
    assert "build/cosim/blob/" in table


def test_without_a_file_the_box_experiment_runs(capsys: Capture) -> None:
    assert main(["cosim", "--json", "--no-waves"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary == json.loads(Path("build/cosim/boxes/summary.json").read_text())
    assert summary["exact"] is True
    assert summary["hardware"] == "cot_motion"
    for side in ("hardware", "software"):
        assert summary["births"][side] >= 9
        assert summary["lifetimes"][side]["lost"] >= 2


@pytest.mark.parametrize("hardware", ["cot", "cot_chain"])
def test_other_hardware_is_checked_too(recording: Path, hardware: str, capsys: Capture) -> None:
    assert main(["cosim", str(recording), "--hardware", hardware, "--slots", "1", "--json", "--no-waves"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["exact"], summary["hardware"], summary["slots"]) == (True, hardware, 1)


def test_a_run_of_no_track_shows_its_first_event() -> None:
    assert main(["cosim", "discs", "--to", "0.1", "--preset", "motion", "-o", "out", "-q"]) == 0
    summary = json.loads(Path("out/summary.json").read_text())
    assert (summary["exact"], summary["agreement"]["tracks_hardware"]) == (True, 0)
    assert "event 0" in Path("out/waves.gtkw").read_text()


def test_waves_of_a_time_window(recording: Path, capsys: Capture, refused: Refused) -> None:
    assert main(["waves", str(recording), "--hardware", "cot_array", "--from", "10", "--to", "11"]) == 0
    assert "events 500 to 549 in build/waves/blob/" in capsys.readouterr().out
    folder = Path("build/waves/blob")
    assert {path.name for path in folder.iterdir()} == {"run.toml", *view_files("waves")}
    assert (folder / "waves.vcd").read_text().count("\n#") >= 2 * 50
    assert refused("waves", "--from", "9000").startswith("waveform from 9000000 us to 9002000 us: no event there")


def test_presets_are_listed(capsys: Capture) -> None:
    assert main(["presets"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows[1:]] == list(PRESETS)
    assert rows[1].endswith("refractory, activity by the noise")
    assert main(["presets", "--json"]) == 0
    slow = json.loads(capsys.readouterr().out)["slow"]["hardware"]
    assert (slow["slots"][0]["clust_nev"], slow["slots"][0]["max_ticks"]) == (8, 20)


def broken_verilog(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, old: str, new: str) -> None:
    """Let builds use a copy of the RTL in which one text stands for another."""
    sources = copy_rtl(tmp_path / "broken")
    text = (sources / file).read_text()
    assert text.count(old) == 1
    (sources / file).write_text(text.replace(old, new))
    monkeypatch.setattr(evcot_cosim.rtl.build, "verilog_dir", lambda: sources)


def test_a_mismatch_is_exit_code_1_and_leaves_its_record_and_waveform(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    broken_verilog(tmp_path, monkeypatch, "array_order.v", "|(at & ~behind)", "|(at & behind)")
    assert main(["cosim", str(recording), "--preset", "davis346", "--stalls", "9"]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert re.search(r"MISMATCH: cot_array: event \d+, tick \d+: record\.\w+: hardware has \d+, model has \d+", printed.err)
    folder = Path("build/cosim/blob")
    assert {path.name for path in folder.iterdir()} == {
        "run.toml", "summary.json", "report.html", "hardware.npz", "model.npz", *view_files("mismatch"),
    }  # fmt: skip
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["exact"] is False
    found = summary["mismatch"]
    assert found["seed"] == 9
    assert found["hardware"] != found["model"]
    assert found["config"]["tick_us"] == 1
    assert f"event {found['event_index']}, tick {found['tick']}: {found['field']}" in printed.err


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("nothing.aedat4", None, "nothing.aedat4: cannot be read: No such file or directory"),
        ("what.bin", b"\x00\x01\x02\x03" * 9, "what.bin: "),
    ],
)  # fmt: skip
def test_a_bad_file(name: str, content: bytes | None, message: str, refused: Refused) -> None:
    if content is not None:
        Path(name).write_bytes(content)
    assert refused("cosim", name).startswith(message)


def test_a_name_with_a_line_break_and_codes_for_a_terminal_is_told_in_one_line(capsys: Capture) -> None:
    assert main(["info", "a\nb\x1b[31m.raw"]) == 2
    assert capsys.readouterr().err == "evcot: a\\nb\\x1b[31m.raw: cannot be read: No such file or directory\n"


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("[cot]\ninit_cm_x = 128", "run.toml: cot.slot[0].init_cm_x = 128: must be an integer from 0 to 127"),
        ("[shape]\nn_slots = 65", "run.toml: shape.n_slots = 65: must be an integer from 1 to 64"),
        ("[shape]\nn_slots = 1\n[[slot]]\n[[slot]]", "run.toml: [[slot]] occurs 2 times: must be at most shape.n_slots = 1"),
        ("[shape]\nx_w = 6", "shape.x_w = 6: too few bits for 128 pixels of blob"),
        ("[cot", "run.toml: is not TOML: "),
    ],
)
def test_a_bad_configuration(recording: Path, toml: str, message: str, refused: Refused) -> None:
    Path("run.toml").write_text(toml)
    assert refused("cosim", str(recording), "--config", "run.toml").startswith(message)


def test_no_simulator(recording: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused) -> None:
    monkeypatch.setenv("VERILATOR", "/nowhere/verilator")
    assert refused("cosim", str(recording)).startswith("$VERILATOR is /nowhere/verilator, which is not an executable")


def test_no_compiler(recording: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    assert "g++ (install the g++ package)" in refused("cosim", str(recording))


def test_rtl_that_does_not_build(recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused) -> None:
    broken_verilog(tmp_path, monkeypatch, "cot_array.v", "module cot_array #(", "module cot_array ((")
    assert re.search(
        r"^cannot build cot_array .*%Error: .*cot_array\.v:\d+", refused("cosim", str(recording), "--preset", "dvs128")
    )


def test_an_unwritable_folder(recording: Path, refused: Refused) -> None:
    Path("taken").write_text("a file where a folder should be")
    said = refused("cosim", str(recording), "-o", "taken/run", "--quiet")
    assert re.fullmatch(r"-o taken/\S*: cannot be written: Not a directory", said)


def test_a_full_disk_leaves_nothing_that_looks_whole(recording: Path, capsys: Capture) -> None:
    assert main(["cosim", str(recording), "-o", "before", "--quiet"]) == 0  # Numba's cache is full from here on
    assert capsys.readouterr() == ("", "")
    with full_disk(20_000):
        run = subprocess.run(
            [sys.executable, "-m", "evcot_cosim", "cosim", str(recording)],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    assert (run.returncode, run.stdout) == (2, "")
    assert re.fullmatch(r"evcot: build/cosim/blob/[\w.]+: cannot be written: File too large\n", run.stderr)
    assert not Path("build").exists()


def interrupt(module: str, *arguments: str, after_s: float = 0.0) -> None:
    """Interrupt the command so long after it has imported a module: it says so in one line, and has written nothing."""
    command = [sys.executable, "-X", "importtime", "-m", "evcot_cosim", *arguments]
    with subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        assert run.stderr is not None
        while not run.stderr.readline().rstrip().endswith(f" {module}"):
            assert run.poll() is None
        time.sleep(after_s)
        os.kill(run.pid, signal.SIGINT)
        out, err = run.communicate(timeout=120)
    told = [line for line in err.splitlines() if not line.startswith(("import time:", "evcot: compiling"))]
    assert (run.returncode, out, told) == (2, "", ["evcot: interrupted: nothing was written"])


def test_an_interrupt_leaves_nothing_that_looks_whole(home: Path) -> None:
    write_recording(blob(4_000_000), Path("long.npz"))
    interrupt("evcot_cosim.commands.actions.progress", "cosim", "long.npz", "--hardware", "cot_chain", after_s=2.0)
    assert not list(Path().glob("build/*/*"))
    interrupt("evcot.errors", "presets")  # while the program loads

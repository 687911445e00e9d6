# SPDX-License-Identifier: Apache-2.0
"""A run that is not held in memory says what one in memory says, continues where it was killed, and grows with nothing."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.outputs import own_files
from evcot.recordings.files import write_recording
from evcot.scenes.registry import simulate_scene
from evcot.tracks.log import TrackLog
from evcot_cosim.cli import main

pytest.importorskip("pyarrow")

_TIMES = ("wall_s", "realtime_factor", "events_per_s", "software_events_per_s", "build", "command", "parts")
# What makes a run of some ten thousand events a long one; in a process of its own, too, which may end itself.
_SMALL = """
import os, signal, sys
import evcot_cosim.commands.actions.cosim as action, evcot_cosim.report.part_pages as parts
import evcot_cosim.lockstep.cosim as runs, evcot.unfinished as unfinished
from evcot_cosim.cli import main
action.EVENTS_MAX, parts.PART_EVENTS, runs.CHUNK = 9_000, 4_000, 2_000
saves, save = [], unfinished.Unfinished.save
def counted(work, state):
    save(work, state)
    saves.append(state)
    if len(saves) == int(sys.argv[1]):
        os.kill(os.getpid(), signal.SIGKILL)
unfinished.Unfinished.save = counted
sys.exit(main(sys.argv[2:]))
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("long") / "discs.npz"
    write_recording(simulate_scene("discs", 5, {"duration_us": 250_000}).recording, path)
    return path


@pytest.fixture(scope="module")
def runs(recorded: Path) -> Path:
    """The same recording in memory, in parts, and in parts after being killed twice."""
    folder = recorded.parent
    common = ["cosim", str(recorded), "--preset", "discs", "--no-waves", "-q", "--stalls", "3"]
    assert main([*common, "-o", str(folder / "short")]) == 0
    for name, kill_at in (("long", 0), ("killed", 2), ("killed", 1), ("killed", 0)):
        command = [sys.executable, "-c", _SMALL, str(kill_at), *common[:-3], "--stalls", "3", "--checkpoint", "4000"]
        done = subprocess.run(
            [*command, "-o", str(folder / name)], env={**os.environ}, capture_output=True, text=True, check=False, timeout=500
        )
        assert done.returncode == (-signal.SIGKILL if kill_at else 0), done.stderr
        if name == "killed":
            assert (folder / ".killed.unfinished").exists() == bool(kill_at)
            said = re.search(r"continues after ([0-9,]+) events", done.stderr)
            assert (said[1] if said else None) == {2: None, 1: "8,000", 0: "12,000"}[kill_at]
    return folder


def summary(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return found


def test_a_long_run_says_what_a_short_one_says(runs: Path) -> None:
    short, long = summary(runs / "short"), summary(runs / "long")
    assert short["events"] > 9_000 + 4 * 4_000
    for figures in (short, long):
        for name in ("model",):
            for by_engine in ("births", "merges", "lifetimes", "owned_fraction"):
                figures[by_engine].pop(name, None)
    clocks = {"cycles", "cycles_per_event", "latency_clocks"}  # a run in memory is driven in larger chunks
    for key in short.keys() - {*_TIMES, *clocks, "verdict"}:
        assert long[key] == short[key], key
    assert long["verdict"]["headline"] == short["verdict"]["headline"]
    for name in ("hardware", "software"):
        one, other = TrackLog.load(runs / "short" / f"{name}.npz"), TrackLog.load(runs / "long" / f"{name}.parquet")
        assert np.array_equal(one.records, other.records)
        assert np.array_equal(one.owner, other.owner)
        assert (one.engine, one.recording) == (other.engine, other.recording)


def test_a_killed_run_is_the_unbroken_one_bit_for_bit(runs: Path) -> None:
    for name in ("hardware.parquet", "software.parquet"):
        assert (runs / "killed" / name).read_bytes() == (runs / "long" / name).read_bytes()
    killed, long = summary(runs / "killed"), summary(runs / "long")
    assert killed["parts"] == long["parts"]
    assert {key: killed[key] for key in killed.keys() - set(_TIMES)} == {key: long[key] for key in long.keys() - set(_TIMES)}


def test_every_part_has_a_page_beside_the_overview(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = runs / "long"
    parts = summary(folder)["parts"]
    assert len(parts) > 5
    assert sum(part["events"] for part in parts) == summary(folder)["events"]
    assert sum(part["births_hardware"] for part in parts) == summary(folder)["births"]["hardware"]
    page = (folder / "report.html").read_text()
    for part in parts:
        assert part["page"] in page
        assert "<title>discs, " in (folder / part["page"]).read_text()
    assert own_files(folder) == {path.name for path in folder.iterdir()}
    capsys.readouterr()
    assert main(["report", str(folder), "-q"]) == 0
    assert (folder / "report.html").read_text() == page
    assert main(["report", str(folder), "-o", str(runs / "other.html")]) == 2
    assert "its pages are beside its report" in capsys.readouterr().err
    assert main(["evaluate", str(folder), "--truth", str(runs / "none.csv")]) == 2
    assert "none.csv" in capsys.readouterr().err


def test_a_run_whose_pages_cannot_be_written_goes_on_without_simulating_again(
    runs: Path, recorded: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The last step of a run may find the disk full, hours after the first event."""
    for name, value in {"commands.actions.cosim.EVENTS_MAX": 9_000, "report.part_pages.PART_EVENTS": 4_000}.items():
        monkeypatch.setattr(f"evcot_cosim.{name}", value)
    monkeypatch.setattr("evcot_cosim.lockstep.cosim.CHUNK", 2_000)
    command = ["cosim", str(recorded), "--preset", "discs", "--no-waves", "-q", "--stalls", "3"]
    command += ["--checkpoint", "4000", "-o", str(runs / "full")]

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.EFBIG, "File too large", str(runs / "full" / "report.html"))

    with monkeypatch.context() as patched:
        patched.setattr("evcot_cosim.report.long_run.write_overview", full)
        assert main(command) == 2
    assert not (runs / "full").exists()
    assert capsys.readouterr().err == (
        f"evcot: {runs}/full: cannot be written: {runs}/full/report.html: File too large; remove the cause and give the same "
        f"command again: it goes on from its last checkpoint (kept in {runs}/.full.unfinished)\n"
    )

    monkeypatch.delattr("evcot_cosim.lockstep.lockstep.Lockstep.feed")
    assert main([word for word in command if word != "-q"]) == 0
    assert f"continues after {summary(runs / 'long')['events']:,} events" in capsys.readouterr().err
    for name in ("hardware.parquet", "software.parquet"):
        assert (runs / "full" / name).read_bytes() == (runs / "long" / name).read_bytes()
    assert summary(runs / "full")["parts"] == summary(runs / "long")["parts"]
    assert not (runs / ".full.unfinished").exists()


@pytest.mark.parametrize("name", ["part-00002.html", "part-123456.html", "software.1.parquet"])
def test_a_file_of_the_user_is_found_before_the_run(
    name: str, runs: Path, recorded: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("evcot_cosim.commands.actions.cosim.EVENTS_MAX", 9_000)
    monkeypatch.delattr("evcot_cosim.lockstep.lockstep.Lockstep.feed")
    folder = runs / f"mine {name}"
    shutil.copytree(runs / "short", folder)
    (folder / name).write_text("mine")
    assert main(["cosim", str(recorded), "--preset", "discs", "--no-waves", "-o", str(folder)]) == 2
    assert f"-o {folder}: holds {name}, which evcot did not write" in capsys.readouterr().err
    assert (folder / name).read_text() == "mine"


def test_long_logs_alone_have_a_report_in_parts(
    runs: Path, recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of Parquet and npz, of one log and of two, they say of each part what the run says."""
    monkeypatch.setattr("evcot_cosim.commands.actions.report.EVENTS_MAX", 9_000)
    monkeypatch.setattr("evcot_cosim.report.part_pages.PART_EVENTS", 4_000)
    monkeypatch.chdir(tmp_path)
    long, wanted = runs / "long", summary(runs / "long")["parts"]
    TrackLog.load(long / "software.parquet").save("software.npz")
    both = ["report", str(long / "hardware.parquet"), "software.npz", "--recording", str(recorded), "-q"]
    assert main([*both, "-o", "both.html"]) == 0
    text = Path("both.html").read_text()
    found = json.loads(re.search(r'id="facts">(.*?)</script>', text)[1])  # type: ignore[index]
    assert [side["name"] for side in found["sides"]] == ["hardware", "rct"]
    for part, of_run in zip(found["parts"], wanted, strict=True):
        assert part["page"] == f"both.parts/{of_run['page']}"
        assert "<title>discs, " in Path(part["page"]).read_text()
        assert (part["births_hardware"], part["births_rct"]) == (of_run["births_hardware"], of_run["births_software"])
        assert (part["from_us"], part["to_us"], part["events"]) == (of_run["from_us"], of_run["to_us"], of_run["events"])
    assert {path.name for path in Path("both.parts").iterdir()} == {*(part["page"] for part in wanted), "run.toml"}
    assert "Agreement" not in text

    assert main([*both, "-o", "both.html"]) == 2
    assert "both.html: exists: must be another file" in capsys.readouterr().err
    Path("both.parts/part-00001.html").write_text("mine")
    assert main([*both, "-o", "both.html", "--force"]) == 2
    assert "both.parts: holds part-00001.html, which evcot did not write" in capsys.readouterr().err
    assert main(["report", "software.npz", "--recording", str(recorded), "--truth", "software.npz", "-o", "x.html"]) == 2
    assert f"{recorded}: has more than 9000 events" in capsys.readouterr().err
    other = ["report", "software.npz", "--recording", str(recorded), "--to", "200", "-o", "x.html"]
    assert main(other) == 2
    assert "software.npz: does not belong to" in capsys.readouterr().err
    assert not Path("x.html").exists()
    assert not Path("x.parts").exists()

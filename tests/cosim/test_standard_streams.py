# SPDX-License-Identifier: Apache-2.0
"""`-` as a file to read or to write, as a user meets it: behind pipes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.errors import RecordingError
from evcot.recordings.files import read_recording
from evcot.tracks.log import TrackLog
from evcot_cosim.cli import main
from evcot_cosim.lockstep.run_file import read_run_file
from evcot_cosim.standard_streams import STANDARD_INPUT, as_file, begin_command

TRUTH = "t_us,object_id,left,top,width,height,vx,vy,visible,occluded\n0,0,10,20,30,40,100,0,1,0\n"
SPEC = 'recordings = ["drive.npz"]\nengines = ["rct"]\npreset = "discs"\n'


@pytest.fixture(autouse=True)
def drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording of half a second and its log; temporary files of the commands are in `spool`."""
    monkeypatch.chdir(tmp_path)
    Path("spool").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "spool"))
    recording = evcot.simulate("discs", seed=1, duration_us=500_000).recording
    evcot.write(recording, "drive.npz")
    evcot.track(recording, "rct", "discs").save("log.npz")
    return tmp_path


def piped(content: bytes, *arguments: str) -> subprocess.CompletedProcess[bytes]:
    done = subprocess.run([sys.executable, "-m", "evcot_cosim", *arguments], input=content, capture_output=True)
    assert list(Path("spool").iterdir()) == []
    return done


def fed(content: bytes, *arguments: str) -> int:
    """The exit code of a command in this process, with this on standard input."""
    Path("fed").write_bytes(content)
    with pytest.MonkeyPatch.context() as patch, open("fed") as file:
        patch.setattr("sys.stdin", file)
        return main(list(arguments))


def test_a_run_of_standard_input_is_repeated_from_the_same_events_alone() -> None:
    events = Path("drive.npz").read_bytes()
    assert piped(events, "cosim", "-", "-o", "run", "-q", "--no-waves").returncode == 0
    described = read_run_file(Path("run/run.toml"))
    assert described is not None
    assert (described.source.recording, described.source.name) == ("/dev/stdin", "stdin")
    assert piped(events, "cosim", "--config", "run/run.toml", "-o", "again", "-q", "--no-waves").returncode == 0
    np.testing.assert_array_equal(TrackLog.load("again/hardware.npz").records, TrackLog.load("run/hardware.npz").records)
    assert piped(events, "report", "run", "-o", "page.html", "-q").returncode == 0
    evcot.write(read_recording("drive.npz", to_us=300_000), "other.npz")
    done = piped(Path("other.npz").read_bytes(), "cosim", "--config", "run/run.toml", "-o", "third", "-q")
    assert done.returncode == 2
    assert b"must be that of /dev/stdin, which has changed since" in done.stderr


@pytest.mark.parametrize("arguments", [("-", "--recording", "drive.npz"), ("log.npz", "--recording", "-")])
def test_report_reads_log_or_recording_and_writes_only_the_page(arguments: tuple[str, ...]) -> None:
    content = Path("log.npz" if arguments[0] == "-" else "drive.npz").read_bytes()
    done = piped(content, "report", *arguments, "-o", "-")
    assert (done.returncode, done.stdout[:15], done.stdout[-8:]) == (0, b"<!doctype html>", b"</html>\n")
    assert done.stderr.startswith(b"/dev/stdout: ")


def test_sweep_reads_its_specification() -> None:
    done = piped(SPEC.encode(), "sweep", "-", "--dry-run")
    assert done.returncode == 0
    assert [line.split() for line in done.stdout.splitlines()[:3]] == [[b"name", b"stdin"], [b"inputs", b"1"], [b"runs", b"1"]]


def test_evaluate_reads_log_or_truth() -> None:
    Path("truth.csv").write_text(TRUTH)
    for content, log, truth in ((Path("log.npz").read_bytes(), "-", "truth.csv"), (TRUTH.encode(), "log.npz", "-")):
        done = piped(content, "evaluate", log, "--truth", truth)
        assert (done.returncode, done.stdout[:4]) == (0, b"HOTA"), done.stderr


def test_config_is_read_as_often_as_needed() -> None:
    done = piped(b"[motion]\ngain_log2 = 3\n", "cosim", "drive.npz", "--config", "-", "--print-config")
    assert b"gain_log2 = 3" in done.stdout


def test_a_log_on_standard_output_is_not_mixed_with_the_table() -> None:
    done = piped(b"", "track", "drive.npz", "--engine", "rct", "--preset", "discs", "-o", "-")
    Path("piped.npz").write_bytes(done.stdout)
    np.testing.assert_array_equal(TrackLog.load("piped.npz").records, TrackLog.load("log.npz").records)
    assert b"tracks" in done.stderr


def test_a_full_disk_is_reported_with_what_would_help(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("shutil.copyfileobj", full)
    begin_command()
    with open("/dev/null") as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        with pytest.raises(RecordingError, match=r"No space left on device: must have room .*TMPDIR"):
            as_file(STANDARD_INPUT)


def test_a_folder_cannot_be_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("cosim", "sweep", "waves", "vectors"):
        with pytest.raises(SystemExit, match="2"):
            main([command, "drive.npz", "-o", "-"])
        assert "-: must be a folder, which standard output is not" in capsys.readouterr().err
    assert not Path("-").exists()


@pytest.mark.parametrize("command", ["info", "track", "cosim", "evaluate", "anomalies"])
def test_an_error_names_standard_input_and_not_its_copy(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("truth.csv").write_text(TRUTH)
    assert fed(b"x,y\n1,2\n", command, "-", *(["--truth", "truth.csv"] if command == "evaluate" else [])) == 2
    assert capsys.readouterr().err.startswith("evcot: /dev/stdin: ")


def test_every_reader_of_logs_takes_standard_input() -> None:
    log = Path("log.npz").read_bytes()
    for arguments in (
        ("anomalies", "-"),
        ("boxes", "-", "boxes.txt", "--frame-us", "10000"),
        ("plot", "drive.npz", "-", "-o", "plot.png"),
        ("render", "drive.npz", "-", "-o", "film.gif", "--fps", "4"),
    ):
        assert fed(log, *arguments) == 0, arguments
    for recording in (("anomalies", "log.npz", "--recording", "-"), ("plot", "-", "log.npz", "-o", "again.png")):
        assert fed(Path("drive.npz").read_bytes(), *recording) == 0, recording


def test_commands_without_an_option_for_the_format_write_npz_on_standard_output() -> None:
    original = read_recording("drive.npz")
    Path("piped.npz").write_bytes(piped(b"", "filter", "drive.npz", "-", "--region", "0,0,345,259").stdout)
    np.testing.assert_array_equal(read_recording("piped.npz").events.t_us, original.events.t_us)
    Path("scene.npz").write_bytes(piped(b"", "simulate", "boxes", "-o", "-", "--duration", "0.1", "--truth", "t.csv").stdout)
    assert len(read_recording("scene.npz").events)
    assert Path("t.csv").exists()


def test_a_scene_on_standard_output_needs_a_place_for_its_truth() -> None:
    done = piped(b"", "simulate", "boxes", "-o", "-")
    assert (done.returncode, done.stderr) == (
        2,
        b"evcot: --truth: must be given with -o -: standard output has no folder for it\n",
    )

# SPDX-License-Identifier: Apache-2.0
"""`evcot live`: from a source to figures, a recording and a log."""

from __future__ import annotations

import json
import os
import pty
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import evcot
from evcot.recordings.files import read_recording, write_recording
from evcot.scenes.registry import simulate_scene
from evcot.tracks.log import TrackLog
from evcot_cosim.cli import main
from evcot_cosim.commands.actions import live as action
from support.sweeping import until

from ..conftest import Refused

DURATION_US = 400_000


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four discs for 0.4 s."""
    path = tmp_path_factory.mktemp("live") / "discs.aedat4"
    write_recording(simulate_scene("discs", 5, {"duration_us": DURATION_US}).recording, path)
    return path


@pytest.fixture
def source(recorded: Path, home: Path) -> Path:
    """The same; the working folder is empty."""
    return recorded


def lines(text: str) -> list[dict[str, object]]:
    return [json.loads(line) for line in text.splitlines()]


def test_a_file_leaves_the_recording_and_the_log_that_the_tracker_alone_would(
    source: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["live", str(source), "--speed", "0.5", "--save", "a.aedat4", "--save-log", "a.npz", "--json"]) == 0
    result = lines(capsys.readouterr().out)
    first, *figures, last = (line["kind"] for line in result)
    assert (first, set(figures), last) == ("start", {"figures"}, "summary")
    recording = read_recording(source)
    saved, log, wanted = read_recording("a.aedat4"), TrackLog.load_npz("a.npz"), evcot.track(recording)
    assert np.array_equal(saved.events.t_us, recording.events.t_us)
    assert result[-1]["events"] == result[-1]["saved"] == len(recording.events) == len(log.owner)
    if result[-1]["dropped"] == 0:
        assert np.array_equal(log.records, wanted.records)
        assert np.array_equal(log.owner, wanted.owner)
    assert result[-1]["recording_s"] == pytest.approx(DURATION_US / 1e6, rel=0.05)


def test_in_a_pipe_it_says_only_what_was_found(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["live", str(source), "--engine", "rct", "--preset", "discs", "--activity", "5"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert printed.out.startswith("events ")
    assert "event to tracked" in printed.out
    assert main(["live", str(source), "-q", "--to", "50"]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_terminal_sees_why_it_waits_for_the_first_event(source: Path) -> None:
    command = [sys.executable, "-m", "evcot_cosim", "live", str(source), "--for", "0.1"]
    ours, theirs = pty.openpty()
    subprocess.run(command, stdout=subprocess.PIPE, stderr=theirs, env={**os.environ, "TERM": "xterm"}, check=True)
    os.close(theirs)
    assert "preparing cot_motion (compiled the first time, up to a minute)" in os.read(ours, 100_000).decode()
    os.close(ours)


def test_it_stops_when_its_time_is_over(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["live", str(source), "--speed", "0.01", "--for", "0.5", "--json"]) == 0
    summary = lines(capsys.readouterr().out)[-1]
    assert summary["kind"] == "summary"
    assert 0 < summary["events"] < 0.2 * len(read_recording(source).events)  # type: ignore[operator]


@pytest.mark.parametrize("which", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_it_cleanly(source: Path, which: signal.Signals) -> None:
    command = [sys.executable, "-m", "evcot_cosim", "live", str(source), "--speed", "0.01", "--json"]
    command += ["--save", "a.raw", "--save-log", "a.npz"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as live:
        assert live.stdout is not None
        assert json.loads(live.stdout.readline())["kind"] == "start"
        assert json.loads(live.stdout.readline())["kind"] == "figures"
        live.send_signal(which)
        out, err = live.communicate(timeout=30)
    assert live.returncode == 0
    assert err == ""
    summary = lines(out)[-1]
    assert summary["kind"] == "summary"
    assert len(read_recording("a.raw").events) == len(TrackLog.load_npz("a.npz").owner) == summary["saved"]


def test_an_open_page_may_see_a_file_again_after_its_end(source: Path) -> None:
    client = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    command = [sys.executable, "-m", "evcot_cosim", "live", str(source), "--speed", "0.1", "--web", "0", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as live:
        assert live.stdout is not None
        page = json.loads(live.stdout.readline())["page"]
        with client.connect(page.replace("http", "ws") + "events", origin=page.rstrip("/"), compression=None) as connection:

            def next_text(kind: str) -> dict[str, object]:
                while isinstance(message := connection.recv(timeout=60), bytes) or json.loads(message)["type"] != kind:
                    if isinstance(message, bytes):
                        connection.send(b"\x02\0\0\0" + message[4:8])
                return json.loads(message)

            assert next_text("hello")["changes"]
            while (told := next_text("figures"))["running"]:
                pass
            assert told["length_s"] == pytest.approx(DURATION_US / 1e6, rel=0.05)
            assert told["place_s"] == told["length_s"]
            wish = {"type": "play", "engine": "cot_motion", "preset": None, "hardware": True, "at_s": 0.2}
            connection.send(json.dumps(wish))
            hello = next_text("hello")
            assert (hello["engine"], hello["lanes"]) == ("cot_motion", ["cot_motion", "hardware"])
            assert hello["kinds"] == ["model", "hardware"]
            while (told := next_text("figures"))["running"]:
                pass
            assert told["recording_s"] == pytest.approx(0.2, abs=0.03)
            (beside,) = told["beside"]
            assert beside["about"].partition(";")[0] in ("RTL in simulation", "golden model")
            assert beside["tracks"] > 0
        out, _ = live.communicate(timeout=30)  # nobody looks any more
    assert live.returncode == 0
    assert lines(out)[-1]["kind"] == "summary"


@pytest.mark.parametrize(("terminal", "patience_s", "comes"), [(True, 60.0, True), (True, 0.2, False), (False, 60.0, False)])
def test_a_person_at_a_terminal_may_open_the_first_page_after_the_end_of_a_file(
    terminal: bool, patience_s: float, comes: bool, source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    said: list[dict[str, Any]] = []
    monkeypatch.setattr(action, "_print_line", said.append)
    monkeypatch.setattr(action, "_PAGE_S", patience_s)
    monkeypatch.setattr(action, "Console", lambda: Console(force_terminal=terminal))
    opened = threading.Event()
    count = len(read_recording(source).window(0, 50_000).events)

    def open_late() -> None:
        until(lambda: any(line["kind"] == "figures" and line["events"] == count for line in said), "the end of the file")
        page = said[0]["page"]
        with client.connect(page.replace("http", "ws") + "events", origin=page.rstrip("/"), compression=None):
            opened.set()

    person = threading.Thread(target=open_late if comes else int)
    person.start()
    assert main(["live", str(source), "--to", "50", "--web", "0", "--json"]) == 0
    person.join()
    assert opened.is_set() == comes
    assert said[-1]["kind"] == "summary"


def test_hardware_runs_beside_the_engine(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["live", str(source), "--with-hardware", "--speed", "0.2", "--save-log", "a.npz", "--json"]) == 0
    summary = lines(capsys.readouterr().out)[-1]
    (beside,) = summary["beside"]  # type: ignore[misc]
    assert beside["name"] == "hardware"
    assert beside["tracks"] > 0
    assert TrackLog.load_npz("a.npz").engine == "cot_motion"


# In a process of its own: taken down, dv-processing's writer may wait for ever.
DV_SERVER = """
import sys, time
import dv_processing as dv
from evcot.recordings.files import read_recording
recording = read_recording(sys.argv[2])
stream = dv.io.Stream.EventStream(0, "events", "PRESSED", (recording.width, recording.height))
writer = dv.io.NetworkWriter("127.0.0.1", int(sys.argv[1]), stream)
events = recording.events
print("listening", flush=True)
while not writer.getClientCount():
    time.sleep(0.01)
for begin in range(0, len(events), 500):
    part, store = events[begin : begin + 500], dv.EventStore()
    for t_us, x, y, p in zip(part.t_us.tolist(), part.x.tolist(), part.y.tolist(), part.p.tolist()):
        store.push_back(t_us, x, y, bool(p))
    writer.writeEvents(store)
    time.sleep(0.002)
time.sleep(60)
"""


def test_dv_processing_s_stream(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("dv_processing", reason="dv-processing is not installed")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with subprocess.Popen([sys.executable, "-c", DV_SERVER, str(port), str(source)], stdout=subprocess.PIPE) as sender:
        try:
            assert sender.stdout is not None
            assert sender.stdout.readline() == b"listening\n"
            assert main(["live", f"tcp://127.0.0.1:{port}", "--for", "4", "--json", "--save", "a.aedat4"]) == 0
        finally:
            sender.kill()
    result = lines(capsys.readouterr().out)
    assert result[0]["source"] == f"PRESSED at tcp://127.0.0.1:{port}"
    saved, whole = read_recording("a.aedat4").events, read_recording(source).events
    assert len(saved) == result[-1]["events"] > 1_000
    for name in ("t_us", "x", "y", "p"):
        assert np.array_equal(getattr(saved, name), getattr(whole, name)[: len(saved)])
    assert result[-1]["tracks"] >= 4  # type: ignore[operator]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("{source} --speed 0", "--speed 0: must be from 0.001 to 1000"),
        ("{source} --for 0", "--for 0: must be more than 0 seconds"),
        ("{source} --save {source}", "an input of the same call: must be another file"),
        ("{source} --save a.csv", "--save a.csv: must end in .aedat4 or .raw"),
        ("{source} --save-log a.csv", "--save-log a.csv: suffix '.csv': must be .npz"),
        ("{source} --bind 127.0.0.1", "--bind 127.0.0.1: must be given with --web"),
        ("{source} --loop --save again.raw", "--save: must not be given with --loop"),
        ("tcp://127.0.0.1:9 --loop", "--loop: must not be given with tcp://127.0.0.1:9"),
        ("{source} --preset none", "--preset none: must be one of motion"),
        ("{source} --from 9999", "holds no events from 9.999 s"),
        ("none.aedat4", "none.aedat4: cannot be read: No such file"),
        ("tcp://here", "tcp://here: must be tcp://HOST:PORT"),
        ("tcp://127.0.0.1:9", "tcp://127.0.0.1:9: cannot be reached: Connection refused"),
        ("tcp://127.0.0.1:9 --speed 2", "--speed: must not be given with tcp://127.0.0.1:9, which is no file"),
        ("camera --learn-hot-pixels", "--learn-hot-pixels: must not be given with camera, which is no file"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(source: Path, refused: Refused, arguments: str, message: str) -> None:
    assert message in refused("live", *arguments.format(source=source).split(), "-q")

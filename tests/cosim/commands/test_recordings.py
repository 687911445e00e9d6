# SPDX-License-Identifier: Apache-2.0
"""`evcot info`, `evcot convert` and `evcot simulate` as a user meets them."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from evcot.events import Events
from evcot.recordings.files import read_recording, write_events
from evcot.recordings.formats import WRITABLE
from evcot.scenes import SCENES, Truth, simulate_scene
from evcot.tracks.formats.registry import read_boxes
from evcot_cosim.cli import main

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]
pytestmark = pytest.mark.usefixtures("home")
EPOCH_US = 1_718_925_184_590_631


@pytest.fixture
def drive() -> Path:
    """Ten seconds, an event every 100 us, of which pixel (5, 7) sends every second one."""
    n = 100_000
    random = np.random.default_rng(1)
    hot = np.arange(n) % 2 == 0
    x = np.where(hot, 5, random.integers(0, 346, n)).astype(np.uint16)
    y = np.where(hot, 7, random.integers(0, 130, n)).astype(np.uint16)
    path = Path("drive.npz")
    write_events(path, (346, 260), [Events(EPOCH_US + 100 * np.arange(n), x, y, hot.astype(np.uint8))])
    return path


def csv(name: str, *rows: str) -> str:
    Path(name).write_text("".join(f"{row}\n" for row in rows))
    return name


def table(capture: Capture, *arguments: str) -> dict[str, str]:
    assert main(["info", *arguments]) == 0
    printed = capture.readouterr()
    assert printed.err == ""
    rows = [line.split("  ", 1) for line in printed.out.splitlines()]
    assert len({len(line) - len(line.split("  ", 1)[1].lstrip()) for line in printed.out.splitlines()}) == 1, "aligned"
    return {name: value.strip() for name, value in rows}


def test_info_says_what_is_in_a_recording(drive: Path, capsys: Capture) -> None:
    rows = table(capsys, "drive.npz")
    busiest = rows.pop("busiest pixels")
    silent = rows.pop("silent pixels")
    assert rows == {
        "file": "drive.npz",
        "format": "NumPy npz",
        "times in": "microseconds",
        "sensor": "346x260 pixels",
        "events": "100,000",
        "first event": "2024-06-20 23:13:04 UTC (1,718,925,184.590631 s)",
        "duration": "9.999900 s",
        "mean rate": "10 k events/s",
        "peak rate": "10 k events/s, over 10 ms",
        "ON events": "50.0 %",
        "pixel interval": "200 us between two events of a pixel, median",
    }
    assert busiest.startswith("(5, 7) 50 %, (")
    assert busiest.count("(") == 5
    assert 50 < float(silent.removesuffix(" %")) < 70


def test_info_of_a_window_and_another_sensor(drive: Path, capsys: Capture) -> None:
    rows = table(capsys, "drive.npz", "--from", "1000", "--to", "1000.35", "--sensor", "400X300")
    assert (rows["events"], rows["duration"], rows["sensor"]) == ("4", "0.000300 s", "400x300 pixels")
    assert "peak rate" not in rows


def test_info_of_little_is_little(capsys: Capture) -> None:
    rows = table(capsys, csv("a.csv", "0.25 1 2 1"))
    assert rows == {
        "file": "a.csv",
        "format": "CSV or text",
        "separator": "blanks",
        "times in": "seconds",
        "columns": "t, x, y, p, assumed by their values; a first line such as x,y,t,p names them",
        "sensor": "2x3 pixels, the smallest that holds every event",
        "events": "1",
        "first event": "0.250000 s",
        "duration": "0.000000 s",
        "ON events": "100.0 %",
        "silent pixels": "83.3 %",
        "busiest pixels": "(1, 2) 100 %",
    }


def test_info_as_json(drive: Path, capsys: Capture) -> None:
    assert main(["info", "drive.npz", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["file"] == "drive.npz"
    assert (found["events"], found["width"], found["first_us"]) == (100_000, 346, EPOCH_US)
    assert found["pixels"]["busiest"][0]["share"] > 0.5


def test_damage_is_an_error_or_warnings_of_one_line(capsys: Capture, refused: Refused) -> None:
    csv("a.csv", "20001,1,1,1", "20002,1,1,7", "0,1,1,1", "20003,2,1,0", "oh")
    why = "line 5: 'oh': must have 4 cells, as the first event; it has 1"
    assert refused("info", "a.csv") == f"a.csv: {why} (--skip-damaged reads what can be read)"
    csv("none.csv", "oh")  # nothing to be read: no advice
    assert "--skip-damaged" not in refused("info", "none.csv")
    for _ in range(2):  # and again, if done again
        assert main(["info", "a.csv", "--skip-damaged"]) == 0
        printed = capsys.readouterr()
        assert printed.err.splitlines() == [
            f"evcot: warning: a.csv: everything after 4 events left out: {why}",
            "evcot: warning: a.csv: 1 events left out: outside the sensor, or without a polarity",
            "evcot: warning: a.csv: 1 events left out: time runs back",
        ]
        assert printed.out.splitlines()[-2:] == [
            "left out        1 events: outside the sensor, or without a polarity",
            "left out        1 events: time runs back",
        ]
    assert main(["convert", "a.csv", "b.npz", "--skip-damaged", "-q"]) == 0
    assert len(capsys.readouterr().err.splitlines()) == 3
    assert read_recording("b.npz").events.t_us.tolist() == [20_001, 20_003]


def test_a_camera_file_that_was_cut_off_is_rescued(drive: Path, refused: Refused) -> None:
    assert main(["convert", "drive.npz", "drive.aedat4", "-q"]) == 0
    content = Path("drive.aedat4").read_bytes()
    Path("cut.aedat4").write_bytes(content[: len(content) // 2])
    assert refused("info", "cut.aedat4").endswith("is it cut off or damaged? (--skip-damaged reads what can be read)")
    assert main(["convert", "cut.aedat4", "rescued.npz", "--skip-damaged", "-q"]) == 0
    rescued, whole = read_recording("rescued.npz").events, read_recording("drive.npz").events
    assert 30_000 < len(rescued) < len(whole)
    assert np.array_equal(rescued.t_us, whole.t_us[: len(rescued)])


def test_what_is_amiss_but_loses_nothing_is_told_once_and_is_no_failure(capsys: Capture) -> None:
    csv("a.csv", "20001,1,1,1", "20000,1,1,1", "20003,2,1,0")
    what = "1 events run back in time, by at most 1 us: each has the time of the latest before it"
    assert main(["info", "a.csv"]) == 0
    printed = capsys.readouterr()
    assert printed.err == f"evcot: warning: a.csv: {what}\n"
    assert printed.out.splitlines()[-1] == f"remark          {what}"
    assert main(["track", "a.csv", "-o", "out.npz", "--sensor", "9x9"]) == 0  # reads it more than once
    assert capsys.readouterr().err.count("run back in time") == 1


@pytest.mark.parametrize("name", WRITABLE)
def test_convert_gives_the_same_recording_in_another_format(drive: Path, name: str, capsys: Capture) -> None:
    target = f"out{WRITABLE[name].suffix}"
    assert main(["convert", "drive.npz", target, "--format", name]) == 0
    printed = capsys.readouterr()
    assert (printed.out, printed.err) == (f"100,000 events in {target}, {WRITABLE[name].title}\n", "")
    ours, theirs = read_recording(drive), read_recording(target)
    assert (ours.width, ours.height) == (theirs.width, theirs.height)
    for field in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(ours.events, field), getattr(theirs.events, field))


def test_convert_of_a_window_goes_by_the_suffix_and_may_be_quiet(drive: Path, capsys: Capture) -> None:
    Path("out.csv").write_text("older")
    assert main(["convert", "drive.npz", "out.csv", "--from", "0.1", "--to", "0.4", "--quiet", "--force"]) == 0
    assert capsys.readouterr() == ("", "")
    assert read_recording("out.csv").events.t_us.tolist() == [EPOCH_US + 100, EPOCH_US + 200, EPOCH_US + 300]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("info", "absent.raw"), "absent.raw: cannot be read: No such file or directory"),
        (("info", "."), ".: is a directory, and no ROS 2 bag: has no metadata.yaml"),
        (("info", "drive.npz", "--from", "-1"), "--from -1: must be from 0 to 1e15 ms"),
        (("info", "drive.npz", "--to", "nan"), "--to nan: must be from 0 to 1e15 ms"),
        (("info", "drive.npz", "--from", "5", "--to", "5"), "--to 5: must be after --from 5"),
        (("info", "drive.npz", "--from", "20000"), "drive.npz: holds no events from 20 s"),
        (("info", "drive.npz", "--sensor", "346"), "--sensor 346: must be WIDTHxHEIGHT in pixels, as 346x260"),
        (("info", "drive.npz", "--sensor", "0x5"), "drive.npz: sensor 0x5: each side must be from 1 to 65536 pixels"),
        (("info", "drive.npz", "--sensor", "5x5"), "drive.npz: event 0: x = 5: must be below the sensor's 5"),
        (("convert", "drive.npz", "out.jpeg"), "out.jpeg: suffix '.jpeg': must be one of .npz, "),
        (("convert", "drive.npz", "out", "--format", "gif"), "format 'gif': must be one of npz, csv"),
        (("convert", "drive.npz", "out.csv", "--from", "20000"), "drive.npz: holds no events from 20 s"),
        (("convert", "drive.npz", "absent/out.csv"), "output absent/out.csv: cannot be written: No such file or directory"),
        (("convert", "bad.csv", "out.npz"), "bad.csv: event 1: t = 1 us follows t = 20002 us: time must not run back"),
    ],
)
def test_what_cannot_be_done_is_one_line(drive: Path, arguments: tuple[str, ...], message: str, refused: Refused) -> None:
    csv("bad.csv", "20002,1,1,1", "1,1,1,1")
    assert refused(*arguments).startswith(message)


def test_a_dash_is_standard_input_and_output(drive: Path) -> None:
    def run(*arguments: str, content: bytes = drive.read_bytes()) -> subprocess.CompletedProcess[bytes]:
        return subprocess.run([sys.executable, "-m", "evcot_cosim", *arguments], input=content, capture_output=True)

    described = json.loads(run("info", "-", "--json").stdout)
    assert (described["events"], described["width"]) == (100_000, 346)
    done = run("convert", "-", "-", "--format", "aedat4")
    assert done.stderr == b"100,000 events in /dev/stdout, AEDAT 4.0\n"
    Path("copy.aedat4").write_bytes(done.stdout)
    assert np.array_equal(read_recording("copy.aedat4").events.t_us, read_recording(drive).events.t_us)
    done = run("convert", "-", "-")
    assert (done.returncode, done.stdout) == (2, b"")
    assert b"must be one of .npz" in done.stderr
    done = run("info", "-", content=b"")
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.endswith(b"stdin: is empty\n")
    assert run("track", "-", "-o", "log.npz", "-q").returncode == 0
    with h5py.File("drive.h5", "w") as hdf5:
        hdf5["events/t"], hdf5["events/x"], hdf5["events/y"], hdf5["events/p"] = [1, 2], [3, 4], [5, 6], [0, 1]
    assert run("info", "-", content=Path("drive.h5").read_bytes()).returncode == 0
    with Path("drive.h5").open("rb") as file:  # not copied
        subprocess.run([sys.executable, "-m", "evcot_cosim", "info", "-"], stdin=file, check=True)


def test_a_terminal_sees_how_far_it_is_and_a_pipe_does_not(drive: Path) -> None:
    command = [sys.executable, "-m", "evcot_cosim", "convert", "drive.npz", "out.csv", "--force"]
    ours, theirs = pty.openpty()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=theirs, env={**os.environ, "TERM": "xterm"}, check=True)
    os.close(theirs)
    assert "writing out.csv" in os.read(ours, 100_000).decode()
    os.close(ours)
    assert done.stdout == b"100,000 events in out.csv, CSV\n"
    done = subprocess.run(command, capture_output=True, check=True)
    assert done.stderr == b""


def several(*names: str) -> list[Path]:
    """Recordings of two, three, ... events."""
    paths = []
    for count, name in enumerate(names, 2):
        path = Path(name)
        path.parent.mkdir(exist_ok=True)
        columns = np.zeros((2, count), np.uint16)
        write_events(path, (64, 48), [Events(np.arange(count), *columns, np.zeros(count, np.uint8))])
        paths.append(path)
    return paths


def test_info_of_several_is_a_table_each(capsys: Capture) -> None:
    several("a.npz", "b.npz")
    assert main(["info", "a.npz", "b.npz"]) == 0
    tables = capsys.readouterr().out.split("\n\n")
    assert [[line.split()[-1] for line in table.splitlines() if line.startswith(("file", "events"))] for table in tables] == [
        ["a.npz", "2"], ["b.npz", "3"],
    ]  # fmt: skip
    assert main(["info", "a.npz", "b.npz", "--json"]) == 0
    assert [(each["file"], each["events"]) for each in json.loads(capsys.readouterr().out)] == [("a.npz", 2), ("b.npz", 3)]


def test_what_is_wrong_with_one_of_several_stops_no_other(capsys: Capture) -> None:
    several("a.npz", "b.npz")
    Path("broken.raw").write_bytes(b"\0" * 99)
    assert main(["info", "absent.npz", "a.npz", "broken.raw", "b.npz", "--json"]) == 2
    printed = capsys.readouterr()
    assert [each["file"] for each in json.loads(printed.out)] == ["a.npz", "b.npz"]
    assert [line.split(":")[1].strip() for line in printed.err.splitlines()] == ["absent.npz", "broken.raw"]


def test_several_are_converted_into_a_folder(capsys: Capture) -> None:
    paths = several("a.npz", "b.npz", "in/c.npz")
    assert main(["convert", *map(str, paths), "out", "--format", "evt3"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "2 events in out/a.raw, Prophesee RAW, EVT 3.0",
        "3 events in out/b.raw, Prophesee RAW, EVT 3.0",
        "4 events in out/c.raw, Prophesee RAW, EVT 3.0",
    ]  # fmt: skip
    for path in paths:
        assert len(read_recording(Path("out", f"{path.stem}.raw")).events) == len(read_recording(path).events)
    Path("more").mkdir()
    assert main(["convert", "a.npz", "b.npz", "more", "--format", "csv", "--json"]) == 0
    written = json.loads(capsys.readouterr().out)
    assert [(each["recording"], each["events"]) for each in written] == [("more/a.csv", 2), ("more/b.csv", 3)]


def test_one_that_cannot_be_converted_stops_no_other_and_replaces_nothing(capsys: Capture) -> None:
    several("a.npz", "b.npz")
    Path("out").mkdir()
    Path("out/a.csv").write_text("mine")
    assert main(["convert", "a.npz", "absent.npz", "b.npz", "out", "--format", "csv", "-q"]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("evcot: a.npz: output out/a.csv: exists: must be another file, or --force")
    assert second == "evcot: absent.npz: cannot be read: No such file or directory"
    assert sorted(path.name for path in Path("out").iterdir()) == ["a.csv", "b.csv"]
    assert Path("out/a.csv").read_text() == "mine"
    assert main(["convert", "a.npz", "b.npz", "out", "--format", "csv", "-q", "--force"]) == 0
    assert Path("out/a.csv").read_text() != "mine"


def test_an_input_is_never_the_output_of_another(capsys: Capture) -> None:
    several("a.npz", "b.csv")
    before = Path("a.npz").read_bytes()
    assert main(["convert", "b.csv", "a.npz", ".", "--format", "npz", "--force", "-q", "--sensor", "64x48"]) == 2
    assert capsys.readouterr().err == (
        "evcot: a.npz: output a.npz: is a.npz, an input of the same call: must be another file\n"
    )
    assert Path("a.npz").read_bytes() == before
    assert Path("b.npz").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("a.npz", "b.npz", "out"), "--format: must be given with several recordings, for the files in out"),
        (("a.npz", "in/a.npz", "out", "--format", "csv"), "a.npz and in/a.npz: would both be written as out/a.csv: must have"),
        (("a.npz", "in/A.npz", "out", "--format", "csv"), "a.npz and in/A.npz: would both be written as out/A.csv: must have"),
        (("a.npz", "b.npz", "c.npz", "--format", "csv"), "output c.npz: exists: must be a folder with several recordings"),
        (("a.npz", "b.npz", "no/out", "--format", "csv"), "output no/out: cannot be made: No such file or directory"),
        (("a.npz", "b.npz", "out", "--format", "tar"), "format 'tar': must be one of"),
    ],
)
def test_outputs_that_cannot_be_are_refused_before_any_is_written(
    arguments: tuple[str, ...], message: str, refused: Refused
) -> None:
    several("a.npz", "b.npz", "c.npz", "in/a.npz", "in/A.npz")
    assert refused("convert", *arguments).startswith(message)


def test_a_folder_into_which_nothing_was_written_is_not_left(capsys: Capture) -> None:
    several("a.npz")
    assert main(["convert", "absent.npz", "missing.npz", "out", "--format", "csv"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2
    assert not Path("out").exists()


@pytest.mark.parametrize("suffix", ["npz", "csv", "raw"])
def test_a_scene_is_written_in_the_format_of_the_suffix_with_its_truth_beside(
    suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", "discs", "-o", f"d.{suffix}", "--seed", "7", "--duration", "0.05", "--set", "count=2"]) == 0
    expected = simulate_scene("discs", 7, {"duration_us": 50_000, "count": 2})
    events = read_recording(f"d.{suffix}", (346, 260)).events
    wanted = expected.recording.events
    assert capsys.readouterr().out == f"{len(wanted):,} events, 346x260 pixels, in d.{suffix}; the truth in d.truth.csv\n"
    for field in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(events, field), getattr(wanted, field))
    np.testing.assert_allclose(Truth.load("d.truth.csv").samples["x"], expected.truth.samples["x"], atol=1e-3)
    assert sorted(path.name for path in Path.cwd().iterdir()) == [f"d.{suffix}", "d.truth.csv"]


def test_size_seed_and_place_of_the_truth_can_be_chosen_and_the_report_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["boxes", "-o", "b.npz", "--sensor", "128x96", "--duration", "0.1", "--truth", "t.csv", "--set", "jitter_us=0"]
    assert main(["simulate", *arguments, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert {key: report[key] for key in ("recording", "truth", "scene", "width", "height")} == {
        "recording": "b.npz", "truth": "t.csv", "scene": "boxes", "width": 128, "height": 96,
    }  # fmt: skip
    assert report["events"] == len(read_recording("b.npz").events)
    assert (report["settings"]["jitter_us"], report["settings"]["duration_us"]) == (0, 100_000)
    assert len(Truth.load("t.csv").samples) == 9 * 100


def test_labels_are_coco_boxes_with_the_names_of_the_classes(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["-o", "h.npz", "--labels", "h.json", "--duration", "0.1", "--set", "truth_step_us=50000"]
    assert main(["simulate", "highway", *arguments]) == 0
    samples = Truth.load("h.truth.csv").samples
    samples = samples[samples["visible"]]
    data = json.loads(Path("h.json").read_text())
    assert [image["t_us"] for image in data["images"]] == [0, 50_000]
    assert {(one["id"], one["name"]) for one in data["categories"]} == {(1, "car"), (2, "lorry")}
    boxes = read_boxes("h.json")
    assert boxes.rows["class_id"].tolist() == samples["class_id"].tolist()
    assert boxes.rows["counted"].tolist() == (samples["occluded"] <= 0.5).tolist()
    np.testing.assert_allclose(boxes.rows["left"], samples["x"] - samples["width"] / 2, atol=1e-3)
    Path("h.npz").unlink()
    Path("h.truth.csv").unlink()
    assert main(["simulate", "highway", *arguments]) == 2
    assert "h.json: exists" in capsys.readouterr().err
    assert [path.name for path in Path.cwd().iterdir()] == ["h.json"]


def test_the_scenes_and_a_scenes_settings_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(SCENES)
    assert main(["simulate", "--list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {name: kind.title for name, kind in SCENES.items()}
    assert main(["simulate", "discs", "--list"]) == 0
    assert "noise_hz = 0.1" in capsys.readouterr().out.splitlines()
    assert main(["simulate", "discs", "--list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ways"] == "crossing"


def test_images_become_a_recording_without_truth(capsys: pytest.CaptureFixture[str]) -> None:
    Path("film").mkdir()
    for i, grey in enumerate((10, 200, 10)):
        Image.new("L", (8, 6), grey).save(f"film/{i}.png")
    assert main(["simulate", "film", "-o", "f.npz", "--set", "fps=100", "--set", "shrink=2", "--set", "on_threshold=0.5"]) == 0
    recording = read_recording("f.npz")
    assert (recording.width, recording.height) == (4, 3)
    assert 0 < len(recording.events) < 4 * 3 * 40
    assert capsys.readouterr().out == f"{len(recording.events)} events, 4x3 pixels, in f.npz\n"
    assert not Path("f.truth.csv").exists()


SCENE_NAMES = f"must be one of {', '.join(SCENES)}, a video file or a folder of images"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("", f"SCENE: {SCENE_NAMES}"),
        ("discs", "-o FILE: must say where the recording goes"),
        ("disc -o d.npz", f"SCENE 'disc': {SCENE_NAMES}; did you mean discs?"),
        ("discs -o d.gif", "d.gif: suffix '.gif': must be one of "),
        ("discs -o no/d.npz", "-o no/d.npz: cannot be written: No such file or directory"),
        ("discs -o no/d.npz --truth t.csv", "-o no/d.npz: cannot be written: No such file or directory"),
        ("discs -o d.csv --truth d.csv", "--truth d.csv: is also -o: must be another file"),
        ("discs -o d.npz --sensor big", "--sensor big: must be WIDTHxHEIGHT in pixels, as 346x260"),
        ("discs -o d.npz --sensor 9x9", "discs.width = 9: must be from 64 to 4096"),
        ("discs -o d.npz --duration nan", "--duration nan: must be more than 0 seconds"),
        ("discs -o d.npz --set count", "--set count: must be KEY=VALUE; `evcot simulate discs --list` shows the keys"),
        ("discs -o d.npz --set n=2", "discs.n: no such setting: must be one of width"),
        ("discs -o d.npz --seed -1", "discs.seed = -1: must be from 0"),
        ("empty -o d.npz", "empty: holds no images: must hold files named *.png"),
        ("empty -o d.npz --sensor 64x64", "--sensor: must not be given for footage"),
        ("empty -o d.npz --set x=1", "footage.x: no such setting: must be one of fps"),
    ],
)
def test_what_a_user_can_mend_ends_in_one_line_with_nothing_written(arguments: str, message: str, refused: Refused) -> None:
    Path("empty").mkdir()
    assert refused("simulate", *arguments.split()).startswith(message)

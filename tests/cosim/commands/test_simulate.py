# SPDX-License-Identifier: Apache-2.0
"""`evcot simulate` as a person uses it: scenes, images, truth beside, and errors in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from evcot.recordings.files import read_recording
from evcot.scenes import SCENES, Truth, simulate_scene
from evcot_cosim.cli import main
from evcot_cosim.commands.parsing import USER_ERROR


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that `evcot simulate` ends with; nothing else may stay behind."""
    before = sorted(Path.cwd().rglob("*"))
    assert main(["simulate", *arguments]) == USER_ERROR
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert sorted(Path.cwd().rglob("*")) == before
    return captured.err.removeprefix("evcot: ").rstrip("\n")


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


def test_quiet_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "boxes", "-o", "b.npz", "--duration", "0.01", "-q"]) == 0
    assert capsys.readouterr().out == ""


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


def test_what_a_user_can_mend_ends_in_one_line_with_nothing_written(capsys: pytest.CaptureFixture[str]) -> None:
    names = ", ".join(SCENES)
    Path("empty").mkdir()
    assert refused(capsys) == f"SCENE: must be one of {names}, a video file or a folder of images"
    assert refused(capsys, "discs") == "-o FILE: must say where the recording goes"
    assert refused(capsys, "disc", "-o", "d.npz") == (
        f"SCENE 'disc': must be one of {names}, a video file or a folder of images; did you mean discs?"
    )
    assert refused(capsys, "discs", "-o", "d.gif").startswith("d.gif: suffix '.gif': must be one of ")
    assert refused(capsys, "discs", "-o", "no/d.npz").endswith("d.npz: cannot be written: No such file or directory")
    assert refused(capsys, "discs", "-o", "no/d.npz", "--truth", "t.csv").endswith(": No such file or directory")
    assert refused(capsys, "discs", "-o", "d.csv", "--truth", "d.csv") == "--truth d.csv: is also -o: must be another file"
    assert refused(capsys, "discs", "-o", "d.npz", "--sensor", "big") == (
        "--sensor big: must be WIDTHxHEIGHT in pixels, as 346x260"
    )
    assert refused(capsys, "discs", "-o", "d.npz", "--sensor", "9x9").startswith("discs.width = 9: must be from 64 to 4096")
    assert refused(capsys, "discs", "-o", "d.npz", "--duration", "nan") == "--duration nan: must be more than 0 seconds"
    assert refused(capsys, "discs", "-o", "d.npz", "--set", "count") == (
        "--set count: must be KEY=VALUE; `evcot simulate discs --list` shows the keys"
    )
    assert refused(capsys, "discs", "-o", "d.npz", "--set", "n=2").startswith("discs.n: no such setting: must be one of width")
    assert refused(capsys, "discs", "-o", "d.npz", "--seed", "-1").startswith("discs.seed = -1: must be from 0")
    assert refused(capsys, "empty", "-o", "d.npz").startswith("empty: holds no images: must hold files named *.png")
    assert refused(capsys, "empty", "-o", "d.npz", "--sensor", "64x64").startswith("--sensor: must not be given for footage")
    assert refused(capsys, "empty", "-o", "d.npz", "--set", "x=1").startswith("footage.x: no such setting: must be one of fps")

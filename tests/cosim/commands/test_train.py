# SPDX-License-Identifier: Apache-2.0
"""`evcot train` and `evcot track --classify` as a user meets them: squares and crosses that move."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.recognition.weights import Weights
from evcot_cosim.cli import main

SENSOR = 200, 100
CATEGORIES = [{"id": 0, "name": "square"}, {"id": 1, "name": "cross"}]


def recorded(folder: Path, name: str, shape: int, seed: int) -> None:
    """A square (class 0) or a cross (class 1) that moves to the right, and its labels as COCO boxes."""
    random = np.random.default_rng(seed)
    count = 80_000
    t_us = np.sort(random.integers(0, 1_000_000, count))
    along, across, side = random.uniform(-10, 10, count), random.integers(-1, 2, count), random.integers(0, 4, count)
    edge = np.where(side < 2, 10.0, -10.0) if shape == 0 else across
    x = 30 + t_us * 140e-6 + np.where(side % 2, along, edge)
    y = 50 + np.where(side % 2, edge, along)
    p = random.integers(0, 2, count)
    events = evcot.Events(t_us, np.rint(x).astype(np.uint16), np.rint(y).astype(np.uint16), p.astype(np.uint8))
    evcot.write(evcot.Recording(events, *SENSOR, name), folder / f"{name}.aedat4")
    images = [{"id": k + 1, "t_us": 10_000 * k, "width": SENSOR[0], "height": SENSOR[1]} for k in range(100)]
    boxes = [
        {"id": k + 1, "image_id": k + 1, "category_id": shape, "bbox": [20 + 1.4 * k, 40, 20, 20], "track_id": 1}
        for k in range(100)
    ]
    (folder / f"{name}.json").write_text(json.dumps({"images": images, "annotations": boxes, "categories": CATEGORIES}))


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with recordings a to f, of which a to d are learned, and weights."""
    folder = tmp_path_factory.mktemp("trained")
    for number, name in enumerate("abcdef"):
        recorded(folder, name, number % 2, number)
    files = [[str(folder / f"{name}.{suffix}") for name in "abcd"] for suffix in ("aedat4", "json")]
    assert main(["train", *files[0], "--labels", *files[1], "-o", str(folder / "w.npz"), "--window-log2", "8"]) == 0
    return folder


@pytest.mark.parametrize(("name", "class_id", "called"), [("e", 0, "square"), ("f", 1, "cross")])
def test_tracks_get_the_class_of_their_object(
    trained: Path, tmp_path: Path, name: str, class_id: int, called: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log, boxes, table = tmp_path / "log.npz", tmp_path / "boxes.json", tmp_path / "log.csv"
    outputs = ["-o", str(log), "--csv", str(table), "--boxes", str(boxes), "--frame-us", "10000"]
    recording = str(trained / f"{name}.aedat4")
    assert main(["track", recording, "--classify", str(trained / "w.npz"), *outputs, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["classified"] == 1
    found = evcot.TrackLog.load(log)
    assert found.verdicts["class_id"][-1] == class_id
    assert [row.split(",")[-1] for row in (table.read_text().splitlines()[k] for k in (0, 1, -1))] == [
        "class_id",
        "-1",
        str(class_id),
    ]
    written = json.loads(boxes.read_text())
    assert {row["category_id"] for row in written["annotations"]} == {-1, class_id}
    assert {"id": class_id, "name": called} in written["categories"]
    assert found.class_names == {0: "square", 1: "cross"}
    same = evcot.track(recording, classify=trained / "w.npz")
    assert np.array_equal(same.verdicts, found.verdicts)
    columns = tmp_path / "log.parquet"
    assert main(["track", recording, "--classify", str(trained / "w.npz"), "-o", str(columns), "--quiet"]) == 0
    assert np.array_equal(evcot.TrackLog.load(columns).verdicts, found.verdicts)
    assert main(["evaluate", str(log), "--truth", str(trained / f"{name}.json"), "--json"]) == 0
    classes = json.loads(capsys.readouterr().out)["classes"]
    assert (classes["class_ids"], classes["labels"], classes["accuracy"]) == ([class_id], [called], 1.0)
    assert 0 < classes["hota"][0] == classes["hota_mean"]
    assert main(["evaluate", str(log), "--truth", str(trained / f"{name}.json")]) == 0
    assert f"1 as {called}; recall 100 %, precision 100 %; HOTA {classes['hota_mean']:.3f}" in capsys.readouterr().out
    assert main(["evaluate", str(log), str(columns), "--truth", str(trained / f"{name}.json")]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("HOTA, mean of classes "))
    assert row.split()[-2:] == [f"{classes['hota_mean']:.3f}"] * 2


def test_a_live_run_has_the_same_verdicts(trained: Path, tmp_path: Path) -> None:
    recording, log = str(trained / "e.aedat4"), tmp_path / "log.npz"
    assert main(["live", recording, "--classify", str(trained / "w.npz"), "--save-log", str(log), "--speed", "5", "-q"]) == 0
    found, wanted = evcot.TrackLog.load(log), evcot.track(recording, classify=trained / "w.npz")
    if np.array_equal(found.owner, wanted.owner):  # a busy machine drops packets
        assert np.array_equal(found.verdicts, wanted.verdicts)
    assert len(found.verdicts)
    assert found.class_names == {0: "square", 1: "cross"}


def test_the_verdicts_of_a_run_are_behind_the_owned_events_of_the_hardware(
    trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A short run, and the same as a long one in pages: both say what the tracker with its classifier says."""
    monkeypatch.chdir(tmp_path)
    recording, classify = str(trained / "e.aedat4"), ["--classify", str(trained / "w.npz"), "-q", "--no-waves"]
    wanted = evcot.track(recording, classify=trained / "w.npz")
    assert main(["cosim", recording, *classify, "-o", "short"]) == 0
    monkeypatch.setattr("evcot_cosim.commands.actions.cosim.EVENTS_MAX", 1_000)
    monkeypatch.setattr("evcot_cosim.report.part_pages.PART_EVENTS", 30_000)
    assert main(["cosim", recording, *classify, "-o", "long"]) == 0
    for path in (Path("short/hardware.npz"), Path("short/model.npz"), next(Path("long").glob("hardware.*"))):
        found = evcot.TrackLog.load(path)
        assert np.array_equal(found.verdicts, wanted.verdicts), path
        assert found.class_names == {0: "square", 1: "cross"}
    assert not len(evcot.TrackLog.load("short/software.npz").verdicts)
    for page in (Path("short/report.html"), Path("long/part-00002.html")):
        assert '"labels":["square"]' in page.read_text(), page


def test_a_run_of_another_module_is_refused(trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--classify", str(trained / "w.npz"), "--hardware", "cot_array", "-o", str(tmp_path / "run")]
    assert main(["cosim", str(trained / "e.aedat4"), *arguments, "-q"]) == 2
    assert "engine cot_array: must be cot_motion, the tracker of the weights" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_live_run_of_another_engine_is_refused(trained: Path, capsys: pytest.CaptureFixture[str]) -> None:
    classify = ["--classify", str(trained / "w.npz"), "--engine", "rct"]
    assert main(["live", str(trained / "e.aedat4"), *classify, "-q"]) == 2
    assert "engine rct: must be cot_motion, the tracker of the weights" in capsys.readouterr().err


def test_a_margin_that_nothing_reaches_gives_none_of_the_classes(trained: Path, tmp_path: Path) -> None:
    files = [[str(trained / f"{name}.{suffix}") for name in "abcd"] for suffix in ("aedat4", "json")]
    strict = str(tmp_path / "strict.npz")
    assert main(["train", *files[0], "--labels", *files[1], "-o", strict, "--window-log2", "8", "--margin-min", "255"]) == 0
    found = evcot.track(trained / "e.aedat4", classify=strict).verdicts
    assert set(found["class_id"][found["margin"] < 255 * found["windows"]]) == {-1}


def test_size_and_speed_are_learned_where_that_is_asked_for(trained: Path, tmp_path: Path) -> None:
    files = [[str(trained / f"{name}.{suffix}") for name in "abcd"] for suffix in ("aedat4", "json")]
    sized = tmp_path / "sized.npz"
    assert main(["train", *files[0], "--labels", *files[1], "-o", str(sized), "--window-log2", "8", "--size-speed"]) == 0
    plain, weights = Weights.load(trained / "w.npz"), Weights.load(sized)
    assert (plain.size_speed.shape, weights.size_speed.shape) == ((0, 0), (6, 2))
    assert np.array_equal(plain.network.w1, weights.network.w1)
    for name, class_id in (("e", 0), ("f", 1)):
        found = evcot.track(trained / f"{name}.aedat4", classify=sized).verdicts
        assert found["class_id"][-1] == class_id
    # A table that knows one class alone gives it, whatever the image says; margin and windows stay the hardware's.
    only = np.zeros((6, 2))
    only[-1, 1] = 1.0
    replace(weights, size_speed=only).save(tmp_path / "only.npz")
    other = evcot.track(trained / "e.aedat4", classify=tmp_path / "only.npz").verdicts
    image = evcot.track(trained / "e.aedat4", classify=trained / "w.npz").verdicts
    assert set(other["class_id"]) == {1}
    assert np.array_equal(other[["margin", "windows"]], image[["margin", "windows"]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["train", "a.aedat4", "--labels", "a.json", "b.json"], "2 files of labels, 1 recordings: must be one for each"),
        (["train", "a.aedat4", "--labels", "none.txt", "--frame-us", "10000"], "none.txt: no track of a.aedat4 is in a box"),
        (["train", "a.aedat4", "--labels", "a.json"], "number of labelled classes in the tracks found is 1: must be 2 to 10"),
        (["train", "a.aedat4", "--labels", "far.json"], "far.json: no track of a.aedat4 is in a box"),
        (
            ["train", "a.aedat4", "b.aedat4", "--labels", "a.json", "b.json", "--window-log2", "12"],
            " windows: must be at least 50",
        ),
        (["train", "a.aedat4", "--labels", "a.json", "--window-log2", "13"], "recognition.window_log2 = 13"),
        (["train", "a.aedat4", "--labels", "a.json", "--margin-min", "256"], "recognition.margin_min = 256"),
        (["train", "a.aedat4", "--labels", "a.json", "--seed", "-1"], "seed = -1: must be an integer"),
        (["track", "a.aedat4", "--engine", "rct", "--classify", "w.npz"], "engine rct: must be cot_motion, the tracker of"),
        (["track", "a.aedat4", "--classify", "a.json"], "a.json: is damaged, or no npz file: must be weights"),
        (
            ["train", "a.aedat4", "b.aedat4", "--labels", "a.json", "other.json"],
            "other.json: class 0 = 'disc': must be 'square', as in the files before",
        ),
        (["train", "a.aedat4", "--labels", "twice.json"], "--labels: classes 0, 1 = 'square': must have different names"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(
    trained: Path,
    arguments: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(trained)
    far = json.loads(Path("a.json").read_text())
    for box in far["annotations"]:
        box["bbox"] = [0, 0, 5, 5]
    Path("far.json").write_text(json.dumps(far))
    for name, categories in (("other", [(0, "disc")]), ("twice", [(0, "square"), (1, "square")])):
        named = far | {"categories": [{"id": number, "name": category} for number, category in categories]}
        Path(f"{name}.json").write_text(json.dumps(named))
    Path("none.txt").touch()
    assert main([*arguments, "-o", "out.npz"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert message in said[0]
    assert not Path("out.npz").exists()
    assert not list(Path().glob(".*"))

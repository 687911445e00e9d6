# SPDX-License-Identifier: Apache-2.0
"""`evcot boxes`, and boxes of any tracker in `evcot evaluate` and `evcot track`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.cli import main
from support.logs import log_of

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]
FRAME = ["--frame-us", "10000"]


@pytest.fixture(autouse=True)
def story(home: Path) -> None:
    """Two objects for half a second; the log follows one of them, 2 px off, and has a false track for a while."""
    lines = []
    for frame in range(50):
        lines += [f"{frame + 1},1,{11.5 + frame},21.5,20,12,1,1,1", f"{frame + 1},2,150,100,20,12,1,1,1"]
    Path("gt.txt").write_text("\n".join(lines) + "\n")
    rows: list[Any] = [(10_000 * frame, Kind.MOVED if frame else Kind.BORN, 0, 20.0 + frame, 28.0) for frame in range(50)]
    rows += [(100_000 + 10_000 * frame, Kind.MOVED if frame else Kind.BORN, 1, 200.0, 50.0) for frame in range(10)]
    rows += [(200_000, Kind.LOST, 1, 200.0, 50.0), (500_000, Kind.LOST, 0, 70.0, 28.0)]
    log_of(sorted(rows)).save_npz("log.npz")


def said(capture: Capture, *arguments: str) -> dict[str, Any]:
    assert main([*arguments, "--json"]) == 0
    found: dict[str, Any] = json.loads(capture.readouterr().out)
    return found


def test_a_log_scores_the_same_in_every_format(capsys: Capture) -> None:
    own = said(capsys, "evaluate", "log.npz", "--truth", "gt.txt", *FRAME)
    assert (own["frames"], own["truth_ids"], own["track_ids"]) == (50, 2, 2)
    assert (own["tp"], own["fp"], own["fn"], own["idsw"]) == (50, 10, 50, 0)
    assert own["motp"] == pytest.approx(20 * 10 / (2 * 20 * 12 - 20 * 10))  # 2 px too low
    for target in ("result.txt", "tracks.json", "tracks_bbox.npy"):
        wrote = said(capsys, "boxes", "log.npz", target, *FRAME)
        assert (wrote["count"], wrote["tracks"], wrote["instants"]) == (60, 2, 51)
        scores = said(capsys, "evaluate", target, "--truth", "gt.txt", *FRAME)
        for name in ("hota", "mota", "motp", "idf1", "tp", "fp", "fn", "deta", "assa"):
            assert scores[name] == pytest.approx(own[name], abs=1e-6), (target, name)


def test_a_truth_scores_the_same_in_every_format(capsys: Capture) -> None:
    own = said(capsys, "evaluate", "log.npz", "--truth", "gt.txt", *FRAME)
    for target in ("gt.json", "gt_bbox.npy"):
        assert main(["boxes", "gt.txt", target, *FRAME, "-q"]) == 0
        scores = said(capsys, "evaluate", "log.npz", "--truth", target)
        assert scores["hota"] == pytest.approx(own["hota"], abs=1e-6)
    assert main(["boxes", "gt_bbox.npy", "again.txt", "--format", "mot-gt", *FRAME, "-q"]) == 0
    assert Path("again.txt").read_text() == Path("gt.txt").read_text()


def test_the_origin_moves_frames(capsys: Capture, refused: Refused) -> None:
    assert main(["boxes", "log.npz", "late.txt", *FRAME, "--origin-us", "100000", "-q"]) == 0
    assert Path("late.txt").read_text().startswith("1,1,21.5,23.5,20,12,0.5,-1,-1,-1\n1,2,")
    assert said(capsys, "evaluate", "late.txt", "--truth", "gt.txt", *FRAME)["tp"] < 20
    log = TrackLog.load_npz("log.npz")
    log.records["t_us"] += 10**15
    log.save_npz("decades.npz")
    message = refused("evaluate", "decades.npz", "--truth", "gt.txt", *FRAME)
    spans = "t_us from 1000000000000000 to 1000000000500000, the truth's from 0 to 490000"
    assert message.startswith(f"decades.npz: {spans}: must be of one clock")
    assert said(capsys, "evaluate", "decades.npz", "--truth", "gt.txt", *FRAME, "--origin-us", str(10**15))["tp"] == 50


def test_track_writes_boxes_of_the_recordings_frames(capsys: Capture, refused: Refused) -> None:
    assert main(["simulate", "boxes", "-o", "scene.npz", "--set", "duration_us=100000"]) == 0
    capsys.readouterr()
    found = said(capsys, "track", "scene.npz", "-o", "own.npz", "--boxes", "own.txt", *FRAME)
    assert main(["boxes", "own.npz", "same.txt", *FRAME, "--origin-us", str(found["frame_1_at_us"]), "-q"]) == 0
    assert Path("own.txt").read_text() == Path("same.txt").read_text() != ""
    assert "must be given (--frame-us)" in refused("track", "scene.npz", "--boxes", "more.txt")
    assert "exists" in refused("track", "scene.npz", "--boxes", "own.txt", *FRAME)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("boxes log.npz out.txt", "frame_us: must be given, the time from frame to frame (--frame-us)"),
        ("boxes log.npz out.xml --frame-us 10000", "out.xml: must end in .txt, .json, .npy, .mcap, or its format must"),
        ("boxes log.npz out.txt --format mp4 --frame-us 10000", "format 'mp4': must be one of mot, mot-gt, mot-det, coco"),
        ("boxes log.npz out.txt --frame-us 0", "--frame-us = 0.0: must be from 1 to 1e+09"),
        ("boxes gt.txt gt.txt --frame-us 10000 --force", "output gt.txt: "),
        ("boxes log.npz gt.txt --frame-us 10000", "output gt.txt: exists"),
        ("boxes none.txt out.txt --frame-us 10000", "none.txt: cannot be read: No such file or directory"),
        ("boxes gt.txt out.txt --frame-us 10000 --source-format coco", "gt.txt: line 1: is no JSON"),
        ("evaluate log.npz --truth gt.txt", "gt.txt: has frames in place of times"),
        ("evaluate gt.txt --truth log.npz --frame-us 10000", "log.npz: "),
        (
            "evaluate log.npz --truth gt.txt --frame-us 10000 --sensor 100x100",
            "gt.txt: line 2: x = 158.5, width = 20: must reach",
        ),
        ("evaluate log.npz --truth gt.txt --frame-us 10000 --rule scene", "counted.visible: must be one of confidence, class"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(arguments: str, message: str, refused: Refused) -> None:
    assert refused(*arguments.split()).startswith(message)


def test_the_line_for_people(capsys: Capture) -> None:
    assert main(["boxes", "log.npz", "out.txt", *FRAME]) == 0
    assert capsys.readouterr().out == "60 boxes of 2 tracks at 51 instants in out.txt, MOTChallenge result\n"
    assert np.loadtxt("out.txt", delimiter=",").shape == (60, 10)

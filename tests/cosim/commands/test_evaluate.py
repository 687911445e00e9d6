# SPDX-License-Identifier: Apache-2.0
"""`evcot evaluate` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from evcot.trackers.config import RunConfig
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.cli import main
from evcot_cosim.lockstep.run_file import RunFile, Source, write_run_file

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]
KEYS = {
    "hota", "deta", "assa", "loca", "mota", "motp", "idf1", "idp", "idr", "idsw", "frag", "tp", "fp", "fn", "mt", "ml",
    "position_error_px_median", "position_error_px_p90", "velocity_error_median", "latency_ms", "frames", "truth_ids",
    "track_ids",
}  # fmt: skip


@pytest.fixture(autouse=True)
def story(home: Path) -> None:
    """A box that drives to the right for a second at 100 px/s, and a track that is 2 px below it, for half the time."""
    lines = ["t_us,object_id,left,top,width,height,vx,vy,visible,occluded"]
    lines += [f"{t},0,{10 + t * 1e-4:.4f},20,30,40,100,0,1,0" for t in range(0, 1_000_000, 10_000)]
    Path("truth.csv").write_text("\n".join(lines) + "\n")
    records = np.zeros(500, TRACK)
    records["t_us"] = np.arange(0, 500_000, 1_000)
    records["kind"] = Kind.MOVED
    records["kind"][0], records["kind"][-1] = Kind.BORN, Kind.LOST
    records["x"], records["y"] = 25 + records["t_us"] * 1e-4, 42.0
    TrackLog("rct", records, np.empty(0, np.int16)).save_npz("software.npz")


def test_every_figure_as_json(capsys: Capture) -> None:
    assert main(["evaluate", "software.npz", "--truth", "truth.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) >= KEYS
    assert (found["frames"], found["truth_ids"], found["track_ids"]) == (100, 1, 1)
    assert (found["tp"], found["fp"], found["fn"], found["mota"]) == (50, 0, 50, 0.5)
    assert found["idf1"] == pytest.approx(2 / 3)
    assert found["motp"] == pytest.approx(1 - 2 / 25)
    assert found["position_error_px_median"] == pytest.approx(2.0)
    assert found["velocity_error_median"] == pytest.approx(0.0, abs=1e-6)
    assert found["latency_ms"] == 0.0


def test_the_table_for_people(capsys: Capture) -> None:
    assert main(["evaluate", "software.npz", "--truth", "truth.csv"]) == 0
    printed = capsys.readouterr()
    table = {line[:16].strip(): line[16:].strip() for line in printed.out.splitlines() if line[0] != " "}
    assert table["MOTA"] == "0.500  50 found, 50 missed, 0 false, 0 switches, 0 interruptions"
    assert table["IDF1"] == "0.667  recall 0.500, precision 1.000"
    assert table["objects"] == "1: 0 mostly tracked, 0 mostly lost"
    assert table["position error"] == "2 px median, 2 px at 90 %"
    assert table["latency"] == "0 ms"
    assert printed.err == ""


def test_stated_velocity_against_displacement(capsys: Capture) -> None:
    """A track at 100 px/s that states 125 px/s."""
    log = TrackLog.load_npz("software.npz")
    log.records["t_us"][-1] += 1_000  # lives for 0.5 s
    log.records["vx"] = 125
    log.save_npz("faster.npz")
    assert main(["evaluate", "faster.npz", "--truth", "truth.csv"]) == 0
    off = "0 degrees (median) off the displacement over 300 ms, more than 45 in 0 %; 25 % relative error"
    assert f"direction        stated velocity {off}" in capsys.readouterr().out.splitlines()


def test_what_is_not_known_is_null(capsys: Capture) -> None:
    TrackLog.empty("rct").save_npz("nobody.npz")
    assert main(["evaluate", "nobody.npz", "--truth", "truth.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["latency_ms"] is None
    assert main(["evaluate", "nobody.npz", "--truth", "truth.csv"]) == 0
    assert "latency          unknown\n" in capsys.readouterr().out


def test_a_rule_of_ones_own_and_the_sensor(capsys: Capture, refused: Refused) -> None:
    Path("left.toml").write_text('base = "scene"\nclip = true\n')
    arguments = ["evaluate", "software.npz", "--truth", "truth.csv", "--rule", "left.toml", "--json"]
    assert refused("evaluate", *arguments[1:]).startswith("sensor: must be given (--sensor WxH")
    assert main([*arguments, "--sensor", "40x100"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["tp"] + found["fn"] == 30  # left edges from 10 to 39 px lie on 40 columns


def test_without_a_rule_it_is_the_one_whose_columns_the_truth_has(refused: Refused) -> None:
    boxes = "0,0,1000,7,10,10,20,20\n"
    Path("boxes.csv").write_text(f"frame,t_begin_us,t_end_us,track_id,left,top,width,height\n{boxes}")
    Path("other.csv").write_text("t,id,x,y\n1,2,3,4\n")
    scene, traffic, none = (
        refused("evaluate", "software.npz", "--truth", "boxes.csv", *rule)
        for rule in (["--rule", "scene"], ["--rule", "traffic"], [])
    )
    assert scene.startswith("boxes.csv: line 1: ")
    assert none == traffic
    assert "must have one column" in refused("evaluate", "software.npz", "--truth", "other.csv")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.npz", "--truth", "truth.csv"], "none.npz: cannot be read: No such file or directory"),
        (["truth.csv", "--truth", "truth.csv"], "truth.csv: CSV has records alone, without owners"),
        (["software.npz", "--truth", "none.csv"], "none.csv: cannot be read: No such file or directory"),
        (
            ["software.npz", "--truth", "truth.csv", "--rule", "cars"],
            "rule 'cars': must be one of boxes, scene, traffic, or a .toml",
        ),
        (["software.npz", "--truth", "truth.csv", "--rule", "traffic"], "truth.csv: line 1: 't_us,object_id,left,"),
        (["software.npz", "--truth", "truth.csv", "--sensor", "big"], "--sensor big: must be WIDTHxHEIGHT in pixels"),
        (["software.npz", "--truth", "truth.csv", "--sensor", "0x5"], "sensor = (0, 5): must be [width, height]"),
    ],
)
def test_what_cannot_be_used_is_named(arguments: list[str], message: str, refused: Refused) -> None:
    assert refused("evaluate", *arguments).startswith(message)


def test_a_log_that_no_engine_writes_is_named(refused: Refused) -> None:
    log = TrackLog.load_npz("software.npz")
    log.records["x"][3] = np.nan
    log.save_npz("bad.npz")
    assert (
        refused("evaluate", "bad.npz", "--truth", "truth.csv")
        == "bad.npz: record 3: x = nan: must be a number of at most 1e+09"
    )


def run_folder(digest: str = "0123456789abcdef", of_model: str = "") -> Path:
    """A folder as `evcot cosim` leaves it, with the log of the story as each engine's, the model's without its last half."""
    folder = Path("run")
    folder.mkdir()
    config = RunConfig()
    write_run_file(folder / "run.toml", RunFile(Source("drive.npz"), None, digest, config))
    log = TrackLog.load_npz("software.npz")
    for name, records, of in (
        ("hardware", log.records, digest), ("model", log.records[:250], of_model or digest), ("software", log.records, ""),
    ):  # fmt: skip
        TrackLog("any", records, log.owner, of).save_npz(folder / f"{name}.npz")
    return folder


def test_all_engines_of_a_run(capsys: Capture) -> None:
    run_folder()
    assert main(["evaluate", "run", "--truth", "truth.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == ["hardware", "software", "model"]
    assert (found["hardware"]["tp"], found["software"]["tp"]) == (50, 50)
    assert found["model"]["tp"] < 35
    assert main(["evaluate", "run", "--truth", "truth.csv"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert rows[0].split() == ["hardware", "software", "model"]
    assert next(row.split()[1:] for row in rows if row.startswith("found")) == ["50", "50", str(found["model"]["tp"])]


def test_a_log_of_another_recording_in_a_run_is_refused(refused: Refused) -> None:
    run_folder(of_model="fedcba9876543210")
    assert refused("evaluate", "run", "--truth", "truth.csv").startswith(
        "run/model.npz: recording = 'fedcba9876543210': must be"
    )


def test_a_folder_that_is_no_run(refused: Refused) -> None:
    Path("empty").mkdir()
    assert refused("evaluate", "empty", "--truth", "truth.csv").startswith("empty: is no folder of a run: must be")


def test_several_logs_and_runs_are_columns_of_one_table(capsys: Capture) -> None:
    run_folder()
    Path("other").mkdir()
    TrackLog.load_npz("software.npz").save_npz("other/mine.npz")
    assert main(["evaluate", "software.npz", "other/mine.npz", "run", "--truth", "truth.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == ["software", "mine", "run/hardware", "run/software", "run/model"]
    assert found["software"] == found["mine"] == found["run/hardware"]
    assert main(["evaluate", "software.npz", "other/mine.npz", "--truth", "truth.csv"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert rows[0].split() == ["software", "mine"]
    assert next(row.split()[1:] for row in rows if row.startswith("found")) == ["50", "50"]


def test_logs_of_one_name_are_told_apart_by_their_folders(capsys: Capture) -> None:
    Path("other").mkdir()
    TrackLog.load_npz("software.npz").save_npz("other/software.npz")
    assert main(["evaluate", "software.npz", "other/software.npz", "--truth", "truth.csv", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)) == ["software.npz", "other/software.npz"]


def test_a_log_that_cannot_be_scored_stops_no_other(capsys: Capture) -> None:
    Path("bad.npz").write_bytes(b"no log")
    TrackLog.load_npz("software.npz").save_npz("good.npz")
    assert main(["evaluate", "absent.npz", "software.npz", "bad.npz", "good.npz", "--truth", "truth.csv", "--json"]) == 2
    printed = capsys.readouterr()
    assert list(json.loads(printed.out)) == ["software", "good"]
    assert [line.split(":")[1].strip() for line in printed.err.splitlines()] == ["absent.npz", "bad.npz"]


def test_the_truth_of_another_recording_is_warned_of_in_one_line(capsys: Capture) -> None:
    other = [f"{t},0,200,150,30,40,0,0,1,0" for t in range(0, 1_000_000, 10_000)]
    Path("other.csv").write_text("\n".join([Path("truth.csv").read_text().splitlines()[0], *other]) + "\n")
    run_folder()
    assert main(["evaluate", "run", "--truth", "other.csv"]) == 0
    rule = "must be the truth of this recording, on its clock and in its pixels"
    assert capsys.readouterr().err == f"evcot: warning: other.csv: hardly any track meets an object: {rule}\n"
    assert main(["evaluate", "run", "--truth", "truth.csv"]) == 0
    assert capsys.readouterr().err == ""
    TrackLog.empty("rct").save_npz("nothing.npz")
    assert main(["evaluate", "nothing.npz", "--truth", "other.csv"]) == 0
    assert capsys.readouterr().err == ""  # who finds nothing tells nothing of the truth

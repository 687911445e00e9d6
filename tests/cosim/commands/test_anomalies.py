# SPDX-License-Identifier: Apache-2.0
"""`evcot anomalies` as a user meets it."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events
from evcot.recordings.files import write_events
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.cli import main

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]

ZONES = """
[[line]]
name = "gate"
begin = [0, 130]
end = [345, 130]

[[zone]]
name = "lawn, west"
kind = "forbidden"
polygon = [[0, 0], [30, 0], [30, 259], [0, 259]]
"""


def drive(track_id: int, begin_us: int, x: float, y_from: float, px_s: float) -> np.ndarray:
    """2 s straight up or down the picture."""
    records = np.zeros(201, TRACK)
    records["t_us"] = begin_us + np.arange(201) * 10_000
    records["kind"] = Kind.MOVED
    records["kind"][0], records["kind"][-1] = Kind.BORN, Kind.LOST
    records["track_id"], records["radius"], records["other_id"] = track_id, 10.0, -1
    records["width"] = records["height"] = 20.0
    records["x"], records["y"] = x, y_from + px_s * (records["t_us"] - begin_us) * 1e-6
    return records


def save(name: str, *tracks: np.ndarray) -> None:
    records = np.concatenate(tracks)
    records = records[np.argsort(records["t_us"], kind="stable")]
    TrackLog("rct", records, np.zeros(1000, np.int16)).save_npz(name)


@pytest.fixture(autouse=True)
def logs(home: Path) -> None:
    """monday.npz: ten cars that drive up; today.npz: four, and one that drives down."""
    save("monday.npz", *(drive(i, 500_000 * i, 100.0, 230, -100) for i in range(10)))
    save("today.npz", *(drive(i, 500_000 * i, 100.0, 230, -100) for i in range(4)), drive(7, 300_000, 101.0, 40, 100))
    Path("zones.toml").write_text(ZONES)
    t_us = np.linspace(0, 4_000_000, 1000).astype(np.int64)
    x = np.arange(1000).astype(np.uint16) % 346
    write_events(Path("today.csv"), (346, 260), [Events(t_us, x, x % 260, (x % 2).astype(np.uint8))])


def learned() -> None:
    assert main(["anomalies", "--learn", "monday.npz", "--sensor", "346x260", "-o", "normal.npz"]) == 0


def test_learn_then_tell(capsys: Capture) -> None:
    learned()
    assert capsys.readouterr().out.startswith("10 tracks, ")
    assert main(["anomalies", "today.npz", "--normal", "normal.npz", "--zones", "zones.toml"]) == 0
    printed = capsys.readouterr()
    head, row, counts, total = printed.out.splitlines()
    assert head.split() == ["time", "s", "track", "kind", "where", "x", "y", "seen", "expected", "unit", "score", "after", "s"]
    cells = row.split()
    assert cells[1:3] == ["7", "wrong_way"]
    assert 0.8 <= float(cells[0]) <= 2.0
    assert (cells[5], cells[6], cells[7]) == ("90", "-90", "deg")
    assert counts == "gate: 1 to the right, 4 to the left"
    assert total == "1 alarm on 5 tracks"
    assert printed.err == ""


def test_everything_as_json(capsys: Capture) -> None:
    learned()
    capsys.readouterr()
    arguments = ["anomalies", "today.npz", "--normal", "normal.npz", "--zones", "zones.toml", "--json"]
    assert main([*arguments, "--set", "wrong_way_deg=170", "--set", "hold_us=100000"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["tracks"] == 5
    assert found["lines"] == [{"name": "gate", "to_right": 1, "to_left": 4}]
    (alarm,) = found["alarms"]
    assert (alarm["kind"], alarm["track_id"], alarm["zone"], alarm["birth_us"]) == ("wrong_way", 7, None, 300_000)
    assert alarm["score"] == pytest.approx(180 / 170, abs=0.02)
    assert found["settings"]["hold_us"] == 100_000
    assert main(["anomalies", "--learn", "monday.npz", "today.npz", "-o", "both.npz", "--set", "cell_px=4", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["normal"], report["tracks"], report["width"], report["height"]) == ("both.npz", 14, 102, 241)


def test_alarms_go_into_files_and_a_picture(capsys: Capture) -> None:
    save("lawn.npz", drive(3, 0, 10.0, 230, -100))
    arguments = ["anomalies", "lawn.npz", "--zones", "zones.toml", "--picture", "alarms.png", "--force", "-o"]
    assert main([*arguments, "alarms.csv"]) == 0
    with Path("alarms.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["kind"], row["zone"], row["track_id"], row["unit"]) == ("forbidden", "lawn, west", "3", "s")
    assert main([*arguments, "alarms.json"]) == 0
    (same,) = json.loads(Path("alarms.json").read_text())
    assert {name: str(value) for name, value in same.items()} == row
    assert Path("alarms.png").read_bytes().startswith(b"\x89PNG")
    save("good.npz", drive(3, 0, 100.0, 230, -100))
    capsys.readouterr()
    assert main(["anomalies", "good.npz", "--zones", "zones.toml", "-o", "none.csv"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "0 alarms on 1 track"
    assert Path("none.csv").read_text().count("\n") == 1


def test_a_log_that_does_not_belong_is_refused(refused: Refused) -> None:
    learned()
    assert main(["anomalies", "today.npz", "--normal", "normal.npz", "--recording", "today.csv", "--sensor", "346x260"]) == 0
    assert refused("anomalies", "monday.npz", "--recording", "today.csv").startswith(
        "monday.npz: does not belong to today.csv: record "
    )
    log = TrackLog.load_npz("today.npz")
    TrackLog("rct", log.records, log.owner[:-1]).save_npz("short.npz")
    assert refused("anomalies", "short.npz", "--recording", "today.csv") == (
        "short.npz: does not belong to today.csv: owner has 999 entries: must be one for each of the recording's 1000 events"
    )
    assert refused("anomalies", "today.npz", "--normal", "normal.npz", "--sensor", "128x128") == (
        "sensor 128x128: must be that of the normal motion and the zones, 346x260"
    )
    save("wide.npz", drive(1, 0, 500.0, 230, -100))
    assert refused("anomalies", "wide.npz", "--normal", "normal.npz").startswith(
        "wide.npz: record 0: x = 500: must lie on the 346x260"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.npz"], "none.npz: cannot be read: No such file or directory"),
        (["today.npz", "monday.npz"], "2 logs: must be one, unless --learn is given"),
        (["today.npz", "--normal", "monday.npz"], "monday.npz: has no array format: must be a field of normal motion"),
        (["today.npz", "--zones", "none.toml"], "none.toml: cannot be read: No such file or directory"),
        (["today.npz", "-o", "alarms.txt"], "-o alarms.txt: suffix '.txt': must be one of .csv, .json, .npz"),
        (["today.npz", "-o", "no/alarms.csv"], "-o no/alarms.csv: cannot be written: No such file or directory"),
        (["today.npz", "--set", "hold"], "--set hold: must be KEY=VALUE"),
        (["today.npz", "--set", "hold=1"], "anomalies.hold: no such setting: must be one of step_us,"),
        (["today.npz", "--set", "hold_us=1.5"], "anomalies.hold_us = '1.5': must be a whole number"),
        (["today.npz", "--set", "fast_ratio=0"], "anomalies.fast_ratio = 0.0: must be from 1 to 100 (times the normal speed)"),
        (["today.npz", "--sensor", "wide"], "--sensor wide: must be WIDTHxHEIGHT in pixels"),
        (["--learn", "today.npz"], "-o FILE.npz: must say where normal motion goes"),
        (["--learn", "today.npz", "-o", "normal.csv"], "-o FILE.npz: must say where normal motion goes"),
        (["--learn", "today.npz", "-o", "n.npz", "--zones", "zones.toml"], "--zones: must not be given with --learn"),
        (["--learn", "today.npz", "-o", "n.npz", "--set", "cell_px=0"], "field.cell_px = 0: must be from 1 to 1024"),
    ],
)
def test_what_cannot_be_used_is_named(arguments: list[str], message: str, refused: Refused) -> None:
    assert refused("anomalies", *arguments).startswith(message)


def test_a_field_learned_otherwise_is_refused(refused: Refused) -> None:
    learned()
    assert refused("anomalies", "today.npz", "--normal", "normal.npz", "--set", "travel_px=8").startswith(
        "step_us = 25000, window_us = 500000, travel_px = 8: must be as when normal motion was learned"
    )

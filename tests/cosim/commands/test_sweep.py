# SPDX-License-Identifier: Apache-2.0
"""`evcot sweep` and `evcot tune`, from the command line to their files."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest

import evcot
from evcot.trackers.presets import run_config
from evcot_cosim.cli import main
from evcot_cosim.lockstep.lockstep import Lockstep
from evcot_cosim.lockstep.mismatch import MismatchError
from evcot_cosim.sweep.spec import SHIPPED, read_spec
from evcot_cosim.sweep.store import read_rows
from support.sweeping import recorded

from ..conftest import Refused

pytest.importorskip("pyarrow")

Capture = pytest.CaptureFixture[str]

SPEC = """
recordings = ["data"]
engines = ["rct"]
preset = "discs"
[objectives]
hota = "max"
idsw = "min"
[fields]
rct.radius_px = [6.0, 9.0, 14.0]
"""
# The shape is that of other tests, whose compiled model it shares.
FUZZ = """
seeds = { from = 1, to = 3 }
[fuzz]
modules = ["cot_array", "cot", "cot_motion"]
events = 400
[[fuzz.shapes]]
n_slots = 2
x_w = 7
y_w = 7
radix_w = 5
nev_w = 6
tc_w = 12
sup_w = 8
id_w = 16
seq_w = 16
time_w = 20
tick_w = 3
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "data").mkdir()
    for seed in (1, 2, 3):
        recorded(folder / "data", seed)
    (folder / "spec.toml").write_text(SPEC)
    return folder


@pytest.fixture(autouse=True)
def inside(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(made)


def test_a_sweep_writes_its_store_and_its_report(made: Path, capsys: Capture) -> None:
    assert main(["sweep", "spec.toml", "--dry-run", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["inputs"], told["runs"], told["invalid"], told["designs"]) == (3, 9, 0, 0)
    assert not (made / "build").exists()
    assert main(["sweep", "spec.toml", "--jobs", "1", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["runs"], summary["new"], summary["status"], summary["faults"]) == (9, 9, {"done": 9}, [])
    best = [each["means"]["hota"] for each in summary["best"]]
    assert best == sorted(best, reverse=True)
    folder = made / summary["folder"]
    names = {"run.toml", "sweep.toml", "report.html", "runs", "playback", "journal.jsonl", "runs.json"}
    assert {path.name for path in folder.iterdir()} == names
    page = (folder / "report.html").read_text()
    assert all(path in page and (folder / path).is_file() for path in summary["best"][0]["playback"])
    assert len(summary["best"][0]["playback"]) == 1
    first = {path: path.read_bytes() for path in folder.glob("playback/*")}
    assert main(["sweep", "spec.toml", "--jobs", "1"]) == 0
    assert "9 runs: 9 done; 0 now" in capsys.readouterr().out
    assert {path: path.read_bytes() for path in folder.glob("playback/*")} == first


def test_a_report_that_was_changed_is_kept(made: Path, capsys: Capture) -> None:
    assert main(["sweep", "spec.toml", "--jobs", "1", "-o", "kept", "-q"]) == 0
    (made / "kept" / "report.html").write_text("mine")
    assert main(["sweep", "spec.toml", "--jobs", "1", "-o", "kept", "-q"]) == 2
    assert "holds report.html, which evcot did not write or which has changed since" in capsys.readouterr().err
    assert (made / "kept" / "report.html").read_text() == "mine"


def test_one_run_alone_from_the_command_of_its_row(made: Path, capsys: Capture) -> None:
    assert main(["sweep", "spec.toml", "--jobs", "1", "-o", "only", "-q"]) == 0
    row = read_rows(made / "only")[0]
    program, *arguments = row["command"].split()
    assert program == "evcot"
    assert main(arguments) == 0
    printed = capsys.readouterr().out
    assert printed.endswith("as stored\n")
    assert f"{row['hota']:.6g}" in printed


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["sweep", "nothing.toml"], "nothing.toml: cannot be read: No such file or directory"),
        (["sweep", "fuzzz"], "fuzzz: cannot be read: No such file or directory (evcot's own are fuzz, leave_one_family_out)"),
        (["sweep", "data"], "data: is a folder: must be a specification"),
        (["sweep", "data", "--only", "1234567"], "data: is no folder of a sweep: must hold sweep.toml and runs"),
        (["sweep", "spec.toml", "--jobs", "0", "-o", "new"], "--jobs 0: must be at least 1"),
        (["sweep", "spec.toml", "--jobs", "1", "--scheduler", "tcp://127.0.0.1:1", "-o", "new"], "--jobs: must not be given"),
        (["sweep", "spec.toml", "-o", "data"], "holds files, and evcot did not make it"),
        (
            ["tune", "data/discs1.npz", "--field", "rct.radius_px", "-o", "new.toml"],
            "--field rct.radius_px: must be NAME=LOW..HIGH",
        ),
        (["tune", "data/discs1.npz", "--field", "cot.mode=1,2", "-o", "new.toml"], "must be a field of engine rct"),
        (
            ["tune", "data/discs1.npz", "--truth", "spec.toml", "--truth", "spec.toml", "-o", "new.toml"],
            "--truth: 2 for 1 recordings: must be given",
        ),
        (["tune", "data/discs1.npz", "--validate", "1", "-o", "new.toml"], "--validate 1: must be from 0.05 to 0.95"),
        (
            ["tune", "data/discs1.npz", "--objective", "best", "-o", "new.toml"],
            "--objective best: must be METRIC or METRIC:min",
        ),
        (["tune", "spec.toml", "-o", "new.toml"], "spec.toml"),
    ],
)
def test_what_cannot_be_is_one_line(arguments: list[str], why: str, refused: Refused) -> None:
    assert why in refused(*arguments)


def test_fuzzing_writes_junit_and_ends_with_1_on_a_mismatch(
    made: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    (made / "fuzz.toml").write_text(FUZZ)
    assert main(["sweep", "fuzz.toml", "--jobs", "1", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["status"] == {"done": 3, "invalid": 2}, "a single tracker has one slot, motion a time of 32 bits"
    array = summary["modules"]["cot_array"]
    assert (array["shapes"], array["runs"], array["exact"], array["mismatches"], array["events"]) == (1, 3, 3, 0, 1_200)
    assert main(["sweep", "fuzz.toml", "--jobs", "1"]) == 0
    assert re.search(r"cot_array +1 +3 +3 +0 +1,200", capsys.readouterr().out)
    root = ElementTree.parse(made / "build" / "sweep" / "fuzz" / "junit.xml").getroot()
    assert (root.get("tests"), root.get("failures"), root.get("errors"), root.get("skipped")) == ("5", "0", "0", "2")
    run = [case for case in root.iter("testcase") if case.find("skipped") is None]
    assert [case.get("name", "").rpartition(" ")[2] for case in run] == ["1", "2", "3"]
    row = next(row for row in read_rows(made / "build" / "sweep" / "fuzz") if row["seed"] == 2)
    assert (row["events"], row["status"], row["hardware"]) == (400, "done", "cot_array")
    assert row["cycles"] > 400

    def differs(self: Lockstep, events: evcot.Events) -> None:
        raise MismatchError(self._mismatch(7, 9, "owner", 1, 2))

    monkeypatch.setattr(Lockstep, "feed", differs)
    monkeypatch.setattr("evcot_cosim.sweep.run.LocalPool", InThisProcess)
    assert main(["sweep", "fuzz.toml", "-o", "differs", "--json"]) == 1
    summary = json.loads(capsys.readouterr().out)
    assert summary["status"] == {"mismatch": 3, "invalid": 2}
    assert len(summary["tests"]) == 3
    for test in summary["tests"]:
        assert "assert run_case(Case(CONFIG, EVENTS" in (made / "differs" / test).read_text()
    root = ElementTree.parse(made / "differs" / "junit.xml").getroot()
    assert root.get("failures") == "3"
    failure = next(root.iter("failure"))
    assert failure.get("message") == "cot_array: event 7, tick 9: owner: hardware has 1, model has 2"
    assert "--only" in (failure.text or "")


class InThisProcess:
    """In place of the pool, where something is patched."""

    def __init__(self, function, *_):  # type: ignore[no-untyped-def]
        self.function = function

    def __enter__(self):  # type: ignore[no-untyped-def]
        return self

    def __exit__(self, *_):  # type: ignore[no-untyped-def]
        return None

    def run(self, tasks):  # type: ignore[no-untyped-def]
        from evcot_cosim.sweep.pool import Done

        for task in tasks:
            yield Done(task, self.function(task), "", 1)


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tuning makes four sweeps, whose processes would all have to start."""
    monkeypatch.setattr("evcot_cosim.sweep.run.LocalPool", InThisProcess)


@pytest.mark.usefixtures("in_this_process")
def test_settings_are_chosen_on_some_recordings_and_validated_on_others(made: Path, capsys: Capture) -> None:
    arguments = ["--preset", "discs", "--field", "rct.radius_px=5.0..20.0", "--samples", "6", "--jobs", "1", "--json"]
    assert main(["tune", *(f"data/discs{seed}.npz" for seed in (1, 2, 3)), *arguments, "-o", "mine.toml"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (len(found["chosen_on"]), len(found["validated_on"]), found["tried"]) == (2, 1, 6)
    assert not set(found["chosen_on"]) & set(found["validated_on"])
    # Each figure is what track and evaluate say of the file that was written.
    for names, figure in ((found["chosen_on"], "chosen"), (found["validated_on"], "validated")):
        scores = []
        for name in names:
            log = evcot.track(made / "data" / name, "rct", config="mine.toml")
            truth = made / "data" / f"{Path(name).stem}.truth.csv"
            scores.append(evcot.evaluate(log, truth, sensor=(96, 64)).hota)
        assert found[figure] == pytest.approx(sum(scores) / len(scores), abs=1e-12)
    values = tomllib.loads((made / "mine.toml").read_text())
    assert values["rct"]["radius_px"] == found["settings"]["rct.radius_px"]
    assert main(["tune", "data/discs1.npz", "-o", "mine.toml"]) == 2, "it exists"


@pytest.mark.usefixtures("in_this_process")
def test_the_time_of_one_recording_is_divided(made: Path, capsys: Capture) -> None:
    arguments = [
        "--engine",
        "cot_array",
        "--preset",
        "discs",
        "--field",
        "cot.init_radix=8,10",
        "--samples",
        "3",
        "--jobs",
        "1",
    ]
    assert main(["tune", "data/discs2.npz", *arguments, "--validate", "0.5", "-o", "cot.toml"]) == 0
    printed = capsys.readouterr().out
    assert "validated on" in printed
    assert "Expect what the validation says" in printed
    values = tomllib.loads((made / "cot.toml").read_text())
    assert "x_w" not in values["shape"], "it follows the sensor"
    assert main(["track", "data/discs3.npz", "--engine", "cot_array", "--config", "cot.toml", "-o", "log.npz", "-q"]) == 0


def test_what_is_shipped_can_be_read() -> None:
    assert SHIPPED == ("fuzz", "leave_one_family_out")
    for name in SHIPPED:
        assert read_spec(name).name == name
    families = read_spec("leave_one_family_out").families
    assert set(families) == set(read_spec("leave_one_family_out").scenes)


@pytest.mark.usefixtures("in_this_process")
def test_where_nothing_is_better_the_preset_is_chosen(made: Path, capsys: Capture) -> None:
    arguments = ["--preset", "discs", "--field", "rct.radius_px=0.5..0.6", "--samples", "1", "--jobs", "1", "--json"]
    assert main(["tune", "data/discs1.npz", *arguments, "-o", "same.toml"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["settings"], found["tried"], found["gain_chosen"], found["gain_validated"]) == ({}, 1, 0, 0)
    assert found["warning"].startswith("nothing was gained")
    assert tomllib.loads((made / "same.toml").read_text())["rct"]["radius_px"] == run_config(96, 64, "discs").rct.radius_px

# SPDX-License-Identifier: Apache-2.0
"""summary.json and the table: figures from logs whose answers are known."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.config import CotConfig
from evcot.trackers.config import RunConfig
from evcot.tracks.compare import compare
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.lockstep.cosim import CosimRun
from evcot_cosim.lockstep.mismatch import Mismatch
from evcot_cosim.lockstep.run_file import read_run_file
from evcot_cosim.lockstep.summary import read_summary, summarise, summarise_mismatch, table, write_summary
from evcot_cosim.lockstep.verdict import verdict_from
from evcot_cosim.report import Material, Side, write_report
from evcot_cosim.rtl.build import BuiltModel


def log(engine: str, *rows: tuple[int, Kind, int, int], owned: int = 3) -> TrackLog:
    """Records of (t_us, kind, track_id, other_id), and four events of which the first `owned` were taken."""
    records = np.zeros(len(rows), TRACK)
    for record, (t_us, kind, track_id, other_id) in zip(records, rows, strict=True):
        record["t_us"], record["kind"], record["track_id"], record["other_id"] = t_us, kind, track_id, other_id
    return TrackLog(engine, records, np.where(np.arange(4) < owned, 0, -1).astype(np.int16))


LIVES = ((0, Kind.BORN, 0, -1), (100, Kind.BORN, 1, -1), (400, Kind.MERGED, 1, 0), (1_000, Kind.LOST, 0, -1))


def run_of(hardware: TrackLog, model: TrackLog, software: TrackLog) -> CosimRun:
    t_us = np.array([0, 500, 1_000, 2_000])
    events = Events(t_us, np.zeros(4, np.uint16), np.zeros(4, np.uint16), np.zeros(4, np.uint8))
    return CosimRun(
        recording=Recording(events, 8, 8, "four"),
        config=RunConfig(hardware=CotConfig()),
        hardware=hardware,
        model=model,
        software=software,
        agreement=compare(hardware, software, span_us=(0, 2_000)),
        cycles=12,
        latency=np.array([0, 0, 3, 0, 1]),
        wall_s=0.5,
        software_s=0.25,
        build=BuiltModel("cot_array", {"N": 8}, Path("Vcot_array"), "key", True, 0.01),
        seed=None,
    )


def test_figures_of_a_run() -> None:
    logs = log("cot_array", *LIVES), log("cot_array", *LIVES), log("rct", LIVES[0], owned=1)
    summary = summarise(run_of(*logs), "evcot cosim four.npz")
    assert summary["exact"] is True
    assert (summary["events"], summary["records"], summary["cycles"]) == (4, 4, 12)
    assert summary["recording_s"] == pytest.approx(0.002)
    assert summary["realtime_factor"] == pytest.approx(0.004)
    assert summary["events_per_s"] == pytest.approx(8)
    assert summary["software_events_per_s"] == pytest.approx(16)
    assert summary["cycles_per_event"] == pytest.approx(3)
    assert summary["latency_clocks"] == {"median": 2, "p99": 4, "max": 4, "histogram": [[2, 3], [4, 1]]}
    assert summary["births"] == {"hardware": 2, "model": 2, "software": 1}
    assert summary["merges"] == {"hardware": 1, "model": 1, "software": 0}
    assert summary["owned_fraction"] == {"hardware": 0.75, "model": 0.75, "software": 0.25}
    assert summary["lifetimes"]["hardware"] == {
        "tracks": 2, "lost": 1, "median_s": pytest.approx(0.00065), "longest_s": pytest.approx(0.001),
    }  # fmt: skip
    assert summary["lifetimes"]["software"]["longest_s"] == pytest.approx(0.002)
    assert {side: of.tracks for side, of in verdict_from(summary["verdict"]).figures.items()} == {"hardware": 2, "software": 1}
    assert summary["config"]["hardware"]["shape"]["n_slots"] == summary["slots"] == 8
    assert summary["command"] == "evcot cosim four.npz"
    assert set(summary["versions"]) == {"evcot", "python", "verilator", "compiler", "numpy", "numba", "pyverilator-mm"}


@pytest.mark.parametrize("other", [log("cot_array", *LIVES[:3]), log("cot_array", *LIVES, owned=2)])
def test_a_record_or_an_owner_that_differs_is_not_exact(other: TrackLog) -> None:
    summary = summarise(run_of(log("cot_array", *LIVES), other, log("rct")), "")
    assert summary["exact"] is False
    assert ("hardware = model", "NO") in table(summary)


def test_nothing_is_none_and_the_summary_is_json(tmp_path: Path) -> None:
    empty = [TrackLog(engine, np.empty(0, TRACK), np.full(4, -1, np.int16)) for engine in ("cot_array", "cot_array", "rct")]
    summary = summarise(run_of(*empty), "")
    assert summary["lifetimes"]["software"] == {"tracks": 0, "lost": 0, "median_s": None, "longest_s": None}
    write_summary(summary, tmp_path / "summary.json")
    assert json.loads((tmp_path / "summary.json").read_text())["agreement"]["distance_median_px"] is None
    assert ("distance of pairs", "no pair") in table(summary)
    with pytest.raises(ValueError, match="Out of range float"):
        write_summary({"rate": float("nan")}, tmp_path / "nan.json")


def test_a_summary_of_an_earlier_release_is_read_with_its_pairs_counted(tmp_path: Path) -> None:
    lives = ((0, Kind.BORN, 0, -1), (100, Kind.BORN, 1, -1), (1_900, Kind.MERGED, 1, 0), (2_000, Kind.LOST, 0, -1))
    summary = summarise(run_of(log("cot_array", *lives), log("cot_array", *lives), log("rct", *lives)), "")
    assert summary["agreement"]["tracks_paired"] > 0
    write_summary(summary, tmp_path / "new.json")
    assert read_summary(tmp_path / "new.json") == json.loads(json.dumps(summary))
    assert summary["agreement"]["merges_comparable_hardware"] > 0
    counted = ("tracks_paired", "merges_paired", "merges_comparable_hardware", "merges_comparable_software")
    earlier = {key: value for key, value in summary["agreement"].items() if key not in counted}
    write_summary(summary | {"agreement": earlier}, tmp_path / "earlier.json")
    assert read_summary(tmp_path / "earlier.json") == read_summary(tmp_path / "new.json")


def test_summary_of_a_mismatch() -> None:
    config = RunConfig(hardware=CotConfig())
    found = Mismatch(7, 70, "owner", 1, -1, 5, config.hardware)
    recording = run_of(log("cot_array"), log("cot_array"), log("rct")).recording
    summary = summarise_mismatch(found, recording, config, "evcot cosim four.npz")
    assert summary["exact"] is False
    kept = summary["mismatch"]
    assert [kept[name] for name in ("event_index", "tick", "field", "hardware", "model", "seed")] == [7, 70, "owner", 1, -1, 5]
    assert (kept["config"]["module"], kept["config"]["shape"]["n_slots"]) == ("cot_array", 8)


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    """The summary of a run, as another version of evcot has written it."""
    logs = log("cot_array", *LIVES), log("cot_array", *LIVES), log("rct", LIVES[0], owned=1)
    summary = summarise(run_of(*logs), "evcot cosim four.npz")
    summary["versions"]["evcot"] = "0.0.9"
    path = tmp_path / "summary.json"
    write_summary(summary, path)
    assert read_summary(path)["versions"]["evcot"] == "0.0.9"  # what has all figures is read, whoever wrote it
    return path


@pytest.mark.parametrize(
    "place",
    [
        ("latency_clocks", "p99"), ("agreement", "radius_px"), ("agreement", "merges"), ("verdict", "headline"),
        ("verdict", "figures", "software"), ("verdict", "figures", "hardware", "short"),
    ],
    ids=".".join,
)  # fmt: skip
def test_a_run_of_an_older_version_that_lacks_a_figure_is_one_sentence(stored: Path, place: tuple[str, ...]) -> None:
    summary = json.loads(stored.read_text())
    inner = summary
    for name in place[:-1]:
        inner = inner[name]
    del inner[place[-1]]
    stored.write_text(json.dumps(summary))
    with pytest.raises(ConfigError) as error:
        read_summary(stored)
    advice = f"it is of 0.0.9, and this is {evcot.__version__}: run `evcot cosim` on its recording again"
    assert str(error.value) == f"{stored}: lacks {'.'.join(place)}: {advice}"


def test_how_many_figures_are_lacking_is_said_and_a_damaged_section_too(stored: Path) -> None:
    summary = json.loads(stored.read_text())
    summary["latency_clocks"], summary["agreement"] = {}, [3]
    summary["versions"]["evcot"] = evcot.__version__
    stored.write_text(json.dumps(summary))
    with pytest.raises(ConfigError, match=r"lacks latency_clocks\.median and 4 more: it was changed, or an earlier"):
        read_summary(stored)
    stored.write_text(json.dumps({"verdict": 5}))
    with pytest.raises(ConfigError, match="lacks verdict: it is of an unknown version of evcot, and this is"):
        read_summary(stored)


def test_configuration_of_an_older_version_says_so(stored: Path) -> None:
    run = stored.with_name("run.toml")
    run.write_text('hardware = "cot_motion"\n[motion]\nold_register = 3\n')
    with pytest.raises(ConfigError, match=r"old_register.*; it is of 0\.0\.9, and this is .*: run `evcot cosim`"):
        read_run_file(run)
    stored.write_text("no JSON")
    with pytest.raises(ConfigError) as error:
        read_run_file(run)
    assert "evcot cosim" not in str(error.value)


def test_the_page_of_a_run_needs_no_figure_that_is_not_checked(stored: Path) -> None:
    """What the report reads of a summary, `read_summary` has found there: sections by themselves may be missing."""
    summary = json.loads(stored.read_text())
    recording = run_of(*(log("cot_array", *LIVES) for _ in range(3))).recording
    sides = tuple(Side(name, log("cot_array", *LIVES)) for name in ("hardware", "software"))
    for section in ("latency_clocks", "agreement", "verdict", "config", "build", "filters", "owned_fraction", "slots"):
        stored.write_text(json.dumps({key: value for key, value in summary.items() if key != section}))
        write_report(Material(recording, read_summary(stored), sides), stored.with_name("report.html"), force=True)

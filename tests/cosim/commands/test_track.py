# SPDX-License-Identifier: Apache-2.0
"""`evcot track`: a recording in, a track log out, with any engine."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.filters.config import FilterConfig
from evcot.filters.run import apply
from evcot.hardware.golden import track as cot_track
from evcot.recordings.files import read_recording, write_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.config import RunConfig, load_toml
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import MOTION, fit, preset, run_config
from evcot.trackers.rct.config import PRESETS
from evcot.trackers.rct.tracker import track as rct_track
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.cli import main

from ..conftest import Refused


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four discs for a fifth of a second."""
    path = tmp_path_factory.mktemp("track") / "discs.npz"
    write_recording(simulate_scene("discs", 5, {"duration_us": 200_000}).recording, path)
    return path


@pytest.fixture
def source(recorded: Path, home: Path) -> Path:
    """The same; the working folder is empty."""
    return recorded


def tracked(source: Path, *options: str) -> TrackLog:
    assert main(["track", str(source), "-o", "log.npz", "-q", "--force", *options]) == 0
    return TrackLog.load_npz("log.npz")


def assert_same(got: TrackLog, wanted: TrackLog) -> None:
    assert np.array_equal(got.records, wanted.records)
    assert np.array_equal(got.owner, wanted.owner)


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("engine", sorted(ENGINES.keys() - {"cot"}))  # a single tracker follows one of four
def test_every_engine_follows_the_discs(source: Path, engine: str) -> None:
    log = tracked(source, "--engine", engine)
    assert log.engine == engine
    assert len(log.owner) == len(read_recording(source).events)
    assert len(log.of_kind(Kind.BORN)) >= 4


def test_the_default_is_the_model_of_the_default_hardware(source: Path) -> None:
    log = tracked(source)
    assert log.engine == "cot_motion"
    recording = read_recording(source)
    assert_same(log, cot_track(recording, run_config(346, 260).device_config()))
    assert_same(log, evcot.track(recording))
    assert_same(log, tracked(source, "--engine", "cot_motion", "--preset", "motion"))


def test_adaptive_prints_its_estimates_unless_asked_to_be_quiet(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", str(source), "--json", "--engine", "adaptive"]) == 0
    assert re.fullmatch(r"adaptive: 346x260, 0.2 s, noise [0-9.]+ Hz/pixel, 0 hot pixels, .*\n", capsys.readouterr().err)
    for quiet in (["-q", "--engine", "adaptive"], ["--json"]):
        assert main(["track", str(source), *quiet]) == 0
        assert capsys.readouterr().err == ""


def test_settings_come_from_the_preset_then_the_file_then_the_options(source: Path) -> None:
    Path("mine.toml").write_text("[rct]\nradius_px = 9.0\nlifetime_us = 7_000\n")
    name = list(PRESETS)[-1]
    config = replace(PRESETS[name], radius_px=9.0, lifetime_us=8_000)
    log = tracked(source, "--engine", "rct", "--preset", name, "--config", "mine.toml", "--set", "lifetime_us=8000")
    assert_same(log, rct_track(read_recording(source), config))


def test_the_hardware_s_model_takes_a_preset_of_the_hardware(source: Path) -> None:
    recording = read_recording(source)
    config: RunConfig = fit(preset("davis346"), recording.width, recording.height)
    log = tracked(source, "--engine", "cot_array", "--preset", "davis346")
    assert_same(log, cot_track(recording, config.hardware))


def test_a_file_with_registers_of_slots_is_on_top_of_the_preset_for_the_sensor(source: Path) -> None:
    Path("slots.toml").write_text("[cot]\nmax_ticks = 12_000\n")
    config = load_toml(Path("slots.toml"), fit(preset("davis346"), 346, 260))
    log = tracked(source, "--engine", "cot_array", "--config", "slots.toml")
    assert_same(log, cot_track(read_recording(source), config.hardware))


def test_single_registers_of_motion_can_be_changed(source: Path) -> None:
    log = tracked(source, "--set", "birth_support=150", "--set", "seed_px=5")
    assert_same(log, evcot.track(source, birth_support=150, seed_px=5))
    assert not np.array_equal(log.records, tracked(source).records)


def test_filters_that_are_given_follow_nothing(source: Path) -> None:
    recording = read_recording(source)
    held = replace(MOTION.filters, activity_noise_hz=0.0, activity_support=2)
    log = tracked(source, "--activity-support", "2")
    assert np.array_equal(log.owner == -2, ~apply(recording, held)[1])
    without = tracked(source, "--activity", "0")
    assert np.array_equal(without.owner == -2, ~apply(recording, FilterConfig(refractory_us=1_000, cell_px=1))[1])


@pytest.mark.parametrize("engine", [("rct",), ("cot_array", "--preset", "davis346")])
def test_filters_go_in_front_of_any_engine(source: Path, engine: tuple[str, ...]) -> None:
    recording = read_recording(source)
    _, keep = apply(recording, FilterConfig(activity_us=2_000))
    log = tracked(source, "--engine", *engine, "--activity", "2")
    assert 0 < np.count_nonzero(keep) < len(keep)
    assert np.array_equal(log.owner == -2, ~keep)


@pytest.mark.parametrize("option", ["-o", "--csv"])
def test_records_are_written_as_csv(source: Path, option: str, refused: Refused) -> None:
    log = tracked(source)
    assert main(["track", str(source), option, "y.csv", "-q"]) == 0
    log.write_csv("wanted.csv")
    assert Path("y.csv").read_text() == Path("wanted.csv").read_text()
    message = "y.csv: CSV has records alone, without owners: must be the .npz or .parquet log of the same run"
    assert message in refused("plot", str(source), "y.csv", "-o", "y.png")


def test_a_log_of_another_suffix_is_not_written(source: Path) -> None:
    with pytest.raises(evcot.OutputError, match=r"^y\.log: suffix '\.log': must be one of \.npz, \.parquet, \.csv$"):
        tracked(source).save("y.log")
    assert {path.name for path in Path().iterdir()} == {"log.npz"}


def test_a_run_that_saves_nothing_says_so(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", str(source)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "nothing was saved: -o LOG.npz writes the track log, --boxes its boxes"
    assert main(["track", str(source), "--csv", "y.csv"]) == 0
    assert "nothing was saved" not in capsys.readouterr().out


def test_a_window_of_the_recording(source: Path) -> None:
    log = tracked(source, "--from", "50", "--to", "150")
    events = read_recording(source).window(50_000, 150_000).events
    assert len(log.owner) == len(events)
    assert log.records["t_us"].min() >= events.t_us[0]


def test_the_table_and_json_say_what_was_found(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", str(source), "--engine", "rct", "--csv", "log.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    log = rct_track(read_recording(source), PRESETS["plain"])
    counts = [len(log.of_kind(kind)) for kind in (Kind.BORN, Kind.MERGED, Kind.LOST)]
    assert [found[name] for name in ("tracks", "merged", "lost")] == counts
    assert found["alive_at_the_end"] == counts[0] - counts[1] - counts[2]
    assert found["events"] == len(log.owner) == found["owned"] + found["passed"] + found["filtered"]
    assert found["settings"]["radius_px"] == PRESETS["plain"].radius_px
    lives = [
        rows["t_us"][-1] - rows["t_us"][0] for rows in (log.records[log.records["track_id"] == i] for i in range(counts[0]))
    ]
    assert found["longest_track_s"] == max(lives) / 1e6
    assert len(Path("log.csv").read_text().splitlines()) == 1 + len(log.records)

    assert main(["track", str(source), "--engine", "rct"]) == 0
    assert f"tracks{'':>12}{counts[0]}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--preset trafic", "--preset trafic: must be one of plain, traffic, discs with --engine rct; did you mean traffic?"),
        ("--preset none", "--preset none: must be one of plain"),
        ("--engine frames --preset cars", "--preset cars: must be one of discs, traffic with --engine frames"),
        ("--engine mean-shift --preset x", "--preset x: must be one of discs, traffic with --engine mean-shift"),
        ("--engine frames --preset disc", "--preset disc: must be one of discs, traffic with --engine frames"),
        ("--engine cot_array --preset plain", "--preset plain: must be one of slow"),
        ("--set radius", "--set radius: must be KEY=VALUE with a key among max_clusters"),
        ("--set radium=3", "--set radium=3: must be KEY=VALUE with a key among max_clusters"),
        ("--set radius_px=wide", "rct.radius_px = 'wide': must be a number"),
        ("--set radius_px=-1", "rct.radius_px = -1.0: must be from "),
        ("--engine cot_motion --set init_radix=3", "--set init_radix=3: must be KEY=VALUE with a key among step_log2"),
        ("--config none.toml", "none.toml: cannot be read: No such file"),
        ("--config wrong.toml", "wrong.toml: top level: unknown field 'cot': must be one of filters, rct"),
        ("--config bad.toml", "bad.toml: [rct]: unknown field 'radix': must be one of "),
        ("--activity -1", "filters.activity_us = -1000: must be from "),
        ("--from 999 ", "holds no events from 0.999 s"),
        ("--set radius_pxx=3", "; did you mean radius_px?"),
        ("--engine cot_motion --set radus=3", "; did you mean radius_px of --engine rct?"),
        ("-o y.xlsx", "-o y.xlsx: suffix '.xlsx': must be one of .npz, .parquet, .csv"),
        (
            "--engine cot_array --preset dvs128 --set seed_px=5",
            "engine cot_array with preset dvs128: no single setting can be changed: its slots have",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line(source: Path, refused: Refused, options: str, message: str) -> None:
    Path("wrong.toml").write_text("[cot]\n")
    Path("bad.toml").write_text("[rct]\nradix = 3\n")
    said = refused("track", str(source), "--engine", "rct", "-o", "log.npz", *options.split())
    assert said.removeprefix(f"{source}: ").startswith(message) or (message.startswith(";") and said.endswith(message))

# SPDX-License-Identifier: Apache-2.0
"""What a run was made of: run.toml repeats it exactly, from any folder; the truth of its recording; its named moments."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.digest import digest
from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig
from evcot.hardware.golden import track
from evcot.metrics import evaluate
from evcot.recordings.files import write_recording
from evcot.scenes import simulate_scene
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import PRESETS
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.lockstep.moments import Moment, find_moment
from evcot_cosim.lockstep.run_file import RunFile, Source, read_run_file, run_toml, write_run_file
from evcot_cosim.lockstep.truth import Truth, scene_truth


def events(n: int = 50) -> Events:
    t = np.arange(n, dtype=np.int64)
    return Events(t, (t % 40).astype(np.uint16), (t % 30).astype(np.uint16), (t % 2).astype(np.uint8))


def back(run: RunFile, folder: Path) -> RunFile:
    write_run_file(folder / "run.toml", run)
    found = read_run_file(folder / "run.toml")
    assert found is not None
    return found


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_comes_back_as_it_was(name: str, tmp_path: Path) -> None:
    run = RunFile(Source("boxes", is_scene=True, seed=7), 3, "0123", PRESETS[name])
    assert back(run, tmp_path) == run


def test_slots_and_filters_of_their_own_come_back(tmp_path: Path) -> None:
    base = PRESETS["davis346"].hardware
    slots = tuple(replace(slot, init_radix=11 + i % 3) for i, slot in enumerate(base.slots))
    filters = FilterConfig(region=(1, 2, 30, 40), polarity="on", hot_pixels=((3, 4), (5, 6)), decay_tau_us=1500.0)
    config = RunConfig("own", CotConfig(base.shape, slots, 3), PRESETS["slow"].rct, filters)
    run = RunFile(Source("boxes", is_scene=True, from_us=5, to_us=500), None, "", config)
    assert back(run, tmp_path) == run


def test_a_file_is_named_from_the_root_and_a_scene_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    config = PRESETS["slow"]
    assert f'recording = "{tmp_path}/x.npz"' in run_toml(RunFile(Source("x.npz"), None, "", config))
    text = run_toml(RunFile(Source("boxes", is_scene=True, seed=0), None, "", config))
    assert 'scene = "boxes"' in text
    assert "recording" not in text
    assert "seed = 0" in text


def test_the_current_folder_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a file that is called as a scene is, nor one of the recording's name."""
    home, away = tmp_path / "home", tmp_path / "away"
    for folder, count in ((home, 100), (away, 50)):
        folder.mkdir()
        write_recording(Recording(events(count), 40, 30, "x"), folder / "x.npz")
        (folder / "boxes").write_text("no scene")
    (home / "file.toml").write_text("[run]\nrecording = 'x.npz'\n")
    (home / "scene.toml").write_text("[run]\nscene = 'boxes'\nto_us = 1000\n")
    monkeypatch.chdir(away)
    file, scene = read_run_file(Path("../home/file.toml")), read_run_file(home / "scene.toml")
    assert file is not None
    assert scene is not None
    assert len(file.source.read().events) == 100
    assert scene.source.name == "boxes"
    assert len(scene.source.read().events)
    assert scene.source.scene_truth() is not None
    assert back(scene, home) == scene
    assert not Source.named("boxes").is_scene  # on the command line a file comes first
    monkeypatch.chdir(tmp_path)
    assert Source.named("boxes").is_scene


def test_the_digest_tells_every_field_of_every_event() -> None:
    same = digest(events())
    assert same == digest(events()) == digest(events(100)[:50])
    for field in ("t_us", "x", "y", "p"):
        column = getattr(events(), field).copy()
        column[17] ^= 1
        assert digest(replace(events(), **{field: column})) != same


def test_a_recording_that_has_changed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    write_recording(Recording(events(), 40, 30, "x"), path)
    source = Source(str(path))
    run = RunFile(source, None, digest(source.read().events), PRESETS["slow"])
    run.check(tmp_path / "run.toml", source.read().events)
    write_recording(Recording(events(49), 40, 30, "x"), path, force=True)
    with pytest.raises(ConfigError, match=r"run\.toml: run\.digest = '\w+': must be that of .*x\.npz, which has changed since"):
        run.check(tmp_path / "run.toml", source.read().events)


def test_a_configuration_alone_is_no_run(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text("[cot]\nhist_avg = 2\n")
    assert read_run_file(tmp_path / "own.toml") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("run = 3", r"\[run\] must be a table, not 3"),
        ("[run]\nfile = 'x'", r"\[run\]: unknown field 'file': must be one of digest, from_us, height"),
        ("[run]\nstalls = 3", r"\[run\]: must have either recording, a file, or scene, one of boxes, "),
        ("[run]\nrecording = 'x.npz'\nscene = 'boxes'", r"\[run\]: must have either recording, a file, or scene"),
        ("[run]\nscene = 'nowhere'", r"run\.scene = 'nowhere': must be one of boxes, "),
        ("[run]\nrecording = 3", r"run\.recording = 3: must be text"),
        ("[run]\nrecording = 'boxes'\nfrom_us = -1", r"run\.from_us = -1: must be a whole number, not negative"),
        ("[run]\nrecording = 'boxes'\nstalls = true", r"run\.stalls = True: must be a whole number"),
        ("[run]\nrecording = 'boxes'\nskip_damaged = 1", r"run\.skip_damaged = 1: must be true or false"),
        ("[run]\nrecording = 'boxes'\nhardware = 'cot'", r"\[run\]: unknown field 'hardware'"),
        ("hardware = 'gpu'", r"hardware = 'gpu': must be one of cot, cot_chain, cot_array, cot_motion"),
    ],
)
def test_a_table_run_that_cannot_be_used(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(ConfigError, match=r"run\.toml: " + message):
        read_run_file(tmp_path / "run.toml")


@pytest.fixture(scope="module")
def truth() -> Truth:
    scene = simulate_scene("discs", 1, {"duration_us": 200_000})
    return scene_truth(scene.truth, (scene.recording.width, scene.recording.height))


def test_a_summary_has_objects_and_the_scores_of_each_side(truth: Truth) -> None:
    log = TrackLog.empty("rct")
    found = truth.figures({"hardware": log, "software": log})
    assert found is not None
    assert found["objects"] == len(truth.objects.ids) == 6
    assert found["alive_mean"] == pytest.approx(6.0)
    assert found["rule"] == truth.words
    assert found["scores"] == dict.fromkeys(("hardware", "software"), evaluate(log, truth.objects, truth.rule).to_dict())


def test_objects_that_do_not_count_are_not_counted(truth: Truth) -> None:
    objects = truth.objects.objects.copy()
    objects["counted"] &= objects["object"] != 2
    kept = Truth(type(truth.objects)(truth.objects.instants_us, objects, truth.objects.ids), truth.rule)
    found = kept.figures({})
    assert found is not None
    assert (found["objects"], found["alive_mean"]) == (5, pytest.approx(5.0))


def test_a_truth_of_another_time_has_no_figures(truth: Truth) -> None:
    late_us = int(truth.objects.instants_us[-1]) + 1
    assert truth.within(late_us, late_us + 1_000).figures({"hardware": TrackLog.empty("rct")}) is None


def test_the_part_within_some_time_has_its_instants_only(truth: Truth) -> None:
    instants_us = truth.objects.instants_us
    part = truth.within(int(instants_us[3]), int(instants_us[7]))
    assert part.objects.instants_us.tolist() == instants_us[3:8].tolist()
    assert np.unique(part.objects.objects["frame"]).tolist() == [0, 1, 2, 3, 4]


@pytest.fixture
def recording(blobs: Events) -> Recording:
    return Recording(blobs, 128, 128, "blobs")


def test_a_moment_of_a_track_is_named_by_the_id_that_records_have(recording: Recording, config: CotConfig) -> None:
    log = track(recording, config)
    for name, kind in (("birth", Kind.BORN), ("move", Kind.MOVED), ("merge", Kind.MERGED), ("loss", Kind.LOST)):
        records = log.of_kind(kind)
        assert len(records) >= 1, name
        ids = records["track_id"].tolist()
        assert find_moment(name, recording, config) == find_moment(f"{name}:{ids[0]}", recording, config)
        for track_id in dict.fromkeys(ids):
            wanted = min(int(records["event_index"][ids.index(track_id)]), len(recording.events) - 1)
            found = find_moment(f"{name}:{track_id}", recording, config)
            assert found == Moment(wanted, f"{name} {track_id}", kind, track_id)
        with pytest.raises(
            ConfigError, match=rf"^--around {name}:999: must be the id of a track with a {name}: {min(ids)}, .*{max(ids)}$"
        ):
            find_moment(f"{name}:999", recording, config)


def test_events_and_times(recording: Recording, config: CotConfig) -> None:
    t_us = recording.events.t_us
    assert find_moment("event:17", recording, config) == Moment(17, "event 17")
    assert find_moment("time:0", recording, config).event_index == 0
    ms = (t_us[300] - t_us[0]) / 1000
    found = find_moment(f"time:{ms}", recording, config).event_index
    assert t_us[found] == t_us[300]
    assert found == 0 or t_us[found - 1] < t_us[300]


def test_the_mismatch_of_a_run(recording: Recording, config: CotConfig, tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text(json.dumps({"mismatch": {"event_index": 31}}))
    assert find_moment("mismatch", recording, config, tmp_path) == Moment(31, "mismatch")
    (tmp_path / "summary.json").write_text(json.dumps({"exact": True}))
    with pytest.raises(ConfigError, match="there is none: hardware and model agreed in this run"):
        find_moment("mismatch", recording, config, tmp_path)
    with pytest.raises(ConfigError, match="needs the folder of a run"):
        find_moment("mismatch", recording, config)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("merge:x", "must be birth:ID"),
        ("merge:", "must be birth:ID"),
        ("merge:9999", "must be the id of a track with a merge: "),
        ("event", "must be birth:ID"),
        ("event:-1", "must be birth:ID"),
        ("event:99999999", "must be from event:0 to event:"),
        ("time:soon", "must be birth:ID"),
        ("time:nan", "must be from time:0 to time:"),
        ("time:1e9", "must be from time:0 to time:"),
        ("mismatch:2", "must be birth:ID"),
        ("noon", "must be birth:ID"),
    ],
)
def test_what_is_no_moment(text: str, message: str, recording: Recording, config: CotConfig) -> None:
    with pytest.raises(ConfigError) as error:
        find_moment(text, recording, config)
    assert str(error.value).startswith(f"--around {text}: {message}")

# SPDX-License-Identifier: Apache-2.0
"""The truth of a run's recording, and named moments of a run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.config import CotConfig
from evcot.hardware.golden import track
from evcot.metrics import evaluate
from evcot.scenes import simulate_scene
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.lockstep.moments import Moment, find_moment
from evcot_cosim.lockstep.truth import Truth, scene_truth


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

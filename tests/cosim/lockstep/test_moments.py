# SPDX-License-Identifier: Apache-2.0
"""Moments by name: which event is meant, and one line for what there is not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.config import CotConfig
from evcot.hardware.golden import track
from evcot.tracks.log import Kind
from evcot_cosim.lockstep.moments import Moment, find_moment


@pytest.fixture
def recording(blobs: Events) -> Recording:
    return Recording(blobs, 128, 128, "blobs")


def test_records_are_counted_from_one_in_their_order(recording: Recording, config: CotConfig) -> None:
    log = track(recording, config)
    for name, kind in (("birth", Kind.BORN), ("move", Kind.MOVED), ("merge", Kind.MERGED), ("loss", Kind.LOST)):
        records = log.of_kind(kind)
        assert len(records) >= 1, name
        assert find_moment(name, recording, config) == find_moment(f"{name}:1", recording, config)
        n = len(records)
        last = find_moment(f"{name}:{n}", recording, config)
        wanted = min(int(records[-1]["event_index"]), len(recording.events) - 1)
        assert last == Moment(wanted, f"{name} {n}", kind, int(records[-1]["track_id"]))
        with pytest.raises(ConfigError, match=rf"^--around {name}:{n + 1}: must be from 1 to {n}$"):
            find_moment(f"{name}:{n + 1}", recording, config)


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
        ("merge:x", "must be birth:N"),
        ("merge:", "must be birth:N"),
        ("merge:0", "must be from 1 to "),
        ("event", "must be birth:N"),
        ("event:-1", "must be birth:N"),
        ("event:99999999", "must be from event:0 to event:"),
        ("time:soon", "must be birth:N"),
        ("time:nan", "must be from time:0 to time:"),
        ("time:1e9", "must be from time:0 to time:"),
        ("mismatch:2", "must be birth:N"),
        ("noon", "must be birth:N"),
    ],
)
def test_what_is_no_moment(text: str, message: str, recording: Recording, config: CotConfig) -> None:
    with pytest.raises(ConfigError) as error:
        find_moment(text, recording, config)
    assert str(error.value).startswith(f"--around {text}: {message}")

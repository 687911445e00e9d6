# SPDX-License-Identifier: Apache-2.0
"""Trackers of other packages: found by their entry points, and every answer checked. docs/plug_in.md is installed by
tests/cosim/commands/test_plug_in.py."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import evcot
from evcot.errors import ConfigError, EngineError
from evcot.trackers import engines
from evcot.trackers.engines import ENGINES, Engine, usable_engines
from evcot.trackers.plug_in import PlugInTracker
from evcot.tracks.tracking import log_of as log_of_blocks
from support.logs import log_of
from support.refusals import refused

MODULE = """
from dataclasses import dataclass
import numpy as np
from evcot import TRACK

@dataclass(frozen=True)
class Settings:
    side_px: int = 8

    def __post_init__(self):
        if self.side_px < 1:
            raise ValueError("side_px must be positive")

class Idle:
    def __init__(self, width, height, settings=Settings()):
        self.made_of = width, height, settings

    def feed(self, events):
        return np.zeros(0, TRACK), np.full(len(events), -1)

    def finish(self):
        return np.zeros(0, TRACK)

def from_sensor(width, height):
    return Idle(width, height)

def raises(width, height):
    return {}["absent"]

def without_finish(width, height):
    return object()

def three(width, height, depth):
    return Idle(width, height)

def no_default(width, height, settings):
    return Idle(width, height)

number = 3
"""
Found = Callable[..., dict[str, Engine]]


@pytest.fixture
def found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Found]:
    """Installs packages, given as name = lines of entry points, and returns the engines of all of them."""
    monkeypatch.syspath_prepend(tmp_path)

    def install(**packages: str) -> dict[str, Engine]:
        (tmp_path / "idle_tracker.py").write_text(MODULE)
        for name, lines in packages.items():
            info = tmp_path / f"{name}-1.0.dist-info"
            info.mkdir()
            (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
            (info / "entry_points.txt").write_text(f"[evcot.trackers]\n{lines}\n")
        importlib.invalidate_caches()
        monkeypatch.setattr(ENGINES, "_plugged", engines._plug_ins())
        return {name: engine for name, engine in ENGINES.items() if engine.plug_in}

    yield install
    sys.modules.pop("idle_tracker", None)


RECORDING = evcot.Recording(evcot.Events(np.arange(10, 13), *np.zeros((2, 3), np.uint16), np.zeros(3, np.uint8)), 32, 24)


def test_an_engine_of_another_package_is_one_of_ours(found: Found) -> None:
    made = found(idle="idle = idle_tracker:Idle\nplain = idle_tracker:from_sensor")
    assert {name: engine.title for name, engine in made.items()} == {
        "idle": "tracker of package idle", "plain": "tracker of package idle",
    }  # fmt: skip
    log = evcot.track(RECORDING, "idle")
    assert (log.engine, log.owner.tolist(), log.owner.dtype, len(log.records)) == ("idle", [-1, -1, -1], np.int16, 0)
    assert evcot.track(RECORDING, "plain").engine == "plain"
    assert {"idle", "plain", "rct"} <= {*usable_engines()}
    assert [path.name for path in made["idle"].sources] == ["idle_tracker.py"]
    assert ENGINES["rct"].sources == []


def test_it_gets_sensor_and_settings(found: Found) -> None:
    found(idle="idle = idle_tracker:Idle\nplain = idle_tracker:from_sensor")
    tracker: Any = evcot.tracker((32, 24), "idle", side_px=5)
    width, height, settings = tracker._tracker.made_of
    assert (width, height, settings.side_px) == (32, 24, 5)
    with pytest.raises(ConfigError, match=r"^idle\.side: no such setting: must be one of side_px; did you mean side_px\?$"):
        evcot.tracker((32, 24), "idle", side=5)
    with pytest.raises(ConfigError, match=r"^plain\.side_px: no such setting: engine plain has none$"):
        evcot.tracker((32, 24), "plain", side_px=5)
    with pytest.raises(ConfigError, match=r"^idle: side_px = 0: ValueError: side_px must be positive$"):
        evcot.tracker((32, 24), "idle", side_px=0)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("no_such_module:Tracker", "cannot be loaded: ModuleNotFoundError: No module named 'no_such_module'"),
        ("idle_tracker:Other", "cannot be loaded: AttributeError: module 'idle_tracker' has no attribute 'Other'"),
        ("idle_tracker:number", "is of type int: must be callable with (width, height) or (width, height, settings)"),
        ("idle_tracker:three", "missing a required argument: 'depth': must be callable with (width, height) or"),
        ("idle_tracker:no_default", "default of settings is none: must be an instance of a dataclass"),
        ("idle_tracker:raises", "cannot be made: KeyError: 'absent' (idle_tracker.py, line 28)"),
        ("idle_tracker:without_finish", "makes something of type object without feed: must have feed and finish"),
    ],
)
def test_what_an_entry_point_cannot_be_is_one_line(found: Found, value: str, message: str) -> None:
    found(theirs=f"mine = {value}")
    with refused(EngineError, start=f"engine mine of package theirs: {value}: {message}"):
        evcot.track(RECORDING, "mine")
    assert "rct" in usable_engines()  # the others are as usable as before


@pytest.mark.parametrize(
    ("packages", "name", "message"),
    [
        (
            {"theirs": "rct = idle_tracker:Idle"}, "rct of theirs",
            "engine rct of package theirs: evcot has an engine rct itself: "
            "the package must name its entry point of evcot.trackers otherwise",
        ),
        (
            {"a": "mine = idle_tracker:Idle", "b": "mine = idle_tracker:from_sensor"}, "mine",
            "engine mine of package a: b has one, too: one of them must be removed",
        ),
        (
            {"theirs": "My Tracker = idle_tracker:Idle"}, "My Tracker",
            "engine My Tracker of package theirs: must be named with lower-case letters, digits, - and _, and not filters, ",
        ),
        ({"theirs": "rtl = idle_tracker:Idle"}, "rtl", "engine rtl of package theirs: must be named with lower-case letters,"),
    ],
)  # fmt: skip
def test_a_name_that_cannot_be_is_refused_when_it_is_used(
    found: Found, packages: dict[str, str], name: str, message: str
) -> None:
    found(**packages)
    for other in ("frames", "rct"):
        assert evcot.track(RECORDING, other).engine == other
    assert name not in usable_engines()
    with refused(EngineError, start=message):
        evcot.track(RECORDING, name)


RECORDS = log_of([(10, evcot.Kind.BORN, 0, 5.0, 6.0), (12, evcot.Kind.MOVED, 0, 5.0, 6.0)]).records
RECORDS["event_index"] = [0, 2]
OWNER = np.full(3, -1, np.int16)


def changed(**fields: Any) -> tuple[Any, Any]:
    records = RECORDS.copy()
    for name, value in fields.items():
        records[name][1] = value
    return records, OWNER


def raising() -> Any:
    raise RuntimeError("two\nlines")


class Answers:
    """Answers to the first run as it is told."""

    settled = 0

    def __init__(self, answer: Callable[[], Any], last: Any = RECORDS[:0]) -> None:
        self._answer, self._last = answer, last

    def feed(self, _: evcot.Events) -> Any:
        return self._answer()

    def finish(self) -> Any:
        return self._last


def tracked(tracker: Any) -> evcot.TrackLog:
    return log_of_blocks("mine", PlugInTracker("engine mine", tracker), [RECORDING.events])


def test_a_good_answer_is_the_log() -> None:
    log = tracked(Answers(lambda: (RECORDS[:1], OWNER.astype(np.int64)), RECORDS[1:]))
    np.testing.assert_array_equal(log.records, RECORDS)
    assert log.owner.dtype == np.int16


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (raising, "feed failed: RuntimeError: two lines (test_plug_in.py, line"),
        (lambda: None, "feed: returns NoneType: must be a tuple (records, owner)"),
        (lambda: ([], OWNER), "feed: records are list: must be a 1-d array of dtype evcot.TRACK"),
        (lambda: (RECORDS["x"], OWNER), "feed: records are ndarray of shape (2,) and dtype float64: must be a 1-d array"),
        (
            lambda: (RECORDS, OWNER[1:]),
            "feed: owner is ndarray of shape (2,) and dtype int16: must be whole numbers, one for each",
        ),
        (lambda: (RECORDS, OWNER * 1.0), "feed: owner is ndarray of shape (3,) and dtype float64: must be whole numbers"),
        (lambda: (RECORDS, OWNER - 2), "feed: owner = -3: must be from -2 to 32767"),
        (lambda: (RECORDS, OWNER.astype(np.int32) + 40_000), "feed: owner = 39999: must be from -2 to 32767"),
        (lambda: changed(x=np.nan), "feed: record 1: x = nan: must be a number of at most 1e+09"),
        (lambda: changed(t_us=9), "feed: record 1: t_us = 9: must not be before the record before it"),
        (lambda: changed(t_us=13), "feed: record 1: t_us = 13: must be from 10 to 12, as the events so far"),
        (lambda: changed(event_index=3), "feed: record 1: event_index = 3: must be from 0 to 2, as the events so far"),
        (lambda: changed(track_id=5), "feed: record 1: kind = 1: must be BORN in the first record of a track_id"),
    ],
)
def test_an_answer_that_breaks_a_rule_is_one_line(answer: Callable[[], Any], message: str) -> None:
    with refused(EngineError, start=f"engine mine: {message}"):
        tracked(Answers(answer))


def test_rules_hold_from_run_to_run_and_at_the_end() -> None:
    late, far = RECORDS[1:].copy(), RECORDS[1:].copy()
    late["t_us"], far["event_index"] = 11, 4
    for last, message in (
        (late, "record 2: t_us = 11: must not be before the record before it"),
        (far, "record 2: event_index = 4: must be from 0 to 3"),
        (None, "records are NoneType"),
    ):
        with refused(EngineError, start=f"engine mine: finish: {message}"):
            tracked(Answers(lambda: (RECORDS, OWNER), last))


def test_settled_events_are_no_longer_spoken_of_and_events_are_read_only() -> None:
    class Writes(Answers):
        def feed(self, events: evcot.Events) -> Any:
            events.x[:] = 0

    with pytest.raises(EngineError, match="feed failed: ValueError: assignment destination is read-only"):
        tracked(Writes(raising))
    inner = Answers(lambda: (RECORDS, OWNER))
    tracker = PlugInTracker("engine mine", inner)
    tracker.feed(RECORDING.events)
    assert tracker.settled == 0
    inner.settled = 3
    assert tracker.settled == 3
    for wrong in (2, 4, "3"):
        inner.settled = wrong  # type: ignore[assignment]
        with pytest.raises(EngineError, match=f"settled = {wrong!r}: must be a whole number from 3, as before, to 3 events"):
            tracker.settled  # noqa: B018

# SPDX-License-Identifier: Apache-2.0
"""A live run: all received events are recorded, those beyond the tracker's rate are dropped and counted, and nothing blocks
the source."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import read_recording
from evcot.tracks.log import DROPPED, Kind, TrackLog
from evcot.tracks.tracking import TrackerOutput
from evcot_cosim.live.recorder import LogKeeper, Recorder
from evcot_cosim.live.session import Session

from .stories import SENSOR, EveryTenth, Played, parts_of, random_events, wait_until


class Slow(EveryTenth):
    """Needs 50 ms for whatever it is fed."""

    def feed(self, some: Events) -> TrackerOutput:
        time.sleep(0.05)
        return super().feed(some)


def test_all_that_comes_is_tracked_and_kept(tmp_path: Path) -> None:
    some = random_events(1_000, 1)
    source = Played(parts_of(some, 30))
    session = Session(source, EveryTenth(), Recorder(tmp_path / "a.aedat4", SENSOR), LogKeeper(tmp_path / "a.npz", "rct"))
    session.start()
    wait_until(lambda: not session.running)
    session.stop()
    assert source.closed
    saved, log = read_recording(tmp_path / "a.aedat4"), TrackLog.load_npz(tmp_path / "a.npz")
    assert np.array_equal(saved.events.t_us, some.t_us)
    wanted, owner = EveryTenth().feed(some)
    assert np.array_equal(log.owner, owner)
    assert np.array_equal(log.records[:-1], wanted)
    figures = session.summary()
    assert [figures[name] for name in ("events", "saved", "dropped", "tracks", "lost", "clusters")] == [
        1_000,
        1_000,
        0,
        1,
        1,
        0,
    ]
    assert figures["recording_s"] == (some.t_us[-1] - some.t_us[0]) / 1e6
    assert 0 < figures["tracked_ms"]["p50"] <= figures["tracked_ms"]["p99"] < 5_000
    assert figures["drawn_ms"] == {"p50": None, "p99": None}


def test_a_tracker_that_is_too_slow_sees_the_newest_and_the_log_still_fits_the_recording(tmp_path: Path) -> None:
    some = random_events(3_000, 2)
    source = Played(parts_of(some, 10), lambda _: time.sleep(0.002))
    keep = Recorder(tmp_path / "a.aedat4", SENSOR), LogKeeper(tmp_path / "a.npz", "rct")
    session = Session(source, Slow(), *keep, wait_s=0.1)
    session.start()
    wait_until(lambda: not session.running, 30)
    session.stop()
    figures, log = session.summary(), TrackLog.load_npz(tmp_path / "a.npz")
    assert len(read_recording(tmp_path / "a.aedat4").events) == figures["saved"] == len(log.owner) == 3_000
    assert figures["dropped"] == np.count_nonzero(log.owner == DROPPED) > 1_000
    assert log.owner[-1] != DROPPED, "the newest are tracked"
    moved = log.records[log.records["kind"] != Kind.LOST]
    assert np.array_equal(moved["event_index"], np.flatnonzero(log.owner == 0))
    assert np.array_equal(moved["t_us"], some.t_us[moved["event_index"]])


def test_who_looks_gets_every_step_from_then_on() -> None:
    some = random_events(500, 3)
    session = Session(Played(parts_of(some, 50)), EveryTenth())
    inbox = session.subscribe()
    away = session.subscribe()
    session.unsubscribe(away)
    session.start()
    wait_until(lambda: not session.running)
    taken = inbox.take()
    assert taken is not None
    assert np.array_equal(np.concatenate([step.events.t_us for step in taken.items]), some.t_us)
    assert np.count_nonzero(np.concatenate([step.owner for step in taken.items]) == 0) == 50
    assert inbox.take() is None
    empty = away.take()
    assert empty is not None
    assert empty.items == []
    session.stop()


def test_an_end_before_the_end() -> None:
    session = Session(Played(parts_of(random_events(10_000, 3), 1), lambda _: time.sleep(0.01)), EveryTenth())
    session.start()
    wait_until(lambda: session.figures()["events"] > 5)
    session.end()
    wait_until(lambda: not session.running)
    session.stop()
    assert 5 < session.figures()["events"] < 10_000


@pytest.mark.parametrize("where", ["source", "tracker"])
def test_what_goes_wrong_on_a_thread_is_raised_where_the_run_is_stopped(tmp_path: Path, where: str) -> None:
    def fail(i: int) -> None:
        if i == 3:
            raise RecordingError("here: something")

    class Failing(EveryTenth):
        def feed(self, some: Events) -> TrackerOutput:
            fail(int(some.t_us[0]))
            return super().feed(some)

    part = random_events(10, 1)
    parts = [Events(np.full(10, t), part.x, part.y, part.p) for t in range(6)]
    source = Played(parts, fail if where == "source" else lambda _: time.sleep(0.05))
    session = Session(source, EveryTenth() if where == "source" else Failing(), Recorder(tmp_path / "a.aedat4", SENSOR))
    session.start()
    wait_until(lambda: not session.running)
    with pytest.raises(RecordingError, match=r"^here: something$"):
        session.stop()
    assert len(read_recording(tmp_path / "a.aedat4").events) >= 30, "what came before is kept"


def test_rates_are_of_the_last_second() -> None:
    session = Session(Played(parts_of(random_events(1_000, 3), 10), lambda _: time.sleep(0.01)), EveryTenth())
    session.start()
    time.sleep(0.6)
    figures = session.figures()
    assert figures["events_per_s"] == pytest.approx(figures["events"] / 0.6, rel=0.3)
    session.stop()

# SPDX-License-Identifier: Apache-2.0
"""A live run: all received events are recorded, those beyond the tracker's rate are dropped and counted, and nothing blocks
the source. Trackers beside its own hold up nobody, and one that is too slow is replaced."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import read_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.rct.config import PRESETS
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import DROPPED, TRACK, Kind, TrackLog
from evcot.tracks.tracking import FilteredTracker, TrackerOutput
from evcot_cosim.live.recorder import LogKeeper, Recorder
from evcot_cosim.live.session import Session
from evcot_cosim.live.tracker_thread import Beside, GapTracker

from .stories import SENSOR, Classified, EveryTenth, Played, parts_of, random_events, record, wait_until


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


def test_without_gaps_it_is_the_tracker() -> None:
    some = random_events(95, 1)
    records, owner = GapTracker(EveryTenth()).feed(some)
    wanted, wanted_owner = EveryTenth().feed(some)
    assert np.array_equal(records, wanted)
    assert np.array_equal(owner, wanted_owner)


def test_records_number_what_the_tracker_has_not_seen_too() -> None:
    tracker = GapTracker(EveryTenth())
    records = [tracker.feed(random_events(15, 1))[0]]  # 0, 10 -> 0, 10
    assert tracker.skip(100).tolist() == [DROPPED] * 100
    records.append(tracker.feed(random_events(10, 2))[0])  # 20 -> 120
    assert tracker.skip(0).tolist() == []
    tracker.skip(7)
    records += [tracker.feed(random_events(10, 3))[0], tracker.finish()]  # 30 -> 137; at the end -> 142
    assert np.concatenate(records)["event_index"].tolist() == [0, 10, 120, 137, 142]


def test_verdicts_number_what_the_tracker_has_not_seen_too() -> None:
    tracker = GapTracker(Classified())
    assert tracker.class_names == {3: "cup", 8: "plate"}
    taken = []
    for size in (90, 60, 60):
        tracker.feed(random_events(size, size))
        taken.append(tracker.take_verdicts()["event_index"].tolist())
        assert not len(tracker.take_verdicts())
        tracker.skip(1_000)
    assert taken == [[], [1_100], [2_200]]


def test_the_log_of_a_session_has_its_verdicts(tmp_path: Path) -> None:
    some = random_events(300, 1)
    names = Classified.class_names
    session = Session(Played(parts_of(some, 30)), Classified(), log=LogKeeper(tmp_path / "a.npz", "cot_motion", names))
    session.start()
    wait_until(lambda: not session.running)
    session.stop()
    log = TrackLog.load_npz(tmp_path / "a.npz")
    assert log.verdicts[["event_index", "class_id"]].tolist() == [(100, 3), (200, -1)]
    assert log.class_names == names
    assert session.labels == ("", "?", "cup", "plate")


class Late:
    """A tracker whose next call returns records of the given events."""

    def __init__(self, *event_indices: list[int]) -> None:
        self._event_indices = iter(event_indices)

    def _records(self) -> NDArray[np.void]:
        return np.concatenate([np.empty(0, TRACK), *(record(Kind.MOVED, 0, i, 1) for i in next(self._event_indices))])

    def feed(self, some: Events) -> TrackerOutput:
        return self._records(), np.zeros(len(some), np.int16)

    def finish(self) -> NDArray[np.void]:
        return self._records()

    @property
    def settled(self) -> int:
        return 0


def test_records_that_come_late_are_numbered_by_where_their_event_was() -> None:
    tracker = GapTracker(Late([], [3], [4, 5, 7], [10], [15]))
    five = random_events(5, 1)
    got = [tracker.feed(five)[0]]
    tracker.skip(100)
    got.append(tracker.feed(five)[0])  # from before the gap
    tracker.skip(1_000)
    got.append(tracker.feed(five)[0])  # from before both, the first after the first, and one more
    got += [tracker.feed(five[:0])[0], tracker.finish()]
    assert [rows["event_index"].tolist() for rows in got] == [[], [3], [4, 105, 107], [1_110], [1_115]]


class Mute:
    """A tracker that tells nothing, of whatever it is fed."""

    settled = 0

    def feed(self, some: Events) -> TrackerOutput:
        self.settled += len(some)
        return np.empty(0, TRACK), np.zeros(len(some), np.int16)

    def finish(self) -> NDArray[np.void]:
        return np.empty(0, TRACK)


def test_gaps_are_let_go_though_the_tracker_tells_nothing() -> None:
    tracker, five = GapTracker(Mute()), random_events(5, 1)
    for _ in range(1_000):
        tracker.feed(five)
        tracker.skip(2)
        tracker.skip(1)
    assert len(tracker._gaps) == 2
    assert tracker.settled == 5 * 1_000 + 3 * 999


@pytest.mark.parametrize("seed", range(3))
def test_a_real_tracker_numbers_as_one_behind_a_filter_does(seed: int) -> None:
    """Its records come later than the events that caused them: packets end after them."""
    recording = simulate_scene("discs", 5, {"duration_us": 100_000}).recording
    events, random = recording.events, np.random.default_rng(seed)
    cuts = np.sort(random.integers(len(events), size=40))
    runs = [events[a:b] for a, b in zip([0, *cuts], [*cuts, len(events)], strict=True)]
    seen = random.random(len(runs)) < 0.7
    config = PRESETS["plain"]

    def software() -> RctTracker:
        return RctTracker(config, recording.width, recording.height)

    gap = GapTracker(software())
    kept = FilteredTracker(lambda run: next(keeps), software())
    keeps = iter([np.full(len(run), see) for run, see in zip(runs, seen, strict=True)])
    wanted = [kept.feed(run) for run in runs]
    got = [gap.feed(run) if see else (None, gap.skip(len(run))) for run, see in zip(runs, seen, strict=True)]
    assert np.array_equal(np.concatenate([o for _, o in got]), np.concatenate([o for _, o in wanted]))
    all_got = np.concatenate([*(records for records, _ in got if records is not None), gap.finish()])
    all_wanted = np.concatenate([*(records for records, _ in wanted), kept.finish()])
    assert len(all_got) > 50
    assert np.array_equal(all_got, all_wanted)


class Refusing(EveryTenth):
    """Refuses what follows the first 100 events."""

    def feed(self, some: Events) -> TrackerOutput:
        if self._seen >= 100:
            raise RecordingError("a wait is too long")
        return super().feed(some)


def played(beside: Beside, pause_s: float = 0.0, wait_s: float = 0.25, count: int = 100) -> Session:
    parts = parts_of(random_events(10 * count, 1), 10)
    session = Session(Played(parts, lambda _: time.sleep(pause_s)), EveryTenth(), wait_s=wait_s, beside=[beside])
    session.start()
    wait_until(lambda: not session.running, 30)
    return session


def test_both_see_all_and_are_counted_apart() -> None:
    session = played(Beside("hardware", "RTL in simulation", EveryTenth()))
    figures = session.figures()
    (beside,) = figures["beside"]
    assert (beside["name"], beside["about"]) == ("hardware", "RTL in simulation")
    for name in ("tracks", "merged", "lost", "dropped", "clusters"):
        assert beside[name] == figures[name]
    assert (beside["tracks"], beside["lost"]) == (1, 1)
    assert beside["tracked_ms"]["p50"] > 0
    session.stop()


def test_one_that_is_too_slow_holds_up_nobody() -> None:
    session = played(Beside("slow", "a slow one", Slow()), 0.003, wait_s=1.0)
    figures = session.figures()
    assert figures["dropped"] == 0
    assert figures["beside"][0]["dropped"] > 500
    assert figures["beside"][0]["about"] == "a slow one"
    session.stop()


def test_its_substitute_takes_over_when_it_does_not_keep_up() -> None:
    session = played(Beside("hardware", "RTL", Slow(), ("golden model", EveryTenth)), 0.003, wait_s=0.1, count=1_500)
    (beside,) = session.figures()["beside"]
    assert beside["about"] == "golden model; RTL did not keep up"
    assert 0 < beside["dropped"] < 14_000, "not to the end"
    assert beside["tracks"] == 1, "it began anew, and so did the count"
    session.stop()


def test_one_loss_is_no_reason() -> None:
    class Once(EveryTenth):
        def feed(self, some: Events) -> TrackerOutput:
            if self._seen == 100:
                time.sleep(0.4)
            return super().feed(some)

    session = played(Beside("hardware", "RTL", Once(), ("golden model", EveryTenth)), 0.003, wait_s=0.1, count=300)
    (beside,) = session.figures()["beside"]
    assert beside["dropped"] > 0
    assert beside["about"] == "RTL"
    session.stop()


def test_its_substitute_takes_over_what_it_refuses() -> None:
    session = played(Beside("hardware", "RTL", Refusing(), ("golden model", EveryTenth)), wait_s=10.0)
    (beside,) = session.figures()["beside"]
    assert beside["about"] == "golden model; RTL a wait is too long"
    assert beside["dropped"] == 0
    assert beside["tracks"] == 1
    session.stop()


def test_without_a_substitute_a_refusal_ends_the_run() -> None:
    session = played(Beside("hardware", "RTL", Refusing()))
    assert session.failed
    with pytest.raises(RecordingError, match=r"^a wait is too long$"):
        session.stop()


def test_clusters_of_each_are_seen() -> None:
    parts = parts_of(random_events(20_000, 1), 10)
    session = Session(Played(parts, lambda _: time.sleep(0.01)), EveryTenth(), beside=[Beside("b", "", EveryTenth())])
    session.start()
    wait_until(lambda: len(session.beside[0].states) == 1 and len(session.clusters.states) == 1)
    assert np.isin(session.beside[0].states["track_id"], session.clusters.states["track_id"]).all()
    session.stop()

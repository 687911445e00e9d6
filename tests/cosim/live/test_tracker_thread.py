# SPDX-License-Identifier: Apache-2.0
"""Trackers beside a session's own: they hold up nobody, and one that is too slow is replaced."""

from __future__ import annotations

import time

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.tracks.tracking import TrackerOutput
from evcot_cosim.live.session import Session
from evcot_cosim.live.tracker_thread import Beside

from .stories import EveryTenth, Played, parts_of, random_events, wait_until


class Slow(EveryTenth):
    """Needs 50 ms for whatever it is fed."""

    def feed(self, some: Events) -> TrackerOutput:
        time.sleep(0.05)
        return super().feed(some)


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
    session = played(Beside("slow", "a slow one", Slow()), 0.003, wait_s=0.1)
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

# SPDX-License-Identifier: Apache-2.0
"""One session after another: a wish is prepared while the one before goes on, and takes its place."""

from __future__ import annotations

import threading
import time

import pytest

from evcot.errors import ConfigError, RecordingError
from evcot_cosim.live.player import Begin, Player, Run, Wish
from evcot_cosim.live.session import Session

from .stories import HELLO, EveryTenth, Played, parts_of, random_events, wait_until


class Studio:
    """Prepares sessions that last until they are ended, and remembers what was wished."""

    def __init__(self) -> None:
        self.wished: list[Wish] = []
        self.go_on = threading.Event()
        self.go_on.set()
        self.fails_at = 10**9

    def prepare(self, wish: Wish) -> Begin:
        if wish.engine == "none":
            raise ConfigError("engine none: must be one of rct")
        self.go_on.wait(10)
        self.wished.append(wish)
        return lambda: Run(Session(Played(parts_of(random_events(300_000, 1), 30), self._before), EveryTenth()), HELLO)

    def _before(self, i: int) -> None:
        time.sleep(0.005)
        if i == self.fails_at:
            raise RecordingError("here: something")


def started(studio: Studio, fixed: str = "") -> Player:
    player = Player(studio.prepare, Wish("rct"), fixed)
    player.start()
    return player


def test_a_wish_takes_the_place_of_the_session_before() -> None:
    studio = Studio()
    player = started(studio)
    first = player.run.session
    studio.go_on.clear()
    player.ask(Wish("adaptive", "auto", True, 2.5))
    wait_until(lambda: player.note == "preparing adaptive and the hardware (compiled the first time, up to a minute)")
    assert player.run.session is first
    assert first.running, "as long as the other is prepared"
    studio.go_on.set()
    wait_until(lambda: player.run.session is not first)
    assert not first.running
    assert first.source.closed is False  # type: ignore[attr-defined]
    wait_until(lambda: player.note == "")
    assert player.run.session.running
    assert studio.wished[-1] == Wish("adaptive", "auto", True, 2.5)
    player.stop()
    assert not player.running


def test_of_wishes_that_wait_the_last_is_granted() -> None:
    studio = Studio()
    player = started(studio)
    studio.go_on.clear()
    player.ask(Wish("first"))
    wait_until(lambda: player.note == "preparing first (compiled the first time, up to a minute)")
    for name in ("second", "third"):
        player.ask(Wish(name))
    studio.go_on.set()
    wait_until(lambda: not player.note and len(studio.wished) > 2)
    assert [wish.engine for wish in studio.wished] == ["rct", "first", "third"]
    player.stop()


def test_a_wish_that_cannot_be_granted_changes_nothing_and_says_why() -> None:
    player = started(Studio())
    run = player.run
    player.ask(Wish("none"))
    wait_until(lambda: player.note == "engine none: must be one of rct")
    assert player.run is run
    assert run.session.running
    player.stop()
    with pytest.raises(ConfigError, match=r"^engine none"):
        Player(Studio().prepare, Wish("none"))


def test_what_is_fixed_stays() -> None:
    studio = Studio()
    player = started(studio, "--save keeps one run")
    player.ask(Wish("adaptive"))
    time.sleep(0.3)
    assert len(studio.wished) == 1
    player.stop()


def test_an_ended_session_can_be_followed_and_a_failed_one_is_told() -> None:
    studio = Studio()
    player = started(studio)
    player.run.session.end()
    wait_until(lambda: not player.running)
    studio.fails_at = 5
    player.ask(Wish("rct"))
    assert player.running
    wait_until(lambda: not player.running)
    assert player.failed
    with pytest.raises(RecordingError, match=r"^here: something$"):
        player.stop()


def test_an_end_does_not_wait_for_what_is_prepared() -> None:
    studio = Studio()
    player = started(studio)
    studio.go_on.clear()
    player.ask(Wish("adaptive"))
    wait_until(lambda: bool(player.note))
    begin_s = time.monotonic()
    player.stop()
    assert time.monotonic() - begin_s < 5
    run = player.run
    studio.go_on.set()
    time.sleep(0.2)
    assert player.run is run

# SPDX-License-Identifier: Apache-2.0
"""The files of a live run, also when it is killed."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, OutputError, RecordingError
from evcot.events import Events
from evcot.recordings.files import read_recording
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.live.player import Begin, Player, Run, Wish
from evcot_cosim.live.recorder import LogKeeper, Recorder
from evcot_cosim.live.session import Session
from support.logs import verdicts_of

from .stories import HELLO, SENSOR, EveryTenth, Played, parts_of, random_events, record, wait_until


@pytest.mark.parametrize("suffix", [".aedat4", ".raw"])
def test_what_was_written_reads_back(tmp_path: Path, suffix: str) -> None:
    some = random_events(50_000, 4)
    recorder = Recorder(tmp_path / f"seen{suffix}", SENSOR)
    for part in parts_of(some, 777):
        recorder.write(part)
    recorder.close()
    got = read_recording(tmp_path / f"seen{suffix}")
    assert (got.width, got.height, recorder.events) == (*SENSOR, len(some))
    for name in ("t_us", "x", "y", "p"):
        assert np.array_equal(getattr(got.events, name), getattr(some, name))


# Writes an event a millisecond, and says after each that it has; then somebody kills it.
WRITER = """
import sys, time
from pathlib import Path
import numpy as np
from evcot.events import Events
from evcot_cosim.live.recorder import Recorder
recorder = Recorder(Path(sys.argv[1]), (64, 48))
begin = time.time()
for i in range(1_000_000):
    t_us = int(1e6 * (time.time() - begin))
    recorder.write(Events(np.array([t_us]), np.array([i % 64], np.uint16), np.array([1], np.uint16), np.array([1], np.uint8)))
    print(t_us, flush=True)
    time.sleep(0.001)
"""


@pytest.mark.parametrize("suffix", [".aedat4", ".raw"])
def test_a_kill_loses_less_than_the_last_second(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"seen{suffix}"
    with subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        written_us = [int(writer.stdout.readline())]
        end_s = time.monotonic() + 2
        while time.monotonic() < end_s:
            written_us.append(int(writer.stdout.readline()))
        writer.kill()
        written_us += [int(line) for line in writer.stdout.read().splitlines()]
    got = read_recording(path, SENSOR, damage="skip").events
    assert written_us[-1] > 1_500_000
    assert written_us[-1] - got.t_us[-1] < 1_000_000
    assert np.array_equal(got.t_us, written_us[: len(got)])
    assert np.array_equal(got.x, np.arange(len(got)) % 64)


def test_a_silence_does_not_keep_events_in_memory(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "seen.aedat4", SENSOR)
    recorder.write(random_events(100, 1))
    time.sleep(0.3)
    recorder.flush_if_due()
    assert len(read_recording(tmp_path / "seen.aedat4").events) == 100
    recorder.close()
    recorder.close()


def test_no_file_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "seen.aedat4").write_bytes(b"dear")
    with pytest.raises(OutputError, match=r"seen\.aedat4: exists: must be another file, or --force"):
        Recorder(tmp_path / "seen.aedat4", SENSOR)
    assert (tmp_path / "seen.aedat4").read_bytes() == b"dear"
    with pytest.raises(ConfigError, match=r"--save .*seen\.csv: must end in \.aedat4 or \.raw: only these"):
        Recorder(tmp_path / "seen.csv", SENSOR)
    with pytest.raises(OutputError, match=r"none/seen\.raw: cannot be written: No such file"):
        Recorder(tmp_path / "none" / "seen.raw", SENSOR)


def test_a_log_is_written_when_it_is_closed(tmp_path: Path) -> None:
    keeper = LogKeeper(tmp_path / "log.npz", "rct", {4: "cup"})
    records = np.concatenate([record(Kind.BORN, 5, 0, 1), record(Kind.MOVED, 9, 3, 1)])
    verdicts = verdicts_of((5, 1, 4), (9, 1, -1))
    keeper.add(records[:1], np.array([0, -1], np.int16), verdicts[:1])
    keeper.add(records[1:], np.array([-2, 0], np.int16), verdicts[1:])
    assert list(tmp_path.iterdir()) == []
    keeper.close()
    log = TrackLog.load_npz(tmp_path / "log.npz")
    assert (log.engine, log.owner.tolist()) == ("rct", [0, -1, -2, 0])
    assert np.array_equal(log.records, records)
    assert np.array_equal(log.verdicts, verdicts)
    assert log.class_names == {4: "cup"}


def test_a_log_of_nothing(tmp_path: Path) -> None:
    LogKeeper(tmp_path / "log.npz", "rct").close()
    assert len(TrackLog.load_npz(tmp_path / "log.npz").records) == 0
    with pytest.raises(ConfigError, match=r"--save-log log\.csv: must end in \.npz"):
        LogKeeper(Path("log.csv"), "rct")
    with pytest.raises(OutputError, match=r"cannot be written: No such file"):
        LogKeeper(tmp_path / "none" / "log.npz", "rct")


def test_times_that_cameras_send(tmp_path: Path) -> None:
    """Microseconds since 1970."""
    some = random_events(1000, 2)
    late = Events(some.t_us + 1_750_000_000_000_000, some.x, some.y, some.p)
    recorder = Recorder(tmp_path / "seen.raw", SENSOR)
    recorder.write(late)
    recorder.close()
    assert np.array_equal(read_recording(tmp_path / "seen.raw").events.t_us, late.t_us)


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

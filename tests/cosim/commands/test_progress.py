# SPDX-License-Identifier: Apache-2.0
"""The progress bar shows events, time taken and left, and rate on a terminal; a pipe sees only that a build begins."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Recording
from evcot.recordings.files import open_recording, write_recording
from evcot_cosim.commands.actions.progress import Length

from ..live.stories import SENSOR, random_events, wait_until

STORY = """
from evcot_cosim.commands.actions.progress import Progress
with Progress("drive", 1000) as progress:
    progress.building()
    progress.update(500, 2_500_000, 4.2e6)
    progress._bars.refresh()
"""

# The whole is known only later.
LATER = """
import time
from evcot_cosim.commands.actions.progress import Progress
with Progress("drive", None) as progress:
    for done in (100, 200):
        progress.update(done, 0, 1e6)
        time.sleep(0.01)
    if {known}:
        progress.measured(1000)
    for done in (250, 300):
        progress.update(done, 0, 1e6)
        time.sleep(0.01)
    progress._bars.refresh()
"""


def seen(story: str) -> str:
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "120"}
    subprocess.run([sys.executable, "-c", story], stderr=theirs, env=environment, check=True)
    os.close(theirs)
    shown = os.read(ours, 100_000).decode()
    os.close(ours)
    return shown


def test_a_terminal_sees_events_time_and_rate() -> None:
    shown = seen(STORY)
    for text in ("drive", "50%", "2.500 s of the recording, 4.20 M events/s"):
        assert text in shown


@pytest.mark.parametrize("known", [True, False])
def test_the_time_left_appears_when_the_whole_is_known(known: bool) -> None:
    shown = seen(LATER.format(known=known))
    assert ("left" in shown, "30%" in shown) == (known, known)


@pytest.mark.parametrize("enabled", [True, False])
def test_a_pipe_sees_that_the_hardware_is_compiled_and_nothing_else(enabled: bool) -> None:
    story = STORY.replace("1000)", f"1000, enabled={enabled})")
    done = subprocess.run([sys.executable, "-c", story], capture_output=True, check=True)
    line = b"evcot: compiling the hardware (10 to 60 s, once for each shape; kept in the cache)\n"
    assert (done.stdout, done.stderr) == (b"", line if enabled else b"")


@pytest.mark.parametrize("window", [(0, None), (1_000, 30_000), (30_000, None)])
def test_it_is_that_of_the_window(tmp_path: Path, window: tuple[int, int | None]) -> None:
    some = random_events(4_000, 1)
    write_recording(Recording(some, *SENSOR), tmp_path / "a.npz")
    after_us = some.t_us - some.t_us[0]
    inside = after_us[(after_us >= window[0]) & (after_us < (window[1] or np.inf))]
    found: list[tuple[int, float]] = []
    with Length(lambda: open_recording(tmp_path / "a.npz"), window, lambda *told: found.append(told)):
        wait_until(lambda: bool(found))
    assert found == [(len(inside), (inside[-1] - window[0]) / 1e6)]


def test_a_file_that_cannot_be_read_has_none() -> None:
    def opened() -> None:
        raise RecordingError("here: something")

    found: list[tuple[int, float]] = []
    length = Length(opened, (0, None), lambda *told: found.append(told))  # type: ignore[arg-type]
    with length:
        length._thread.join(10)
    assert found == []

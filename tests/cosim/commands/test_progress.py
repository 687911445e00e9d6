# SPDX-License-Identifier: Apache-2.0
"""The progress bar shows events, time and rate on a terminal, and nothing in a pipe."""

from __future__ import annotations

import os
import pty
import subprocess
import sys

STORY = """
from evcot_cosim.commands.actions.progress import Progress
with Progress("drive", 1000) as progress:
    progress.building()
    progress.update(500, 2_500_000, 4.2e6)
    progress._bars.refresh()
"""


def test_a_terminal_sees_events_time_and_rate() -> None:
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "120"}
    subprocess.run([sys.executable, "-c", STORY], stderr=theirs, env=environment, check=True)
    os.close(theirs)
    shown = os.read(ours, 100_000).decode()
    os.close(ours)
    for text in ("drive", "50%", "2.500 s simulated, 4.20 M events/s"):
        assert text in shown


def test_a_pipe_sees_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", STORY], capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")

# SPDX-License-Identifier: Apache-2.0
"""Start-up time until the first event is simulated, with an empty and with a filled model cache; CPU time of short commands."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from measure import Goal, Result

__all__ = ["measure"]

_GOAL_S = 3.0
# Commands that do little, and the CPU time that they may take.
_SHORT = {
    "absent": (["info", "absent.raw"], 0.3),
    "info": (["info", "boxes.raw"], 0.5),
    "presets": (["presets"], 0.5),
    "evaluate": (["evaluate", "log.npz", "--truth", "boxes.truth.csv"], 1.5),
}

_BUILD = """
import streams
from evcot_cosim.devices.device import build_device
print(build_device(streams.config().hardware, waves=False).build_s)
"""

# `evcot cosim`, which tells the time and ends once one event has been through the hardware.
_FIRST_EVENT = """
import os, time
from evcot_cosim.cli import main
from evcot_cosim.devices.device import Device
stream = Device.stream_timed
def first(device, *columns):
    stream(device, *(column[:1] for column in columns))
    print(time.monotonic(), flush=True)
    os._exit(0)
Device.stream_timed = first
main(["cosim", "--quiet"])
"""


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """build_s, second_start_s, start_NAME_s of some short commands."""
    with tempfile.TemporaryDirectory() as empty:
        yield Result("build_s", float(_child(_BUILD, EVCOT_CACHE=empty)), "s", how="8-slot array into an empty cache")
    _first_event_s()  # builds
    seconds = median(_first_event_s() for _ in range(3 if quick else 7))
    yield Result(
        "second_start_s", seconds, "s", _GOAL_S, "goal", goal=Goal(1, at_most=True),
        how="from launching `evcot cosim` to the end of the first simulated event, model built before",
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        _evcot_s(folder, "simulate", "boxes", "-o", "boxes.raw", "--duration", "2.5")
        _evcot_s(folder, "track", "boxes.raw", "-o", "log.npz")
        for name, (words, most_s) in _SHORT.items():
            _evcot_s(folder, *words)  # compiles
            yield Result(
                f"start_{name}_s", median(_evcot_s(folder, *words) for _ in range(3 if quick else 7)), "s", most_s, "goal",
                goal=Goal(1, at_most=True), how=f"CPU time of `evcot {' '.join(words)}`; 0.5 M events",
            )  # fmt: skip


def _evcot_s(folder: str, *words: str) -> float:
    """CPU time of a command."""

    def spent_s() -> float:
        spent = resource.getrusage(resource.RUSAGE_CHILDREN)
        return spent.ru_utime + spent.ru_stime

    before_s = spent_s()
    subprocess.run([sys.executable, "-m", "evcot_cosim", *words], cwd=folder, capture_output=True, check=False)
    return spent_s() - before_s


def _first_event_s() -> float:
    launched = time.monotonic()
    return float(_child(_FIRST_EVENT)) - launched


def _child(program: str, **variables: str) -> str:
    child = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parent,
        env=os.environ | variables,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return child.stdout

# SPDX-License-Identifier: Apache-2.0
"""Long recordings: the peak memory of commands must stay below a constant, whatever their length, pages included.

Run as a program with the arguments of `evcot`, it is the child process: it does that and prints its peak in MB.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import evcot
from evcot.events import Events, Recording
from evcot.recordings.files import read_recording, write_events
from evcot.trackers.presets import run_config
from evcot.unfinished import unfinished
from evcot_cosim.cli import main
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.cosim import run_long
from evcot_cosim.lockstep.lockstep import CHUNK, Lockstep, chunks
from evcot_cosim.lockstep.run_file import Source
from measure import Clock, Goal, Result, Timing, take_turns, timed
from memory import child_peak_mb, own_peak_mb

__all__ = ["measure"]

_LIMIT_MB = 400.0
_GROWTH = 1.1
_APART_US = 10_000


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """long_COMMAND_memory, long_COMMAND_growth: of track, cosim, cosim_default and report; long_COMMAND_first: not of track;
    long_cosim_after, long_lockstep_rate."""
    short, long = (3_000_000, 9_000_000) if quick else (8_000_000, 64_000_000)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        discs = evcot.simulate("discs", seed=1, duration_us=1_000_000).recording
        boxes = evcot.simulate("boxes", seed=1).recording
        recordings = {
            (name, count): _written(folder / f"{name}{count}.raw", recording, count)
            for name, recording in (("discs", discs), ("boxes", boxes))
            for count in (short, long)
        }

        def arguments(command: str, count: int) -> list[str]:
            discs, boxes = (str(recordings[name, count]) for name in ("discs", "boxes"))
            output = str(folder / f"{command}{count}")
            return {
                "track": ["track", discs, "-o", f"{output}.parquet", "--force", "--engine", "rct", "--preset", "discs"],
                "cosim": ["cosim", discs, "-o", output, "--preset", "discs", "--no-waves"],
                # Settings are chosen from the recording, and there is a waveform.
                "cosim_default": ["cosim", boxes, "-o", output],
                # Of the logs that the command before has left.
                "report": [
                    "report", *(str(folder / f"cosim_default{count}" / f"{side}.parquet") for side in ("hardware", "software")),
                    "--recording", boxes, "-o", f"{output}.html", "--force",
                ],
            }[command]  # fmt: skip

        for command in ("track", "cosim", "cosim_default", "report"):
            kernels = folder / f"kernels_{command}"  # none yet: the first run compiles them
            kernels.mkdir()
            peaks = []
            for count in (short, short, long):
                began = time.perf_counter()
                peaks.append(child_peak_mb(__file__, *arguments(command, count), "-q", NUMBA_CACHE_DIR=str(kernels)))
            took_s = time.perf_counter() - began
            how = f"resident set of `evcot {' '.join(arguments(command, long)[:1])}` over {long:,} events"
            goal = Goal(1, at_most=True)
            yield Result(f"long_{command}_memory", peaks[2], "MB", _LIMIT_MB, "goal", goal=goal, how=how)
            yield Result(
                f"long_{command}_growth", peaks[2], "MB", peaks[1], f"{short:,} events",
                goal=Goal(_GROWTH, at_most=True), how=how,
            )  # fmt: skip
            if command != "track":  # which compiles in its own process
                how = f"the same over {short:,} events, and no kernel is compiled yet"
                yield Result(f"long_{command}_first", peaks[0], "MB", _LIMIT_MB, "goal", goal=goal, how=how)
            if command == "cosim":
                summary = json.loads((folder / f"cosim{long}" / "summary.json").read_text())
                lockstep_s = float(summary["wall_s"])
                yield Result(
                    "long_cosim_after", took_s - lockstep_s, "s", lockstep_s, "the lock-step itself",
                    goal=goal, how="start, reading, logs and pages of the run; wall time",
                )  # fmt: skip
        yield _rate(folder, recordings["discs", short], 1 if quick else 5)


def _rate(folder: Path, path: Path, rounds: int) -> Result:
    """Lock-step of a file, with its reading, the software tracker and both logs, against that of its events in memory."""
    recording = read_recording(path)
    config = run_config(recording.width, recording.height, "discs")
    cot = config.device_config(recording.width, recording.height)
    model = build_device(cot, waves=False, savable=True)

    def bare() -> Timing:
        with Lockstep(cot, model=model) as lockstep:
            parts = chunks(recording.events)
            lockstep.feed(next(parts))

            def work() -> None:
                for part in parts:
                    lockstep.feed(part)

            return timed(work)

    def long() -> Timing:
        began: list[float] = []

        def progress(*_: object) -> None:
            began[2:] = time.perf_counter(), time.thread_time()

        with unfinished(folder / "rate", lambda: "") as work:
            run_long(Source(str(path)), config, work, progress=progress)
        return Timing(began[-2] - began[0], began[-1] - began[1])

    turns = take_turns({"bare": bare, "long": long}, rounds)
    count = len(recording.events) - CHUNK
    rate_m, bare_m = (count / turns.seconds(name, Clock.WALL) / 1e6 for name in ("long", "bare"))
    return Result(
        "long_lockstep_rate", rate_m, "M events/s", bare_m, "the same events in memory, no logs", goal=Goal(0.95),
        ratio=turns.speed_ratio("long", "bare", Clock.WALL),
        how=f"without the first chunk; wall time; CPU ratio of the thread that drives: {turns.speed_ratio('long', 'bare'):.3f}",
    )  # fmt: skip


def _written(path: Path, recording: Recording, count: int) -> Path:
    """The recording again and again, until it has so many events."""
    events = recording.events
    span_us = recording.duration_us + _APART_US

    def blocks() -> Iterator[Events]:
        for i in range(-(-count // len(events))):
            yield Events(events.t_us + i * span_us, events.x, events.y, events.p)[: count - i * len(events)]

    write_events(path, (recording.width, recording.height), blocks())
    return path


if __name__ == "__main__":
    code = main(sys.argv[1:])
    print(own_peak_mb())
    sys.exit(code)

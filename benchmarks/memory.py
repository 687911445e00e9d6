# SPDX-License-Identifier: Apache-2.0
"""Peak memory of a checked lock-step must not depend on how long the stream is.

Run as a program with a number of events, it is the child process: it streams them and prints its peak in MB.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import streams
from evcot_cosim.lockstep.lockstep import CHUNK, Lockstep
from measure import Goal, Result

__all__ = ["child_peak_mb", "measure", "own_peak_mb"]

_GROWTH = 1.05


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """peak_memory."""
    long, short = (2_000_000, 200_000) if quick else (20_000_000, 2_000_000)
    long_mb, short_mb = (child_peak_mb(__file__, events) for events in (long, short))
    yield Result(
        "peak_memory", long_mb, "MB", short_mb, f"{short:,} events", goal=Goal(_GROWTH, at_most=True),
        how=f"resident set of a checked lock-step over {long:,} events",
    )  # fmt: skip


def child_peak_mb(program: str, *arguments: object, **variables: str) -> float:
    """What a program of the benchmarks prints last: its peak."""
    command = [sys.executable, program, *map(str, arguments)]
    child = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, check=True)
    return float(child.stdout.splitlines()[-1])


def _main(events: int) -> None:
    with Lockstep(streams.config().hardware) as lockstep:
        for run in streams.runs(events, CHUNK):
            lockstep.feed(run)
    print(own_peak_mb())


def own_peak_mb() -> float:
    """The largest resident set of this process so far, MB."""
    status = Path("/proc/self/status")
    if status.is_file():  # not getrusage, which on Linux starts from the peak of the parent
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) / 1e3
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


if __name__ == "__main__":
    _main(int(sys.argv[1]))

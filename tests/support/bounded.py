# SPDX-License-Identifier: Apache-2.0
"""A recording read from its first event to its last in a process of its own, whose peak memory is measured.

The process is forked from one that has imported evcot: it is ready after some hundredths of a second instead of one.
"""

from __future__ import annotations

import multiprocessing
import warnings
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from evcot.errors import RecordingError
from evcot.recordings.files import open_recording
from evcot_cosim.sweep.starting import started

__all__ = ["Answer", "answer_to"]

_PEAK_MB = 640  # libraries and compiled kernels take a third of it; a bomb holds 1 GB and more
_HUNG_S = 300


@dataclass(frozen=True)
class Answer:
    """The result of reading a file."""

    events: int
    longest_block: int
    refusal: str


def answer_to(path: Path) -> Answer:
    """Read a file in another process with bounded memory, which may refuse the file in one line but not crash."""
    here, there = multiprocessing.Pipe(duplex=False)
    with here:
        process = started(_read, path, there)
        there.close()
        assert here.poll(_HUNG_S), f"{path}: still being read after {_HUNG_S} s"
        answer: Answer
        answer, peak_mb = here.recv()  # EOFError where the process ended without an answer
        process.join()
    assert process.exitcode == 0
    assert peak_mb < _PEAK_MB
    assert len(answer.refusal) < 600
    assert answer.refusal.isprintable()
    assert not answer.refusal or answer.refusal.startswith(f"{path}: ")
    return answer


def _read(path: Path, answers: Connection) -> None:
    seen, longest, refusal = 0, 0, ""
    warnings.simplefilter("ignore")
    try:
        with open_recording(path, (640, 480)) as file:
            for block in file.blocks():
                seen, longest = seen + len(block), max(longest, len(block))
    except RecordingError as error:
        refusal = str(error)
    # Not from getrusage, whose peak of a process begins with that of the process that started it.
    with Path("/proc/self/status").open() as status:
        peak_kb = next(int(line.split()[1]) for line in status if line.startswith("VmHWM:"))
    answers.send((Answer(seen, longest, refusal), peak_kb // 1024))

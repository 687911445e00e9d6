# SPDX-License-Identifier: Apache-2.0
"""Fuzzing of readers: a small file is damaged in many ways, and every result of the reader is checked."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Recording
from evcot.recordings.files import Damage, read_recording
from support.testing import EXHAUSTIVE

__all__ = ["Outcomes", "cut_lengths", "fuzz", "sample_of"]

# What a warning says: how many events were lost; or that none is, though the file contradicts itself.
_LOSS = re.compile(r": (\d+ events left out: |everything after \d+ events left out: |time restarts in )")
_NO_LOSS = re.compile(
    r": (\d+ events run back in time, by at most \d+ us: |packet table at byte -?\d+: |header: sensor |topic .*: all are read$)"
)


def sample_of(corruptions: int, usual: int) -> int:
    """How many corruptions to try: the usual few, or all."""
    return corruptions if EXHAUSTIVE else usual


def cut_lengths(content: bytes, usual: int) -> range:
    """Where to cut a file: at the usual few places, or after every byte."""
    return range(1, len(content), 1 if EXHAUSTIVE else max(1, len(content) // usual))


@dataclass
class Outcomes:
    """How many damaged files were refused, read with a warning that says how many events were lost, and read in full."""

    refused: int = 0
    lossy: int = 0
    read: int = 0


def fuzz(
    path: Path,
    content: bytes,
    *,
    cuts: bool = True,
    corruptions: int = 10_000,
    usual: int = 2_500,
    seed: int,
    damage: Damage = "refuse",
) -> Outcomes:
    """Damage `content`, read it from `path` each time, and check every answer.

    A reader may refuse the file with a one-line RecordingError that starts with the path; or return events inside the sensor
    and in time order, with a RecordingWarning for every loss, or for a contradiction that loses nothing. A truncated file must
    give a prefix of the file's events.

    Args:
        path: where to write; its suffix is the format's, if that matters.
        content: a good file, of about 50 events: every byte of it is a place to cut.
        cuts: whether to cut the file after every byte.
        corruptions, usual: how many files to damage otherwise: the first with `make exhaustive`, the lesser in the usual tests.
        damage: how the files are read.

    Raises:
        AssertionError, or whatever the reader let through; the note on it says how to repeat the damage.
    """
    outcomes = Outcomes()
    path.write_bytes(content)
    whole = read_recording(path, damage=damage)
    if cuts:
        for length in range(len(content)):
            got = _answer(path, content[:length], damage, outcomes, f"{path.name} cut after byte {length}")
            assert got is None or _is_prefix(got, whole), f"cut after byte {length}: not a prefix of the whole file"
    for number, damaged in enumerate(_corrupted(content, sample_of(corruptions, min(usual, corruptions)), seed)):
        _answer(path, damaged, damage, outcomes, f"{path.name}: corruption {number} of seed {seed}")
    print(f"{path.name}, seed {seed}: {outcomes}")
    return outcomes


def _corrupted(content: bytes, count: int, seed: int) -> Iterator[bytes]:
    random = np.random.default_rng(seed)
    for _ in range(count):
        damaged = np.frombuffer(content, np.uint8).copy()
        at, length = (int(each) for each in random.integers((0, 1), (len(content), 9)))
        match random.integers(6):
            case 0:
                damaged[at] ^= 1 << random.integers(8)
            case 1:
                places = random.integers(0, len(content), length)
                damaged[places] = random.integers(0, 256, length)
            case 2:
                damaged[at : at + length] = random.choice([0, 0x7F, 0x80, 0xFF])
            case 3:
                damaged = np.delete(damaged, slice(at, at + length))
            case 4:
                damaged = np.insert(damaged, at, random.integers(0, 256, length, np.uint8))
            case _:
                other = int(random.integers(len(content)))
                moved = damaged[other : other + length].copy()
                damaged = np.concatenate((damaged[:at], moved, damaged[at + len(moved) :]))
        yield damaged.tobytes()


def _answer(path: Path, content: bytes, damage: Damage, outcomes: Outcomes, what: str) -> Recording | None:
    _overwrite(path, content)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            recording = _read(path, damage)
        for warning in caught:
            assert issubclass(warning.category, RecordingWarning), str(warning.message)
            assert _LOSS.search(str(warning.message)) or _NO_LOSS.search(str(warning.message)), str(warning.message)
        if recording is None:
            outcomes.refused += 1
        else:
            _assert_sound(recording)
            if any(_LOSS.search(str(warning.message)) for warning in caught):
                outcomes.lossy += 1
            else:
                outcomes.read += 1
    except BaseException as error:
        error.add_note(f"{what}: {content.hex()}")
        raise
    return recording


def _overwrite(path: Path, content: bytes) -> None:
    """As `write_bytes`, but ten times as fast: a file that is emptied first has its new content put on the disk at once."""
    with path.open("r+b", buffering=0) as file:
        file.write(content)
        file.truncate()


def _read(path: Path, damage: Damage) -> Recording | None:
    try:
        return read_recording(path, damage=damage)
    except RecordingError as error:
        message = str(error)
        assert message.startswith(f"{path}: "), message
        assert message.isprintable(), message
        return None


def _columns(recording: Recording) -> list[NDArray[np.generic]]:
    events = recording.events
    return [events.t_us, events.x, events.y, events.p]


def _assert_sound(recording: Recording) -> None:
    t_us, x, y, p = _columns(recording)
    assert [values.dtype for values in (t_us, x, y, p)] == [np.int64, np.uint16, np.uint16, np.uint8]
    assert 0 < len(t_us) == len(x) == len(y) == len(p)
    assert (np.diff(t_us) >= 0).all(), "time runs back"
    assert x.max() < recording.width, "outside the sensor"
    assert y.max() < recording.height, "outside the sensor"
    assert p.max() <= 1, "no polarity"


def _is_prefix(part: Recording, whole: Recording) -> bool:
    count = len(part.events)
    return all(
        np.array_equal(values, expected[:count]) for values, expected in zip(_columns(part), _columns(whole), strict=True)
    )

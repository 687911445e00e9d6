# SPDX-License-Identifier: Apache-2.0
"""N-MNIST's five bytes: by hand, across blocks, cut anywhere, and told from other files of that suffix."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import nmnist

from .fuzzing import fuzz


def packed(t_us: int, x: int, y: int, p: int) -> bytes:
    return bytes([x, y]) + (p << 23 | t_us).to_bytes(3, "big")


def rows(events: Events) -> list[tuple[int, ...]]:
    return list(zip(*(getattr(events, name).tolist() for name in ("t_us", "x", "y", "p")), strict=True))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "00002.bin"


def test_bytes_and_overflows(path: Path) -> None:
    content = [(5, 1, 33, 0), (8_000, 33, 0, 1), (0, 0, 240, 0), (100, 2, 3, 1), (8_388_607, 239, 239, 0)]
    path.write_bytes(b"".join(packed(*event) for event in content))
    with open_recording(path) as file:
        assert file.format == "N-MNIST bin"
        found = rows(file.read().events)
    assert found == [(5, 1, 33, 0), (8_000, 33, 0, 1), (8_292, 2, 3, 1), (8_396_799, 239, 239, 0)]


def made(count: int) -> tuple[bytes, list[tuple[int, ...]]]:
    random = np.random.default_rng(7)
    t_us = np.cumsum(random.integers(0, 90, count))
    content, wanted, over = [], [], 0
    for t, (x, y, p) in zip(t_us.tolist(), random.integers(0, (34, 34, 2), (count, 3)).tolist(), strict=True):
        while t - over >= 1 << 13:
            content.append(packed(0, 0, 240, 0))
            over += 1 << 13
        content.append(packed(t - over, x, y, p))
        wanted.append((t, x, y, p))
    return b"".join(content), wanted


@pytest.mark.parametrize("block_events", [3, 1 << 15])
def test_blocks_change_nothing(path: Path, monkeypatch: pytest.MonkeyPatch, block_events: int) -> None:
    monkeypatch.setattr(nmnist, "BLOCK_EVENTS", block_events)
    content, wanted = made(1_000)
    path.write_bytes(content)
    assert rows(read_recording(path).events) == wanted


@pytest.mark.parametrize("rest", range(1, 5))
def test_the_events_before_a_cut_are_given(path: Path, rest: int) -> None:
    content, wanted = made(50)
    path.write_bytes(content + content[:rest])
    with pytest.raises(RecordingError, match=rf"ends within the event at byte {len(content)}; is it cut off\?"):
        read_recording(path)
    with pytest.warns(match="cut off"):
        assert rows(read_recording(path, damage="skip").events) == wanted


def test_other_files_of_that_suffix_are_not_taken_for_it(path: Path) -> None:
    path.write_bytes(np.random.default_rng(1).bytes(5_000))
    with pytest.raises(RecordingError, match="has an unknown format"):
        read_recording(path)


def test_damage(path: Path) -> None:
    assert fuzz(path, made(50)[0], seed=54).refused > 100


def test_damage_left_out(path: Path) -> None:
    assert fuzz(path, made(50)[0], corruptions=2000, seed=55, damage="skip").lossy > 50

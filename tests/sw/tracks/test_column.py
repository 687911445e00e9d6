# SPDX-License-Identifier: Apache-2.0
"""Columns in memory and in a file give back what was added, in blocks of four values."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import TrackLogError
from evcot.tracks import column
from evcot.tracks.column import GrowingColumn, HeldColumn, PackedColumn, in_runs

INT = np.dtype("<i4")


@pytest.fixture(autouse=True)
def _small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(column, "_BLOCK_BYTES", 19)  # four values of four bytes


@pytest.fixture(params=["held", "packed"])
def empty(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[GrowingColumn]:
    if request.param == "held":
        yield HeldColumn(INT)
        return
    packed = PackedColumn(tmp_path / "column", INT)
    yield packed
    packed.close()


def added(values: GrowingColumn, *sizes: int) -> None:
    """Add 0, 1, 2 and so on, so many at a time."""
    for size in sizes:
        values.append(np.arange(len(values), len(values) + size, dtype=INT) << 20)


@pytest.mark.parametrize("sizes", [(), (1,), (4,), (3, 1), (3, 2), (5, 0, 4), (1, 1, 1, 1, 1), (13,), (8, 8)])
def test_every_part_is_what_was_added(empty: GrowingColumn, sizes: tuple[int, ...]) -> None:
    added(empty, *sizes)
    n = sum(sizes)
    assert len(empty) == n
    for begin, end in combinations_with_replacement(range(n + 2), 2):
        part = empty[begin:end]
        assert part.dtype == INT
        assert part.tolist() == [k << 20 for k in range(begin, min(end, n))]
    assert empty[:].tolist() == [k << 20 for k in range(n)]


def test_parts_are_read_while_values_are_added(empty: GrowingColumn) -> None:
    for _ in range(7):
        added(empty, 3)
        assert empty[len(empty) - 2 :].tolist() == [len(empty) - 2 << 20, len(empty) - 1 << 20]
        assert empty[0:1].tolist() == [0]


def test_runs_begin_at_multiples_of_their_size(empty: GrowingColumn) -> None:
    added(empty, 7)
    assert [(begin, (run >> 20).tolist()) for begin, run in in_runs(empty, 3)] == [(0, [0, 1, 2]), (3, [3, 4, 5]), (6, [6])]


def blocks_of(path: Path) -> list[int]:
    """The values in each block of a file."""
    content, counts, at = path.read_bytes(), [], 0
    while at < len(content):
        count, size = np.frombuffer(content, "<u4", 2, at).tolist()
        counts.append(count)
        at += 8 + size
    return counts


def test_full_blocks_are_written_at_once_and_the_rest_when_flushed(tmp_path: Path) -> None:
    path = tmp_path / "column"
    values = PackedColumn(path, INT)
    added(values, 3)
    values.close()
    assert blocks_of(path) == []
    values = PackedColumn(path, INT)
    added(values, 3, 2, 6)
    assert values._packed == 8
    values.flush()
    assert blocks_of(path) == [4, 4, 3]
    values.close()


@pytest.mark.parametrize("length", [0, 4, 8, 11])
def test_a_file_is_cut_back_to_a_checkpoint(tmp_path: Path, length: int) -> None:
    path = tmp_path / "column"
    values = PackedColumn(path, INT)
    added(values, 11)
    values.flush()
    values.close()
    again = PackedColumn(path, INT, length)
    assert (again[:] >> 20).tolist() == list(range(length))
    added(again, 2)
    again.flush()
    assert (again[:] >> 20).tolist() == list(range(length + 2))
    again.close()
    assert sum(blocks_of(path)) == length + 2


@pytest.mark.parametrize(("length", "cut", "held"), [(5, 0, 4), (12, 0, 11), (11, 1, 8), (8, 40, 4)])
def test_a_file_that_lacks_values_is_refused(tmp_path: Path, length: int, cut: int, held: int) -> None:
    path = tmp_path / "column"
    values = PackedColumn(path, INT)
    added(values, 11)
    values.flush()
    values.close()
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - cut])
    with pytest.raises(TrackLogError, match=rf"column: holds {held} values: must hold {length}, as at its checkpoint"):
        PackedColumn(path, INT, length)

# SPDX-License-Identifier: Apache-2.0
"""A column in a scratch file: what is appended is read, part by part, before and after it is opened again."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import OutputError, TrackLogError
from evcot.tracks.column import PackedColumn
from evcot.tracks.record import TRACK
from support.full_disk import full_disk

OWNER = np.dtype(np.int16)
N = 2_000_000


def owners(n: int = N) -> np.ndarray:
    return np.random.default_rng(3).integers(-2, 8, n).astype(OWNER)


def filled(path: Path, values: np.ndarray, step: int = 77_777) -> PackedColumn:
    column = PackedColumn(path, values.dtype)
    for begin in range(0, len(values), step):
        column.append(values[begin : begin + step])
    return column


def test_every_part_is_what_was_appended(tmp_path: Path) -> None:
    values = owners()
    with closing(filled(tmp_path / "o", values)) as column:
        assert len(column) == N
        for begin, end in ((0, 0), (0, 1), (0, N), (524_287, 524_289), (700_000, 1_900_000), (N - 1, N), (N, N + 5)):
            assert np.array_equal(column[begin:end], values[begin:end])
        column.append(values[:3])
        assert np.array_equal(column[N - 1 :], [values[-1], *values[:3]])
    assert (tmp_path / "o").stat().st_size < values.nbytes / 2


def test_records_keep_every_bit(tmp_path: Path) -> None:
    values = np.frombuffer(np.random.default_rng(4).bytes(TRACK.itemsize * 30_000), TRACK)
    with closing(filled(tmp_path / "r", values, 1_000)) as column:
        assert column[0:].tobytes() == values.tobytes()


def test_it_is_cut_back_to_what_it_had_when_it_was_flushed(tmp_path: Path) -> None:
    values = owners()
    column = filled(tmp_path / "o", values[:900_000])
    column.flush()
    column.append(values[:800_000])
    column.close()
    with closing(PackedColumn(tmp_path / "o", OWNER, 900_000)) as again:
        again.append(values[900_000:])
        assert np.array_equal(again[0:], values)


@pytest.mark.parametrize("left", [0, 7, -1])
def test_a_file_that_is_shorter_than_its_checkpoint_is_refused(left: int, tmp_path: Path) -> None:
    column = filled(tmp_path / "o", owners())
    column.flush()
    column.close()
    os.truncate(tmp_path / "o", left if left >= 0 else (tmp_path / "o").stat().st_size - 1)
    with pytest.raises(TrackLogError, match=rf"o: holds \d+ values: must hold {N}, as at its checkpoint"):
        PackedColumn(tmp_path / "o", OWNER, N)


def test_file_too_large_is_said_again_at_the_end(tmp_path: Path) -> None:
    """The system refuses what is buffered a second time when the file is closed, and then does not name the file."""
    column = PackedColumn(tmp_path / "o", OWNER)
    column.append(owners(1_000))
    with full_disk(100):
        for ends in (column.flush, column.close):
            with pytest.raises(OutputError, match=r"/o: cannot be written: File too large$"):
                ends()


def test_several_threads_read(tmp_path: Path) -> None:
    values = owners()
    with closing(filled(tmp_path / "o", values)) as column, ThreadPoolExecutor(4) as pool:
        parts = pool.map(lambda begin: column[begin : begin + 999], range(0, N, 999))
        assert np.array_equal(np.concatenate(list(parts)), values)

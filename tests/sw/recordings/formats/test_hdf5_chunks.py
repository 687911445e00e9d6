# SPDX-License-Identifier: Apache-2.0
"""Compressed chunks of HDF5 datasets are read as they are, whichever filters were skipped for a chunk."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.recordings.formats import hdf5_chunks
from evcot.recordings.formats.hdf5_chunks import Chunks


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[h5py.File]:
    monkeypatch.setattr(hdf5_chunks, "_SURE_BYTES", 0)  # no chunk is left to the library
    with h5py.File(tmp_path / "chunks.h5", "w") as opened:
        yield opened


def shuffled(content: bytes, item_bytes: int) -> bytes:
    return b"".join(content[k::item_bytes] for k in range(item_bytes))


def put(file: h5py.File, values: NDArray[Any], chunks: tuple[int, ...], shuffle: bool, mask: int) -> h5py.Dataset:
    """A compressed dataset, for whose chunks the filters of a mask were skipped: shuffle, if it is used, and deflate."""
    dataset = file.create_dataset("x", values.shape, values.dtype, chunks=chunks, compression="gzip", shuffle=shuffle)
    for place in product(*(range(0, size, step) for size, step in zip(values.shape, chunks, strict=True))):
        whole = np.zeros(chunks, values.dtype)
        there = values[tuple(slice(at, at + step) for at, step in zip(place, chunks, strict=True))]
        whole[tuple(slice(size) for size in there.shape)] = there
        content = whole.tobytes()
        for i, deflates in enumerate([False, True] if shuffle else [True]):
            if not mask >> i & 1:
                content = zlib.compress(content) if deflates else shuffled(content, values.dtype.itemsize)
        dataset.id.write_direct_chunk(place, content, mask)
    return dataset


@pytest.mark.parametrize(("shuffle", "mask"), [(False, 0), (False, 1), (True, 0), (True, 1), (True, 2), (True, 3)])
@pytest.mark.parametrize(
    ("shape", "chunks", "axis"),
    [((10,), (4,), 0), ((10, 3), (4, 3), 0), ((10, 6), (4, 4), 0), ((5, 10), (2, 4), 1), ((5, 10), (1, 4), 1)],
)
def test_every_window_is_read_as_it_is(
    file: h5py.File, shape: tuple[int, ...], chunks: tuple[int, ...], axis: int, shuffle: bool, mask: int
) -> None:
    values = np.random.default_rng(1).integers(0, 1 << 30, shape).astype("<i4")
    dataset = put(file, values, chunks, shuffle, mask)
    for line in range(shape[0] if axis else 1):
        expected = values[line] if axis else values
        rows = Chunks(dataset, axis, line)
        assert len(rows) == 10
        for begin, end in combinations(range(11), 2):
            np.testing.assert_array_equal(rows.read(begin, end), expected[begin:end])


@pytest.mark.parametrize("shape", [(8,), (8, 6)])
def test_a_chunk_that_expands_to_more_than_its_size_is_refused(file: h5py.File, shape: tuple[int, ...]) -> None:
    chunks = (4, 4)[: len(shape)]
    dataset = put(file, np.zeros(shape, "<i4"), chunks, False, 0)
    dataset.id.write_direct_chunk((4, 4)[: len(shape)], zlib.compress(bytes(1 << 20)))
    rows = Chunks(dataset)
    assert not rows.read(0, 4).any()
    with pytest.raises(RecordingError, match="chunk"):
        rows.read(4, 5)


@pytest.mark.parametrize(("more", "refused"), [(0, False), (1, True)])
def test_a_chunk_may_be_a_sixteenth_and_64_kib_longer_than_it_is_expanded(file: h5py.File, more: int, refused: bool) -> None:
    dataset = put(file, np.zeros(256, "<i4"), (256,), False, 0)
    stream = zlib.compress(bytes(1024))
    dataset.id.write_direct_chunk((0,), stream + bytes(1024 + 64 + (1 << 16) + more - len(stream)))
    if refused:
        with pytest.raises(RecordingError, match=r"chunk of 1024 bytes, 66625 when compressed: must not be larger"):
            Chunks(dataset).read(0, 1)
    else:
        assert Chunks(dataset).read(0, 1) == [0]

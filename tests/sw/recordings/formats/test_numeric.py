# SPDX-License-Identifier: Apache-2.0
"""Polarity -1 that was stored in an unsigned type is read as darker, in every reader of plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.recordings.files import read_recording

COUNT = 40
RANDOM = np.random.default_rng(3)
T_US = np.sort(RANDOM.integers(70_000, 90_000, COUNT))
X, Y, P = (RANDOM.integers(0, limit, COUNT) for limit in (64, 48, 2))

Write = Callable[[Path, NDArray[Any]], Any]


def rows(p: NDArray[Any], order: str = "txyp") -> NDArray[np.uint64]:
    return np.stack([{"t": T_US, "x": X, "y": Y, "p": p}[name].astype(np.uint64) for name in order], axis=1)


def write_hdf5(path: Path, p: NDArray[Any]) -> None:
    with h5py.File(path, "w") as file:
        for name, values in (("t", T_US), ("x", X), ("y", Y), ("p", p)):
            file[f"events/{name}"] = values


def write_npz(path: Path, p: NDArray[Any]) -> None:
    with path.open("wb") as file:
        np.savez(file, t=T_US, x=X, y=Y, p=p)


def write_npy(path: Path, p: NDArray[Any]) -> None:
    with path.open("wb") as file:
        np.save(file, rows(p, "xytp").astype(np.uint32))


FORMATS: dict[str, Write] = {
    "npz": write_npz,
    "npy": write_npy,
    "hdf5": write_hdf5,
    "matlab struct": lambda path, p: scipy.io.savemat(path, {"TD": {"ts": T_US, "x": X, "y": Y, "p": p}}, appendmat=False),
    "csv": lambda path, p: np.savetxt(path, rows(p, "ptxy"), "%d", ",", header="p,t,x,y", comments=""),
    "csv without names": lambda path, p: np.savetxt(path, rows(p, "xypt"), "%d", ","),
}


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
@pytest.mark.parametrize("name", FORMATS)
def test_minus_one_without_its_sign_is_darker(tmp_path: Path, name: str, kind: type[Any]) -> None:
    path = tmp_path / "events"
    stored = np.where(P == 0, np.iinfo(kind).max, 1).astype(kind)
    if name == "npy" and kind is not np.uint32:
        pytest.skip("a matrix has one type, which the times need")
    FORMATS[name](path, stored)
    events = read_recording(path).events
    assert (events.t_us.tolist(), events.x.tolist(), events.y.tolist()) == (T_US.tolist(), X.tolist(), Y.tolist())
    assert events.p.tolist() == P.tolist()


@pytest.mark.parametrize("name", FORMATS)
def test_a_largest_number_next_to_zero_is_refused_because_it_may_mean_brighter(tmp_path: Path, name: str) -> None:
    path = tmp_path / "events"
    kind = np.uint32 if name == "npy" else np.uint8
    FORMATS[name](path, np.where(P == 0, 0, np.iinfo(kind).max).astype(kind))
    with pytest.raises(
        RecordingError, match=r"p = \d+ and p = 0: must be \d+, which is -1 without its sign, and 1; or 0 and 1"
    ):
        read_recording(path)

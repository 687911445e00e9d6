# SPDX-License-Identifier: Apache-2.0
"""Damage of npz logs that a checksum does not show, and logs that are read in several runs."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import TrackLogError
from evcot.tracks import npz
from evcot.tracks.log import TRACK, TrackLog
from evcot.tracks.npz import NpzFile


@pytest.fixture
def path(tmp_path: Path) -> Path:
    records = np.zeros(10, TRACK)
    records["t_us"], records["track_id"] = np.arange(10), np.arange(10) % 3
    TrackLog("rct", records, np.arange(25, dtype=np.int16)).save_npz(tmp_path / "log.npz")
    return tmp_path / "log.npz"


@pytest.mark.parametrize("name", ["records", "owner"])
@pytest.mark.parametrize("missing", [1, 4, 60])
def test_an_array_that_ends_too_soon_is_damage(path: Path, name: str, missing: int) -> None:
    with zipfile.ZipFile(path) as whole:
        members = {member: whole.read(member) for member in whole.namelist()}
    members[f"{name}.npy"] = members[f"{name}.npy"][: -min(missing, 49)]
    with zipfile.ZipFile(path, "w") as cut:
        for member, content in members.items():
            cut.writestr(member, content)
    with pytest.raises(TrackLogError, match=rf"log\.npz: is damaged: {name} ends too soon$"):
        NpzFile(path).read()


@pytest.mark.parametrize("rows", [1, 3, 5, 10, 25, 26])
def test_runs_are_parts_of_the_whole(path: Path, rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(npz, "_ROWS", rows)
    file = NpzFile(path)
    records, owner = file.read()
    assert (records["t_us"].tolist(), owner.tolist(), file.count_owners()) == (list(range(10)), list(range(25)), 25)
    np.testing.assert_array_equal(np.concatenate(list(file.record_runs())), records)
    np.testing.assert_array_equal(np.concatenate(list(file.owner_runs())), owner)
    assert {len(run) for run in file.owner_runs()} <= {rows, 25 % rows, 25}


@pytest.mark.parametrize(
    ("name", "array", "message"),
    [
        ("records", np.zeros((2, 2), TRACK), r"records is 2-d .*: must be 1-d"),
        ("records", np.zeros(2, TRACK[["t_us", "kind"]]), r"records lacks event_index, .*: must be a log of this version"),
        ("owner", np.zeros(2, np.int32), r"owner is 1-d int32: must be 1-d int16$"),
        ("owner", np.zeros((), np.int16), r"owner is 0-d int16: must be 1-d int16$"),
        ("engine", np.zeros(2, "U3"), r"engine is 1-d <U3: must be 0-d text$"),
        ("engine", np.zeros((), np.int16), r"engine is 0-d int16: must be 0-d text$"),
    ],
)
def test_arrays_of_another_kind_are_refused(path: Path, name: str, array: object, message: str) -> None:
    with np.load(path) as archive:
        arrays = {**archive, name: array}
    np.savez(path.with_name("other.npz"), **arrays)
    with pytest.raises(TrackLogError, match=message):
        NpzFile(path.with_name("other.npz"))


@pytest.mark.parametrize("name", ["engine", "records", "owner"])
def test_an_array_that_is_missing_is_named(path: Path, name: str) -> None:
    with np.load(path) as archive:
        np.savez(path.with_name("other.npz"), **{key: archive[key] for key in archive if key != name})
    with pytest.raises(TrackLogError, match=rf"has no array {name}: must have engine, records, owner"):
        NpzFile(path.with_name("other.npz"))

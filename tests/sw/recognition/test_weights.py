# SPDX-License-Identifier: Apache-2.0
"""The file of a trained classifier: what was written is read, and everything else is refused in one line."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.errors import ConfigError, OutputError
from evcot.hardware.classifier import CELLS, HIDDEN, RecognitionRegisters
from evcot.recognition.model import Network
from evcot.recognition.weights import Weights


def weights() -> Weights:
    random = np.random.default_rng(1)
    w1, w2 = (random.integers(-128, 128, shape).astype(np.int8) for shape in ((CELLS**2, HIDDEN), (HIDDEN, 3)))
    return Weights(Network(w1, w2), RecognitionRegisters(window_log2=9, classes=3), (4, 7, 9))


def changed(tmp_path: Path, **arrays: Any) -> Path:
    """The file with other arrays; None leaves one out. The checksum stays."""
    weights().save(tmp_path / "w.npz")
    with np.load(tmp_path / "w.npz") as archive:
        content = {**archive, **arrays}
    np.savez(tmp_path / "changed.npz", **{name: array for name, array in content.items() if array is not None})
    return tmp_path / "changed.npz"


def test_what_was_written_is_read(tmp_path: Path) -> None:
    weights().save(tmp_path / "w.npz")
    read = Weights.load(tmp_path / "w.npz")
    assert (read.registers, read.class_ids, read.tracker) == (weights().registers, (4, 7, 9), "cot_motion")
    assert np.array_equal(read.network.w1, weights().network.w1)
    assert np.array_equal(read.network.w2, weights().network.w2)
    assert read.checksum == weights().checksum
    assert read.names == {4: "4", 7: "7", 9: "9"}


def test_names_are_kept_and_belong_to_the_checksum(tmp_path: Path) -> None:
    named = weights().named({4: "car", 9: "lorry", 11: "bus"})
    named.save(tmp_path / "w.npz")
    read = Weights.load(tmp_path / "w.npz")
    assert read.names == {4: "car", 7: "7", 9: "lorry"}
    assert read.checksum == named.checksum != weights().checksum


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("car", "lorry"), "class_names = car, lorry: must be 3 different names, one for each of class_ids"),
        (("car", "car", "lorry"), "class_names = car, car, lorry: must be 3 different names"),
        (("car", "", "lorry"), "name of a class = '': must be 1 to 64 printable characters"),
        (("car", "a\x1b[2J", "lorry"), "must be 1 to 64 printable characters"),
        (("car", "a" * 65, "lorry"), "must be 1 to 64 printable characters"),
    ],
)
def test_names_that_are_not_one_for_each_class_are_refused(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        Weights(weights().network, weights().registers, (4, 7, 9), class_names=names)


def test_equal_weights_give_equal_files(tmp_path: Path) -> None:
    for name in "ab":
        weights().save(tmp_path / f"{name}.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_file_of_the_users_is_kept(tmp_path: Path) -> None:
    (tmp_path / "w.npz").write_text("mine")
    with pytest.raises(OutputError, match="exists"):
        weights().save(tmp_path / "w.npz")
    assert (tmp_path / "w.npz").read_text() == "mine"


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"w2": None}, "has no array w2"),
        ({"class_names": None}, "has no array class_names: must be weights that evcot train wrote: train again"),
        ({"class_names": np.array(["a", "b", "c"])}, "checksum"),
        ({"version": np.array(2)}, "version = 2: must be 1: train again"),
        (
            {"w1": np.zeros((CELLS**2, HIDDEN), np.int8)},
            "checksum = '[0-9a-f]{16}': must be '[0-9a-f]{16}': the file is damaged",
        ),
        ({"class_ids": np.array([1, 2, 3])}, "checksum"),
        ({"w1": np.array([None])}, "is damaged, or no npz file"),
        ({"w1": np.zeros(1 << 20, np.int8)}, "w1 is longer: must be at most 65536 bytes"),
    ],
)
def test_a_changed_file_is_refused(tmp_path: Path, arrays: dict[str, Any], message: str) -> None:
    path = changed(tmp_path, **arrays)
    with pytest.raises(ConfigError, match=rf"changed.npz: {message}"):
        Weights.load(path)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"registers": np.arange(5)}, r"registers is \(5,\) int64: must be \(6,\) int64"),
        ({"registers": np.full(6, "8")}, r"registers is \(6,\) <U1: must be \(6,\) int64"),
        ({"registers": np.full(6, 99)}, r"recognition\.window_log2 = 99: must be from 8 to 12 \(a window has"),
        ({"class_ids": np.array(["a", "b", "c"])}, r"class_ids is \(3,\) <U1: must be \(3,\) int64"),
        ({"class_ids": np.array(3)}, r"class_ids is \(\) int64: must be \(1,\) int64"),
        ({"w2": np.zeros((HIDDEN, 3))}, r"w2 is \(32, 3\) float64: must be \(32, 2 to 10\) int8"),
    ],
)
def test_a_file_with_a_right_checksum_is_still_checked(tmp_path: Path, arrays: dict[str, Any], message: str) -> None:
    (tmp_path / "right").mkdir()
    with pytest.raises(ConfigError, match=r"must be '[0-9a-f]{16}': the file is damaged") as refused:
        Weights.load(changed(tmp_path, **arrays))
    checksum = str(refused.value).rsplit("'", 2)[1]
    with pytest.raises(ConfigError, match=rf"changed\.npz: {message}"):
        Weights.load(changed(tmp_path / "right", checksum=np.array(checksum), **arrays))


def test_what_is_no_weights_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"missing.npz: cannot be read: No such file"):
        Weights.load(tmp_path / "missing.npz")
    (tmp_path / "text.npz").write_text("text")
    with pytest.raises(ConfigError, match=r"text.npz: is damaged, or no npz file"):
        Weights.load(tmp_path / "text.npz")
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(ConfigError, match=r"one.npy: is a single array"):
        Weights.load(tmp_path / "one.npy")
    weights().save(tmp_path / "w.npz")
    for length in (0, 100, 3_000, (tmp_path / "w.npz").stat().st_size - 1):
        (tmp_path / "cut.npz").write_bytes((tmp_path / "w.npz").read_bytes()[:length])
        with pytest.raises(ConfigError, match=r"cut.npz: is damaged, or no npz file"):
            Weights.load(tmp_path / "cut.npz")


@pytest.mark.parametrize("shape", [(10**6, 10**6), (10**12, 10**12)])
def test_an_array_that_claims_more_than_it_holds_is_refused(tmp_path: Path, shape: tuple[int, int]) -> None:
    path = changed(tmp_path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            with archive.open(name, "w") as member:
                if name == "w1.npy":
                    np.lib.format.write_array_header_1_0(member, {"descr": "|i1", "fortran_order": False, "shape": shape})
                else:
                    member.write(content)
    with pytest.raises(ConfigError, match=r"changed.npz: is damaged, or no npz file"):
        Weights.load(path)


@pytest.mark.parametrize("class_ids", [(1, 2), (1, 2, 2), (1, 2, 3, 4)])
def test_classes_that_are_not_those_of_the_network_are_refused(class_ids: tuple[int, ...]) -> None:
    with pytest.raises(ConfigError, match=r"must be 3 different numbers, as w2 and registers have classes"):
        Weights(weights().network, weights().registers, class_ids)

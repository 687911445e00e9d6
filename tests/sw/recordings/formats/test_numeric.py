# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers from general containers, and their order where they have no names."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import permutations
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats.numeric import SAMPLED_ROWS, column_order

from .reading import assert_same, refusal

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


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *((name, kind) for name in FORMATS if name != "npy" for kind in (np.uint8, np.uint16, np.uint32)),
        ("npy", np.uint32),  # a matrix has one type, which the times need
        ("npz", np.uint64),
    ],
)
def test_minus_one_without_its_sign_is_darker_but_not_next_to_other_numbers(tmp_path: Path, name: str, kind: type[Any]) -> None:
    path, top = tmp_path / "events", np.iinfo(kind).max
    FORMATS[name](path, np.where(P == 0, top, 1).astype(kind))
    assert_same(read_recording(path).events, (T_US, X, Y, P))
    FORMATS[name](path, np.where(P == 0, 0, top).astype(kind))
    told = r"p = \d+ and p = 0: must be \d+, which is -1 without its sign, and 1; or 0 and 1"
    assert re.search(told, refusal(path))
    if name == "npz":
        FORMATS[name](path, np.where(P == 0, top - 1, 1).astype(kind))
        assert re.search(r"p = \d+: must be ", refusal(path))


RANDOM_ROWS = np.random.default_rng(6)
ROW_COUNT = 300
COLUMNS = {
    "t": np.sort(RANDOM_ROWS.integers(10**15, 10**15 + 10**6, ROW_COUNT)),
    "x": RANDOM_ROWS.integers(0, 640, ROW_COUNT),
    "y": RANDOM_ROWS.integers(0, 480, ROW_COUNT),
    "p": RANDOM_ROWS.integers(0, 2, ROW_COUNT),
}
KNOWN = ["txyp", "xytp", "xypt", "ptxy", "pxyt"]


def table(order: str, **columns: Any) -> Any:
    return np.stack([np.asarray((COLUMNS | columns)[name]) for name in order], axis=1)


@pytest.mark.parametrize("order", KNOWN)
def test_the_orders_in_use_are_told_apart(order: str) -> None:
    wanted = tuple(order.index(name) for name in "txyp")
    assert column_order(table(order)) == wanted
    assert column_order(table(order, p=2 * COLUMNS["p"] - 1)) == wanted
    assert column_order(table(order, t=COLUMNS["t"] * 1e-6)) == wanted
    assert column_order(table(order)[:16]) == wanted


@pytest.mark.parametrize("order", ["".join(each) for each in permutations("txyp") if "".join(each) not in KNOWN])
def test_x_and_y_exchanged_are_not_noticed_and_other_orders_are_refused(order: str) -> None:
    exchanged = order.translate(str.maketrans("xy", "yx"))
    if exchanged in KNOWN:
        assert column_order(table(order)) == tuple(exchanged.index(name) for name in "txyp")
    elif any(_possible(order, known) for known in KNOWN):
        with pytest.raises(RecordingError, match="columns without names: as "):
            column_order(table(order))
    else:
        assert column_order(table(order)) == (0, 1, 2, 3)  # the reader then names the first value that is out of its range


def _possible(order: str, known: str) -> bool:
    """Whether the columns in `order` can be read in the order `known`: places are addresses, and p is p."""
    meant = dict(zip(known, order, strict=True))
    return meant["p"] == "p" and "t" not in (meant["x"], meant["y"])


def test_a_time_that_is_no_address_settles_the_order_however_few_the_rows() -> None:
    for n in (1, 2, 5, 15):
        assert column_order(table("xypt", t=COLUMNS["t"] + 6_437_104)[:n]) == (3, 0, 1, 2)
        assert column_order(table("pxyt", t=COLUMNS["t"] * 1e-6 + 0.5)[:n]) == (3, 1, 2, 0)
    assert column_order(table("xypt", t=np.full(ROW_COUNT, 6_437_104))) == (3, 0, 1, 2), "equal times"


def test_dense_times_equal_times_and_slight_disorder_do_not_flip_it() -> None:
    dense = np.arange(ROW_COUNT) // 40 + 7
    swapped = dense.copy()
    swapped[[50, 51]] = 9, 7
    for t in (dense, swapped, np.arange(ROW_COUNT) // 2 + 1000):
        assert column_order(table("xytp", t=t)) == (2, 0, 1, 3)
        assert column_order(table("txyp", t=t)) == (0, 1, 2, 3)


@pytest.mark.parametrize("side", [8, 20, 60, 300])
@pytest.mark.parametrize("axes", ["yx", "xy"])
def test_pixels_of_a_frame_in_order_are_not_taken_for_times(side: int, axes: str) -> None:
    """All events of a frame have one time, as from a simulator of frames, and go along its rows or columns."""
    frames = 4
    slow, fast = (np.tile(each.ravel() + 30, frames) for each in np.mgrid[:side, :side])
    columns = {"t": np.repeat(np.arange(frames) * 20_000, side**2), "p": np.arange(len(slow)) % 2, axes[0]: slow, axes[1]: fast}
    for order in KNOWN:
        rows = np.stack([columns[name] for name in order], axis=1)[:SAMPLED_ROWS]
        assert column_order(rows) == tuple(order.index(name) for name in "txyp"), order


@pytest.mark.parametrize("axes", ["yx", "xy"])
def test_pixels_of_one_polarity_after_the_other_are_not_taken_for_times(axes: str) -> None:
    """2 % of the pixels of a frame in order with p = 1, then 2 % in order with p = 0, four times."""
    slow, fast = (
        np.concatenate(each)
        for each in zip(*(np.nonzero(np.random.default_rng(seed).random((346, 260)) < 0.02) for seed in range(8)), strict=True)
    )
    frame = np.repeat(np.arange(4), len(slow) // 4 + 1)[: len(slow)]
    columns = {"t": 5 + 20_000 * frame, "p": np.arange(len(slow)) * 8 // len(slow) % 2, axes[0]: slow, axes[1]: fast}
    for order in KNOWN:
        rows = np.stack([columns[name] for name in order], axis=1)
        for n in (2_500, SAMPLED_ROWS):  # within a frame, and more than one
            assert column_order(rows[:n]) == tuple(order.index(name) for name in "txyp"), (order, n)


def test_one_pixel_and_one_line_of_pixels_have_times() -> None:
    still, t = np.full(ROW_COUNT, 9), np.arange(ROW_COUNT) * 3
    for x, y in ((still, still), (COLUMNS["x"], still), (still, COLUMNS["y"])):
        assert column_order(table("txyp", t=t, x=x, y=y)) == (0, 1, 2, 3)


def test_few_small_numbers_are_in_the_usual_order() -> None:
    for order in ("txyp", "xytp"):
        assert column_order(table(order, t=np.arange(ROW_COUNT) + 100)[:15]) == (0, 1, 2, 3)


def test_columns_in_no_order_are_refused_with_what_looks_like_the_time() -> None:
    """As CeleX writes them: y, x, brightness, polarity, time."""
    rng = np.random.default_rng(1)
    celex = np.stack([*rng.integers(0, 250, (3, 64)), rng.integers(0, 2, 64), np.arange(64)], axis=1)
    with pytest.raises(
        RecordingError, match=r"as t, x, y, p, times would run back in \d+ % .*; column 5 goes on as a time does: "
    ):
        column_order(celex)


def test_what_may_be_the_usual_order_is() -> None:
    """Few rows; small numbers that could be anything; polarities of something else."""
    ones = np.ones(ROW_COUNT, int)
    for rows in (
        table("txyp", t=np.arange(ROW_COUNT), x=ones, y=ones),
        table("txyp", p=7 * ones),
        table("txyp", x=-ones),
        table("xypt", x=COLUMNS["x"] + 0.5),
        np.full((ROW_COUNT, 4), np.inf),
        np.empty((0, 4)),
    ):
        assert column_order(rows) == (0, 1, 2, 3)


def assert_is_table(events: Events) -> None:
    assert_same(events, [COLUMNS[name] for name in "txyp"])


@pytest.mark.parametrize("order", KNOWN)
def test_text_and_arrays_are_read_in_the_order_that_they_have(tmp_path: Path, order: str) -> None:
    text = tmp_path / "events.txt"
    np.savetxt(text, table(order), "%d", " ")
    rows, columns = tmp_path / "rows.npy", tmp_path / "columns.npy"
    np.save(rows, table(order))
    np.save(columns, np.asfortranarray(table(order)))
    for path in (text, rows, columns):
        with open_recording(path) as file:
            assert_is_table(file.read().events)
            assert file.details["columns"].startswith(f"{', '.join(order)}, assumed by their values; ")


def test_csv_of_metavision_has_its_sensor_in_a_comment(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    rows = "".join(f"{x},{y},{p},{t}\n" for x, y, p, t in table("xypt"))
    for head in ("%geometry:1280,720\n", "% geometry 1280x720\n", "# Geometry: 1280, 720\n"):
        path.write_text(head + rows)
        recording = read_recording(path)
        assert_is_table(recording.events)
        assert (recording.width, recording.height) == (1280, 720)
    path.write_text("% a comment\n" + rows)
    assert_is_table(read_recording(path).events)
    message = refusal(path, f"%geometry:{'9' * 40},720\n" + rows)
    assert message == "line 1: a sensor's side of 40 digits: must be a number up to 65536"


def test_polarities_of_true_and_false(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    names = np.array([["False", "FALSE", "false"], ["True", "TRUE", "true"]])[COLUMNS["p"], np.arange(ROW_COUNT) % 3]
    for order, head in (("txyp", ""), ("xypt", ""), ("pxyt", ""), ("txyp", "t,x,y,p\n"), ("yptx", "y,p,t,x\n")):
        path.write_text(head + "\n".join(",".join(map(str, row)) for row in table(order, p=names)) + "\n")
        assert_is_table(read_recording(path).events)
    for wrong in ("tru", "trux", "truer", "falsy", "False1", "t", "yes"):
        message = refusal(path, f"1,2,3,true\n4,5,6,{wrong}\n")
        assert message == f"line 2: p = '{wrong}': must be 0, 1 or -1, or true or false"

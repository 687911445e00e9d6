# SPDX-License-Identifier: Apache-2.0
"""Columns without names: which of them is the time and which the polarity is judged by their first values."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats.column_order import column_order

RANDOM = np.random.default_rng(6)
COUNT = 300
COLUMNS = {
    "t": np.sort(RANDOM.integers(10**15, 10**15 + 10**6, COUNT)),
    "x": RANDOM.integers(0, 640, COUNT),
    "y": RANDOM.integers(0, 480, COUNT),
    "p": RANDOM.integers(0, 2, COUNT),
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
    assert column_order(table("xypt", t=np.full(COUNT, 6_437_104))) == (3, 0, 1, 2), "equal times"


def test_dense_times_equal_times_and_slight_disorder_do_not_flip_it() -> None:
    dense = np.arange(COUNT) // 40 + 7
    swapped = dense.copy()
    swapped[[50, 51]] = 9, 7
    for t in (dense, swapped, np.arange(COUNT) // 2 + 1000):
        assert column_order(table("xytp", t=t)) == (2, 0, 1, 3)
        assert column_order(table("txyp", t=t)) == (0, 1, 2, 3)


@pytest.mark.parametrize("side", [8, 20, 60])
@pytest.mark.parametrize("axes", ["yx", "xy"])
def test_pixels_of_a_frame_in_order_are_not_taken_for_times(side: int, axes: str) -> None:
    """All events of a frame have one time, as from a simulator of frames, and go along its rows or columns."""
    frames = 4
    slow, fast = (np.tile(each.ravel() + 30, frames) for each in np.mgrid[:side, :side])
    columns = {"t": np.repeat(np.arange(frames) * 20_000, side**2), "p": np.arange(len(slow)) % 2, axes[0]: slow, axes[1]: fast}
    for order in KNOWN:
        rows = np.stack([columns[name] for name in order], axis=1)[:256]
        assert column_order(rows) == tuple(order.index(name) for name in "txyp"), order


def test_one_pixel_and_one_line_of_pixels_have_times() -> None:
    still, t = np.full(COUNT, 9), np.arange(COUNT) * 3
    for x, y in ((still, still), (COLUMNS["x"], still), (still, COLUMNS["y"])):
        assert column_order(table("txyp", t=t, x=x, y=y)) == (0, 1, 2, 3)


def test_few_small_numbers_are_in_the_usual_order() -> None:
    for order in ("txyp", "xytp"):
        assert column_order(table(order, t=np.arange(COUNT) + 100)[:15]) == (0, 1, 2, 3)


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
    ones = np.ones(COUNT, int)
    for rows in (
        table("txyp", t=np.arange(COUNT), x=ones, y=ones),
        table("txyp", p=7 * ones),
        table("txyp", x=-ones),
        table("xypt", x=COLUMNS["x"] + 0.5),
        np.full((COUNT, 4), np.inf),
        np.empty((0, 4)),
    ):
        assert column_order(rows) == (0, 1, 2, 3)


def assert_same(events: Events) -> None:
    for got, name in zip((events.t_us, events.x, events.y, events.p), "txyp", strict=True):
        np.testing.assert_array_equal(got, COLUMNS[name])


@pytest.mark.parametrize("order", KNOWN)
def test_text_and_arrays_are_read_in_the_order_that_they_have(tmp_path: Path, order: str) -> None:
    text = tmp_path / "events.txt"
    np.savetxt(text, table(order), "%d", " ")
    rows, columns = tmp_path / "rows.npy", tmp_path / "columns.npy"
    np.save(rows, table(order))
    np.save(columns, np.asfortranarray(table(order)))
    for path in (text, rows, columns):
        with open_recording(path) as file:
            assert_same(file.read().events)
            assert file.details["columns"].startswith(f"{', '.join(order)}, assumed by their values; ")
    assert_same(read_recording(rows, from_us=0).events)


def test_csv_of_metavision_has_its_sensor_in_a_comment(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    rows = "".join(f"{x},{y},{p},{t}\n" for x, y, p, t in table("xypt"))
    for head in ("%geometry:1280,720\n", "% geometry 1280x720\n", "# Geometry: 1280, 720\n"):
        path.write_text(head + rows)
        recording = read_recording(path)
        assert_same(recording.events)
        assert (recording.width, recording.height) == (1280, 720)
    path.write_text("% a comment\n" + rows)
    assert_same(read_recording(path).events)
    path.write_text(f"%geometry:{'9' * 40},720\n" + rows)
    with pytest.raises(RecordingError, match="line 1: a sensor's side of 40 digits: must be a number up to 65536"):
        read_recording(path)


def test_polarities_of_true_and_false(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    names = np.array([["False", "FALSE", "false"], ["True", "TRUE", "true"]])[COLUMNS["p"], np.arange(COUNT) % 3]
    for order, head in (("txyp", ""), ("xypt", ""), ("pxyt", ""), ("txyp", "t,x,y,p\n"), ("yptx", "y,p,t,x\n")):
        path.write_text(head + "\n".join(",".join(map(str, row)) for row in table(order, p=names)) + "\n")
        assert_same(read_recording(path).events)
    for wrong in ("tru", "trux", "truer", "falsy", "False1", "t", "yes"):
        path.write_text(f"1,2,3,true\n4,5,6,{wrong}\n")
        with pytest.raises(RecordingError, match=f"line 2: p = '{wrong}': must be 0, 1 or -1, or true or false"):
            read_recording(path)

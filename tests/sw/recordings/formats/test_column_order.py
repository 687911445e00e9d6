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
def test_x_and_y_exchanged_cannot_be_told_and_anything_else_is_taken_for_the_usual_order(order: str) -> None:
    exchanged = order.replace("x", "-").replace("y", "x").replace("-", "y")
    wanted = exchanged if exchanged in KNOWN else "txyp"
    assert column_order(table(order)) == tuple(wanted.index(name) for name in "txyp")


def test_what_may_be_the_usual_order_is() -> None:
    """Few rows; small numbers that could be anything; times that run back; polarities of something else."""
    ones = np.ones(COUNT, int)
    for rows in (
        table("xypt")[:15],
        table("txyp", t=np.arange(COUNT), x=ones, y=ones),
        table("txyp", t=COLUMNS["t"][::-1]),
        table("txyp", p=7 * ones),
        table("txyp", x=-ones),
        table("xypt", t=COLUMNS["t"][::-1]),
        table("xypt", x=COLUMNS["x"] + 0.5),
        table("xytp", t=np.arange(COUNT) // 10),  # no further apart than the rows of a sensor
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
            assert file.details.get("columns") == (None if order == "txyp" else f"{', '.join(order)}, by their values")
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

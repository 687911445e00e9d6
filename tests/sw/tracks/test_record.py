# SPDX-License-Identifier: Apache-2.0
"""Records and names of classes at the limits of each rule."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, TrackLogError
from evcot.tracks.record import (
    BEGIN_US,
    TRACK,
    VERDICT,
    check_class_name,
    check_records,
    class_label,
    class_names_from,
    class_names_text,
    classes_at,
    labels_at,
    last_until,
)
from support.refusals import refused

LATEST_US = 1 << 60


def records(n: int = 3) -> NDArray[Any]:
    rows = np.zeros(n, TRACK)
    rows["t_us"] = np.arange(n)
    return rows


@pytest.mark.parametrize(
    ("name", "good", "bad", "rule"),
    [
        ("kind", (0, 3), (4, 255), "must be from 0 to 3"),
        *(
            (name, (-1e9, 1e9), (-1.1e9, 1.1e9, np.nan, np.inf), "must be a number of at most 1e+09")
            for name in ("x", "y", "radius", "vx", "vy", "angle")
        ),
        *((name, (0, 1e9), (-0.1, 1.1e9, np.nan), "must be a number from 0 to 1e+09") for name in ("width", "height")),
        ("confidence", (0, 1), (-0.1, 1.1, np.nan), "must be a number from 0 to 1"),
    ],
)
def test_each_number_of_a_record_has_limits(name: str, good: tuple[float, ...], bad: tuple[float, ...], rule: str) -> None:
    rows = records()
    for value in good:
        rows[name][1] = value
        check_records(rows)
    for value in bad:
        rows[name][1] = value
        with refused(TrackLogError, f"record 11: {name} = {rows[name][1]}: {rule}"):
            check_records(rows, 10)


def test_times_begin_and_end_2_to_the_60th_from_zero_and_do_not_run_back() -> None:
    rows = records()
    rows["t_us"] = -LATEST_US, 0, LATEST_US
    check_records(rows)
    for row, value in ((0, -LATEST_US - 1), (2, LATEST_US + 1)):
        wrong = rows.copy()
        wrong["t_us"][row] = value
        with refused(TrackLogError, f"record {row}: t_us = {value}: must be from -2^60 to 2^60"):
            check_records(wrong)
    rows["t_us"] = 5, 5, 4
    with refused(TrackLogError, "record 2: t_us = 4: must not be before the record before it"):
        check_records(rows)
    check_records(rows[:2], 7, 5)
    with refused(TrackLogError, "record 7: t_us = 5: must not be before the record before it"):
        check_records(rows[:2], 7, 6)
    check_records(records(0), 7, 6)
    assert BEGIN_US == -LATEST_US


@pytest.mark.parametrize("name", ["a", "a" * 64, "two words"])
def test_names_of_classes_that_can_be_shown(name: str) -> None:
    assert check_class_name(name) == name


@pytest.mark.parametrize("name", ["", "a" * 65, " a", "a ", "a\tb", 5, None])
def test_other_names_are_refused(name: object) -> None:
    shown = repr(name)[:66]
    with refused(ConfigError, f"name of a class = {shown}: must be 1 to 64 printable characters, without spaces around them"):
        check_class_name(name)


def test_a_class_is_shown_by_its_name_or_number() -> None:
    assert [class_label(number, {0: "car", 2: "van"}) for number in (-1, 0, 1, 2)] == ["?", "car", "1", "van"]


def test_names_survive_their_text() -> None:
    assert class_names_text({2: "van", 0: "car"}) == '{"0": "car", "2": "van"}'
    assert class_names_from('{"0": "car", "2": "van"}', Path("log")) == {0: "car", 2: "van"}
    for text in ("[]", "5", '{"a": "b"}', '{"1": ""}', "{", "x" * 70):
        with refused(TrackLogError, f"log: class_names = {text[:60]!r}: must be JSON, an object of class numbers and names"):
            class_names_from(text, Path("log"))


def test_the_last_row_of_a_key_until_a_time() -> None:
    keys, times = np.array([1, 2, 1, 1]), np.array([10, 20, 30, 30])
    asked = [(1, 9), (1, 10), (1, 29), (1, 30), (1, 99), (2, 19), (2, 20), (0, 99), (3, 99)]
    key, until = np.array(asked).T
    assert last_until(keys, times, key, until).tolist() == [-1, 0, 0, 3, 3, -1, 1, -1, -1]
    assert last_until(keys, times, np.array([1]), np.array([10])).tolist() == [0]
    assert last_until(keys[:0], times[:0], key[:2], until[:2]).tolist() == [-1, -1]


def test_a_track_has_the_class_of_its_last_verdict() -> None:
    verdicts = np.zeros(3, VERDICT)
    verdicts["track_id"], verdicts["t_us"], verdicts["class_id"] = (4, 4, 0), (10, 20, 20), (1, -1, 0)
    track_id, t_us = np.array([4, 4, 4, 0, 0]), np.array([9, 10, 20, 19, 20])
    assert classes_at(verdicts, track_id, t_us).tolist() == [-1, 1, -1, -1, 0]
    assert labels_at(verdicts, {1: "car"}, track_id, t_us) == ["", "car", "?", "", "0"]

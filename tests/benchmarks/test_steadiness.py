# SPDX-License-Identifier: Apache-2.0
"""Differences between two states of a tracker are of equal recordings, and their error is that of members."""

from __future__ import annotations

import math

import pytest

from steadiness import differences, spread


def test_differences_are_of_equal_recordings() -> None:
    before = {"traffic": {"a": [0.5, 0.7], "b": [0.4, 0.4]}, "gone": {"a": [0.1]}}
    now = {"traffic": {"a": [0.6, 0.8], "b": [0.3, 0.5], "new": [0.9]}, "new": {"a": [0.2]}}
    found = differences(now, before)
    assert set(found) == {"traffic"}
    assert found["traffic"] == (pytest.approx(0.05), pytest.approx(0.05))  # +0.1 and 0: two members


def test_one_member_has_no_error() -> None:
    mean, error = differences({"hand": {"a": [0.6, 0.8]}}, {"hand": {"a": [0.5, 0.5]}})["hand"]
    assert mean == pytest.approx(0.2)
    assert math.isnan(error)


def test_spread_says_mean_deviation_and_range() -> None:
    assert spread([0.5, 0.7]) == "HOTA 0.600, standard deviation 0.141, 0.500 to 0.700"

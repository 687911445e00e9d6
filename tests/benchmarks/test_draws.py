# SPDX-License-Identifier: Apache-2.0
"""Thinned draws of recordings, and what their scatter says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from evcot.events import Events, Recording
from field.draws import Difference, Estimate, differences, drawn, estimate, marking, mean_difference, mean_of
from field.member import Member, nothing_there, scene_rule


def member() -> Member:
    x = np.arange(10_000, dtype=np.uint16) % 100
    recording = Recording(Events(np.arange(10_000), x, x, np.ones(10_000, np.uint8)), 100, 100)
    return Member("f", "m", recording, nothing_there(0, 10_000), scene_rule(recording), "nothing")


def test_draw_loses_a_tenth_and_repeats() -> None:
    first, again, other, other_set = (
        drawn(member(), seed_set, draw).recording.events.t_us for seed_set, draw in ((1, 0), (1, 0), (1, 1), (2, 0))
    )
    assert len(first) == pytest.approx(9_000, rel=0.02)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert not np.array_equal(first, other_set)
    assert len(drawn(member(), 1, None).recording.events) == 10_000


def test_error_of_a_family_is_that_of_its_draws_and_not_of_its_members() -> None:
    found = estimate({"a": {0: 0.1, 1: 0.3}, "b": {0: 0.9, 1: 0.9}})
    assert found.mean == pytest.approx(0.55)
    assert found.error == pytest.approx(math.sqrt(0.02 / 2) / 2)  # variance 0.02 of member a, two draws, two members
    assert math.isnan(estimate({"a": {None: 0.5}}).error)
    assert str(estimate({"a": {None: 0.5}})) == "0.500"
    assert str(found) == "0.550 ± 0.050"


def test_error_of_the_mean_over_families() -> None:
    assert mean_of([Estimate(0.2, 0.03), Estimate(0.6, 0.04)]) == (pytest.approx(0.4), pytest.approx(0.025))


def test_differences_are_of_equal_members_and_draws() -> None:
    before = {"traffic": {"a": {0: 0.5, 1: 0.7}, "b": {0: 0.4, 1: 0.4, 2: 0.9}}, "gone": {"a": {0: 0.1}}}
    now = {"traffic": {"a": {1: 0.8, 0: 0.6}, "b": {0: 0.3, 1: 0.5}, "new": {0: 0.9}}, "new": {"a": {0: 0.2}}}
    found = differences(now, before)
    assert set(found) == {"traffic"}
    assert found["traffic"].mean == pytest.approx(0.05)  # +0.1 and 0: two members
    assert found["traffic"].error == pytest.approx(math.sqrt(0.02 / 2) / 2)
    assert found["traffic"].others == pytest.approx(0.05)
    assert str(Difference(0.05, 0.01, 0.02)) == "+0.050 ± 0.010 ± 0.020"


def test_one_member_says_nothing_of_others() -> None:
    found = differences({"hand": {"a": {0: 0.6, 1: 0.8}}}, {"hand": {"a": {0: 0.5, 1: 0.5}}})["hand"]
    assert (found.mean, math.isnan(found.others)) == (pytest.approx(0.2), True)


def test_mean_difference_has_the_scatter_of_the_families() -> None:
    found = mean_difference([Difference(0.1, 0.03, 0.5), Difference(0.3, 0.04, 0.5)])
    assert found == (pytest.approx(0.2), pytest.approx(0.025), pytest.approx(0.1))


@pytest.mark.parametrize(
    ("family", "sets", "said"),
    [
        ("boxes", [1], "validation"),
        ("boxes", [106], "test"),
        ("boxes", [106, 21], "validation"),
        ("traffic, crowd", [106], "validation"),
    ],
)
def test_recordings_that_are_in_every_set_or_selected_something_are_validation(family: str, sets: list[int], said: str) -> None:
    assert marking(family, sets) == said

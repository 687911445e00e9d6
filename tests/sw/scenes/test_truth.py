# SPDX-License-Identifier: Apache-2.0
"""A box is where its waypoints say, and moves as they say."""

from __future__ import annotations

import numpy as np

from evcot.scenes.truth import Box, sample

STORY = Box(
    width=4.0,
    height=2.0,
    brighter=True,
    t_us=np.array([100_000.0, 200_000.0, 300_000.0, 400_000.0]),
    x=np.array([-3.0, 7.0, 7.0, -3.0]),
    y=np.array([5.0, 5.0, 5.0, 25.0]),
)


def test_positions_lie_on_straight_lines_between_waypoints_and_rest_beyond_them() -> None:
    x, y = STORY.centre(np.array([0, 100_000, 150_000, 200_000, 250_000, 350_000, 400_000, 900_000]))
    assert x.tolist() == [-3.0, -3.0, 2.0, 7.0, 7.0, 2.0, -3.0, -3.0]
    assert y.tolist() == [5.0, 5.0, 5.0, 5.0, 5.0, 15.0, 25.0, 25.0]


def test_velocity_is_that_of_the_stretch_and_zero_at_rest() -> None:
    vx, vy = STORY.velocity(np.array([0, 100_000, 199_999, 200_000, 300_000, 399_999, 400_000, 900_000]))
    np.testing.assert_allclose(vx, [0, 100, 100, 0, -100, -100, 0, 0])
    np.testing.assert_allclose(vy, [0, 0, 0, 0, 200, 200, 0, 0])


def test_a_box_is_visible_while_its_centre_is_on_the_sensor() -> None:
    times = np.array([124_000, 126_000, 250_000, 349_000, 374_000, 376_000])
    samples = sample((STORY,), times, (10, 15))
    x, y = STORY.centre(times)
    np.testing.assert_allclose(x[:2], [-0.6, -0.4])
    assert samples["visible"].tolist() == [False, True, True, False, False, False]
    assert y[3] > 14.5
    assert samples.dtype.names == ("t_us", "object_id", "x", "y", "width", "height", "vx", "vy", "visible")

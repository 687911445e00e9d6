# SPDX-License-Identifier: Apache-2.0
"""benchmarks/lines.py: the truth of its bars is where their events are, and both ways of following are scored."""

from __future__ import annotations

import numpy as np
import pytest

import lines


def test_events_lie_on_the_bar() -> None:
    stage, recording = lines.bars(7, 10.0)
    events = recording.events
    normal, rho = (part[:, 0] for part in stage.truth(events.t_us))
    x, y = events.x - (recording.width - 1) / 2, events.y - (recording.height - 1) / 2
    off = x * np.cos(normal) + y * np.sin(normal) - rho
    near = off[abs(off) < 5]
    assert len(near) > 0.95 * len(off), "the rest is noise, and the ends"
    assert abs(near.mean()) < 0.1, "two edges, one on each side"


def test_the_follower_is_better_than_a_tracker_on_the_spikes() -> None:
    run = lines.bars(7, 10.0)
    found, tracked = lines.by_follower(*run), lines.by_tracker(*run)
    assert found.ids == 1
    assert found.error_deg < 0.5 < tracked.error_deg
    assert found.error_px < 0.3


@pytest.mark.usefixtures("kernels")
def test_spikes_of_a_circle_lie_at_its_centre() -> None:
    hota, error_px = lines.circle_scores(1, 3, transform=True)
    assert hota > 0.9
    assert error_px < 0.6

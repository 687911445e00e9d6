# SPDX-License-Identifier: Apache-2.0
"""Frames, and the objects in one of them."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.trackers.frame_based import FrameConfig, FrameTracker, detect

PLAIN = FrameConfig(median_px=1, link_px=0, area_min_px=1)


def block(left: int, top: int, width: int, height: int) -> np.ndarray:  # type: ignore[type-arg]
    """The pixels of a rectangle, (2, n)."""
    return np.stack(np.meshgrid(np.arange(left, left + width), np.arange(top, top + height))).reshape(2, -1)


def events(*parts: np.ndarray) -> Events:  # type: ignore[type-arg]
    x, y = np.concatenate(parts, axis=1).astype(np.uint16)
    return Events(1_000 + np.arange(len(x)), x, y, np.zeros(len(x), np.uint8))


def objects(found: np.ndarray) -> set[tuple[float, ...]]:  # type: ignore[type-arg]
    return {tuple(row) for row in found[["x", "y", "radius", "width", "height", "n"]].tolist()}


def test_frames_count_from_the_first_event_and_empty_frames_are_skipped() -> None:
    t_us = np.array([1005, 1014, 1016, 1024, 1025, 1059, 1064, 1065])
    assert FrameTracker(FrameConfig(frame_us=10)).frame_ends(t_us).tolist() == [2, 4, 5, 7]


def test_an_object_is_its_box_and_its_pixels_at_the_mean_time() -> None:
    found = detect(events(block(0, 0, 5, 3), block(20, 30, 4, 4)), PLAIN)
    assert objects(found) == {(2.0, 1.0, 2.0, 5.0, 3.0, 15), (21.5, 31.5, 2.0, 4.0, 4.0, 16)}
    assert found["after_us"].tolist() == [15.0, 15.0]


def test_pixels_count_once_and_touch_by_their_corners() -> None:
    diagonal = np.array([[7, 8, 9, 9, 9], [7, 8, 9, 9, 9]])
    assert objects(detect(events(diagonal), PLAIN)) == {(8.0, 8.0, 1.5, 3.0, 3.0, 3)}


@pytest.mark.parametrize(("link_px", "objects_expected"), [(2, 2), (3, 1), (4, 1)])
def test_pieces_are_joined_across_a_gap_of_link_px(link_px: int, objects_expected: int) -> None:
    for first, second in ((block(0, 0, 3, 3), block(6, 0, 3, 3)), (block(0, 0, 3, 3), block(0, 6, 3, 3))):
        config = FrameConfig(median_px=1, link_px=link_px, area_min_px=1)
        assert len(detect(events(first, second), config)) == objects_expected


def test_the_median_removes_single_pixels_and_rounds_corners() -> None:
    config = FrameConfig(median_px=3, link_px=0, area_min_px=1)
    noise = np.array([[40, 60, 61], [40, 3, 4]])
    assert objects(detect(events(block(10, 10, 5, 5), noise), config)) == {(12.0, 12.0, 2.5, 5.0, 5.0, 21)}
    assert len(detect(events(noise), config)) == 0


def test_small_objects_are_discarded() -> None:
    config = FrameConfig(median_px=1, link_px=0, area_min_px=4)
    assert objects(detect(events(block(0, 0, 3, 1), block(10, 0, 2, 2)), config)) == {(10.5, 0.5, 1.0, 2.0, 2.0, 4)}


def test_a_frame_that_spans_too_many_pixels_is_refused() -> None:
    message = r"^frame from t = 1000 us: spans 65511x65511 pixels: must be at most 2\^26 in all$"
    with pytest.raises(RecordingError, match=message):
        detect(events(np.array([[0, 65_500], [0, 65_500]])), FrameConfig())

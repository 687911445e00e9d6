# SPDX-License-Identifier: Apache-2.0
"""What of the truth and the tracks is evaluated, and how similar they are, at the limits of each rule."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.metrics.frames import line_up
from evcot.metrics.rule import Rule
from evcot.metrics.truth import OBJECT, GroundTruth
from evcot.tracks.timeline import SAMPLE

SENSOR = 100, 80


def outputs(*places: tuple[float, float], side: float = 10.0) -> NDArray[np.void]:
    """Tracks at the only instant."""
    rows = np.zeros(len(places), SAMPLE)
    rows["track_id"] = np.arange(len(places))
    rows["x"], rows["y"] = np.array(places, float).reshape(-1, 2).T
    rows["width"] = rows["height"] = side
    return rows


def objects(*boxes: tuple[float, float, float, float, bool]) -> GroundTruth:
    """Objects at the only instant: x, y, width, height, whether it counts."""
    rows = np.zeros(len(boxes), OBJECT)
    rows["object"] = np.arange(len(boxes))
    for k, box in enumerate(boxes):
        for name, value in zip(("x", "y", "width", "height", "counted"), box, strict=True):
            rows[name][k] = value
    return GroundTruth(np.array([0]), rows, tuple(str(k) for k in range(len(boxes))))


def kept(place: tuple[float, float], *boxes: tuple[float, float, float, float, bool], **rule: object) -> bool:
    """Whether an output is evaluated."""
    frames, _, _ = line_up(outputs(place), objects(*boxes), Rule({}, sensor=SENSOR, **rule))  # type: ignore[arg-type]
    return frames.n_tracks == 1


@pytest.mark.parametrize(
    ("place", "inside"),
    [((45, 40), True), ((44.9, 40), False), ((55, 40), True), ((55.1, 40), False), ((50, 38), True), ((50, 37.9), False)],
)
def test_an_output_in_a_box_that_does_not_count_is_ignored(place: tuple[float, float], inside: bool) -> None:
    uncounted = (50, 40, 10, 4, False)
    assert kept(place, uncounted) == (not inside)
    assert kept(place, uncounted, (50, 40, 20, 20, True)), "unless it lies in one that counts"


@pytest.mark.parametrize("edge_px", [-0.5, 0.0])
@pytest.mark.parametrize(
    ("edge", "inside", "outside"),
    [
        ("left", (4.9, 40), (5, 40)),
        ("right", (95.1, 40), (95, 40)),
        ("top", (50, 4.9), (50, 5)),
        ("bottom", (50, 75.1), (50, 75)),
    ],
)
def test_an_output_in_an_ignored_band_is_ignored(
    edge: str, inside: tuple[float, float], outside: tuple[float, float], edge_px: float
) -> None:
    for place, is_kept in ((inside, False), (outside, True)):
        at = place[0] + edge_px, place[1] + edge_px
        assert kept(at, ignore={edge: 5.0}, edge_px=edge_px) == is_kept
        assert kept(at, (*at, 1, 1, True), ignore={edge: 5.0}, edge_px=edge_px)


def similarity(place: tuple[float, float], box: tuple[float, float, float, float], side: float = 10.0, **rule: object) -> float:
    truth, made = objects((*box, True)), Rule({}, sensor=SENSOR, **rule)  # type: ignore[arg-type]
    return float(line_up(outputs(place, side=side), truth, made)[0].similarity[0][0, 0])


def test_nearness_is_a_share_of_half_the_diagonal() -> None:
    box = 50, 40, 12, 16  # half a diagonal of 10
    assert similarity((50, 40), box) == 1
    assert similarity((53, 44), box) == 0.5
    assert similarity((60, 40), box) == similarity((70, 40), box) == 0


def test_overlap_is_what_both_share_of_what_either_has() -> None:
    assert similarity((50, 40), (50, 40, 20, 10), similarity="iou") == 0.5
    assert similarity((55, 45), (50, 40, 10, 10), similarity="iou") == 25 / 175
    assert similarity((60, 40), (50, 40, 10, 10), similarity="iou") == 0
    assert similarity((65, 40), (50, 40, 10, 10), similarity="iou") == 0


def test_overlap_counts_what_lies_on_the_sensor() -> None:
    """Its edges are at -0.5, 99.5 and 79.5: there are 8 px of the first track's width, and a quarter of the second."""
    left = similarity((2.5, 40), (5, 40, 10, 10), similarity="iou", clip=True)
    assert left == pytest.approx(75 / (100 + 80 - 75))
    assert similarity((99.5, 79.5), (97.25, 77.25, 4.5, 4.5), similarity="iou", clip=True) == pytest.approx(4.5**2 / 25)
    assert similarity((3, 40), (5.5, 40, 10, 10), similarity="iou", clip=True, edge_px=0.0) == pytest.approx(left)

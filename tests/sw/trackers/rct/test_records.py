# SPDX-License-Identifier: Apache-2.0
"""Sizes, steps and evidence of a cluster at their limits; the order of records."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from evcot.trackers.rct import records
from evcot.trackers.rct.records import BORN, LOST, MERGED, MOVED
from evcot.tracks.log import TRACK
from support.interpreted import interpret


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch, records)


def rules(**given: float) -> Any:
    plain = {"perspective": 0, "vanishing_y_px": 20.0, "reference_y_px": 120.0, "radius_px": 10.0, "aspect": 0.5}
    return SimpleNamespace(
        **plain | {"dynamic_size": 0, "box_quantile": 0.0, "visible_rate_hz": 0.0, "visible_events": 30} | given
    )


def cluster(**given: float) -> Any:
    plain = {"x": 50.0, "y": 70.0, "before": 0, "packet_events": 0, "half_width": 8.0, "half_height": 4.0, "track_id": 3}
    sides = {"left": 44.0, "right": 58.0, "top": 66.0, "bottom": 72.0, "extent_x": 6.0, "extent_y": 2.0, "mass": 0.0}
    return SimpleNamespace(**plain | sides | {"velocity_x": 3.0, "velocity_y": 4.0, "slot": 2} | given)


@pytest.mark.parametrize(
    ("y", "scale"),
    [(120, 1.0), (70, 0.5), (220, 2.0), (0, 0.2), (20, 0.05), (26, 0.06), (2020, 20.0), (2120, 20.0)],
)
def test_with_perspective_sizes_grow_with_the_distance_from_the_vanishing_row(y: float, scale: float) -> None:
    assert records._scale(rules(perspective=1), y) == pytest.approx(scale)
    assert records._scale(rules(), y) == 1.0


@pytest.mark.parametrize(
    ("before", "events", "mix", "step"),
    [(0, 0, 0.2, 0.1), (0, 1, 0.2, 0.1), (4, 6, 0.2, 0.1), (10, 10, 0.1, 0.05), (0, 50, 0.04, 0.02), (200, 200, 0.01, 0.02)],
)
def test_a_young_cluster_follows_its_events_faster(before: int, events: int, mix: float, step: float) -> None:
    one = cluster(before=before, packet_events=events)
    records.set_mixing(one)
    assert (one.mix, one.step_x, one.step_y) == pytest.approx((mix, 8 * step, 4 * step))


def test_the_object_is_its_box_or_its_extent_and_at_least_a_pixel() -> None:
    assert records.object_box(rules(), cluster()) == (12, 4)
    assert records.object_box(rules(box_quantile=0.1), cluster()) == (14, 6)
    assert records.object_box(rules(), cluster(extent_x=0.4, extent_y=0.3)) == (1, 1)
    assert records.object_box(rules(box_quantile=0.1), cluster(right=44.5, bottom=66.0)) == (1, 1)


def test_a_new_cluster_has_a_window_of_its_row_and_no_extent() -> None:
    one = cluster()
    records.start_size(rules(perspective=1), one)
    assert (one.half_width, one.half_height, one.deviation_x, one.deviation_y) == (5.0, 2.5, 0.0, 0.0)
    assert (one.left, one.right, one.top, one.bottom, one.extent_x, one.extent_y) == (50, 50, 70, 70, 0, 0)
    assert (one.mix, one.step_x) == pytest.approx((0.2, 0.5))


@pytest.mark.parametrize(
    ("options", "given", "half_width"),
    [
        ({}, {}, 8.0),
        ({"perspective": 1}, {}, 5.0),
        ({"dynamic_size": 1}, {"track_id": -1}, 8.0),
        ({"dynamic_size": 1}, {"track_id": 0}, 0.7 / 0.9 * 12),  # 1.4 times the object, whose extent leaves out 5 % twice
        ({"dynamic_size": 1}, {"extent_y": 4.0}, 0.7 / 0.9 * 16),  # its height over the aspect of a half
        ({"dynamic_size": 1, "box_quantile": 0.1}, {}, 0.7 / 0.8 * 14),
        ({"dynamic_size": 1}, {"extent_x": 90.0}, 40.0),  # four windows of a new cluster
        ({"dynamic_size": 1}, {"extent_x": 1.0, "extent_y": 0.5}, 10 / 3),
        ({"dynamic_size": 1, "perspective": 1}, {"extent_x": 90.0}, 20.0),
    ],
)
def test_a_window_follows_perspective_and_the_visible_object(
    options: dict[str, Any], given: dict[str, Any], half_width: float
) -> None:
    one = cluster(**given)
    records.follow_size(rules(**options), one)
    assert one.half_width == pytest.approx(half_width)
    assert one.half_height == pytest.approx(half_width / 2 if options else 4.0)
    assert one.step_x == pytest.approx(0.1 * half_width)


def test_evidence_is_a_share_of_the_events_or_the_rate_needed() -> None:
    assert records.weight(rules(), cluster(before=10, packet_events=5)) == 0.5
    assert records.weight(rules(visible_rate_hz=2000.0), cluster(mass=10.0)) == pytest.approx(0.5)  # of 10 ms


def recorded(*rows: tuple[int, int, int], closed: int = 0, **options: float) -> list[tuple[int, int, int]]:
    """The order of records that are made one after the other: kind, index, time."""
    state: Any = SimpleNamespace(
        cursor=[SimpleNamespace(records=0, closed=closed)],
        out=np.zeros(10, TRACK).view(np.recarray),
        clusters=[cluster(before=20, packet_events=10)],
        rules=[rules(**options)],
    )
    for kind, index, t_us in rows:
        records.record(state, kind, index, t_us, 0, 7)
    return [(int(row.kind), int(row.event_index), int(row.t_us)) for row in state.out[: state.cursor[0].records]]


def test_records_stand_in_the_order_of_their_events() -> None:
    assert recorded((MOVED, 5, 50), (BORN, 7, 70), (MERGED, 6, 60)) == [(MOVED, 5, 50), (MERGED, 6, 60), (BORN, 7, 70)]
    assert recorded((MOVED, 5, 50), (BORN, 5, 40)) == [(MOVED, 5, 50), (BORN, 5, 40)]


def test_a_loss_precedes_what_its_event_causes_and_losses_stand_by_time() -> None:
    assert recorded((BORN, 5, 50), (LOST, 5, 45)) == [(LOST, 5, 45), (BORN, 5, 50)]
    assert recorded((LOST, 5, 45), (LOST, 5, 40), (LOST, 5, 45)) == [(LOST, 5, 40), (LOST, 5, 45), (LOST, 5, 45)]
    assert recorded((LOST, 4, 45), (LOST, 5, 40)) == [(LOST, 4, 45), (LOST, 5, 40)]


def test_records_of_closed_packets_stay_where_they_are() -> None:
    assert recorded((MOVED, 9, 90), (LOST, 5, 50), (BORN, 4, 40), closed=1) == [(MOVED, 9, 90), (BORN, 4, 40), (LOST, 5, 50)]


@pytest.mark.parametrize(("quantile", "radius", "box"), [(0.0, 8.0, (12, 4)), (0.1, 7.0, (14, 6))])
def test_a_record_tells_what_is_known_of_the_cluster(quantile: float, radius: float, box: tuple[float, float]) -> None:
    state: Any = SimpleNamespace(
        cursor=[SimpleNamespace(records=0, closed=0)],
        out=np.zeros(2, TRACK).view(np.recarray),
        clusters=[None, cluster(before=20, packet_events=10)],
        rules=[rules(box_quantile=quantile)],
    )
    records.record(state, MERGED, 5, 50, 1, 7)
    row = state.out[0]
    assert (row.track_id, row.slot, row.other_id, row.x, row.y, row.angle, row.vx, row.vy) == (3, 2, 7, 50, 70, 0, 3, 4)
    assert (row.radius, row.width, row.height, row.n_ev, row.support) == (radius, *box, 10, 30)
    assert row.confidence == pytest.approx(0.5)

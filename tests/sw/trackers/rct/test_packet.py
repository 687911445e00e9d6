# SPDX-License-Identifier: Apache-2.0
"""Which clusters merge at the end of a packet, which of two survives, and what becomes of their positions and counts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evcot.trackers.rct import find, life, motion, packet, records
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.state import new_state
from evcot.tracks.log import TRACK, Kind
from support.interpreted import interpret

CONFIG = RctConfig(lifetime_us=1_000, visible_events=30, radius_px=10.0)
RATE = replace(CONFIG, visible_rate_hz=1_000.0)


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch, packet, life, records, find, motion)


def state_of(*clusters: dict[str, Any], config: RctConfig = CONFIG) -> Any:
    """Clusters that were seeded at (100, 60) at 5,000 us, with other values afterwards; the packet ends at 6,000 us."""
    plain: Any = new_state(config, 320, 240)
    views = {name: getattr(plain, name).view(np.recarray) for name in ("rules", "cursor", "clusters")}
    state = plain._replace(**views, out=np.zeros(20, TRACK).view(np.recarray))
    for given in clusters:
        seat = life.seed(state, given.get("x", 100.0), given.get("y", 60.0), 5_000)
        for name, value in given.items():
            state.clusters[name][seat] = value
    state.cursor.index, state.cursor.last_us, state.cursor.packet_end_us = 77, 5_900, 6_000
    return state


def told(state: Any) -> list[tuple[Kind, int, int]]:
    rows = state.out[: state.cursor[0].records]
    assert (rows.event_index == 76).all()
    assert (rows.t_us == 5_900).all()
    return [(Kind(row.kind), int(row.track_id), int(row.other_id)) for row in rows]


@pytest.mark.parametrize(("options", "weights"), [(CONFIG, (30, 10)), (RATE, (1, 3))])
def test_the_merged_cluster_lies_between_the_two_by_their_events_or_mass(options: RctConfig, weights: tuple[int, int]) -> None:
    into = {"x": 100.0, "y": 60.0, "velocity_x": 4.0, "velocity_y": 8.0, "before": 20, "packet_events": 10, "mass": 1.0}
    gone = {"x": 104.0, "y": 52.0, "velocity_x": 8.0, "velocity_y": 0.0, "before": 4, "packet_events": 6, "mass": 3.0}
    box = {"left": 95.0, "right": 106.0, "top": 57.0, "bottom": 64.0, "extent_x": 2.0, "extent_y": 3.0}
    state = state_of(
        into | box | {"last_us": 5_100}, gone | {"last_us": 5_200, "extent_x": 1.5, "extent_y": 5.5}, config=options
    )
    one = state.clusters[0]
    packet._blend(state.rules[0], one, state.clusters[1], 6_000)
    share = weights[1] / sum(weights)
    assert (one.x, one.y) == (100 + 4 * share, 60 - 8 * share)
    assert (one.velocity_x, one.velocity_y) == (4 + 4 * share, 8 - 8 * share)
    assert (one.last_us, one.before, one.packet_events, one.mass) == (5_200, 24, 16, 4.0)
    assert (one.left, one.right, one.top, one.bottom) == (95 + 4 * share, 106 + 4 * share, 57 - 8 * share, 64 - 8 * share)
    # The extent reaches the other's, from the new centre, and at most the window.
    assert (one.extent_x, one.extent_y) == (4 - 4 * share + 1.5, min(8 - 8 * share + 5.5, 10))
    assert one.mix == pytest.approx(2 / 40)


def test_without_mass_events_are_the_weights() -> None:
    state = state_of({"x": 100.0, "before": 30}, {"x": 104.0, "before": 10}, config=RATE)
    state.clusters.packet_events[:2] = 0
    packet._blend(state.rules[0], state.clusters[0], state.clusters[1], 6_000)
    assert state.clusters[0].x == 101


@pytest.mark.parametrize(
    ("first", "second", "options", "survives"),
    [
        ({"track_id": -1}, {"track_id": -1}, CONFIG, 0),
        ({"track_id": -1}, {"track_id": 0}, CONFIG, 1),
        ({"track_id": 0}, {"track_id": -1}, CONFIG, 0),
        ({"track_id": 2}, {"track_id": 1}, CONFIG, 1),
        ({"track_id": 0}, {"track_id": 1}, CONFIG, 0),
        ({"track_id": 1}, {"track_id": 0}, CONFIG, 1),
        ({"track_id": 0, "mass": 2.0}, {"track_id": 1, "mass": 3.0}, RATE, 1),
        ({"track_id": 0, "mass": 3.0}, {"track_id": 1, "mass": 3.0}, RATE, 0),
        ({"track_id": 0, "mass": 2.0}, {"track_id": 1, "mass": 3.0}, CONFIG, 0),
    ],
)
def test_the_track_seen_first_survives_or_the_one_with_more_mass(
    first: dict[str, Any], second: dict[str, Any], options: RctConfig, survives: int
) -> None:
    state = state_of(first, second, config=options)
    assert packet._second_survives(state.rules[0], *state.clusters[:2]) == (survives == 1)
    assert packet._merge(state, 0, 1) == 0
    assert state.live[: state.cursor[0].live].tolist() == [survives]
    ids = first["track_id"], second["track_id"]
    assert told(state) == ([] if ids[1 - survives] < 0 else [(Kind.MERGED, ids[1 - survives], ids[survives])])


def test_the_place_of_the_survivor_among_the_live_clusters_is_told() -> None:
    assert packet._merge(state_of({}, {}, {}, {}), 1, 3) == 1
    assert packet._merge(state_of({}, {}, {}, {"track_id": 0}), 1, 3) == 2


@pytest.mark.parametrize(("events", "born"), [(14, False), (15, True)])
def test_two_clusters_may_become_a_track_together(events: int, born: bool) -> None:
    state = state_of({"before": 10, "packet_events": 5}, {"before": 0, "packet_events": events})
    assert packet._merge(state, 0, 1) == 0
    assert told(state) == ([(Kind.BORN, 0, -1)] if born else [])


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(("apart", "touch"), [(20.0, True), (20.1, False), (-20.0, True), (-20.1, False), (0.0, True)])
def test_windows_touch_where_they_share_a_point(apart: float, touch: bool, axis: str) -> None:
    state = state_of({}, {axis: {"x": 100.0, "y": 60.0}[axis] + apart})
    assert packet._touch(state.clusters[0], state.clusters[1]) == touch
    small = state_of({"half_width": 5.0, "half_height": 5.0}, {axis: {"x": 100.0, "y": 60.0}[axis] + 15.1})
    assert not packet._touch(small.clusters[0], small.clusters[1])


OVERLAP = replace(RATE, merge_overlap=0.5)


@pytest.mark.parametrize(
    ("second", "may"),
    [
        ({"x": 110.0}, True),  # half of 20 x 20 px
        ({"x": 110.1}, False),
        ({"y": 50.0}, True),
        ({"y": 49.9}, False),
        ({"x": 106.0, "y": 54.0}, False),  # 14 x 14
        ({"x": 105.0, "y": 55.0}, True),  # 15 x 15
        ({"x": 110.0, "half_width": 5.0}, True),  # half of 10 x 20 px
        ({"x": 110.1, "half_width": 5.0}, False),
        ({"y": 70.0, "half_height": 5.0}, True),
        ({"y": 70.1, "half_height": 5.0}, False),
        ({"half_width": 5.0, "half_height": 5.0}, True),
    ],
)
def test_windows_merge_from_a_share_of_the_smaller_on(second: dict[str, Any], may: bool) -> None:
    state = state_of({}, second, config=OVERLAP)
    rules, (a, b) = state.rules[0], state.clusters[:2]
    assert packet._may_merge(rules, a, b, 5_500) == packet._may_merge(rules, b, a, 5_500) == may


@pytest.mark.parametrize(("now_us", "may"), [(5_999, True), (6_000, False)])
def test_a_coasting_cluster_does_not_merge(now_us: int, may: bool) -> None:
    state = state_of({}, {"last_us": 5_900}, config=replace(OVERLAP, coast_us=5_000))
    assert packet._may_merge(state.rules[0], state.clusters[0], state.clusters[1], now_us) == may
    plain = state_of({}, {"last_us": 5_900}, config=OVERLAP)
    assert packet._may_merge(plain.rules[0], plain.clusters[0], plain.clusters[1], now_us)


@pytest.mark.parametrize(("events", "merges"), [((0, 0), False), ((1, 0), True), ((0, 1), True)])
def test_clusters_of_the_paper_merge_if_one_has_new_events(events: tuple[int, int], merges: bool) -> None:
    state = state_of({"packet_events": events[0]}, {"packet_events": events[1], "x": 115.0})
    packet.merge_overlapping(state)
    assert state.cursor[0].live == (1 if merges else 2)


def test_a_merged_cluster_may_merge_with_one_before_it() -> None:
    # The second and the third merge at (111.5, 78), which touches the first; neither did. The fourth is alone.
    state = state_of({}, {"x": 102.0, "y": 81.0}, {"x": 121.0, "y": 75.0}, {"x": 200.0})
    packet.merge_overlapping(state)
    assert state.live[: state.cursor[0].live].tolist() == [0, 3]
    state = state_of({}, {"x": 121.0}, {"x": 125.0}, {"x": 200.0})
    packet.merge_overlapping(state)
    assert state.live[: state.cursor[0].live].tolist() == [0, 1, 3]


def test_a_visible_cluster_with_events_has_moved_and_counts_are_carried_over() -> None:
    visible = {"track_id": 0, "before": 40, "packet_events": 3, "last_us": 5_900}
    state = state_of(visible, visible | {"x": 200.0, "track_id": 1, "packet_events": 0}, {"x": 300.0, "last_us": 5_900})
    packet.close_packet(state, 6_000)
    assert told(state) == [(Kind.MOVED, 0, -1)]
    assert (state.clusters.before[:3].tolist(), state.clusters.packet_events[:3].tolist()) == ([43, 40, 1], [0, 0, 0])

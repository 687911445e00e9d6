# SPDX-License-Identifier: Apache-2.0
"""When a cluster becomes a track, is hidden, coasts and ends, at the limits of each rule."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from evcot.trackers.rct import find, life, records
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.state import CELLS, NEVER_US, new_state
from evcot.tracks.log import TRACK, Kind
from support.interpreted import interpret

CONFIG = RctConfig(lifetime_us=1_000, visible_events=30, radius_px=10.0)


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch, life, records, find)


def state_of(*clusters: dict[str, Any], config: RctConfig = CONFIG) -> Any:
    """Clusters that were seeded at (20, 30), (60, 30) and so on at 5,000 us, with other values afterwards."""
    state: Any = new_state(config, 320, 240)
    views = {name: getattr(state, name).view(np.recarray) for name in ("rules", "cursor", "clusters")}
    state = state._replace(**views, out=np.zeros(20, TRACK).view(np.recarray))
    for i, given in enumerate(clusters):
        seat = life.seed(state, 20.0 + 40 * i, 30.0, 5_000)
        for name, value in given.items():
            state.clusters[name][seat] = value
    state.cursor.index = 77
    return state


def told(state: Any) -> list[tuple[Kind, int, int, int]]:
    """Kind, track, time and event of the records."""
    rows = state.out[: state.cursor[0].records]
    assert (rows.other_id == -1).all()
    return [(Kind(row.kind), int(row.track_id), int(row.t_us), int(row.event_index)) for row in rows]


def test_a_new_cluster_takes_the_lowest_free_slot() -> None:
    state = state_of({}, {}, {})
    life.drop(state, 1)
    assert state.taken[:4].tolist() == [1, 0, 1, 0]
    assert state.live[: state.cursor[0].live].tolist() == [0, 2]
    seat = life.seed(state, 100.0, 90.0, 6_000)
    one = state.clusters[seat]
    assert (one.slot, one.x, one.y, one.last_us, one.packet_events, one.before) == (1, 100, 90, 6_000, 1, 0)
    assert (one.track_id, one.from_us, one.due_us, one.places, one.measured) == (-1, NEVER_US, -NEVER_US, 0, 0)
    assert (one.mass, one.velocity_x, one.velocity_y, one.half_width) == (0, 0, 0, 10)
    assert state.live[: state.cursor[0].live].tolist() == [0, 2, seat]


def test_clusters_leave_no_trace_in_the_lookup() -> None:
    state = state_of({}, {}, {})
    assert state.cells[0].any()
    for _ in range(3):
        life.drop(state, 0)
    assert not state.cells.any()
    assert not state.taken.any()


@pytest.mark.parametrize(("x", "y"), [(20, 30), (3, 3), (510, 508), (600, 30), (0, 0)])
def test_a_cluster_is_found_in_every_cell_of_its_window(x: float, y: float) -> None:
    state = state_of()
    seat = life.seed(state, x, y, 0)
    for ex in range(int(x) - 10, int(x) + 11):
        for ey in range(int(y) - 10, int(y) + 11):
            if ex >= 0 and ey >= 0:
                assert int(state.cells[0, (ey >> 3) % CELLS * CELLS + (ex >> 3) % CELLS]) >> seat & 1
    assert np.count_nonzero(state.cells) <= 25, "and in few others"


def test_missing_events_and_mass() -> None:
    state = state_of({"before": 12, "packet_events": 5})
    assert life.missing_events(state.rules[0], state.clusters[0]) == 13
    life.grow_mass(state.clusters[0], 0.5)
    life.grow_mass(state.clusters[0], 0.5)
    assert state.clusters[0].mass == 7.5


@pytest.mark.parametrize(
    ("given", "due"),
    [
        ({"before": 25, "packet_events": 5, "deviation_x": 1.5, "deviation_y": 0.5}, True),
        ({"before": 24, "packet_events": 5, "deviation_x": 1.5, "deviation_y": 0.5}, False),
        ({"before": 25, "packet_events": 5, "deviation_x": 1.25, "deviation_y": 0.5}, False),
    ],
)
def test_a_cluster_becomes_a_track_with_enough_events_that_are_spread(given: dict[str, Any], due: bool) -> None:
    state = state_of(given, config=replace(CONFIG, birth_spread_px=2.0))
    assert life.is_due(state.rules[0], state.clusters[0]) == due
    assert life.show_if_due(state, 0, 76, 6_000) == -1
    assert told(state) == ([(Kind.BORN, 0, 6_000, 76)] if due else [])
    assert state.cursor[0].births == due


RATE = replace(CONFIG, visible_rate_hz=1_000.0)  # a mass of 10; hidden below a fifth of it


@pytest.mark.parametrize(("mass", "track_id", "weak"), [(1.9, 0, True), (2.0, 0, False), (1.9, -1, False)])
def test_a_track_is_weak_below_a_fifth_of_the_rate(mass: float, track_id: int, weak: bool) -> None:
    state = state_of({"mass": mass, "track_id": track_id}, config=RATE)
    assert life.is_weak(state.rules[0], state.clusters[0]) == weak
    plain = state_of({"mass": mass, "track_id": track_id})
    assert not life.is_weak(plain.rules[0], plain.clusters[0])


COAST = replace(CONFIG, coast_us=10_000)
BIG = {"before": 40}


@pytest.mark.parametrize(
    ("lost", "taken_over"),
    [
        ({"track_id": 4, "last_us": 5_000}, True),
        ({"track_id": 0, "last_us": 5_000}, True),
        ({"track_id": 4, "last_us": 5_001}, False),  # within its lifetime
        ({"track_id": -1, "last_us": 5_000}, False),
        ({"track_id": 4, "last_us": 5_000, "x": 79.9}, False),  # 20.1 px away
        ({"track_id": 4, "last_us": 5_000, "x": 80.0}, True),
        ({"track_id": 4, "last_us": 5_000, "y": 50.0}, True),
        ({"track_id": 4, "last_us": 5_000, "y": 50.1}, False),
    ],
)
def test_a_new_track_continues_one_that_coasts_nearby(lost: dict[str, Any], taken_over: bool) -> None:
    others = {"track_id": 9, "last_us": 5_000, "x": 300.0}, {"track_id": 8, "last_us": 5_000, "x": 119.95, "y": 49.95}
    coasting = {"x": 100.0, "before": 7, "velocity_x": 3.0, "velocity_y": 4.0} | lost
    state = state_of(others[0], coasting, BIG | {"x": 100.0, "y": 30.0}, config=COAST)
    found = life.show_if_due(state, 2, 76, 6_000)
    assert found == (1 if taken_over else -1)
    one = state.clusters[2]
    if taken_over:
        assert (one.track_id, one.before, one.velocity_x, one.velocity_y) == (lost["track_id"], 47, 3, 4)
        assert told(state) == []
    else:
        assert told(state) == [(Kind.BORN, 0, 6_000, 76)]
    assert life.show_if_due(state_of(others[0], coasting, BIG | {"x": 100.0}), 2, 76, 6_000) == -1, "without coasting"


def test_of_two_that_coast_the_nearest_is_continued() -> None:
    lost = [{"track_id": k, "last_us": 5_000, "x": x} for k, x in enumerate((85.0, 95.0, 110.0))]
    state = state_of(*lost, BIG | {"x": 100.0}, config=COAST)
    assert life.show_if_due(state, 3, 76, 6_000) == 1
    life.check(state, 3, 76, 6_000)
    assert state.cursor[0].live == 4
    state = state_of(*lost, BIG | {"x": 100.0}, config=COAST)
    life.check(state, 3, 76, 6_000)
    assert state.live[: state.cursor[0].live].tolist() == [0, 2, 3], "whose cluster is dropped"


@pytest.mark.parametrize(
    ("level", "begin_us", "end_us", "at_us"),
    [
        (0.19, 5_000, 9_000, 5_000),  # it is below already
        (0.2, 5_000, 5_000, NEVER_US),
        (0.2, 5_000, 9_000, 6_000),  # in the first packet
        (0.2 * np.exp(0.25), 5_000, 9_000, 8_000),  # 2.5 packets of 1 ms, of a time constant of 10 ms
    ],
)
def test_when_a_level_falls_below_a_fifth(level: float, begin_us: int, end_us: int, at_us: int) -> None:
    state = state_of(config=replace(RATE, packet_us=1_000))
    assert life._falls_at(state.rules[0], level, begin_us, end_us) == at_us


@pytest.mark.parametrize(
    ("given", "options", "end_us"),
    [
        ({"track_id": 3, "mass": 1.0}, {}, 5_000),
        ({"track_id": 0, "mass": 1.0}, {}, 5_000),
        ({"track_id": -1, "mass": 1.0}, {}, None),
        ({"track_id": 3, "mass": 1.0}, {"visible_rate_hz": 0.0}, None),
        ({"track_id": 3, "mass": 2.5}, {}, 8_000),
        ({"track_id": 3, "mass": 10.0}, {}, None),  # after the silence
        ({"track_id": 3, "mass": 1.0, "last_us": 4_500}, {"coast_us": 1_500}, 7_000),
        ({"track_id": 3, "mass": 1.0, "last_us": 4_500}, {"coast_us": 3_500}, 9_000),
        ({"track_id": 3, "mass": 1.0, "last_us": 4_500}, {"coast_us": 3_501}, None),
    ],
)
def test_a_track_whose_rate_falls_in_a_silence_ends_and_its_cluster_goes_on(
    given: dict[str, Any], options: dict[str, Any], end_us: int | None
) -> None:
    state = state_of(given, config=replace(RATE, packet_us=1_000, **options))
    life.hide_weak(state, 0, 5_000, 9_000)
    assert told(state) == ([] if end_us is None else [(Kind.LOST, given["track_id"], end_us, 77)])
    assert state.clusters[0].track_id == (given["track_id"] if end_us is None else -1)
    assert state.cursor[0].live == 1


@pytest.mark.parametrize(("track_id", "end_us"), [(-1, 6_000), (0, 16_000), (3, 16_000)])
def test_a_silent_cluster_ends_after_its_lifetime_and_a_track_coasts_before(track_id: int, end_us: int) -> None:
    state = state_of({"track_id": track_id}, {"last_us": 10**9}, config=COAST)
    life.note_ends_of_life(state, end_us - 1)
    assert state.cursor[0].next_due_us == end_us
    life.remove_silent(state, end_us - 1)
    assert state.cursor[0].live == 2
    life.note_ends_of_life(state, end_us)
    state.cursor.index = 99
    life.remove_silent(state, end_us + 5)
    assert state.cursor[0].live == 1
    assert told(state) == ([] if track_id < 0 else [(Kind.LOST, track_id, end_us, 77)]), "at the first event after its end"


def test_an_end_that_was_not_noted_is_at_the_last_event() -> None:
    state = state_of({"last_us": 6_000}, {"track_id": 3}, {"last_us": 6_000}, {"track_id": 4})
    life.remove_silent(state, 6_000)
    assert told(state) == [(Kind.LOST, 3, 6_000, 77), (Kind.LOST, 4, 6_000, 77)]


def test_a_cluster_is_checked_again_when_it_can_become_visible() -> None:
    state = state_of({"before": 10, "packet_events": 3})
    life.check(state, 0, 76, 6_000)
    alone = find.events_within(state.rules[0], state.clusters[0])
    assert state.clusters[0].check_at == 3 + min(alone, 17)
    state = state_of({"before": 28, "packet_events": 1})
    life.check(state, 0, 76, 6_000)
    assert (state.clusters[0].check_at, told(state)) == (2, [])
    state = state_of({"before": 28, "packet_events": 2})
    life.check(state, 0, 76, 6_000)
    assert told(state) == [(Kind.BORN, 0, 6_000, 76)]
    assert state.clusters[0].check_at > 2

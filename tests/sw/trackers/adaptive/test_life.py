# SPDX-License-Identifier: Apache-2.0
"""What the adaptive tracker does at the end of a packet: objects move on, meet, merge, become visible, leave and are lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.adaptive import life
from evcot.trackers.adaptive.layout import INSIDE, NEAR, World
from evcot.tracks.log import TRACK, Kind
from support.interpreted import interpret, scene

OTHER_X = {"x": 300, "y": 300}  # far from (100, 60)


@pytest.fixture(autouse=True)
def _interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    interpret(monkeypatch)


def buffer() -> Any:
    return np.zeros(20, TRACK).view(np.recarray)


@pytest.mark.parametrize(
    ("centre", "half", "seen"),
    [(50, 5, (50, 5)), (0, 5, (2.25, 2.75)), (199, 3, (197.75, 1.75)), (-20, 5, (-0.5, 0)), (230, 5, (199.5, 0))],
)
def test_reported_is_the_part_of_a_box_on_the_sensor(centre: float, half: float, seen: tuple[float, float]) -> None:
    assert life._seen(np.array([centre, 7.0, half, 8.0]), 200) == seen


@pytest.mark.parametrize(("kind", "index"), [(Kind.MOVED, 41), (Kind.LOST, 42)])
def test_a_record_has_the_box_on_the_sensor_and_the_events(kind: Kind, index: int) -> None:
    given = {"x": 100, "y": 118, "hx": 6, "hy": 4, "vx": 3, "vy": 2, "track_id": 9, "travel": 0.75}
    rules, world = scene(OTHER_X, given | {"packet_events": 5, "support": 70}, visible_travel=0.25)
    out = buffer()
    world.run[0].index, world.run[0].records = 42, 1
    life._record(rules, world, out, int(kind), 1_234, 1, 8)
    row = out[1]
    assert (row.t_us, row.event_index, row.kind, row.track_id, row.slot, row.other_id) == (1_234, index, kind, 9, 1, 8)
    assert (row.x, row.width, row.y, row.height) == (100, 12, 116.75, 5.5)
    assert (row.radius, row.angle, row.vx, row.vy, row.n_ev, row.support) == (4.375, 0, 3, 2, 5, 70)
    assert row.confidence == pytest.approx(0.75)
    assert world.run[0].records == 2


def test_speed_beyond_what_is_uncertain() -> None:
    _, world = scene({"vx": 3, "vy": 4, "gx": 6, "gy": 8, "hx": 2, "hy": 7})
    world.cov[0, :, 1, 1], world.cov[0, :, 3, 3] = (1, 3), (4, 12)
    assert (life._sure(world, 0, 1, 1.0), life._sure(world, 0, 3, 2.0), life._sure(world, 0, 1, 3.0)) == (3.0, 2.0, 0.0)
    assert life._half(world, 0) == 7


# Half sides of 10 px, gates of 2 px: boxes 20 px apart touch, gates 24 px apart.
@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(
    ("one", "other", "apart", "meets"),
    [
        ({}, {}, 24, True),
        ({}, {}, 24.1, False),
        ({}, {"gate": 5.0}, 27, True),
        ({"gate": 5.0}, {}, 27.1, False),
        ({}, {"away": 0}, 20, False),
        ({}, {"track_id": -1}, 20, False),  # may be a part of this one
        ({"track_id": 0}, {"track_id": 0}, 20, True),
        ({"track_id": -1}, {"track_id": -1}, 20, True),
        ({"track_id": -1}, {}, 20, True),
    ],
)
def test_objects_meet_where_their_gates_touch(
    one: dict[str, Any], other: dict[str, Any], apart: float, meets: bool, axis: str
) -> None:
    start = {"x": 100, "y": 60}[axis]
    for sign in (1, -1):
        _, world = scene(OTHER_X, one, other | {axis: start + sign * apart})
        assert life._meet(world, 1) == meets
        assert not meets or world.meeting[0] == 2


def test_all_that_meet_are_listed() -> None:
    _, world = scene({"x": 110}, {}, {"y": 70})
    assert (life._meet(world, 1), world.meeting[:2].tolist()) == (2, [0, 2])


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(
    ("given", "apart", "covered"),
    [
        ({}, 10, True),
        ({}, 10.1, False),
        ({"missed": 0.14}, 10, True),
        ({"missed": 0.15}, 10, False),
        ({"track_id": -1}, 10, False),
        ({"track_id": 0}, 10, True),
        ({"away": 0}, 10, False),
    ],
)
def test_an_object_is_covered_by_the_box_of_another_that_holds_its_centre(
    given: dict[str, Any], apart: float, covered: bool, axis: str
) -> None:
    start = {"x": 100, "y": 60}[axis]
    for sign in (1, -1):
        _, world = scene({"hx": 30, "hy": 30}, given | {axis: start + sign * apart})
        assert life._covered(world, 0) == covered


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(
    ("given", "apart", "alone"),
    [({}, 50, False), ({}, 50.1, True), ({"track_id": -1}, 20, True), ({"track_id": 0}, 20, False), ({"away": 0}, 20, True)],
)
def test_an_object_is_alone_if_no_visible_box_is_within_three_half_sides(
    given: dict[str, Any], apart: float, alone: bool, axis: str
) -> None:
    start = {"x": 100, "y": 60}[axis]
    for sign in (1, -1):
        _, world = scene({}, given | {axis: start + sign * apart}, OTHER_X)
        assert life._alone(world, 0) == alone


@pytest.mark.parametrize(
    ("one", "other", "survives"),
    [
        ({"mass": 41, "track_id": 5}, {"mass": 10, "track_id": 1}, True),  # more than four times as heavy
        ({"mass": 40, "track_id": 5}, {"mass": 10, "track_id": 1}, False),  # else the older one
        ({"track_id": 1}, {"track_id": 2}, True),
        ({"track_id": 0}, {"track_id": -1}, True),  # the visible one
        ({"track_id": -1, "born_us": 5}, {"track_id": 0, "born_us": 9}, False),
        ({"track_id": -1, "born_us": 5}, {"track_id": -1, "born_us": 9}, True),
    ],
)
def test_of_two_that_are_one_the_heavier_or_older_survives(one: dict[str, Any], other: dict[str, Any], survives: bool) -> None:
    _, world = scene(one, other)
    assert life._survives(world.objects[0], world.objects[1]) == survives
    assert life._survives(world.objects[1], world.objects[0]) != survives


def merged(*objects: dict[str, Any]) -> tuple[World, Any]:
    rules, world = scene(*({"vx": 5, "within": 3.0, "support": 10 + i} | given for i, given in enumerate(objects)))
    out = buffer()
    life._merge(rules, world, out, 99)
    return world, out[: world.run[0].records]


def test_two_that_are_one_get_a_box_around_both() -> None:
    world, out = merged(OTHER_X, {"x": 106, "y": 58, "track_id": 7}, {"track_id": 3, "hy": 11, "first_x": 50, "first_y": 40})
    np.testing.assert_allclose(world.state[2, :, ::2], [[103.0, 13.0], [59.5, 11.5]])  # 90 to 116, 48 to 71
    o: Any = world.objects[2]
    assert (o.first_x, o.first_y, o.support) == (53, 39.5, 23)
    assert world.objects["alive"].tolist() == [True, False, True]
    (row,) = out
    assert (row.kind, row.track_id, row.other_id, row.t_us, row.slot) == (Kind.MERGED, 7, 3, 99, 1)


def test_what_merges_into_an_object_that_is_not_visible_is_lost() -> None:
    _, (row,) = merged({"mass": 50, "track_id": -1}, {"mass": 10, "x": 102, "track_id": 4})
    assert (row.kind, row.track_id, row.other_id) == (Kind.LOST, 4, -1)
    assert len(merged({"track_id": -1}, {"x": 102, "track_id": -1})[1]) == 0
    assert merged({"track_id": 0}, {"x": 102, "track_id": 4})[1][0].other_id == 0


@pytest.mark.parametrize("given", [{"away": 0}, {"alive": False}, {"away": INSIDE}])
def test_only_objects_on_the_sensor_merge(given: dict[str, Any]) -> None:
    assert len(merged({}, {"x": 102})[1]) == 1
    assert len(merged(given, {"x": 102})[1]) == len(merged({}, {"x": 102} | given)[1]) == 0


def test_three_that_are_one_become_one() -> None:
    world, out = merged({"x": 104}, {"x": 102}, {})
    assert world.objects["alive"].tolist() == [True, False, False]
    assert out.track_id.tolist() == [1, 2]
    np.testing.assert_allclose(world.state[0, 0, ::2], [102, 12])


@pytest.mark.parametrize(
    ("given", "outside", "edge"),
    [
        ({"x": -0.5, "vx": -1}, False, 0),
        ({"x": -0.6, "vx": 1}, True, -1),
        ({"x": 10, "vx": -1}, False, 0),
        ({"x": 10.1, "vx": -1}, False, -1),
        ({"x": 10, "vx": 0}, False, -1),
        ({"x": 199.5, "vx": 1}, False, 1),
        ({"x": 199.6, "vx": -1}, True, -1),
        ({"x": 189, "vx": 1}, False, 1),
        ({"x": 188.9, "vx": 1}, False, -1),
        ({"x": 189, "vx": 0}, False, -1),
        ({"y": -0.5, "vy": -1}, False, 2),
        ({"y": -0.6}, True, -1),
        ({"y": 119.5, "vy": 1}, False, 3),
        ({"y": 119.6, "vy": 1}, True, 3),
        ({"y": 109, "vy": 1}, False, 3),
        ({"y": 108.9, "vy": 1}, False, -1),
    ],
)
def test_an_object_leaves_over_the_edge_towards_which_it_moves(given: dict[str, Any], outside: bool, edge: int) -> None:
    rules, world = scene(OTHER_X, given)
    assert (life._outside(rules, world, 1), life._leaves(rules, world, 1)) == (outside, edge)


@pytest.mark.parametrize(("edge", "missed"), [(0, 0.0), (INSIDE, 0.7)])
def test_what_goes_away_waits_at_rest_on_the_sensor(edge: int, missed: float) -> None:
    rules, world = scene({"x": -9, "vx": -5, "gx": 1, "missed": 0.7}, {"x": 230, "y": 140, "vy": 5, "gy": 1, "missed": 0.7})
    out = buffer()
    for i in range(2):
        life._go_away(rules, world, out, 77, i, edge)
    np.testing.assert_allclose(world.state, [[[0, 0, 10, 0], [60, 0, 10, 0]], [[199, 0, 10, 0], [119, 0, 10, 0]]])
    assert world.objects["away"].tolist() == [edge] * 2
    assert world.objects["missed"].tolist() == [missed] * 2
    assert [(row.kind, row.track_id, row.other_id, row.t_us) for row in out[:2]] == [(Kind.LOST, i, -1, 77) for i in range(2)]


# Half sides of 8 px, a fast object: it must move 2 px = 0.25 half sides.
@pytest.mark.parametrize(
    ("given", "variance", "visible"),
    [
        ({"first_x": 98}, 0, True),
        ({"first_x": 98.1}, 0, False),
        ({"first_y": 58}, 0, True),
        ({"first_y": 58.1}, 0, False),
        ({"first_x": 94}, 2, True),  # and twice the uncertainty of its place, 2 px
        ({"first_x": 94.1}, 2, False),
        ({"first_x": 98, "path": 3.5}, 0, True),  # the path becomes 4 px
        ({"first_x": 98, "path": 3.6}, 0, False),
        ({"first_x": 98, "packets": 3}, 0, False),
        ({"first_x": 98, "path": 8.1}, 0, False),
        ({"first_x": 96, "vx": 4.0}, 0, True),  # slower than 1 half side per second: twice as far
        ({"first_x": 96.1, "vx": 4.0}, 0, False),
        ({"first_x": 92, "vx": 0.0}, 0, True),  # four times as far at most
        ({"first_x": 92.1, "vx": 0.0}, 0, False),
        ({"first_x": 99, "hx": 2, "hy": 2}, 0, True),  # a pixel at least
        ({"first_x": 99.1, "hx": 2, "hy": 2}, 0, False),
    ],
)
def test_an_object_becomes_visible_when_it_has_moved(given: dict[str, Any], variance: float, visible: bool) -> None:
    fast = {"hx": 8, "hy": 8, "vx": 30, "vy": 40, "packets": 4, "first_x": 100, "first_y": 60} if "vx" not in given else {}
    slow = {"hx": 8, "hy": 8, "packets": 4, "first_y": 60}
    rules, world = scene(slow | fast | given, visible_travel=0.25)
    world.cov[0, :, 0, 0] = variance
    assert life._becomes_visible(rules, world, 0, 0.01) == visible


def test_what_wanders_about_starts_anew() -> None:
    given = {"hx": 8, "hy": 8, "vx": 30, "vy": 40, "first_x": 90, "first_y": 50}
    for more in ({"packets": 3, "path": 5}, {"packets": 4, "path": 8.1}):  # a path of four times 2 px
        rules, world = scene(given | more, visible_travel=0.25)
        assert not life._becomes_visible(rules, world, 0, 0.01)
        assert [world.objects[name][0] for name in ("first_x", "first_y", "path")] == [100, 60, 0]
    rules, world = scene(given | {"packets": 4, "path": 8}, visible_travel=0.25)
    assert life._becomes_visible(rules, world, 0, 0.01)
    assert [world.objects[name][0] for name in ("first_x", "first_y", "path")] == [90, 50, 8.5]


def advanced(given: dict[str, Any], lasted_s: float = 0.1, *others: dict[str, Any]) -> tuple[World, Any]:
    """An object of 10 px at 20 px/s: 0.2 half sides in a packet. Its course is certain."""
    rules, world = scene({"vx": 20} | given, *others, agility=0.001, growth_agility=0.0001, gate=0.35)
    life._advance(rules, world, 0, lasted_s)
    return world, world.objects[0]


def test_an_object_moves_on() -> None:
    world, o = advanced({"gx": 1, "packet_events": 6, "support": 4, "travel": 3.0, "still": 1.0, "inside": 2, "within": 0.5})
    went = 2 / 10.1  # half sides; without events for so long it slows down, and grows less
    np.testing.assert_allclose(world.state[0], [[102, 20 * np.exp(-went / 0.5), 10.1, np.exp(-went / 2)], [60, 0, 10, 0]])
    assert (o.support, o.inside, o.still) == (10, -1, 0)
    assert (o.travel, o.within, o.missed) == pytest.approx((3.2, 0.7, 0.2), abs=0.02)
    assert (o.speed, o.gate) == pytest.approx((21, 0.5 * 0.35 * 20.1), abs=0.1)  # growth counts


def test_uncertainty_grows_with_agility_and_less_beside_others() -> None:
    for meets, factor in ((False, 1.0), (True, 0.1)):
        rules, world = scene({"meets": meets}, agility=0.4, growth_agility=0.3, meeting_agility=0.1)
        life._predict(rules, world, 0, 0.1)
        walk = factor**2 * 20**2 * 20 / 10  # (20 px/s)^2 per half side
        for axis in range(2):
            assert world.cov[0, axis, 1, 1] == pytest.approx(walk * 0.4**2 * 0.1)
            assert world.cov[0, axis, 3, 3] == pytest.approx(walk * 0.3**2 * 0.1)


@pytest.mark.parametrize(
    ("given", "speed"),
    [
        ({"vx": 30, "speed": 20.0}, 30),
        ({"vx": 2, "speed": 20.0}, 20 * np.exp(-0.2 / 6)),  # it falls over six half sides of travel
        ({"vx": 0, "speed": 1.0}, 5),  # half a half side per second at least
    ],
)
def test_the_greatest_speed_of_the_recent_past(given: dict[str, Any], speed: float) -> None:
    assert advanced(given)[1].speed == pytest.approx(speed, rel=0.01)


def test_what_does_not_move_for_sure_stands_still() -> None:
    rules, world = scene({"still": 1.0, "within": 0.5, "inside": -1}, agility=0.4)
    life._advance(rules, world, 0, 0.1)
    o: Any = world.objects[0]
    assert (o.still, o.travel, o.within) == pytest.approx((1.2, 0, 0))
    assert o.missed == pytest.approx(0.2)  # two half sides per second


def test_missed_travel_is_that_of_its_velocity() -> None:
    assert advanced({"vx": 30, "vy": 40, "missed": 0.5})[1].missed == pytest.approx(1.0)
    assert advanced({"hx": 2, "hy": 2})[1].gate == 2.0


def test_what_is_hidden_keeps_its_velocity() -> None:
    assert advanced({"missed": 1.0}, 0.1, {})[0].state[0, 0, 1] == pytest.approx(20)
    assert advanced({"missed": 0.0}, 0.07)[0].state[0, 0, 1] == pytest.approx(20)
    assert advanced({"missed": 0.0}, 0.08)[0].state[0, 0, 1] == pytest.approx(20 * np.exp(-0.16 / 0.5))


@pytest.mark.parametrize(("mass", "contrast", "missed"), [(5.0, 2.0, 0.0), (5.0, 1.9, 0.7), (0.0, 5.0, 0.7), (0.5, 9.0, 0.0)])
def test_an_object_is_there_if_it_is_seen_and_stands_out(
    mass: float, contrast: float, missed: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(life, "look", lambda *_: mass)
    given = {"missed": 0.7, "lost_us": 5, "unseen_us": 6, "contrast": contrast}
    rules, world = scene(given | {"hx": 0.5, "gx": -2, "gy": 3})
    life._observe(rules, world, 0, 99)
    o: Any = world.objects[0]
    assert (o.missed, o.lost_us, o.unseen_us) == (missed, 5 if missed else 0, 0)
    assert world.state[0, :, 2].tolist() == [1, 10], "a pixel at least"
    assert world.state[0, :, 3].tolist() == ([0, 0] if missed else [0, 3])


def closed(*objects: dict[str, Any], lasted_us: int = 0, **config: float) -> tuple[World, Any]:
    """The end of a packet; nobody is seen. Objects are older than their settling and far from becoming visible."""
    rules, world = scene(*({"packets": 9, "first_x": 100, "first_y": 60} | given for given in objects), **config)
    world.run[0].birth_end_us = 10**9
    out = buffer()
    life.close_packet(rules, world, 1_000, lasted_us, out)
    return world, out[: world.run[0].records]


@pytest.fixture
def unseen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(life, "look", lambda *_: 0.0)


# `coast` 1 and `pause` 0.25 half sides.
@pytest.mark.parametrize(
    ("given", "others", "missed"),
    [
        ({}, [], 1.25),
        ({"track_id": -1}, [], 0.75),  # not visible yet
        ({}, [{"hx": 30, "hy": 30, "vx": -50, "track_id": 8}], 4.25),  # covered
        ({"x": 10, "vx": -5}, [], 0.5),  # on its way over the edge
        ({"x": 10, "vx": 5}, [], 1.25),
    ],
)
@pytest.mark.usefixtures("unseen")
def test_an_object_without_support_is_lost_when_patience_ends(
    given: dict[str, Any], others: list[dict[str, Any]], missed: float
) -> None:
    for more, alive in ((0.0, True), (0.001, False)):
        world, out = closed(given | {"missed": missed + more}, *others, coast=1.0, pause=0.25)
        assert world.objects["alive"][0] == alive
        assert (Kind.LOST in out.kind) == (not alive and "track_id" not in given)


@pytest.mark.parametrize(("still", "alive"), [(3.0, True), (3.1, False)])
@pytest.mark.usefixtures("unseen")
def test_an_object_that_stands_still_is_lost(still: float, alive: bool) -> None:
    assert closed({"still": still})[0].objects["alive"][0] == alive


@pytest.mark.parametrize(
    ("given", "others", "away"),
    [
        ({"missed": 2.0, "travel": 1.0}, [], INSIDE),
        ({"missed": 2.0, "travel": 0.9}, [], None),
        ({"still": 4.0, "travel": 1.0}, [], INSIDE),
        ({"missed": 2.0, "travel": 1.0, "track_id": -1}, [], None),
        ({"missed": 2.0, "travel": 1.0, "track_id": 0}, [], INSIDE),
        ({"missed": 2.0, "travel": 1.0}, [{"x": 130}], None),  # not alone
        ({"missed": 2.0, "travel": 1.0, "x": 10, "vx": -5}, [], 0),
        ({"missed": 2.0, "travel": 1.0, "y": 109, "vy": 5}, [], 3),
        ({"x": -1, "vx": -5, "travel": 1.0}, [], 0),
        ({"x": -1, "vx": -5, "travel": 0.9}, [], None),
        ({"x": -1, "vx": 5, "travel": 1.0}, [], None),  # outside, and not leaving
        ({"x": 10, "vx": -5, "travel": 1.0}, [], -1),
        ({}, [], -1),
    ],
)
@pytest.mark.usefixtures("unseen")
def test_what_has_travelled_a_half_side_may_return_over_its_edge_or_where_it_was_alone(
    given: dict[str, Any], others: list[dict[str, Any]], away: int | None
) -> None:
    world, out = closed(given, *others)
    assert world.objects["alive"][0] == (away is not None)
    assert away is None or world.objects["away"][0] == away
    kinds = out.kind[out.slot == 0].tolist()
    assert kinds == ([Kind.MOVED] if away == -1 else [Kind.LOST] if given.get("track_id") != -1 else [])


@pytest.mark.usefixtures("unseen")
def test_what_is_away_waits_for_sixteen_half_sides() -> None:
    for missed, alive in ((15.7, True), (15.8, True), (15.9, False)):  # 20 px/s in 0.1 s are 0.2 half sides
        world, out = closed({"away": 1, "missed": missed}, lasted_us=100_000)
        assert (world.objects["alive"][0], world.run[0].live, len(out)) == (alive, alive, 0)
        assert world.objects["missed"][0] == pytest.approx(missed + 0.2)
    assert world.objects["lost_us"][0] == 100_000


@pytest.mark.usefixtures("unseen")
def test_time_without_support_and_between_measurements_adds_up() -> None:
    given = {"unseen_us": 1_000, "lost_us": 2_000, "vx": 20, "speed": 20.0}
    world, _ = closed(given, lasted_us=9_000, pause=0.03)  # 0.02 half sides in 10 ms
    o: Any = world.objects[0]
    assert (o.unseen_us, o.lost_us, o.packets, o.meets) == (10_000, 11_000, 10, False)
    assert world.state[0, 0, 0] == pytest.approx(100.18)
    world, _ = closed(given | {"unseen_us": 7_000}, {"x": 122}, lasted_us=9_000, pause=0.03)  # 0.032 in 16 ms: measured
    assert (world.objects["unseen_us"][0], world.objects["meets"].tolist()) == (0, [True, True])


@pytest.mark.parametrize(
    ("given", "others", "reported"),
    [({"missed": 0.3}, [], True), ({"missed": 0.31}, [], False), ({"missed": 0.31}, [{"hx": 20, "vx": -50}], True)],
)
@pytest.mark.usefixtures("unseen")
def test_an_object_is_reported_while_it_was_seen_lately_or_is_covered(
    given: dict[str, Any], others: list[dict[str, Any]], reported: bool
) -> None:
    _, out = closed(given, *others)
    assert out.kind[out.slot == 0].tolist() == [Kind.MOVED] * reported


@pytest.mark.usefixtures("unseen")
def test_an_object_is_born_once() -> None:
    new = {"track_id": -1, "first_x": 80, "vx": 50}
    world, out = closed(OTHER_X | {"x": 20, "y": 20}, new, new | {"x": 160, "name": 5}, new | {"y": 100, "name": 0})
    assert [(row.kind, row.track_id) for row in out[out.slot > 0]] == [(Kind.BORN, 0), (Kind.MOVED, 5), (Kind.MOVED, 0)]
    assert world.run[0].births == 1


def test_births_are_looked_for_every_5_ms(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(life, "find_births", lambda _rules, _world, t_us: asked.append(t_us))
    rules, world = scene()
    for t_us in (999, 1_000, 5_999, 6_000, 7_000):
        world.run[0].birth_end_us = world.run[0].birth_end_us or 1_000
        life.close_packet(rules, world, t_us, 100, buffer())
    assert asked == [1_000, 6_000]


@pytest.mark.parametrize(
    ("objects", "packet_us"),
    [
        ([], 5_000),
        ([{"speed": 100.0}], 3_000),  # 0.03 of 10 px
        ([{"speed": 100.0, "hy": 5, "hx": 4}, {}], 1_500),
        ([{"speed": 10.0}], 5_000),
        ([{"speed": 1_000.0}], 1_000),
    ],
)
def test_a_packet_is_a_small_part_of_the_travel_of_the_fastest(objects: list[dict[str, Any]], packet_us: int) -> None:
    assert life._next_packet_us(*scene(*objects, step=0.03)) == packet_us


def test_events_are_assigned_by_the_box_in_mid_packet_and_its_cells() -> None:
    given = {"x": 100, "y": 60, "hx": 6, "hy": 4, "vx": 100, "vy": -50, "packet_events": 7}
    rules, world = scene(given, {"away": 0}, {"x": 4, "y": 3}, {"x": 199, "y": 119})
    world.run[0].packet_us = 40_000
    life._prepare(rules, world)
    o: Any = world.objects[0]
    assert (o.x, o.y, o.half_x, o.half_y, o.packet_events) == (102, 59, 6, 4, 0)
    near: NDArray[np.int16] = world.near
    # 94 to 111 and 53 to 66 are columns 11 to 13 and rows 6 to 8.
    assert {(int(r), int(c)) for r, c in np.argwhere(near[:, :, 0] == 0)} == {(r, c) for r in (6, 7, 8) for c in (11, 12, 13)}
    assert {(int(r), int(c)) for r, c in np.argwhere(near[:, :, 0] == 2)} == {(r, c) for r in (0, 1, 2) for c in (0, 1, 2)}
    assert {(int(r), int(c)) for r, c in np.argwhere(near[:, :, 0] == 3)} == {(r, c) for r in (13, 14) for c in (23, 24)}
    assert (near != 1).all()
    assert (near[:, :, 1:] == -1).all()


def test_a_cell_has_four_objects_near_it() -> None:
    rules, world = scene(*[{}] * (NEAR + 1))
    life._prepare(rules, world)
    assert world.near[7, 12].tolist() == [0, 1, 2, 3]


def opened(t_us: int, **run: int) -> tuple[bool, World, list[tuple[int, int]]]:
    """Whether the next packet holds a time; the world; which packets were closed: time and length."""
    packets: list[tuple[int, int]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(life, "close_packet", lambda _rules, _world, end_us, lasted_us, _out: packets.append((end_us, lasted_us)))
        rules, world = scene(*[{"speed": 100.0}] * run.pop("live", 0), step=0.03)
        for name, value in run.items():
            world.run[name] = value
        holds = life.open_packet(rules, world, t_us, buffer())
    return holds, world, packets


def test_the_first_packet_begins_with_the_first_event() -> None:
    holds, world, packets = opened(70, index=3)
    assert (holds, packets) == (True, [])
    run: Any = world.run[0]
    assert (run.packet_end_us, run.birth_end_us, run.packet_us, run.packet, run.settled) == (5_070, 5_070, 5_000, 2, 3)


@pytest.mark.parametrize(
    ("live", "t_us", "holds", "end_us"),
    [
        (0, 5_999, True, 6_000),
        (0, 6_000, True, 11_000),  # packets without events are left out
        (0, 6_001, True, 11_001),
        (1, 3_999, True, 4_000),
        (1, 4_000, False, 4_000),
        (1, 9_000, False, 4_000),  # unless objects live
    ],
)
def test_packets_follow_one_another(live: int, t_us: int, holds: bool, end_us: int) -> None:
    said, world, packets = opened(t_us, live=live, packet_end_us=1_000, packet_us=200, packet=2**31 - 1)
    assert (said, packets) == (holds, [(1_000, 200)])
    assert (world.run[0].packet_end_us, world.run[0].packet) == (end_us, 0)

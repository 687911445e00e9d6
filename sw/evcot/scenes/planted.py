# SPDX-License-Identifier: Apache-2.0
"""Planted anomalies on the highway: wrong-way drivers, cars that stop, people and animals that cross, people who loiter on the
shoulder, speeders. Each has a label with its kind and time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..errors import ConfigError
from .traffic import LEFT_M, MIDDLE_M, SHOULDER_M, LaneChange, Stretch, Vehicle, car, meets, stopping_car
from .truth import ObjectClass

__all__ = ["KINDS", "Planted", "Road", "plant"]

_SIDE_M = 0.16, 0.21  # left and right of the camera per metre along: out of the picture
_TRIES = 200


class Road(NamedTuple):
    """The visible part of the road, in metres along, and the mean speed on it."""

    near_m: float
    far_m: float
    speed_m_s: float


class Planted(NamedTuple):
    """One anomaly: vehicle, kind (of `KINDS`), begin and end in seconds; it may be out of sight for a part of that time."""

    vehicle: Vehicle
    kind: str
    begin_s: float
    end_s: float


def _wrong_way(road: Road, random: np.random.Generator) -> Planted:
    speed_m_s = random.uniform(0.6, 1.0) * road.speed_m_s
    lane_m = LEFT_M if random.random() < 0.5 else MIDDLE_M
    return Planted(car(lane_m, Stretch(0.0, road.far_m, -speed_m_s)), "wrong_way", 0.0, (road.far_m - road.near_m) / speed_m_s)


def _stopping(road: Road, random: np.random.Generator) -> Planted:
    stop_s = 3.0
    vehicle = stopping_car(road.speed_m_s, stop_s, stop_s + random.uniform(4.0, 8.0), random.uniform(40.0, 70.0))
    brakes, drives_on = vehicle.changes
    return Planted(vehicle, "stopping", brakes.t_s, drives_on.t_s + drives_on.lasts_s)


def _crossing(_road: Road, random: np.random.Generator) -> Planted:
    along_m, speed_m_s = random.uniform(30.0, 50.0), random.uniform(2.0, 4.0)
    left_m, right_m = -_SIDE_M[0] * along_m - 1.0, _SIDE_M[1] * along_m + 1.0
    from_m, to_m = (left_m, right_m) if random.random() < 0.5 else (right_m, left_m)
    lasts_s = (right_m - left_m) / speed_m_s
    is_person = random.random() < 0.5
    class_id = ObjectClass.PERSON if is_person else ObjectClass.ANIMAL
    width_m, height_m, length_m = (0.6, 1.75, 0.5) if is_person else (1.5, 1.3, 0.5)  # the animal is a deer
    way = LaneChange(0.0, lasts_s, to_m - from_m)
    walker = Vehicle(class_id, width_m, height_m, length_m, from_m, (Stretch(0.0, along_m, 0.0),), (way,))
    return Planted(walker, "crossing", 0.0, lasts_s)


def _loitering(_road: Road, random: np.random.Generator) -> Planted:
    along_m, stays_s = random.uniform(44.0, 56.0), random.uniform(10.0, 16.0)
    outside_m, place_m = _SIDE_M[1] * along_m + 1.0, SHOULDER_M + random.uniform(0.0, 0.5)
    comes_s, pace_s, pace_m = 3.0, random.uniform(1.4, 2.0), random.uniform(1.0, 1.5)
    paces = 2 * round(stays_s / pace_s / 2)
    goes_s = comes_s + paces * pace_s
    there, back = LaneChange(0.0, comes_s, place_m - outside_m), LaneChange(goes_s, comes_s, outside_m - place_m)
    steps = [LaneChange(comes_s + i * pace_s, pace_s, -pace_m * (-1) ** i) for i in range(paces)]
    person = Vehicle(ObjectClass.PERSON, 0.6, 1.75, 0.5, outside_m, (Stretch(0.0, along_m, 0.0),), (there, *steps, back))
    return Planted(person, "loitering", 0.0, goes_s + comes_s)


def _speeding(road: Road, random: np.random.Generator) -> Planted:
    speed_m_s = random.uniform(1.8, 2.3) * road.speed_m_s
    begin_m = road.near_m - 6.0
    return Planted(car(LEFT_M, Stretch(0.0, begin_m, speed_m_s)), "speeding", 0.0, (road.far_m - begin_m) / speed_m_s)


KINDS: Mapping[str, Callable[[Road, np.random.Generator], Planted]] = {
    "loitering": _loitering,
    "stopping": _stopping,
    "wrong_way": _wrong_way,
    "crossing": _crossing,
    "speeding": _speeding,
}


def plant(
    counts: Mapping[str, int], road: Road, duration_s: float, others: Sequence[Vehicle], random: np.random.Generator
) -> list[Planted]:
    """Place `counts` anomalies of each kind at random times so that none meet; the longest are placed first.

    Raises:
        ConfigError: they do not fit into the duration of the scene.
    """
    planted: list[Planted] = []
    for kind in [name for name in KINDS for _ in range(counts[name])]:
        fixed = [*others, *(each.vehicle for each in planted)]
        for _ in range(_TRIES):
            one = KINDS[kind](road, random)
            one = _later(one, random.uniform() * (duration_s - one.end_s) - one.begin_s)
            if one.end_s <= duration_s and not meets(one.vehicle, fixed, one.begin_s, one.end_s):
                planted.append(one)
                break
        else:
            raise ConfigError(f"highway.{kind} = {counts[kind]}: no room for so many in {duration_s:g} s")
    return planted


def _later(planted: Planted, by_s: float) -> Planted:
    vehicle = planted.vehicle
    stretches = tuple(stretch._replace(t_s=stretch.t_s + by_s) for stretch in vehicle.stretches)
    changes = tuple(change._replace(t_s=change.t_s + by_s) for change in vehicle.changes)
    return Planted(
        replace(vehicle, stretches=stretches, changes=changes), planted.kind, planted.begin_s + by_s, planted.end_s + by_s
    )

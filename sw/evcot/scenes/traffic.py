# SPDX-License-Identifier: Apache-2.0
"""Traffic on the highway: vehicles with a story, and random ones, placed so that none collide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._highway_kernel import meet, motion_at
from .truth import ObjectClass

__all__ = [
    "LEFT_M",
    "MIDDLE_M",
    "SHOULDER_M",
    "LaneChange",
    "Stretch",
    "Traffic",
    "Vehicle",
    "car",
    "meets",
    "stopping_car",
    "story",
    "traffic",
]

LEFT_M, MIDDLE_M, _RIGHT_M, SHOULDER_M = -3.4, 0.2, 3.8, 7.4  # middles of the lanes, right of the camera
_LANE_SPEEDS = (1.2, 1.0, 0.85)  # of the mean speed, from the left
_SPEED_SPREAD = 0.08
_GAP_M = 5.0  # minimum distance along the road, and a tenth of it across
_BRAKING_M_S2, _STARTING_M_S2 = 6.0, 3.0
_LANE_CHANGE_S = 2.5
_CHECK_S = 0.1
_LATEST = 40  # number of latest vehicles with which a new one may collide
_BEFORE_M = 2.0  # distance before the visible part at which a vehicle enters the road


class Stretch(NamedTuple):
    """A stretch of motion from a time on: position along the road, speed, and constant acceleration."""

    t_s: float
    along_m: float
    speed_m_s: float
    acceleration_m_s2: float = 0.0


class LaneChange(NamedTuple):
    """A smooth lateral motion: start time, duration, displacement to the right."""

    t_s: float
    lasts_s: float
    by_m: float


@dataclass(frozen=True)
class Vehicle:
    """One vehicle: size and motion; `along_m` is that of its rear, which always faces the camera."""

    class_id: ObjectClass
    width_m: float
    height_m: float
    length_m: float
    across_m: float
    stretches: tuple[Stretch, ...]
    changes: tuple[LaneChange, ...] = ()


class Motion(NamedTuple):
    """Positions and speeds, one per vehicle: of the middle across, of the rear along."""

    across_m: NDArray[np.float64]
    along_m: NDArray[np.float64]
    across_m_s: NDArray[np.float64]
    along_m_s: NDArray[np.float64]


class Traffic:
    """All vehicles of a scene; (n,) arrays `class_id`, `width_m`, `height_m`, `length_m`, as in `Vehicle`; and `motions`, the
    arguments of `motion_at` but the time."""

    def __init__(self, vehicles: Sequence[Vehicle]) -> None:
        self.class_id = np.array([vehicle.class_id for vehicle in vehicles], np.int64)
        self.width_m, self.height_m, self.length_m, across_m = (
            np.array([getattr(vehicle, name) for vehicle in vehicles])
            for name in ("width_m", "height_m", "length_m", "across_m")
        )
        stretches = _padded([vehicle.stretches for vehicle in vehicles], Stretch(np.inf, 0.0, 0.0))
        changes = _padded([vehicle.changes for vehicle in vehicles], LaneChange(np.inf, 1.0, 0.0))
        self.motions = stretches, changes, across_m

    def at(self, t_s: float) -> Motion:
        """Exact positions and speeds at a time."""
        return Motion(*motion_at(*self.motions, t_s).T)


def _padded(ways: Sequence[Sequence[tuple[float, ...]]], filler: tuple[float, ...]) -> NDArray[np.float64]:
    """(n, longest, fields), with the shorter ones padded."""
    most = max(map(len, ways), default=1) or 1
    return np.array([[*way, *[filler] * (most - len(way))] for way in ways], np.float64).reshape(len(ways), most, len(filler))


def traffic(
    fixed: Sequence[Vehicle],
    duration_s: float,
    speed_m_s: float,
    vehicles_per_s: float,
    lorry_share: float,
    road_m: tuple[float, float],
    random: np.random.Generator,
) -> Traffic:
    """Vehicles on a road that is visible over the interval `road_m`, in metres along, for `duration_s` from 0 on: first the
    given ones, then random ones."""
    vehicles = list(fixed)
    before_s = (road_m[1] - road_m[0]) / speed_m_s
    lasts_s = duration_s + before_s
    entries_s = np.sort(random.uniform(-before_s, duration_s, random.poisson(vehicles_per_s * lasts_s)))
    for entry_s in entries_s.tolist():
        vehicle = _passer_by(entry_s, speed_m_s, lorry_share, road_m[0], random)
        latest = vehicles[len(fixed) :][-_LATEST:]
        if not meets(vehicle, [*fixed, *latest], entry_s, min(entry_s + 2 * before_s, duration_s)):
            vehicles.append(vehicle)
    return Traffic(vehicles)


def car(across_m: float, *stretches: Stretch, changes: tuple[LaneChange, ...] = ()) -> Vehicle:
    """An ordinary car."""
    return Vehicle(ObjectClass.CAR, 1.8, 1.5, 4.4, across_m, stretches, changes)


def stopping_car(speed_m_s: float, stop_s: float, go_s: float, stops_at_m: float) -> Vehicle:
    """A car that brakes in the right lane, stands on the shoulder from `stop_s` to `go_s`, and drives on; `changes` has the
    lane change to the shoulder, which takes as long as braking, and the one back."""
    brakes_s, starts_s = 0.8 * speed_m_s / _BRAKING_M_S2, 0.8 * speed_m_s / _STARTING_M_S2
    brakes_at_m = stops_at_m - _BRAKING_M_S2 * brakes_s**2 / 2
    aside = SHOULDER_M - _RIGHT_M
    return car(
        _RIGHT_M,
        Stretch(stop_s - brakes_s - 60.0, brakes_at_m - 48.0 * speed_m_s, 0.8 * speed_m_s),
        Stretch(stop_s - brakes_s, brakes_at_m, 0.8 * speed_m_s, -_BRAKING_M_S2),
        Stretch(stop_s, stops_at_m, 0.0),
        Stretch(go_s, stops_at_m, 0.0, _STARTING_M_S2),
        Stretch(go_s + starts_s, stops_at_m + _STARTING_M_S2 * starts_s**2 / 2, 0.8 * speed_m_s),
        changes=(LaneChange(stop_s - brakes_s, brakes_s, aside), LaneChange(go_s + 3.0, _LANE_CHANGE_S, -aside)),
    )


def story(duration_s: float, speed_m_s: float) -> list[Vehicle]:
    """The wrong-way driver, the car that stops, the car that overtakes, and the lorry that is overtaken."""
    middle_s = 0.5 * duration_s
    overtakes = LaneChange(middle_s - _LANE_CHANGE_S, _LANE_CHANGE_S, MIDDLE_M - _RIGHT_M)
    return [
        car(LEFT_M, Stretch(middle_s, 55.0, -0.8 * speed_m_s)),
        stopping_car(speed_m_s, 0.4 * duration_s, 0.6 * duration_s, 58.0),
        car(_RIGHT_M, Stretch(middle_s, 46.0, 1.25 * speed_m_s), changes=(overtakes,)),
        Vehicle(ObjectClass.LORRY, 2.5, 3.4, 9.0, _RIGHT_M, (Stretch(middle_s, 44.0, 0.7 * speed_m_s),)),
    ]


def _passer_by(entry_s: float, speed_m_s: float, lorry_share: float, near_m: float, random: np.random.Generator) -> Vehicle:
    size, pace = random.uniform(0.93, 1.07), random.uniform(-1, 1)
    lane, lorry = int(random.integers(0, 3)), bool(random.random() < lorry_share)
    if lorry:
        lane = 2
    speed = speed_m_s * _LANE_SPEEDS[lane] * (1 + _SPEED_SPREAD * pace)
    width, height, length = (2.5, 3.4, 9.0) if lorry else (1.8, 1.5, 4.4)
    entry = Stretch(entry_s, near_m - _BEFORE_M - length * size, speed)
    class_id = ObjectClass.LORRY if lorry else ObjectClass.CAR
    return Vehicle(class_id, width * size, height * size, length * size, (LEFT_M, MIDDLE_M, _RIGHT_M)[lane], (entry,))


def meets(vehicle: Vehicle, others: Sequence[Vehicle], from_s: float, to_s: float) -> bool:
    """Whether a vehicle gets too close to one of the others."""
    all_of_them = Traffic([vehicle, *others])
    times_s = np.arange(from_s, to_s, _CHECK_S)
    return bool(meet(times_s, all_of_them.motions, all_of_them.width_m / 2, all_of_them.length_m, _GAP_M))

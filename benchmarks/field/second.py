# SPDX-License-Identifier: Apache-2.0
"""Two families made by other means, so that nothing is learnt from the ways of our own simulator.

Frames are drawn here with Pillow, from their own geometry, and made into events by eventcv's camera, a pixel model after v2e
(lin-log response, a photoreceptor whose bandwidth falls with the light, mismatch, leak and shot noise), which shares no code
with `evcot.scenes`. Without eventcv, an extra of tests and benchmarks, these families are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter
from scipy.spatial import ConvexHull

from evcot.events import Events, Recording
from evcot.metrics.truth import OBJECT, GroundTruth
from field.member import TRUTH_STEP_US, Absent, Entry, Member, kept, scene_rule

__all__ = ["SOURCE", "Bouncing", "entries"]


class Bouncing:
    """Straight motion, reflected where an object's box meets the edge of the sensor.

    Args:
        sensor: (width, height) in pixels.
        size_px: (n, 2) width and height of the objects.
        speed_px_s: (n,)
        crossing: all over the sensor; otherwise along rows, from the top to the bottom.
    """

    def __init__(
        self,
        sensor: tuple[int, int],
        size_px: NDArray[np.float64],
        speed_px_s: NDArray[np.float64],
        crossing: bool,
        random: np.random.Generator,
    ) -> None:
        count = len(size_px)
        self._low = size_px.T / 2 - 0.5
        self._room = np.array(sensor, float)[:, None] - size_px.T
        self._start = random.uniform(0, 1, (2, count)) * self._room
        if crossing:
            angle = random.uniform(0, 2 * np.pi, count)
            self._speed = speed_px_s * np.stack((np.cos(angle), np.sin(angle)))
        else:
            rows = (np.arange(count) + 0.5) * sensor[1] / count
            self._start[1] = np.clip(rows - size_px[:, 1] / 2, 0, self._room[1])
            self._speed = np.stack((speed_px_s * random.choice((-1.0, 1.0), count), np.zeros(count)))

    def at(self, t_us: NDArray[np.int64], which: NDArray[np.int64] | int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centres and velocities, (2, n), of objects at times."""
        start, speed, room, low = (each[:, which] for each in (self._start, self._speed, self._room, self._low))
        if np.ndim(which) == 0:
            start, speed, room, low = (each[:, None] for each in (start, speed, room, low))
        way = (start + speed * (t_us * 1e-6)) % (2 * room)
        back = way > room
        return low + np.where(back, 2 * room - way, way), np.where(back, -speed, speed)


SOURCE = "second simulator"
_SENSORS = ((240, 180), (346, 260))
_OVERSAMPLED = 2
_SECONDS = 3.0
_LEAST_SEEN, _LEAST_PX = 0.5, 8.0  # what an object must show to be counted
_NUMBER = 3

Points = NDArray[np.float64]


class Shown(NamedTuple):
    """One object at one time: its outline, (k, 2) points, and the faces to draw, back to front, with their grey tones."""

    number: int
    outline: Points
    faces: list[tuple[Points, int]]


class Scenery(Protocol):
    """What is drawn. Points are in event coordinates."""

    count: int
    fps: float

    def at(self, t_us: float) -> list[Shown]:
        """The objects in the picture, the farthest first."""


def entries(seed: int, quick: bool) -> Iterator[Entry]:
    """Two families."""
    for index, (family, make) in enumerate({"second simulator, shapes": _Shapes, "second simulator, road": _Road}.items()):
        for number in range(1 if quick else _NUMBER):
            yield Entry(family, f"{number + 1}", SOURCE, _builder(family, f"{number + 1}", make, (seed, 5, index, number)))


def _builder(
    family: str, name: str, make: Callable[[tuple[int, int], np.random.Generator], Scenery], seed: tuple[int, ...]
) -> Callable[[], Member]:
    def build() -> Member:
        random = np.random.default_rng(seed)
        sensor = _SENSORS[random.integers(len(_SENSORS))]
        scenery = make(sensor, random)
        recording = Recording(_seen(scenery, sensor, random), *sensor, family)
        rule = scene_rule(recording)
        return Member(family, name, recording, _truth(scenery, sensor), rule, "exact, by another simulator")

    return kept(f"{family} {name} {seed}", build, "second", "paths")


def _seen(scenery: Scenery, sensor: tuple[int, int], random: np.random.Generator) -> Events:
    """The events of eventcv's camera."""
    try:
        import eventcv
    except ImportError as error:
        raise Absent("eventcv is not installed") from error
    threshold = random.uniform(0.15, 0.3)
    stream: Any = eventcv.simulate(
        _frames(scenery, sensor, random),
        fps=scenery.fps,
        pos_thres=threshold,
        neg_thres=threshold * random.uniform(0.85, 1.2),
        sigma_thres=0.03,
        refractory_us=int(random.integers(100, 600)),
        cutoff_hz=random.uniform(100.0, 300.0),
        leak_rate_hz=random.uniform(0.02, 0.2),
        shot_noise_rate_hz=random.uniform(0.1, 1.5),
        upsample="2",
        seed=int(random.integers(1 << 31)),
    )
    columns = stream.numpy()
    columns = columns[np.argsort(columns[:, 2], kind="stable")]
    x, y, t_us, p = (np.ascontiguousarray(columns[:, i]) for i in range(4))
    return Events(t_us.astype(np.int64), x.astype(np.uint16), y.astype(np.uint16), (p > 0).astype(np.uint8))


def _frames(scenery: Scenery, sensor: tuple[int, int], random: np.random.Generator) -> NDArray[np.uint8]:
    width, height = (_OVERSAMPLED * side for side in sensor)
    spots = gaussian_filter(random.standard_normal((height, width)), 3 * _OVERSAMPLED)
    ground = Image.fromarray(np.clip(120 + 8 * spots / spots.std(), 0, 255).astype(np.uint8))
    times_us = np.arange(round(_SECONDS * scenery.fps)) * 1e6 / scenery.fps
    frames = np.empty((len(times_us), sensor[1], sensor[0]), np.uint8)
    for frame, t_us in zip(frames, times_us, strict=True):
        picture = ground.copy()
        draw = ImageDraw.Draw(picture)
        for shown in scenery.at(float(t_us)):
            for face, tone in shown.faces:
                draw.polygon([tuple(point) for point in (face + 0.5) * _OVERSAMPLED - 0.5], fill=tone)
        frame[:] = np.asarray(picture.reduce(_OVERSAMPLED))
    return frames


def _truth(scenery: Scenery, sensor: tuple[int, int]) -> GroundTruth:
    """The outlines' boxes on the sensor; what is hidden or outside for the most part, or tiny, need not be found."""
    instants_us = np.arange(0, round(_SECONDS * 1e6), TRUTH_STEP_US)
    objects = []
    limits = np.array([[-0.5, -0.5], [sensor[0] - 0.5, sensor[1] - 0.5]])
    for frame, t_us in enumerate(instants_us.tolist()):
        shown = scenery.at(t_us)
        moved = {one.number: _box(one.outline, limits).mean(axis=0) for one in scenery.at(t_us + 1_000)}
        hidden = Image.new("I", sensor, -1)
        draw = ImageDraw.Draw(hidden)
        for one in shown:
            draw.polygon([tuple(point) for point in one.outline], fill=one.number)
        visible = np.bincount(np.asarray(hidden).ravel() + 1, minlength=scenery.count + 1)[1:]
        for one in shown:
            low, high = _box(one.outline, limits)
            if (high <= low).any():
                continue
            middle, size = (low + high) / 2, high - low
            speed = (moved.get(one.number, middle) - middle) * 1e3
            part = visible[one.number] / max(ConvexHull(one.outline).volume, 1.0)
            counted = part >= _LEAST_SEEN and size.min() >= _LEAST_PX
            objects.append((frame, one.number, *middle, *size, *speed, counted, -1))
    return GroundTruth(instants_us, np.array(objects, OBJECT), tuple(map(str, range(scenery.count))))


def _box(outline: Points, limits: Points) -> Points:
    """Lowest and highest x, y within the limits."""
    return np.clip(np.stack((outline.min(axis=0), outline.max(axis=0))), *limits)


class _Shapes:
    """Striped polygons that turn while they bounce off the edges, some apart and some crossing."""

    fps = 500.0

    def __init__(self, sensor: tuple[int, int], random: np.random.Generator) -> None:
        self.count = int(random.integers(2, 6))
        crossing = bool(random.integers(2))
        lane = sensor[1] / self.count if not crossing else sensor[1] / 4
        self._radius = random.uniform(0.22, 0.42, self.count) * min(lane, 60.0)
        self._stretch = random.uniform(0.55, 1.0, self.count)
        self._corners = random.integers(3, 13, self.count)
        self._tone = np.where(random.permutation(self.count) % 2 == 0, random.integers(50, 95), random.integers(150, 225))
        self._turn = random.uniform(-3.0, 3.0, self.count)
        self._phase = random.uniform(0, 2 * np.pi, self.count)
        speed = np.exp(random.uniform(np.log(40.0), np.log(250.0), self.count))
        size = np.repeat(2 * self._radius[:, None], 2, axis=1)
        self._paths = Bouncing(sensor, size, speed, crossing, random)

    def at(self, t_us: float) -> list[Shown]:
        shown = []
        for number in range(self.count):
            (x, y), _ = self._paths.at(np.array([round(t_us)]), number)
            angle = self._phase[number] + self._turn[number] * t_us * 1e-6
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            corner = np.arange(self._corners[number]) * 2 * np.pi / self._corners[number]
            unit = np.stack((np.cos(corner), self._stretch[number] * np.sin(corner)), axis=1) * self._radius[number]
            stripe = np.array([(-0.45, -0.12), (0.45, -0.12), (0.45, 0.12), (-0.45, 0.12)]) * self._radius[number]
            middle = np.array([x[0], y[0]])
            outline = unit @ turn + middle
            faces = [(outline, int(self._tone[number])), (stripe @ turn + middle, 120)]
            shown.append(Shown(number, outline, faces))
        return shown


class _Road:
    """A pinhole camera beside or above a road looks down at cars, vans and lorries that come and go in several lanes."""

    fps = 800.0
    _KINDS_M = np.array([(1.8, 1.5, 4.3), (2.0, 2.2, 5.5), (2.5, 3.5, 9.5)])  # width, height, length
    _CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (0.0, 1.0) for z in (-0.5, 0.5)])
    _FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5), (2, 3, 7, 6))  # left, right, near, far, top
    _SHADES = 0.8, 0.8, 0.6, 0.6, 1.0

    def __init__(self, sensor: tuple[int, int], random: np.random.Generator) -> None:
        self._sensor = sensor
        self._focal = random.uniform(0.8, 1.6) * sensor[0]
        self._height_m = random.uniform(7.0, 16.0)
        self._down = np.radians(random.uniform(12.0, 35.0))
        self._roll = np.radians(random.uniform(-6.0, 6.0))
        middle_m = self._height_m / np.tan(self._down)
        self._side_m = random.uniform(-0.15, 0.15) * middle_m
        top = self._down - np.arctan(sensor[1] / 2 / self._focal)
        self._near_m = self._height_m / np.tan(self._down + np.arctan(sensor[1] / 2 / self._focal)) - 12.0
        self._far_m = min(self._height_m / np.tan(max(top, 0.06)) + 8.0, 150.0)
        self._place(random)

    def _place(self, random: np.random.Generator) -> None:
        """Vehicles lane by lane, each lane with its own speed and direction, none driving into another."""
        lanes = int(random.integers(2, 5))
        rows = []
        for lane in range(lanes):
            forth = random.random() < 0.5
            speed = random.uniform(8.0, 26.0) * (1 if forth else -1)
            reach = abs(speed) * _SECONDS + self._far_m - self._near_m
            along = random.uniform(0.0, 25.0)
            while along < reach:
                kind = int(random.choice(3, p=(0.75, 0.15, 0.1)))
                start = self._far_m - along if forth else self._near_m + along
                tone = int(random.choice((random.integers(40, 95), random.integers(150, 235))))
                rows.append((start, (lane - (lanes - 1) / 2) * 3.6 + self._side_m, speed, kind, tone))
                along += self._KINDS_M[kind, 2] + random.uniform(8.0, 45.0)
        self._start_m, self._across_m, self._speed, kinds, self._tone = (np.array(column) for column in zip(*rows, strict=True))
        self._size_m = self._KINDS_M[kinds]
        self.count = len(rows)

    def _project(self, points_m: Points) -> Points:
        """Across, up and along to pixels."""
        across, up, along = points_m[..., 0], points_m[..., 1] - self._height_m, points_m[..., 2]
        sine, cosine = np.sin(self._down), np.cos(self._down)
        depth = np.maximum(along * cosine - up * sine, 0.5)
        x, y = self._focal * across / depth, -self._focal * (up * cosine + along * sine) / depth
        sine, cosine = np.sin(self._roll), np.cos(self._roll)
        width, height = self._sensor
        return np.stack((cosine * x - sine * y + (width - 1) / 2, sine * x + cosine * y + (height - 1) / 2), axis=-1)

    def at(self, t_us: float) -> list[Shown]:
        along = self._start_m + self._speed * t_us * 1e-6
        there = np.flatnonzero((along > max(self._near_m, 2.0)) & (along < self._far_m))
        shown = []
        for number in there[np.argsort(-along[there])].tolist():
            corners_m = self._CORNERS * self._size_m[number] + (self._across_m[number], 0.0, along[number])
            corners = self._project(corners_m)
            hull = corners[ConvexHull(corners).vertices]
            if (hull.max(axis=0) < -1).any() or (hull.min(axis=0) > np.array(self._sensor)).any():
                continue
            shown.append(Shown(number, hull, self._faces(number, corners, corners_m)))
        return shown

    def _faces(self, number: int, corners: Points, corners_m: Points) -> list[tuple[Points, int]]:
        """The far faces first; a window in the front and in the back."""
        away = np.hypot(corners_m[:, 0], corners_m[:, 2])
        tone = float(self._tone[number])
        faces = []
        for face in sorted(range(len(self._FACES)), key=lambda face: -away[list(self._FACES[face])].mean() + 100 * (face == 4)):
            four = corners[list(self._FACES[face])]
            faces.append((four, round(tone * self._SHADES[face])))
            if face in (2, 3):
                middle = four.mean(axis=0)
                upper = four[np.argsort(four[:, 1])[:2]].mean(axis=0)
                faces.append(((four - middle) * (0.8, 0.3) + middle + 0.45 * (upper - middle), 60 if tone > 110 else 150))
        return faces

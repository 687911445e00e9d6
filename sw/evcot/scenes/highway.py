# SPDX-License-Identifier: Apache-2.0
"""A motorway seen from a bridge: cars drive towards the vanishing point, one drives the wrong way, one stops and continues.

Lengths are in metres: across the road to the right of the camera, up from the road, and along it from the camera. A pinhole
camera with a vertical image plane projects (across, up, along) to

    x = vanishing x + focal * across / along,    y = vanishing y + focal * (camera height - up) / along.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..ranges import setting
from ._highway_kernel import MARGIN_PX, project_each
from .pixel import PixelModel
from .planted import KINDS, Road, plant
from .stage import Moments, StageSettings, film, texture
from .traffic import story, traffic
from .truth import TRUTH, Label, ObjectClass, Scene

__all__ = ["Highway", "simulate"]

SHADOW = 0  # the face that is not part of the vehicle's box
FACES = 10

_GLASS, _DARK, _SHADE = -0.9, -0.7, -0.45  # log intensity, as a fraction of the contrast
_ROOF_SHINE = 0.25


def _across_face(half: float, low: tuple[float, float], half_high: float, high: tuple[float, float]) -> list[list[float]]:
    """A face across the vehicle, between two transverse lines at (up, along)."""
    return [[-half, *low], [half, *low], [half_high, *high], [-half_high, *high]]


def _side_face(across: float, *points: tuple[float, float]) -> list[list[float]]:
    return [[across, *point] for point in points]


def _faces(body: float) -> list[list[list[float]]]:
    """The faces of a vehicle whose body has this fraction of its height, the farthest first."""
    cabin = (body, 0.12), (body, 0.75), (1.0, 0.65), (1.0, 0.25)
    sides = (0.08, 0.0), (body, 0.0), (body, 1.0), (0.08, 1.0)
    return [
        _across_face(0.56, (0.0, -0.12), 0.56, (0.0, 1.0)),
        _side_face(-0.5, *sides),
        _side_face(0.5, *sides),
        _across_face(0.5, (body, 0.0), 0.5, (body, 1.0)),
        _across_face(0.5, (0.08, 0.0), 0.5, (body, 0.0)),
        _across_face(0.5, (0.08, 0.0), 0.5, (0.3 * body, 0.0)),
        _side_face(-0.45, *cabin),
        _side_face(0.45, *cabin),
        _across_face(0.4, (1.0, 0.25), 0.4, (1.0, 0.65)),
        _across_face(0.45, (body, 0.12), 0.4, (1.0, 0.25)),
    ]


def outline(
    is_box: NDArray[np.bool_], paint: NDArray[np.float64], contrast: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of all faces, (n, FACES, 4, 3): across from the middle, up and along from the rear; and their log intensities,
    (n, FACES)."""
    car, box = np.array(_faces(0.6)), np.array(_faces(1.0))
    corners = np.where(is_box[:, None, None, None], box, car)
    glass, dark, shade = (np.full(len(paint), part * contrast) for part in (_GLASS, _DARK, _SHADE))
    side, roof = paint - 0.1 * contrast, paint + _ROOF_SHINE * contrast
    tones = (shade, side, side, roof, paint, dark, glass, glass, roof, glass)
    return corners, np.stack(tones, axis=1)


_WIDTH = 346  # sensor width for which the next three are given; scaled for other sensors
_FOCAL_PX = 1_000.0
_VANISHING_PX = 150.0, -54.0


def _pixel() -> PixelModel:
    return PixelModel(
        on_threshold=0.36, off_threshold=0.36, mismatch=0.1, refractory_us=100, noise_hz=0.02, hot_pixels=1, hot_hz=9_140.0
    )


@dataclass(frozen=True)
class Highway(StageSettings):
    """Three lanes and a shoulder; the defaults give a recording like one from a 346x260 camera (see docs/scenes.md)."""

    NAME: ClassVar[str] = "highway"

    pixel: PixelModel = field(default_factory=_pixel)
    camera_height_m: float = setting(7.5, 5.0, 30.0, "camera above the road")
    speed_m_s: float = setting(20.0, 5.0, 60.0, "mean speed in the middle lane")
    vehicles_per_s: float = setting(2.0, 0.0, 3.0, "how many come, in all lanes together")
    lorry_share: float = setting(0.12, 0.0, 1.0, "how many of them are lorries")
    contrast: float = setting(1.1, 0.1, 3.0, "log intensity between paint and road")
    story: int = setting(1, 0, 1, "whether the first come the wrong way, stop and overtake")
    wrong_way: int = setting(0, 0, 1_000, "how many come the wrong way besides")
    stopping: int = setting(0, 0, 1_000, "how many stop on the shoulder and drive on besides")
    crossing: int = setting(0, 0, 1_000, "people and animals that cross the road")
    loitering: int = setting(0, 0, 1_000, "people who stay on the shoulder")
    speeding: int = setting(0, 0, 1_000, "how many drive about twice as fast")


def simulate(settings: Highway) -> Scene:
    """See `stage.film`. The truth has a vehicle while its box is on the sensor. With the story, object_id 0 drives the wrong
    way, 1 stops on the shoulder, 2 overtakes the lorry 3; then follow the planted anomalies, by kind, which have labels; then
    the others in the order in which they enter the road.

    Raises:
        ConfigError: more anomalies than fit into the duration of the scene.
    """
    stage = _Stage(settings)
    scene = film(stage, settings)
    return replace(scene, truth=replace(scene.truth, labels=stage.labels(scene.truth.samples)))


class _Stage:
    def __init__(self, settings: Highway) -> None:
        random = np.random.default_rng(settings.seed)
        scale = settings.width / _WIDTH
        self._focal = _FOCAL_PX * scale
        self._vanishing_x, self._vanishing_y = (place * scale for place in _VANISHING_PX)
        self._height_m = settings.camera_height_m
        self._sensor = settings.width, settings.height
        reach = self._focal * self._height_m
        self._near_m = reach / (settings.height + MARGIN_PX - self._vanishing_y)
        self._far_m = reach / (-MARGIN_PX - self._vanishing_y)
        self.background = texture(settings, random, 1.0, 0.03)
        duration_s, speed_m_s = settings.duration_us * 1e-6, settings.speed_m_s
        told = story(duration_s, speed_m_s) if settings.story else []
        self._planted = plant(
            {kind: getattr(settings, kind) for kind in KINDS}, Road(self._near_m, self._far_m, speed_m_s), duration_s, told,
            np.random.default_rng((settings.seed, 1)),
        )  # fmt: skip
        self._first_planted = len(told)
        self._traffic = traffic(
            [*told, *(each.vehicle for each in self._planted)], duration_s, speed_m_s, settings.vehicles_per_s,
            settings.lorry_share, (self._near_m, self._far_m), random,
        )  # fmt: skip
        vehicles = self._traffic
        count = len(vehicles.class_id)
        tones = random.uniform(0.25, 1.0, count) * random.choice((-1, 1), count)
        parts, log_intensity = outline(vehicles.class_id != ObjectClass.CAR, settings.contrast * tones, settings.contrast)
        self._intensity = np.exp(log_intensity)
        size_m = np.stack((vehicles.width_m, vehicles.height_m, vehicles.length_m), axis=1)
        self._corners_m = np.ascontiguousarray(parts * size_m[:, None, None, :])
        self._size_m = np.ascontiguousarray(size_m[:, 1:])

    def shapes(self, t_us: float) -> NDArray[np.float64]:
        return self._project(np.array([t_us]))[2]

    def objects(self, t_us: float) -> NDArray[np.void]:
        return self.moments(np.array([t_us])).objects

    def moments(self, times_us: NDArray[Any]) -> Moments:
        ends, seen, shapes, boxes = self._project(times_us)
        by_id = np.lexsort((seen, np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))))
        objects = np.zeros(len(seen), TRUTH)
        objects["object_id"] = seen[by_id]
        objects["class_id"] = self._traffic.class_id[objects["object_id"]]
        for name, values in zip(("x", "y", "width", "height", "vx", "vy"), boxes[by_id].T, strict=True):
            objects[name] = values
        return Moments(shapes, ends * FACES, objects, ends)

    def labels(self, samples: NDArray[np.void]) -> tuple[Label, ...]:
        """Labels of the planted anomalies while they are visible."""
        labels = []
        for object_id, planted in enumerate(self._planted, self._first_planted):
            t_us = samples["t_us"][(samples["object_id"] == object_id) & samples["visible"]]
            t_us = t_us[(t_us >= planted.begin_s * 1e6) & (t_us <= planted.end_s * 1e6)]
            if len(t_us):
                labels.append(Label(object_id, planted.kind, int(t_us[0]), int(t_us[-1])))
        return tuple(labels)

    def _project(self, times_us: NDArray[Any]) -> tuple[NDArray[Any], ...]:
        """See `project_each`."""
        projected: tuple[NDArray[Any], ...] = project_each(
            times_us * 1e-6, self._traffic.motions, self._size_m, self._corners_m, self._intensity, self._focal,
            (self._vanishing_x, self._vanishing_y), self._height_m, (self._near_m, self._far_m), self._sensor, SHADOW + 1,
        )  # fmt: skip
        return projected

    def shift(self, _t_us: float) -> tuple[float, float]:
        return 0.0, 0.0

# SPDX-License-Identifier: Apache-2.0
"""The registry of scenes by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from ..errors import ConfigError
from ..ranges import read_value
from . import boxes, discs, highway, insects, pendulum, shake
from .scene import Scene

__all__ = ["SCENES", "SceneKind", "adjusted", "scene_settings", "simulate_scene"]


@dataclass(frozen=True)
class SceneKind:
    """A scene's settings class, its simulation function, and a one-line description."""

    settings: Callable[[], Any]
    simulate: Callable[[Any], Scene]
    title: str


SCENES: dict[str, SceneKind] = {
    "boxes": SceneKind(boxes.BoxExperiment, boxes.simulate, "bright and dark boxes, slow and fast: the box experiment"),
    "discs": SceneKind(discs.Discs, discs.simulate, "discs that bounce off the walls and cross each other"),
    "highway": SceneKind(
        highway.Highway, highway.simulate, "a motorway in perspective; one car comes the wrong way, one stops"
    ),
    "insects": SceneKind(insects.Insects, insects.simulate, "small fast dots before waving grass and glints"),
    "pendulum": SceneKind(pendulum.Pendulum, pendulum.simulate, "a damped pendulum: a bob on a rod"),
    "shake": SceneKind(shake.Shake, shake.simulate, "boxes before a textured wall, seen by a trembling camera"),
}


def simulate_scene(name: str, seed: int = 1, overrides: Mapping[str, Any] | None = None) -> Scene:
    """Simulate a scene of `SCENES`; see `scene_settings`."""
    settings = scene_settings(name, seed, overrides)
    return SCENES[name].simulate(settings)


def scene_settings(name: str, seed: int = 1, overrides: Mapping[str, Any] | None = None) -> Any:
    """A scene's settings: its defaults with `seed` and `overrides`, see `adjusted`.

    Raises:
        ConfigError: unknown scene or setting, or a value outside its range.
    """
    if name not in SCENES:
        raise ConfigError(f"scene {name!r}: must be one of {', '.join(SCENES)}")
    return adjusted(name, SCENES[name].settings(), {"seed": seed, **(overrides or {})})


def adjusted(name: str, settings: Any, overrides: Mapping[str, Any]) -> Any:
    """Settings with some fields replaced, including those of the pixel model. Text is parsed as the type of the field.

    Raises:
        ConfigError: unknown field, or a value outside its range.
    """
    pixel = getattr(settings, "pixel", None)
    known = asdict(settings)
    own_keys = known.keys() - {"pixel"}
    known |= known.pop("pixel", {})
    values: dict[str, Any] = {}
    for key, value in overrides.items():
        if key not in known:
            raise ConfigError(f"{name}.{key}: no such setting: must be one of {', '.join(known)}")
        values[key] = read_value(f"{name}.{key}", value, known[key]) if isinstance(value, str) else value
    own = {key: value for key, value in values.items() if key in own_keys}
    of_pixel = {key: value for key, value in values.items() if key not in own_keys}
    if pixel is not None and of_pixel:
        own["pixel"] = replace(pixel, **of_pixel)
    return replace(settings, **own)

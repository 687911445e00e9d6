# SPDX-License-Identifier: Apache-2.0
"""The registry of scenes by name; a scene's module is imported when it is first used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigError, RecordingError, meant
from ..ranges import read_value

if TYPE_CHECKING:
    from .truth import Scene

__all__ = ["SCENES", "SceneKind", "adjusted", "check_source", "scene_settings", "simulate_scene"]


@dataclass(frozen=True)
class SceneKind:
    """A scene.

    Attributes:
        title: one-line description.
        module: module of this package whose `simulate` simulates the scene.
        settings_class: name of its settings class, whose defaults describe the scene.
    """

    title: str
    module: str
    settings_class: str

    @property
    def settings(self) -> Callable[[], Any]:
        """Makes the scene's settings."""
        made: Callable[[], Any] = getattr(self._imported(), self.settings_class)
        return made

    @property
    def simulate(self) -> Callable[[Any], Scene]:
        """The scene of such settings."""
        simulate: Callable[[Any], Scene] = self._imported().simulate
        return simulate

    def _imported(self) -> Any:
        return import_module(f".{self.module}", __package__)


SCENES: dict[str, SceneKind] = {
    "boxes": SceneKind("bright and dark boxes, slow and fast: the box experiment", "boxes", "BoxExperiment"),
    "discs": SceneKind("discs that bounce off the walls and cross each other", "discs", "Discs"),
    "highway": SceneKind("a motorway in perspective; one car comes the wrong way, one stops", "highway", "Highway"),
    "insects": SceneKind("small fast dots before waving grass and glints", "insects", "Insects"),
    "pendulum": SceneKind("a damped pendulum: a bob on a rod", "pendulum", "Pendulum"),
    "shake": SceneKind("boxes before a textured wall, seen by a trembling camera", "shake", "Shake"),
}


def check_source(name: str) -> None:
    """Raise RecordingError for a name that is neither that of a file or folder nor that of a scene."""
    if not Path(name).exists() and name not in SCENES:
        scenes = f"nor is it a scene, one of {', '.join(SCENES)}{meant(name, SCENES)}"
        raise RecordingError(f"{name}: cannot be read: No such file or directory; {scenes}")


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

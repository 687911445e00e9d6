# SPDX-License-Identifier: Apache-2.0
"""Simulated scenes, each drawn anew from ranges of sensor, size, speed, contrast, noise and number."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from evcot.metrics.truth import OBJECT, GroundTruth, ground_truth_of
from evcot.scenes.insects import Insects, grass
from evcot.scenes.pendulum import ROD
from evcot.scenes.registry import scene_settings, simulate_scene
from field.hard import without_faint
from field.member import TRUTH_STEP_US, Entry, Member, kept, scene_rule
from field.transforms import backwards, upside_down

__all__ = ["entries", "with_grass"]

Settings = dict[str, Any]
Draw = Callable[[np.random.Generator], Settings]

_SENSORS = ((240, 180), (346, 260), (346, 260), (480, 360))
_SECONDS = 4.0
_INSECT_BOX_PX = 8.0  # the least side of an insect's box, as a person would draw it


def _between(random: np.random.Generator, low: float, high: float) -> float:
    """A value from a range, each factor as likely."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _view(random: np.random.Generator) -> Settings:
    """Sensor and pixels, alike for all filmed scenes."""
    width, height = _SENSORS[random.integers(len(_SENSORS))]
    threshold = _between(random, 0.12, 0.3)
    return {
        "contrast": min(threshold * _between(random, 2.5, 7.0), 1.6),  # events an edge and pixel: two to seven
        "width": width,
        "height": height,
        "on_threshold": threshold,
        "off_threshold": threshold * random.uniform(0.8, 1.25),
        "mismatch": random.uniform(0.0, 0.08),
        "refractory_us": int(random.integers(100, 1_000)),
        "noise_hz": _between(random, 0.02, 2.0),
        "hot_pixels": int(random.integers(0, 3)),
        "hot_hz": _between(random, 100, 10_000),
        "duration_us": round(_SECONDS * 1e6),
    }


def _motorway(random: np.random.Generator) -> Settings:
    view = _view(random)
    threshold = _between(random, 0.2, 0.4)
    return view | {
        "on_threshold": threshold,
        "off_threshold": threshold,
        "camera_height_m": _between(random, 5.5, 14.0),
        "speed_m_s": _between(random, 12.0, 36.0),
        "vehicles_per_s": _between(random, 1.0, 2.5),
        "lorry_share": random.uniform(0.0, 0.25),
        "contrast": _between(random, 0.7, 1.6),
        "story": int(random.integers(0, 2)),
    }


def _discs(ways: str, most: int) -> Draw:
    def draw(random: np.random.Generator) -> Settings:
        view = _view(random)
        count = int(random.integers(2, most + 1))
        room = view["height"] / (count if ways == "separate" else 4)
        return view | {
            "ways": ways,
            "count": count,
            "radius_px": min(_between(random, 5.0, 18.0), 0.4 * room),
            "speed_px_s": _between(random, 50.0, 400.0),
        }

    return draw


def _boxes(random: np.random.Generator) -> Settings:
    width, height = _SENSORS[random.integers(len(_SENSORS))]
    return {
        "width": width,
        "height": height,
        "speed": ("both", "slow", "fast")[random.integers(3)],
        "slow_px_s": _between(random, 40.0, 150.0),
        "fast_px_s": _between(random, 200.0, 600.0),
        "side_px": round(random.uniform(0.2, 0.6) * height / 6),
        "contrast_steps": int(random.integers(2, 7)),
        "noise_hz_per_px": _between(random, 0.05, 2.0),
        "flicker_hz_per_px": _between(random, 5.0, 30.0),
        "duration_us": 3_000_000,
    }


def _insects(random: np.random.Generator) -> Settings:
    return _view(random) | {
        "count": int(random.integers(3, 13)),
        "radius_px": _between(random, 1.2, 3.0),
        "speed_px_s": _between(random, 100.0, 400.0),
        "blades": int(random.integers(0, 13)),
        "glints": int(random.integers(0, 13)),
    }


def _pendulum(random: np.random.Generator) -> Settings:
    view = _view(random)
    return view | {
        "length_px": random.uniform(0.5, 0.75) * view["height"],
        "bob_px": _between(random, 7.0, 20.0),
        "rod_px": _between(random, 1.0, 3.0),
        "angle_deg": random.uniform(15.0, 45.0),
        "period_s": _between(random, 0.8, 2.5),
    }


def _shake(random: np.random.Generator) -> Settings:
    view = _view(random)
    return view | {
        "count": int(random.integers(2, 6)),
        "side_px": random.uniform(0.08, 0.15) * view["height"],
        "speed_px_s": _between(random, 60.0, 250.0),
        "shake_px": random.uniform(1.0, 5.0),
        "shake_hz": _between(random, 1.5, 8.0),
        "texture_contrast": _between(random, 0.02, 0.08),
        "grain_px": random.uniform(2.0, 6.0),
    }


# family -> (scene, how many members, what is drawn)
_FAMILIES: Mapping[str, tuple[str, int, Draw]] = {
    "motorway, simulated": ("highway", 6, _motorway),
    "discs in lanes": ("discs", 4, _discs("separate", 6)),
    "discs crossing": ("discs", 4, _discs("crossing", 6)),
    "boxes": ("boxes", 4, _boxes),
    "insects": ("insects", 3, _insects),
    "pendulum, simulated": ("pendulum", 3, _pendulum),
    "shake": ("shake", 3, _shake),
}


def entries(seed: int, quick: bool) -> Iterator[Entry]:
    """Seven families."""
    for index, (family, (scene, count, draw)) in enumerate(_FAMILIES.items()):
        for number in range(1 if quick else count):
            yield Entry(family, f"{scene} {number + 1}", scene, _builder(family, scene, draw, (seed, 3, index, number)))


def _builder(family: str, scene: str, draw: Draw, seed: tuple[int, ...]) -> Callable[[], Member]:
    number = seed[-1]
    name = f"{scene} {number + 1}"
    settings = draw(np.random.default_rng(seed)) | {"truth_step_us": TRUTH_STEP_US}
    of_scene = int(np.random.SeedSequence(seed).generate_state(1)[0])

    def simulate() -> Member:
        made = simulate_scene(scene, of_scene, settings)
        rule = scene_rule(made.recording)
        member = Member(family, name, made.recording, ground_truth_of(made.truth, rule), rule, "exact")
        return without_faint(member) if scene == "highway" else member

    def build() -> Member:
        member = simulated()
        objects = member.truth.objects
        if scene == "insects":
            for side in ("width", "height"):
                objects[side] = np.maximum(objects[side], _INSECT_BOX_PX)
            return replace(member, truth=with_grass(member.truth, scene_settings(scene, of_scene, settings)))
        if scene == "pendulum":
            return _bob_or_whole(member)
        if scene == "highway" and number % 3 == 1:
            return backwards(member)  # cars come towards the camera
        if scene == "highway" and number % 3 == 2:
            return upside_down(member)
        return member

    simulated = kept(f"{family} {name} {of_scene} {settings}", simulate, "hard")
    return build


def with_grass(truth: GroundTruth, settings: Insects) -> GroundTruth:
    """The truth with each blade of grass as an object that is not counted: within its reach, tracks on it are not false."""
    reach = grass(settings)
    blades = np.zeros((len(truth.instants_us), len(reach)), OBJECT)
    blades["frame"] = np.arange(len(truth.instants_us))[:, None]
    blades["object"] = len(truth.ids) + np.arange(len(reach))
    blades["vx"] = blades["vy"] = np.nan
    for index, (axis, side) in enumerate((("x", "width"), ("y", "height"))):
        low, high = reach[:, index], reach[:, 2 + index]
        blades[axis], blades[side] = (low + high) / 2, high - low
    objects = np.concatenate((truth.objects, blades.ravel()))
    ids = (*truth.ids, *(f"grass {number + 1}" for number in range(len(reach))))
    return GroundTruth(truth.instants_us, objects[np.argsort(objects["frame"], kind="stable")], ids)


def _bob_or_whole(member: Member) -> Member:
    """Two truths: the bob, where a track on the rod is not false; or bob and rod as one object."""
    objects, rods = member.truth.objects, member.truth.ids.index(str(ROD))
    is_bob = objects["object"] != rods
    objects["counted"] &= is_bob
    bob, rod = objects[is_bob], objects[~is_bob]
    assert np.array_equal(bob["frame"], rod["frame"])
    whole = bob.copy()
    for axis, side in (("x", "width"), ("y", "height")):
        low, high = (
            limit(bob[axis] + sign * bob[side] / 2, rod[axis] + sign * rod[side] / 2)
            for limit, sign in ((np.minimum, -1), (np.maximum, 1))
        )
        whole[axis], whole[side], whole[f"v{axis}"] = (low + high) / 2, high - low, np.nan
    return replace(member, alternatives=(replace(member.truth, objects=whole),))

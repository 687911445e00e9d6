# SPDX-License-Identifier: Apache-2.0
"""Anomalies on the highway: they are present, behave as labelled, and do not change the default scene."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.scenes import highway
from evcot.scenes.planted import KINDS
from evcot.scenes.registry import scene_settings, simulate_scene
from evcot.scenes.stage import _samples
from evcot.scenes.truth import Label, ObjectClass

ALL = dict.fromkeys(KINDS, 2)


def staged(seed: int = 101, seconds: int = 45, **overrides: Any) -> tuple[Any, NDArray[np.void], tuple[Label, ...]]:
    """A stage, its truth every 50 ms, and its labels."""
    stage = highway._Stage(scene_settings("highway", seed, {"duration_us": seconds * 10**6, **overrides}))
    samples = _samples(stage, range(0, seconds * 10**6, 50_000), (346, 260))
    return stage, samples, stage.labels(samples)


def test_the_default_scene_has_the_bytes_that_it_always_had() -> None:
    """Ways of all vehicles, before anything is drawn: the same on every machine to the last digit that a truth file has."""
    stage = highway._Stage(scene_settings("highway", 1))
    ways = np.concatenate([np.stack(stage._traffic.at(t), axis=1) for t in (0.0, 1.7, 3.9)])
    assert hashlib.sha256(np.round(ways, 6).tobytes()).hexdigest()[:16] == "13972fdbe2f32a48"
    assert stage.labels(_samples(stage, range(0, 4_000_000, 100_000), (346, 260))) == ()


def test_so_many_of_each_kind_are_labelled_while_they_are_visible_and_do_what_it_says() -> None:
    stage, samples, labels = staged(story=0, vehicles_per_s=1.2, **ALL)
    assert [label.kind for label in labels] == [kind for kind in KINDS for _ in range(2)]
    assert [label.object_id for label in labels] == list(range(10))
    for label in labels:
        own = samples[(samples["object_id"] == label.object_id) & samples["visible"]]
        assert own["t_us"][0] <= label.begin_us < label.end_us <= own["t_us"][-1]
        t_s = own["t_us"] * 1e-6
        if label.kind == "wrong_way":
            assert (own["vy"] > 0).all()
        elif label.kind == "speeding":
            assert all(stage._traffic.at(t).along_m_s[label.object_id] >= 36 for t in t_s)
        elif label.kind == "crossing":
            assert np.ptp(own["x"]) > 250
            assert np.ptp(own["y"]) < 2
            assert abs(own["vx"]).min() > 0
        elif label.kind == "stopping":
            stands = (own["vx"] == 0) & (own["vy"] == 0)
            assert 4.0 <= stands.sum() * 0.05 <= 8.1
            before = own[own["t_us"] < label.begin_us]
            assert (before["vy"] < 0).all()
        else:
            assert label.kind == "loitering"
            middle = own[(t_s > t_s[0] + 3) & (t_s < t_s[-1] - 3)]
            assert len(middle) * 0.05 > 6
            assert np.ptp(middle["x"]) < 40


def test_the_planted_meet_nobody() -> None:
    stage, _, _ = staged(seed=104, story=0, vehicles_per_s=2.0, **ALL)
    traffic = stage._traffic
    for t_s in np.arange(0, 45, 0.25):
        now = traffic.at(float(t_s))
        gap_x = abs(now.across_m[:10, None] - now.across_m) - (traffic.width_m[:10, None] + traffic.width_m) / 2
        rear, front = now.along_m, now.along_m + traffic.length_m
        overlap = np.minimum(front[:10, None], front) - np.maximum(rear[:10, None], rear)
        in_sight = (rear[:10, None] > 24) & (rear[:10, None] < 145)
        assert not ((gap_x < 0) & ~np.eye(10, len(rear), dtype=bool) & in_sight & (overlap > 0)).any()


def test_the_story_stays_in_front_of_them_and_without_it_all_drive_away() -> None:
    _, samples, labels = staged(seconds=20, vehicles_per_s=1.0, wrong_way=1)
    assert [(label.object_id, label.kind) for label in labels] == [(4, "wrong_way")]
    assert (samples["vy"][samples["object_id"] == 0] > 0).all()
    _, samples, labels = staged(seconds=10, story=0)
    assert labels == ()
    assert (samples["vy"] < 0).all()


def test_labels_come_with_the_scene() -> None:
    scene = simulate_scene("highway", 3, {"duration_us": 4_000_000, "truth_step_us": 20_000, "story": 0, "speeding": 1,
                                          "vehicles_per_s": 0.2})  # fmt: skip
    (label,) = scene.truth.labels
    assert label.kind == "speeding"
    assert label.end_us - label.begin_us > 1_500_000


def test_each_object_has_its_class() -> None:
    stage, samples, labels = staged(story=0, vehicles_per_s=1.2, lorry_share=0.5, crossing=2, loitering=2)
    traffic = stage._traffic
    assert (samples["class_id"] == traffic.class_id[samples["object_id"]]).all()
    size_of = {
        ObjectClass.CAR: (1.8, 1.5),
        ObjectClass.LORRY: (2.5, 3.4),
        ObjectClass.PERSON: (0.6, 1.75),
        ObjectClass.ANIMAL: (1.5, 1.3),
    }
    for class_id, width_m, height_m in zip(traffic.class_id, traffic.width_m, traffic.height_m, strict=True):
        assert abs(width_m / size_of[class_id][0] - 1) < 0.0701
        assert abs(height_m / size_of[class_id][1] - 1) < 0.0701
    assert {ObjectClass.CAR, ObjectClass.LORRY, ObjectClass.PERSON} <= set(traffic.class_id)
    for label in labels:
        walks = ObjectClass.PERSON if label.kind == "loitering" else (ObjectClass.PERSON, ObjectClass.ANIMAL)
        assert traffic.class_id[label.object_id] in np.atleast_1d(walks)

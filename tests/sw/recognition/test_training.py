# SPDX-License-Identifier: Apache-2.0
"""Training: labels of windows, and a network that tells bars from crosses, on the tracker's own windows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.hardware.classifier import CELLS, RecognitionRegisters
from evcot.hardware.config import MotionConfig
from evcot.recognition import training
from evcot.recognition.tracker import ClassifyingTracker, TrackWindows
from evcot.recognition.training import UNLABELLED, LabelledWindows, label_windows, registers_for, train, windows_of
from evcot.tracks.formats.base import BOX, Boxes
from evcot.tracks.log import TRACK, Kind
from evcot.tracks.tracking import log_of

SENSOR = 200, 100
CONFIG = MotionConfig()


def moving(shape: int, seed: int, duration_us: int = 400_000, seen: bool = True) -> tuple[Events, Boxes]:
    """An object that moves to the right at 200 px/s: the outline of a square (0) or a cross (1); and its labelled boxes."""
    random = np.random.default_rng(seed)
    count = duration_us // 12
    t_us = np.sort(random.integers(0, duration_us, count))
    along, across, side = random.uniform(-10, 10, count), random.integers(-1, 2, count), random.integers(0, 4, count)
    edge = np.where(side < 2, 10.0, -10.0) if shape == 0 else across
    dx, dy = np.where(side % 2, along, edge), np.where(side % 2, edge, along)
    x, y = 30 + t_us * 200e-6 + dx, 50 + dy + seed % 5
    p = random.integers(0, 2, count)
    instants_us = np.arange(0, duration_us, 10_000)
    rows = np.zeros(len(instants_us), BOX)
    rows["instant"], rows["id"], rows["class_id"] = np.arange(len(rows)), 1, 5 + shape
    rows["left"], rows["top"] = 20 + instants_us * 200e-6 + (0 if seen else 70), 40 + seed % 5
    rows["width"] = rows["height"] = 20
    return Events(t_us, np.rint(x).astype(np.uint16), np.rint(y).astype(np.uint16), p.astype(np.uint8)), Boxes(
        instants_us, rows
    )


def in_blocks(events: Events) -> Iterator[Events]:
    for begin in range(0, len(events), 5_000):
        yield events[begin : begin + 5_000]


def labelled(seeds: range, registers: RecognitionRegisters) -> LabelledWindows:
    parts = []
    for seed in seeds:
        events, boxes = moving(seed % 2, seed)
        parts.append(label_windows(windows_of(in_blocks(events), CONFIG, registers), boxes))
    return LabelledWindows.of(parts)


REGISTERS = replace(registers_for([moving(0, 0)[1]]), window_log2=8)


def test_a_trained_classifier_names_objects_it_has_not_seen() -> None:
    weights = train(labelled(range(12), REGISTERS), REGISTERS, "cot_motion")
    assert weights.class_ids == (5, 6)
    assert weights.registers.window_log2 == 8
    for seed in (20, 21, 22, 23):
        events, _ = moving(seed % 2, seed)
        tracker = ClassifyingTracker(CONFIG, weights)
        log = log_of("cot_motion", tracker, in_blocks(events))
        assert len(log.of_kind(Kind.BORN)) == 1
        assert len(log.verdicts) > 10
        assert log.verdicts["class_id"][-1] == 5 + seed % 2
        assert set(log.verdicts["track_id"]) == set(log.records["track_id"])
        assert np.array_equal(log.verdicts["t_us"], events.t_us[log.verdicts["event_index"]])
        assert (log.owner[log.verdicts["event_index"]] == log.verdicts["slot"]).all()
        whole = log_of("cot_motion", ClassifyingTracker(CONFIG, weights), [events])
        assert np.array_equal(whole.verdicts, log.verdicts)


def test_the_same_seed_gives_the_same_weights() -> None:
    windows = labelled(range(4), REGISTERS)
    first, again, other = (train(windows, REGISTERS, "cot_motion", seed).checksum for seed in (1, 1, 2))
    assert first == again != other


def deviations(monkeypatch: pytest.MonkeyPatch, affine: float, bend: float, shift: float) -> None:
    for name, deviation in (("_AFFINE", affine), ("_BEND", bend), ("_SHIFT", shift)):
        monkeypatch.setattr(training, name, deviation)


def test_distortions_of_no_size_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    deviations(monkeypatch, 0, 0, 0)
    images = np.random.default_rng(1).random((20, CELLS**2), np.float32)
    assert np.allclose(training._distorted(images, np.random.default_rng(2)), images, atol=1e-5)


def test_each_kind_of_distortion_changes_what_it_names(monkeypatch: pytest.MonkeyPatch) -> None:
    # An image whose value is the row: a shift adds the same to all cells, an affine change a multiple of the
    # place, a bend a curve. Cells near the edge have neighbours beyond it.
    rows = np.repeat(np.arange(CELLS, dtype=np.float32), CELLS)
    inner = np.zeros((CELLS, CELLS), np.bool_)
    inner[3:-3, 3:-3] = True
    v, u = (axis[inner] - (CELLS - 1) / 2 for axis in np.indices((CELLS, CELLS)))
    one = np.ones_like(v)
    for affine, bend, shift, terms in ((0, 0, 0.3, [one]), (0.05, 0, 0, [v, u]), (0, 0.05, 0, [one, v * v, u * v, u * u])):
        deviations(monkeypatch, affine, bend, shift)
        distorted = training._distorted(np.tile(rows, (16, 1)), np.random.default_rng(3))
        moved = (distorted - rows)[:, inner.ravel()]
        fit, *_ = np.linalg.lstsq(np.stack(terms, axis=1), moved.T, rcond=None)
        assert np.allclose(np.stack(terms, axis=1) @ fit, moved.T, atol=1e-4)
        assert np.abs(moved).max(axis=1).min() > 0.01
        assert np.allclose(moved[::2], moved[1::2])  # two images in each of eight parts
        assert len(np.unique(moved[:, 0].round(5))) == 8


def test_a_class_with_too_few_windows_is_refused() -> None:
    images = np.zeros((120, CELLS**2), np.uint8)
    class_id = np.r_[np.full(49, 1), np.full(71, 2)]
    with pytest.raises(ConfigError, match=r"class 1 has 49 windows: must be at least 50"):
        train(LabelledWindows(images, class_id, class_id), REGISTERS, "cot_motion")
    with pytest.raises(ConfigError, match=r"number of labelled classes in the tracks found is 1: must be 2 to 10"):
        train(LabelledWindows(images[:99], np.full(99, 2), class_id), REGISTERS, "cot_motion")
    with pytest.raises(ConfigError, match=r"number of labelled classes in the tracks found is 0: must be 2 to 10"):
        train(LabelledWindows(images, np.full(120, UNLABELLED), class_id), REGISTERS, "cot_motion")


def test_weights_of_another_tracker_are_refused() -> None:
    weights = replace(train(labelled(range(4), REGISTERS), REGISTERS, "cot_motion"), tracker="cot_array")
    with pytest.raises(ConfigError, match=r"engine cot_motion: must be cot_array, the tracker of the weights"):
        ClassifyingTracker(CONFIG, weights)


def windows_at(*places: tuple[int, float, float]) -> TrackWindows:
    states = np.zeros(len(places), TRACK)
    states["track_id"] = np.arange(len(places))
    for row, (_, x, y) in enumerate(places):
        states["x"][row], states["y"][row] = x, y
    t_us = np.array([place[0] for place in places], np.int64)
    return TrackWindows(t_us, states, np.zeros((len(places), CELLS**2), np.uint8))


def test_a_window_has_the_class_of_the_nearest_box_around_its_track() -> None:
    rows = np.zeros(3, BOX)
    rows["instant"], rows["id"], rows["class_id"] = (0, 0, 1), (0, 1, 0), (3, 4, 6)
    rows["left"], rows["top"], rows["width"], rows["height"] = (0, 8, 100), 0, 10, 10
    labels = Boxes(np.array([1_000, 2_000]), rows)
    places = ((900, 5, 5), (1_500, 9.1, 5), (1_501, 9.1, 5), (1_400, 8.9, 5), (1_400, 15, 11), (9_999, 105, 0))
    assert label_windows(windows_at(*places), labels).class_id.tolist() == [3, 4, UNLABELLED, 3, UNLABELLED, 6]


def test_the_start_scale_fits_labelled_objects() -> None:
    # A side of 20 px is 40 half pixels, shown on 9.6 of the 12 cells: 9.6 * 4096 / 40.
    assert registers_for([moving(0, 0)[1]]).scale_start == 983

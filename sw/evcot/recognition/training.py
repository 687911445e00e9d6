# SPDX-License-Identifier: Apache-2.0
"""Training of the classifier: windows that the tracker has found, their classes from labelled boxes, and the network.

And training of rules S (docs/recognition.md), on the verdicts of a trained network, with size and speed of their tracks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..events import Events
from ..hardware.classifier import CELLS, CLASSES_MAX, HIDDEN, HIDDEN_MAX, LOSS_MAX, RecognitionRegisters
from ..hardware.config import MotionConfig
from ..ranges import check_integer
from ..tracks.formats.base import Boxes
from ._windows import judge
from .model import Network
from .tracker import TrackWindows, WindowTracker, joined
from .weights import Weights, inputs_of

__all__ = [
    "INPUT_COUNTS",
    "LOGITS_MAX",
    "UNLABELLED",
    "WINDOWS_MIN",
    "LabelledWindows",
    "fitted",
    "fitted_size_speed",
    "label_windows",
    "registers_for",
    "train",
    "verdicts_of",
    "windows_of",
]

UNLABELLED = -1
WINDOWS_MIN = 50  # of a class
_EPOCHS, _BATCH = 40, 256
_RATE, _DECAY = 2e-3, 0.05  # of Adam, and decay of weights per step in units of the rate
_DROP = 0.1  # share of cells left out in training
_DISTORTIONS = 8  # of a batch: each changes a part of its images
_AFFINE, _SHIFT = 0.1, 0.3  # standard deviations of a distortion: of its affine change, and of its shift in cells
_BEND = 0.1  # and of its bend: how far an edge moves against the middle, in halves of an image
INPUT_COUNTS = 4.0  # counts per unit of the network's input in training
LOGITS_MAX = 6.0  # distance from the best class at which a loss is limited
_OBJECT_CELLS = CELLS / 1.25  # side of a labelled object in the image of a track's first window


@dataclass(frozen=True, eq=False)
class LabelledWindows:
    """Windows with classes.

    Attributes:
        images: (n, CELLS^2) uint8.
        class_id: (n,) int64, `UNLABELLED` where the track is in no labelled box.
        track_id: (n,) int64.
    """

    images: NDArray[np.uint8]
    class_id: NDArray[np.int64]
    track_id: NDArray[np.int64]

    @classmethod
    def of(cls, parts: Sequence[LabelledWindows]) -> LabelledWindows:
        """All windows of several recordings, whose track ids are kept."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("images", "class_id", "track_id")))


def registers_for(labels: Sequence[Boxes], window_log2: int = 10, margin_min: int = 0) -> RecognitionRegisters:
    """Registers whose start scale fits labelled objects: the median of their sides."""
    sides_px = np.concatenate([(boxes.rows["width"] + boxes.rows["height"]) / 2 for boxes in labels])
    half_pixels = 2 * float(np.median(sides_px)) if len(sides_px) else 40.0
    scale = round(min(max(_OBJECT_CELLS * 4096 / half_pixels, 16), 4095))
    return RecognitionRegisters(window_log2=window_log2, scale_start=scale, margin_min=margin_min)


def windows_of(blocks: Iterable[Events], config: MotionConfig, registers: RecognitionRegisters) -> TrackWindows:
    """Run the tracker over a recording; the windows of all its tracks."""
    tracker = WindowTracker(config, registers)
    return joined([tracker.windows(block) for block in blocks])


def label_windows(windows: TrackWindows, labels: Boxes) -> LabelledWindows:
    """Give each window the class of the labelled box that its track is in: the nearest box that holds the track's middle.

    Boxes are taken at the instant nearest to the window's end.
    """
    instants_us, rows = labels.instants_us, labels.rows
    if not len(instants_us):
        return LabelledWindows(windows.images, np.full(len(windows.t_us), UNLABELLED), windows.states["track_id"])
    begins = np.searchsorted(rows["instant"], np.arange(len(instants_us) + 1))
    after = np.clip(np.searchsorted(instants_us, windows.t_us), 1, max(len(instants_us) - 1, 1))
    before_us = windows.t_us - instants_us[after - 1]
    instant = np.where(before_us <= instants_us[np.minimum(after, len(instants_us) - 1)] - windows.t_us, after - 1, after)
    instant = np.minimum(instant, len(instants_us) - 1)
    class_id = np.full(len(instant), UNLABELLED)
    for row, (at, state) in enumerate(zip(instant.tolist(), windows.states, strict=True)):
        boxes = rows[begins[at] : begins[at + 1]]
        off_x = np.abs(boxes["left"] + boxes["width"] / 2 - state["x"])
        off_y = np.abs(boxes["top"] + boxes["height"] / 2 - state["y"])
        inside = np.flatnonzero((off_x <= boxes["width"] / 2) & (off_y <= boxes["height"] / 2))
        if len(inside):
            class_id[row] = boxes["class_id"][inside[np.argmin(np.hypot(off_x, off_y)[inside])]]
    return LabelledWindows(windows.images, class_id, windows.states["track_id"])


def train(windows: LabelledWindows, registers: RecognitionRegisters, tracker: str, seed: int = 1) -> Weights:
    """Train the network, and quantise it.

    Args:
        windows: those without a label are left out.
        registers: those that the windows were made with.
        tracker: the module whose owned events they hold.
        seed: of all random numbers; the same seed and windows give the same weights on one machine.

    Raises:
        ConfigError: fewer than two classes, more than the network has, or one with fewer than `WINDOWS_MIN` windows.
    """
    check_integer("seed", seed, 0, 2**63 - 1)
    labelled = windows.class_id != UNLABELLED
    images = windows.images[labelled]
    class_ids, target, counts = np.unique(windows.class_id[labelled], return_inverse=True, return_counts=True)
    if not 2 <= len(class_ids) <= CLASSES_MAX:
        raise ConfigError(f"number of labelled classes in the tracks found is {len(class_ids)}: must be 2 to {CLASSES_MAX}")
    if counts.min() < WINDOWS_MIN:
        few = int(np.argmin(counts))
        rule = f"must be at least {WINDOWS_MIN}: label more recordings of this class"
        raise ConfigError(f"class {class_ids[few]} has {counts[few]} windows: {rule}")
    w1, w2 = fitted(images.astype(np.float32) / INPUT_COUNTS, target, len(class_ids), np.random.default_rng(seed))
    network, shift_1, shift_2 = _quantised(w1 / INPUT_COUNTS, w2, images)
    own = replace(registers, shift_1=shift_1, shift_2=shift_2, classes=len(class_ids))
    return Weights(network, own, tuple(class_ids.tolist()), tracker)


def fitted(
    inputs: NDArray[np.float32], target: NDArray[np.int64], classes: int, random: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Weights of both layers before they are quantised: Adam on the cross-entropy, with a rate that falls as a cosine.

    Args:
        inputs: (n, CELLS^2), counts / `INPUT_COUNTS`.
        target: (n,), classes from 0.

    Returns:
        (CELLS^2, HIDDEN) and (HIDDEN, classes).
    """
    n = len(inputs)
    weights = [
        random.normal(0, math.sqrt(2 / inputs.shape[1]), (inputs.shape[1], HIDDEN)).astype(np.float32),
        random.normal(0, math.sqrt(1 / HIDDEN), (HIDDEN, classes)).astype(np.float32),
    ]
    mean, square = ([np.zeros_like(each) for each in weights] for _ in range(2))
    steps = _EPOCHS * -(-n // _BATCH)
    step = 0
    for _ in range(_EPOCHS):
        order = random.permutation(n)
        for begin in range(0, n, _BATCH):
            rows = order[begin : begin + _BATCH]
            some = _distorted(inputs[rows], random)
            some *= (random.random(some.shape, dtype=np.float32) > _DROP) * np.float32(1 / (1 - _DROP))
            before = some @ weights[0]
            hidden = np.maximum(before, 0)
            scores = hidden @ weights[1]
            error = np.exp(scores - scores.max(axis=1, keepdims=True))
            error /= error.sum(axis=1, keepdims=True)
            error[np.arange(len(rows)), target[rows]] -= 1
            error /= len(rows)
            slopes = some.T @ ((error @ weights[1].T) * (before > 0)), hidden.T @ error
            step += 1
            rate = _RATE * 0.5 * (1 + math.cos(math.pi * step / steps))
            for k, slope in enumerate(slopes):
                mean[k] += 0.1 * (slope - mean[k])
                square[k] += 0.001 * (slope**2 - square[k])
                moved = mean[k] / (1 - 0.9**step) / (np.sqrt(square[k] / (1 - 0.999**step)) + 1e-8)
                weights[k] -= np.float32(rate) * (moved + np.float32(_DECAY) * weights[k])
    return weights[0], weights[1]


def _distorted(images: NDArray[np.float32], random: np.random.Generator) -> NDArray[np.float32]:
    """Images (n, CELLS^2) under as many distortions as a batch has, each for one part of them."""
    parts = np.array_split(images, _DISTORTIONS)
    return np.concatenate([part @ matrix for part, matrix in zip(parts, _distortions(random), strict=True)])


def _distortions(random: np.random.Generator) -> NDArray[np.float32]:
    """Small random changes of images, (_DISTORTIONS, CELLS^2, CELLS^2), to be multiplied with rows.

    A cell takes its value from another place, by bilinear interpolation. The place is a random polynomial of second degree: an
    affine change, a shift and a bend.
    """
    middle = (CELLS - 1) / 2
    v, u = cells = np.indices((CELLS, CELLS)).reshape(2, -1) / middle - 1
    bends = np.stack((v * v, u * v, u * u))
    bends -= bends.mean(axis=1, keepdims=True)
    affine, bend, shift = (
        random.normal(0, deviation, (_DISTORTIONS, 2, count)) for deviation, count in ((_AFFINE, 2), (_BEND, 3), (_SHIFT, 1))
    )
    place = middle * (1 + cells + affine @ cells + bend @ bends) + shift
    # The share of each row, and of each column, in each place.
    shares: NDArray[np.float32] = np.maximum(1 - np.abs(place[:, :, None] - np.arange(CELLS)[:, None]), 0).astype(np.float32)
    of_rows, of_columns = shares[:, 0, :, None], shares[:, 1, None]
    return np.reshape(of_rows * of_columns, (_DISTORTIONS, CELLS**2, CELLS**2))


def _quantised(w1: NDArray[np.float32], w2: NDArray[np.float32], images: NDArray[np.uint8]) -> tuple[Network, int, int]:
    """The weights in 8 bits, and the shifts after both layers."""
    per_1, per_2 = (127 / float(np.abs(weights).max()) for weights in (w1, w2))
    whole_1, whole_2 = (np.rint(weights * per).astype(np.int8) for weights, per in ((w1, per_1), (w2, per_2)))
    some = images[:: max(len(images) // 4096, 1)].astype(np.int64)
    top = float(np.quantile((some @ whole_1.astype(np.int64)).max(axis=1), 0.99))
    shift_1 = max(math.ceil(math.log2(max(top, 1) / HIDDEN_MAX)), 0)
    per_logit = per_1 * per_2 / 2**shift_1
    shift_2 = min(max(round(math.log2(per_logit * LOGITS_MAX / LOSS_MAX)), 0), 15)
    return Network(whole_1, whole_2), shift_1, shift_2


_RIDGE = 1e-3  # of the weights' squares, in units of the mean loss of a track
_STEPS = 500
_SPREAD_MIN = 1e-6  # of an input's standard deviation: others are constant


def verdicts_of(weights: Weights, windows: LabelledWindows) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Winner, margin and number of windows of the vote after each window, (n,) int64, without `margin_min`."""
    tracks, track = np.unique(windows.track_id, return_inverse=True)
    stages = np.full(len(track), 2, np.uint8)  # not 1, which begins a vote: each track has its own
    registers, network = weights.registers, weights.network
    pairs = np.stack((np.arange(len(track)), track), axis=1)
    votes, voted = np.zeros((len(tracks), registers.classes), np.int64), np.zeros(len(tracks), np.int64)
    out = np.zeros((len(track), 5), np.int64)
    judge(
        network.w1.astype(np.int32), network.w2.astype(np.int32), registers.shift_1, registers.shift_2, 0,
        pairs, stages, windows.images, votes, voted, out,
    )  # fmt: skip
    return out[:, 2], out[:, 3], out[:, 4]


def fitted_size_speed(weights: Weights, windows: LabelledWindows, states: NDArray[np.void]) -> NDArray[np.float64]:
    """`Weights.size_speed` of a trained network: multinomial logistic regression, in which every track counts once.

    Args:
        windows: in the order of each track, those that the network was trained with.
        states: (n,) of dtype `TRACK`, the newest record of each window's track.
    """
    classes = len(weights.class_ids)
    inputs = inputs_of(*verdicts_of(weights, windows), states, classes)
    labelled = windows.class_id != UNLABELLED
    inputs, track_id = inputs[labelled], windows.track_id[labelled]
    wanted = windows.class_id[labelled][:, None] == np.array(weights.class_ids)
    _, track, counts = np.unique(track_id, return_inverse=True, return_counts=True)
    share = 1 / (counts[track] * len(counts))
    middle, spread = inputs.mean(axis=0), inputs.std(axis=0)
    middle[-1], spread[spread < _SPREAD_MIN] = 0.0, 1.0
    scaled = _logistic((inputs - middle) / spread, wanted.astype(np.float64), share) / spread[:, None]
    scaled[-1] -= middle @ scaled
    return np.asarray(scaled)


def _logistic(inputs: NDArray[np.float64], wanted: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights, (inputs, classes): descent with the bound of the second derivative by Boehning (1992), which never diverges."""
    weights = np.zeros((inputs.shape[1], wanted.shape[1]))
    step = np.linalg.inv((inputs * share[:, None]).T @ inputs / 2 + _RIDGE * np.eye(len(weights)))
    for _ in range(_STEPS):
        scores = inputs @ weights
        likely = np.exp(scores - scores.max(axis=1, keepdims=True))
        likely /= likely.sum(axis=1, keepdims=True)
        weights -= step @ (inputs.T @ ((likely - wanted) * share[:, None]) + _RIDGE * weights)
    return weights

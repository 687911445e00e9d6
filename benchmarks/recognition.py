# SPDX-License-Identifier: Apache-2.0
"""How often the classifier is right: digits that a camera saw (N-MNIST), four at once, each carried along a path.

    python benchmarks/recognition.py           # 8 folds of 100 samples; validation
    python benchmarks/recognition.py --all     # also what costs how much, a baseline, and other objects
    python benchmarks/recognition.py --still   # digits that stand against digits that move
    python benchmarks/recognition.py --hats    # the baseline HATS

The network of a fold is trained on windows that the tracker has found of the other 700 samples, of both kinds together.
A track's class is that of all its windows together, as in the last verdict of up to 128 windows; its true class that of the
labelled box which most of its windows lie in.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import evcot
from evcot.events import Events, Recording
from evcot.hardware.classifier import CELLS, HIDDEN, HIDDEN_MAX, LOSS_MAX, RecognitionRegisters
from evcot.hardware.config import MotionConfig
from evcot.hardware.golden import GoldenTracker
from evcot.hardware.model import Decisions
from evcot.metrics.truth import GroundTruth
from evcot.recognition.model import Classifier, Network, OwnedEvents
from evcot.recognition.tracker import TrackWindows, WindowTracker, joined
from evcot.recognition.training import (
    INPUT_COUNTS,
    LOGITS_MAX,
    UNLABELLED,
    LabelledWindows,
    fitted,
    label_windows,
    train,
)
from evcot.recognition.weights import Weights
from evcot.trackers.presets import MOTION, fit
from evcot.tracks.formats.base import BOX, Boxes
from field.digits import FILE, digit_labels, digits
from field.transforms import poisson_noise
from hats import HatsTracker, linear
from measure import Goal, Result, Skip
from shared import SHARED

WAYS = "apart", "crossing"
FOLDS, AT_ONCE = 8, 4
LONG = 10  # windows of a track
EVENTS_PER_S, TRACKS = 20e6, {"apart": 0.94, "crossing": 0.91}  # goals


class Found(NamedTuple):
    """Windows of the recordings of a fold, "apart" or "crossing"; no track id occurs twice, also not in other draws."""

    fold: int
    way: str
    windows: LabelledWindows


class TruthCentred(WindowTracker):
    """The tracker's events, with addresses relative to the true middle of the nearest object: what recentring costs."""

    def __init__(self, config: MotionConfig, registers: RecognitionRegisters, truth: Boxes) -> None:
        super().__init__(config, registers)
        self._truth, self._mask = truth, (1 << config.shape.rel_w) - 1

    def decide(self, events: Events) -> tuple[NDArray[np.void], Decisions]:
        """See `GoldenTracker`."""
        records, decided = super().decide(events)
        rows, instants_us = self._truth.rows, self._truth.instants_us
        off_x, off_y = (
            np.stack([
                address - np.interp(events.t_us, instants_us[own["instant"]], own[low] + own[side] / 2)
                for own in (rows[rows["id"] == one] for one in np.unique(rows["id"]))
            ])
            for address, low, side in ((events.x, "left", "width"), (events.y, "top", "height"))
        )  # fmt: skip
        nearest = np.argmin(np.hypot(off_x, off_y), axis=0)[None]
        rel_x, rel_y = (
            (np.rint(2 * np.take_along_axis(off, nearest, 0)[0]).astype(np.int64) & self._mask).astype(np.uint16)
            for off in (off_x, off_y)
        )
        return records, decided._replace(rel_x=rel_x, rel_y=rel_y)


def scenes(fold: int, way: str, draw: int) -> Iterator[tuple[Recording, Boxes]]:
    """The recordings of a fold, with the labelled boxes of each."""
    labels = digit_labels()
    numbers = np.random.default_rng((draw, fold)).permutation(np.arange(fold, len(labels), FOLDS))
    for place in range(0, len(numbers), AT_ONCE):
        some = numbers[place : place + AT_ONCE]
        member = digits(way, len(some), (draw, fold, place), some.tolist())
        yield member.recording, boxes_of(member.truth, labels[some])


def boxes_of(truth: GroundTruth, class_id: NDArray[np.int64]) -> Boxes:
    """A truth as labelled boxes; `class_id` of each object."""
    objects = truth.objects
    rows = np.zeros(len(objects), BOX)
    rows["instant"], rows["id"], rows["class_id"] = objects["frame"], objects["object"], class_id[objects["object"]]
    for low, axis, side in (("left", "x", "width"), ("top", "y", "height")):
        rows[low], rows[side] = objects[axis] - objects[side] / 2, objects[side]
    rows["confidence"] = rows["visibility"] = 1.0
    rows["counted"] = True
    return Boxes(truth.instants_us, rows)


def config_for(recording: Recording) -> MotionConfig:
    """The default tracker."""
    config = fit(MOTION, recording.width, recording.height).device_config(recording.width, recording.height)
    assert isinstance(config, MotionConfig)
    return config


def hats_in(fold: int, way: str, draw: int) -> Found:
    """As `found_in`, with the features of HATS for images."""
    parts = []
    for number, (recording, boxes) in enumerate(scenes(fold, way, draw)):
        windows = HatsTracker(config_for(recording), RecognitionRegisters()).windows(recording.events)
        windows.states["track_id"] += (draw << 48) + (number << 32)
        parts.append(label_windows(windows, boxes))
    return Found(fold, way, LabelledWindows.of(parts))


def found_in(fold: int, way: str, draw: int, registers: RecognitionRegisters, truth_centred: bool = False) -> Found:
    """Run the tracker over a fold's recordings."""
    parts = []
    for number, (recording, boxes) in enumerate(scenes(fold, way, draw)):
        config = config_for(recording)
        tracker = TruthCentred(config, registers, boxes) if truth_centred else WindowTracker(config, registers)
        windows = joined([tracker.windows(block) for block in in_blocks(recording.events)])
        windows.states["track_id"] += (draw << 48) + (number << 32)
        parts.append(label_windows(windows, boxes))
    return Found(fold, way, LabelledWindows.of(parts))


def in_blocks(events: Events) -> Iterator[Events]:
    """Events in the blocks of a file."""
    for begin in range(0, len(events), 1 << 18):
        yield events[begin : begin + (1 << 18)]


def losses(weights: Weights, images: NDArray[np.uint8]) -> NDArray[np.int64]:
    """The loss of each class in each window, (n, classes)."""
    registers, network = weights.registers, weights.network
    hidden = np.maximum(images.astype(np.int64) @ network.w1.astype(np.int64), 0) >> registers.shift_1
    scores = np.minimum(hidden, HIDDEN_MAX) @ network.w2.astype(np.int64)
    return np.minimum((scores.max(axis=1, keepdims=True) - scores) >> registers.shift_2, LOSS_MAX)


class Score(NamedTuple):
    """Right windows, right tracks; `by_track` is (tracks, 4): true class, class found, margin per window, windows."""

    windows: float
    tracks: float
    by_track: NDArray[np.float64]


Scores = dict[str, list[Score]]


def score(loss: NDArray[np.float64], class_ids: NDArray[np.int64], windows: LabelledWindows) -> Score:
    """Score windows that the network has not seen: a track's class is that of all its windows together."""
    labelled = windows.class_id != UNLABELLED
    right = class_ids[loss.argmin(axis=1)] == windows.class_id
    rows = []
    for track in np.unique(windows.track_id):
        own = windows.track_id == track
        classes, counts = np.unique(windows.class_id[own], return_counts=True)
        votes = np.sort(vote := loss[own].sum(axis=0))
        rows.append((classes[np.argmax(counts)], class_ids[vote.argmin()], (votes[1] - votes[0]) / own.sum(), own.sum()))
    table = np.array(rows)
    objects = table[table[:, 0] != UNLABELLED]
    shares = float(right[labelled].mean()) if labelled.any() else 0.0, float((objects[:, 0] == objects[:, 1]).mean())
    return Score(*shares, table)


Learner = Callable[[LabelledWindows, int], Callable[[NDArray[np.uint8]], NDArray[np.float64]]]
"""From windows and a seed to the loss of each class, 0 to 9, in each of other windows."""


def int8(windows: LabelledWindows, seed: int) -> Callable[[NDArray[np.uint8]], NDArray[np.float64]]:
    """The classifier."""
    weights = train(windows, RecognitionRegisters(), "cot_motion", seed)
    return lambda images: losses(weights, images).astype(np.float64)


def in_float(windows: LabelledWindows, seed: int) -> Callable[[NDArray[np.uint8]], NDArray[np.float64]]:
    """The same network before it is quantised."""
    target = np.unique(windows.class_id[windows.class_id != UNLABELLED], return_inverse=True)[1]
    inputs = windows.images[windows.class_id != UNLABELLED].astype(np.float32) / INPUT_COUNTS
    w1, w2 = fitted(inputs, target, 10, np.random.default_rng(seed))

    def loss(images: NDArray[np.uint8]) -> NDArray[np.float64]:
        scores = np.maximum(images.astype(np.float32) / INPUT_COUNTS @ w1, 0) @ w2
        return np.minimum(scores.max(axis=1, keepdims=True) - scores, LOGITS_MAX).astype(np.float64)

    return loss


def pca_and_neighbours(windows: LabelledWindows, _seed: int) -> Callable[[NDArray[np.uint8]], NDArray[np.float64]]:
    """Baseline in the manner of PCA-RECT: 40 principal components, and the classes of the 15 nearest windows."""
    from sklearn.decomposition import PCA
    from sklearn.neighbors import KNeighborsClassifier

    labelled = windows.class_id != UNLABELLED
    images = windows.images[labelled].astype(np.float32)
    components = PCA(40, random_state=0).fit(images)
    nearest = KNeighborsClassifier(15).fit(components.transform(images), windows.class_id[labelled])
    return lambda others: -nearest.predict_proba(components.transform(others.astype(np.float32)))


def hats_and_linear(windows: LabelledWindows, _seed: int) -> Callable[[NDArray[np.float32]], NDArray[np.float64]]:
    """Baseline HATS: a linear classifier of time surfaces, which stand in for the images."""
    labelled = windows.class_id != UNLABELLED
    weights, offset = linear(windows.images[labelled], windows.class_id[labelled], 10)
    return lambda features: -(np.sqrt(features) @ weights + offset).astype(np.float64)


def validate(found: Sequence[Found], folds: Sequence[int], learner: Learner, seed: int, others: Sequence[Found] = ()) -> Scores:
    """Train on all folds but one, score that one, all draws together; for each of `folds`. `others` are only scored."""
    scored = (*found, *others)
    scores: Scores = {one.way: [] for one in scored}
    for fold in folds:
        loss = learner(LabelledWindows.of([one.windows for one in found if one.fold != fold]), seed)
        for way in scores:
            own = LabelledWindows.of([one.windows for one in scored if (one.fold, one.way) == (fold, way)])
            scores[way].append(score(loss(own.images), np.arange(10), own))
    return scores


def print_scores(name: str, scores: Scores) -> None:
    """Means over folds, with standard errors of the share of tracks."""
    for way, own in scores.items():
        tracks = np.array([one.tracks for one in own])
        error = tracks.std(ddof=1) / len(tracks) ** 0.5 if len(tracks) > 1 else float("nan")
        count = sum(len(one.by_track) for one in own)
        windows = np.mean([one.windows for one in own])
        every = np.concatenate([one.by_track for one in own])
        long = every[(every[:, 3] >= LONG) & (every[:, 0] != UNLABELLED)]
        of_long = f"of {LONG} windows and more {(long[:, 0] == long[:, 1]).mean():.4f} of {len(long)}"
        print(
            f"{name:18s} {way:9s} windows {windows:.3f}  tracks {tracks.mean():.4f} +- {error:.4f} of {count}, {of_long}",
            flush=True,
        )


def strangers(name: str, seed: int) -> TrackWindows:
    """Windows of the tracks in a recording without digits: a scene's, or noise."""
    if name == "noise":
        random = np.random.default_rng(seed)
        recording = Recording(poisson_noise((346, 260), (0, 4_000_000), 10.0, random), 346, 260, name)
    else:
        recording = evcot.simulate(name, seed=seed).recording
    tracker = WindowTracker(config_for(recording), RecognitionRegisters())
    return joined([tracker.windows(block) for block in in_blocks(recording.events)])


def print_strangers(found: Sequence[Found], scores: Scores, seed: int) -> None:
    """Tracks of other things that get a class, at the margin that 0.95 of the tracks of digits reach."""
    margins = np.concatenate([one.by_track[:, 2] for own in scores.values() for one in own])
    least = float(np.quantile(margins, 0.05))
    loss = int8(LabelledWindows.of([one.windows for one in found]), seed)
    print(f"margin per window that 0.95 of the tracks reach: {least:.1f}")
    for name in ("noise", "discs", "boxes", "insects", "highway"):
        windows = strangers(name, 1)
        tracks = np.unique(windows.states["track_id"])
        votes = np.array([np.sort(loss(windows.images[windows.states["track_id"] == track]).mean(axis=0)) for track in tracks])
        named = int((votes[:, 1] - votes[:, 0] >= least).sum()) if len(tracks) else 0
        print(f"{name:10s} {named} of {len(tracks)} tracks with a verdict are called a digit", flush=True)


def print_still(folds: Sequence[int], draws: Sequence[int], seed: int) -> None:
    """Digits that stand, but for the camera's saccades, and digits that move apart: trained on one kind, scored on both."""
    still, apart = (
        [found_in(fold, way, draw, RecognitionRegisters()) for draw in draws for fold in range(FOLDS)]
        for way in ("still", "apart")
    )
    print_scores("trained on still", validate(still, folds, int8, seed, apart))
    print_scores("trained on apart", validate(apart, folds, int8, seed, still))


def print_hats(folds: Sequence[int], draws: Sequence[int], seed: int) -> None:
    """The baseline HATS."""
    found = [hats_in(fold, way, draw) for draw in draws for way in WAYS for fold in range(FOLDS)]
    print_scores("HATS, linear", validate(found, folds, hats_and_linear, seed))


def owned_events_per_s() -> float:
    """Rate of the golden model, without the tracker in front: the best of five."""
    recording, _ = next(scenes(0, "apart", 1))
    config = config_for(recording)
    decided = GoldenTracker(config).decide(recording.events)[1]
    owned = decided.owner >= 0
    columns = [np.tile(column[owned], 20) for column in decided[1:]]
    events = OwnedEvents(*columns, np.ones(len(columns[0]), np.bool_))
    random = np.random.default_rng(1)
    network = Network(*(random.integers(-99, 99, shape).astype(np.int8) for shape in ((CELLS**2, HIDDEN), (HIDDEN, 10))))
    taken_s = []
    for _ in range(5):
        classifier = Classifier(RecognitionRegisters(), network, config.shape.n_slots, config.shape.rel_w)
        begin_s = time.perf_counter()
        classifier.feed(events)
        taken_s.append(time.perf_counter() - begin_s)
    return len(events.owner) / min(taken_s)


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """Rate of the golden model, and tracks with the right class (validation); quick: one fold, one draw."""
    if not (SHARED / FILE).is_file():
        raise Skip(f"{FILE} is missing")
    rate = owned_events_per_s()
    yield Result("recognition_model", rate, "owned events/s", EVENTS_PER_S, "goal", goal=Goal(1))
    draws, folds = ((1,), [0]) if quick else ((1, 2), list(range(FOLDS)))
    found = [found_in(fold, way, draw, RecognitionRegisters()) for draw in draws for way in WAYS for fold in range(FOLDS)]
    for way, scores in validate(found, folds, int8, 1).items():
        share = float(np.mean([one.tracks for one in scores]))
        yield Result(f"recognition_{way}", share, "of tracks", TRACKS[way], "goal", goal=Goal(1), how="validation")


def main() -> None:
    """Validation; what recentring and eight bits cost; a baseline; other objects."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--folds", type=int, nargs="+", default=list(range(FOLDS)))
    parser.add_argument("--draws", type=int, nargs="+", default=[1, 2], help="seeds of the paths")
    parser.add_argument("--seed", type=int, default=1, help="seed of the training")
    parser.add_argument("--still", action="store_true", help="only: still digits against moving ones")
    parser.add_argument("--hats", action="store_true", help="only: the baseline HATS")
    parser.add_argument("--all", action="store_true", help="also float, truth-centred, baseline, other objects (an hour)")
    options = parser.parse_args()

    def found(truth_centred: bool) -> list[Found]:
        registers = RecognitionRegisters()
        return [
            found_in(fold, way, draw, registers, truth_centred)
            for draw in options.draws
            for way in WAYS
            for fold in range(FOLDS)
        ]

    if options.hats:
        print_hats(options.folds, options.draws, options.seed)
        return
    if options.still:
        print_still(options.folds, options.draws, options.seed)
        return
    print(f"golden model: {owned_events_per_s() / 1e6:.0f} M owned events/s", flush=True)
    windows = found(False)
    scores = validate(windows, options.folds, int8, options.seed)
    print_scores("tracker", scores)
    if options.all:
        print_strangers(windows, scores, options.seed)
        print_scores("float", validate(windows, options.folds, in_float, options.seed))
        print_scores("PCA, neighbours", validate(windows, options.folds, pca_and_neighbours, options.seed))
        print_scores("truth-centred", validate(found(True), options.folds, int8, options.seed))


if __name__ == "__main__":
    main()

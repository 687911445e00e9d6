# SPDX-License-Identifier: Apache-2.0
"""All scores of a TrackLog against a ground truth; its classes against those of the truth, where both have classes."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingWarning, TrackLogError
from ..tracks.log_files import RecordRuns
from ..tracks.log_parts import sampled
from ..tracks.record import ClassNames, class_label, classes_at
from .frames import Frames, Matches, line_up
from .mot import clear, hota, identity
from .motion import motion
from .rule import Rule
from .sampling import checked_runs
from .truth import GroundTruth

__all__ = ["ClassScores", "Scores", "class_hota", "class_scores", "evaluate", "warn_of_other_truth"]


@dataclass(frozen=True)
class ClassScores:
    """How often tracks have the class of their object.

    Attributes:
        class_ids: classes of truth and verdicts, ascending, without -1.
        labels: how each is shown: by its name, if the log has it.
        confusion: tracks of each true class (row) with each class found (column, in the same order); the last column has
            those without a class: none of these, or without a verdict.
        accuracy: share of all tracks with the right class.
        recall, precision: of each class; None without a track of it, or with it.
        hota: of each class, of its objects and of the tracks while they have this class; None without an object of it.
        hota_mean: over the classes with objects.
    """

    class_ids: tuple[int, ...]
    labels: tuple[str, ...]
    confusion: tuple[tuple[int, ...], ...]
    accuracy: float
    recall: tuple[float | None, ...]
    precision: tuple[float | None, ...]
    hota: tuple[float | None, ...]
    hota_mean: float


def class_hota(frames: Frames, of_object: NDArray[np.int64], of_output: NDArray[np.int64]) -> dict[int, float]:
    """HOTA of each class of objects: of these objects, and of the outputs with this class.

    Args:
        of_object, of_output: the class of each object and each output, by frame, within a frame in the order of `frames`.
    """
    classes = np.unique(of_object[of_object >= 0]).tolist()
    return {one: hota(frames.restricted(of_object == one, of_output == one)).hota for one in classes}


def class_scores(
    verdicts: NDArray[np.void], names: ClassNames, track_id: NDArray[np.int64], class_id: NDArray[np.int64],
    by_class: Mapping[int, float],
) -> ClassScores | None:  # fmt: skip
    """Compare the last verdict of each track with the class of the object that it met most often.

    Args:
        verdicts: (k,) of dtype `tracks.record.VERDICT`.
        names: of the classes.
        track_id, class_id: (n,), a track and its object's true class, for each instant at which the two met.
        by_class: as of `class_hota`.

    Returns:
        None if no track met an object with a class.
    """
    known = class_id >= 0
    track_id, class_id = track_id[known], class_id[known]
    if not len(track_id):
        return None
    tracks, number = np.unique(track_id, return_inverse=True)
    found = classes_at(verdicts, tracks, np.full(len(tracks), np.iinfo(np.int64).max))
    class_ids = np.unique(np.concatenate((class_id, found[found >= 0], np.array(list(by_class), np.int64))))
    met = np.zeros((len(tracks), len(class_ids)), np.int64)
    np.add.at(met, (number, np.searchsorted(class_ids, class_id)), 1)
    confusion = np.zeros((len(class_ids), len(class_ids) + 1), np.int64)
    np.add.at(confusion, (met.argmax(axis=1), np.where(found >= 0, np.searchsorted(class_ids, found), len(class_ids))), 1)
    right = np.diagonal(confusion)
    return ClassScores(
        tuple(class_ids.tolist()),
        tuple(class_label(one, names) for one in class_ids.tolist()),
        tuple(tuple(row) for row in confusion.tolist()),
        float(right.sum() / len(tracks)),
        _shares(right, confusion.sum(axis=1)),
        _shares(right, confusion.sum(axis=0)[:-1]),
        tuple(by_class.get(one) for one in class_ids.tolist()),
        float(np.mean(list(by_class.values()))),
    )


def _shares(part: NDArray[np.int64], whole: NDArray[np.int64]) -> tuple[float | None, ...]:
    return tuple(one / of if of else None for one, of in zip(part.tolist(), whole.tolist(), strict=True))


_APART_US = 1_000_000  # a log and a truth separated by more than this, and by more than the truth's duration, differ in clock


@dataclass(frozen=True)
class Scores:
    """The result of `evaluate`; meanings as in `hota.Hota`, `clear.Clear`, `identity.Identity` and `motion.Motion`.

    Attributes:
        frames: number of instants evaluated; truth_ids, track_ids: number of objects and tracks evaluated at any of them.
        classes: of tracks, if the log has verdicts and the truth classes.
    """

    hota: float
    deta: float
    assa: float
    loca: float
    detre: float
    detpr: float
    assre: float
    asspr: float
    mota: float
    motp: float
    idf1: float
    idp: float
    idr: float
    idsw: int
    frag: int
    tp: int
    fp: int
    fn: int
    mt: int
    ml: int
    position_error_px_median: float | None
    position_error_px_p90: float | None
    velocity_error_median: float | None
    stated_velocity_error_median: float | None
    stated_angle_error_deg_median: float | None
    stated_angle_over_45_deg_fraction: float | None
    stated_relative_error_median: float | None
    latency_ms: float | None
    frames: int
    truth_ids: int
    track_ids: int
    classes: ClassScores | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values by name; without `classes` if there are none."""
        return {name: value for name, value in asdict(self).items() if name != "classes" or value is not None}


def evaluate(log: RecordRuns, truth: GroundTruth, rule: Rule) -> Scores:
    """Evaluate tracks against a ground truth, as specified by a rule.

    Args:
        log: a log in memory, or the file of one, which is read three times; memory does not depend on its length.

    Raises:
        TrackLogError: the log has invalid records, or times on another clock than the truth.
        ConfigError: the rule ignores bands along the sensor's edges, and the sensor size is unknown.
    """
    span_us: list[int] = []
    outputs = sampled(_noting(checked_runs(log.record_runs()), span_us), truth.instants_us, rule.max_age_us)
    _check_clock(span_us, truth)
    frames, objects, outputs = line_up(outputs, truth, rule)
    followed = clear(frames, rule.threshold)
    identified = identity(frames, rule.threshold)
    row, column = _rows(frames, followed.matches)
    instants_us = truth.instants_us[followed.matches.frame]
    moved = motion(log, rule.max_age_us, objects[row], outputs[column], instants_us)
    return Scores(
        **asdict(hota(frames)),
        **{name: getattr(followed, name) for name in ("mota", "motp", "idsw", "frag", "tp", "fp", "fn", "mt", "ml")},
        **{name: getattr(identified, name) for name in ("idf1", "idp", "idr")},
        **asdict(moved),
        frames=len(truth.instants_us),
        truth_ids=frames.n_truth,
        track_ids=frames.n_tracks,
        classes=_classes(log, truth, frames, objects, outputs, (row, column)),
    )


def _classes(
    log: RecordRuns, truth: GroundTruth, frames: Frames, objects: NDArray[np.void], outputs: NDArray[np.void],
    met: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> ClassScores | None:  # fmt: skip
    """Of a log with verdicts; `met`: rows of `objects` and `outputs` that were matched."""
    verdicts, (row, column) = log.verdicts, met
    if not len(verdicts):
        return None
    now = classes_at(verdicts, outputs["track_id"], truth.instants_us[outputs["sample"]])
    by_class = class_hota(frames, objects["class_id"], now)
    return class_scores(verdicts, log.class_names, outputs["track_id"][column], objects["class_id"][row], by_class)


def _noting(runs: Iterable[NDArray[np.void]], span_us: list[int]) -> Iterator[NDArray[np.void]]:
    """The same runs; `span_us` gets the times of the first and the last record."""
    for records in runs:
        if len(records):
            first_us = span_us[0] if span_us else int(records["t_us"][0])
            span_us[:] = first_us, int(records["t_us"][-1])
        yield records


def _check_clock(log_us: list[int], truth: GroundTruth) -> None:
    if not log_us:
        return
    instants_us = truth.instants_us
    span_us = int(instants_us[-1] - instants_us[0])
    apart_us = max(log_us[0] - int(instants_us[-1]), int(instants_us[0]) - log_us[1])
    if apart_us > max(span_us, _APART_US):
        spans = f"t_us from {log_us[0]} to {log_us[1]}, the truth's from {instants_us[0]} to {instants_us[-1]}"
        raise TrackLogError(f"{spans}: must be of one clock (the rule's origin_us moves the truth)")


def _rows(frames: Frames, matches: Matches) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The indices of each matched pair in all objects and in all outputs."""
    return (
        _places(frames.truth, frames.n_truth, matches.frame, matches.truth),
        _places(frames.tracks, frames.n_tracks, matches.frame, matches.track),
    )


def _places(
    ids: tuple[NDArray[np.int64], ...], n: int, frame: NDArray[np.int64], number: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Index of (frame, number) in the concatenated numbers of all frames."""
    keys = np.repeat(np.arange(len(ids)), [len(own) for own in ids]) * n + np.concatenate([np.empty(0, np.int64), *ids])
    order = np.argsort(keys)
    return np.asarray(order[np.searchsorted(keys[order], frame * n + number)], np.int64)


_MEETING = 0.05  # share of objects, and of tracks' boxes, that is met by chance: up to 0.04 in scenes of six objects


def warn_of_other_truth(scores: Scores, truth: str, stacklevel: int = 2) -> None:
    """Warn if hardly any track meets an object, as with the truth of another recording.

    Args:
        truth: its name.
        stacklevel: as of `warnings.warn`, counted from the caller's caller.
    """
    if scores.track_ids and scores.truth_ids and max(scores.detre, scores.detpr) < _MEETING:
        fault = "hardly any track meets an object: must be the truth of this recording, on its clock and in its pixels"
        warnings.warn(f"{truth}: {fault}", RecordingWarning, stacklevel=stacklevel + 1)

# SPDX-License-Identifier: Apache-2.0
"""One contender on one member: how well it follows, and how well at the moment when its answer is available."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import evaluate
from evcot.tracks.log import TRACK, Kind, TrackLog
from field.contenders import Contender
from field.member import Member

__all__ = ["PACKET_US", "Score", "prepared", "run", "score", "score_log"]

PACKET_US = 1_000  # in which events arrive, as a camera's driver hands them on
_WARM_UP = 20_000
_BOTH_WAYS = "hota", "mota", "idf1"  # by centres and by overlap


@dataclass(frozen=True)
class Score:
    """Scores of one recording; None where they have no meaning.

    Attributes:
        hota, mota, idf1: by the distance of centres.
        hota_iou, mota_iou, idf1_iou: by overlap, which tables of other work state.
        switches: of identity.
        tracks: visible tracks in all; the score where nothing is there.
        tracks_per_object: of the tracks that count, per object that counts.
        covered: share of the objects' instants at which a track is on them.
        one_track: share of the objects' instants at which their one best track is on them.
        false_per_instant: tracks on nothing, a mean over the instants.
        stated_angle_deg: median of the angle between stated velocity and displacement (docs/evaluation.md).
        answered: HOTA at the moments when answers are available, computing time included, in packets of `PACKET_US`.
        cpu_s, events_per_s: CPU time of one thread.
    """

    tracks: int
    hota: float | None = None
    mota: float | None = None
    idf1: float | None = None
    hota_iou: float | None = None
    mota_iou: float | None = None
    idf1_iou: float | None = None
    switches: int | None = None
    tracks_per_object: float | None = None
    covered: float | None = None
    one_track: float | None = None
    false_per_instant: float | None = None
    stated_angle_deg: float | None = None
    answered: float | None = None
    cpu_s: float | None = None
    events_per_s: float | None = None

    @property
    def merit(self) -> float:
        """What settings are chosen by: HOTA of the centres; where nothing is there, 1 / (1 + tracks)."""
        return 1 / (1 + self.tracks) if self.hota is None else self.hota

    def to_dict(self) -> dict[str, Any]:
        """Plain values by name."""
        return asdict(self)


def prepared(contender: Contender, member: Member) -> Member:
    """A member as the contender may see it: without hot pixels, learned from the whole recording, if it is `masked`."""
    if not contender.masked:
        return member
    recording = member.recording
    hot = learn_hot_pixels(recording.events, (recording.width, recording.height))
    return replace(member, recording=apply(recording, FilterConfig(hot_pixels=hot))[0]) if hot else member


def run(
    contender: Contender, settings: Any, member: Member, packet_us: int | None = PACKET_US
) -> tuple[TrackLog, TrackLog, float]:
    """The log; the same with every record at the time when it is available; and the CPU time.

    An answer is available when its packet has ended, all before it has been computed, and it has been computed itself. On a
    machine that others use, too, packets' shares of the time are told by the wall clock, and their sum by the CPU time.

    Args:
        packet_us: None: the recording in one packet; answers are then not known.
    """
    recording = member.recording
    sensor = recording.width, recording.height
    first = contender.start(settings, sensor)  # compiles what is not compiled yet
    first.feed(recording.events[:_WARM_UP])
    first.finish()
    tracker = contender.start(settings, sensor)
    records, ends_us, walls_s = [np.empty(0, TRACK)], [], []
    begun_cpu_s = time.thread_time()
    for events, end_us in _packets(recording.events, packet_us):
        begun_s = time.perf_counter()
        records.append(tracker.finish() if events is None else tracker.feed(events)[0])
        walls_s.append(time.perf_counter() - begun_s)
        ends_us.append(end_us)
    cpu_s = time.thread_time() - begun_cpu_s
    ready_us = _ready(np.array(ends_us), np.array(walls_s) * min(1.0, cpu_s / max(sum(walls_s), 1e-9)))
    ready = [np.empty(0, np.int64), *(np.full(len(made), at_us) for made, at_us in zip(records[1:], ready_us, strict=True))]
    every = np.concatenate(records)
    late = every.copy()
    late["t_us"] = np.maximum(np.concatenate(ready), every["t_us"])
    late = late[np.argsort(late["t_us"], kind="stable")]
    owner = np.empty(0, np.int16)
    return TrackLog(contender.name, every, owner), TrackLog(contender.name, late, owner), cpu_s


def _ready(ends_us: NDArray[np.int64], costs_s: NDArray[np.float64]) -> NDArray[np.int64]:
    """When each packet has been computed: after its end, and after the one before it."""
    done_us = np.cumsum(1e6 * costs_s)
    waits_us = np.maximum.accumulate(ends_us - (done_us - 1e6 * costs_s))
    return np.rint(waits_us + done_us).astype(np.int64)


def _packets(events: Events, packet_us: int | None) -> list[tuple[Events | None, int]]:
    """Packets and their ends; last, None for the end of the stream."""
    last_us = int(events.t_us[-1]) + 1
    if packet_us is None:
        return [(events, last_us), (None, last_us)]
    ends_us = np.arange(int(events.t_us[0]) + packet_us, last_us + packet_us, packet_us)
    bounds = np.searchsorted(events.t_us, ends_us)
    cut = [(events[a:b], int(end)) for a, b, end in zip([0, *bounds[:-1]], bounds, ends_us, strict=True)]
    return [*cut, (None, int(ends_us[-1]))]


def score(contender: Contender, settings: Any, member: Member, timed: bool = False) -> Score:
    """All scores; `timed`: in packets, so that it is known when answers are available."""
    packet_us = PACKET_US if timed and not member.empty else None
    log, late, cpu_s = run(contender, settings, member, packet_us)
    scored = score_log(log, member, None if packet_us is None else late)
    return replace(scored, cpu_s=cpu_s, events_per_s=len(member.recording.events) / max(cpu_s, 1e-9))


def score_log(log: TrackLog, member: Member, late: TrackLog | None = None) -> Score:
    """The scores of a log, and of when it was available; of several truths, those of the one that it meets best."""
    tracks = len(np.unique(log.records["track_id"][log.records["kind"] <= Kind.MOVED]))
    if member.empty:
        return Score(tracks)
    rule = member.rule
    truths = [(evaluate(log, truth, rule), truth) for truth in (member.truth, *member.alternatives)]
    centre, truth = max(truths, key=lambda one: _number(one[0].hota))
    boxes = evaluate(log, truth, replace(rule, similarity="iou"))
    objects = max(centre.tp + centre.fn, 1)
    return Score(
        tracks,
        **{name: _number(getattr(centre, name)) for name in _BOTH_WAYS},
        **{f"{name}_iou": _number(getattr(boxes, name)) for name in _BOTH_WAYS},
        switches=centre.idsw,
        tracks_per_object=centre.track_ids / max(centre.truth_ids, 1),
        covered=centre.tp / objects,
        one_track=_number(centre.idr),
        false_per_instant=centre.fp / max(centre.frames, 1),
        stated_angle_deg=centre.stated_angle_error_deg_median,
        answered=None if late is None else _answered(late, replace(member, truth=truth)),
    )


def _answered(late: TrackLog, member: Member) -> float:
    records = late.records[late.records["t_us"] <= member.truth.instants_us[-1]]
    if not len(records):
        return 0.0
    return _number(evaluate(replace(late, records=records), member.truth, member.rule).hota)


def _number(value: float | None) -> float:
    """A score without data is none at all: 0."""
    return 0.0 if value is None or np.isnan(value) else float(value)

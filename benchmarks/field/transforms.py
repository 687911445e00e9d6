# SPDX-License-Identifier: Apache-2.0
"""Changes of a member after which its truth is as exact as before.

Positions are those of events, the centre of pixel (x, y) at (x, y); the rule's edge, bands and ages change with the truth.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.metrics.rule import Rule
from evcot.metrics.truth import OBJECT, GroundTruth
from field.member import Member

__all__ = [
    "at_speed",
    "backwards",
    "doubled",
    "halved",
    "noisy",
    "poisson_noise",
    "spliced",
    "thinned",
    "transposed",
    "upside_down",
    "without",
]

_OTHER_EDGE = {"left": "right", "right": "left", "top": "bottom", "bottom": "top"}
_TRANSPOSED_EDGE = {"left": "top", "top": "left", "right": "bottom", "bottom": "right"}


def backwards(member: Member) -> Member:
    """Played from the end to the beginning, with polarity exchanged: what was brighter before is darker afterwards."""
    events, truth = member.recording.events, member.truth
    ends_us = int(events.t_us[0]) + int(events.t_us[-1])
    turned = Events(ends_us - events.t_us[::-1], events.x[::-1], events.y[::-1], 1 - events.p[::-1])
    objects = truth.objects.copy()
    objects["frame"] = len(truth.instants_us) - 1 - objects["frame"]
    objects["vx"], objects["vy"] = -objects["vx"], -objects["vy"]
    return _changed(member, turned, truth=_by_frame(ends_us - truth.instants_us[::-1], objects, truth.ids))


def upside_down(member: Member) -> Member:
    """As of a camera that hangs upside down: turned by 180 degrees."""
    events, rule = member.recording.events, member.rule
    width, height = member.recording.width, member.recording.height
    turned = Events(events.t_us, _mirrored(events.x, width), _mirrored(events.y, height), events.p)
    objects = member.truth.objects.copy()
    objects["x"], objects["y"] = width - 1 - objects["x"], height - 1 - objects["y"]
    objects["vx"], objects["vy"] = -objects["vx"], -objects["vy"]
    ignore = {_OTHER_EDGE[edge]: band for edge, band in rule.ignore.items()}
    rule = replace(rule, ignore=ignore, edge_px=-1 - rule.edge_px)
    return _changed(member, turned, truth=replace(member.truth, objects=objects), rule=rule)


def transposed(member: Member) -> Member:
    """Rows and columns exchanged."""
    events, rule, truth = member.recording.events, member.rule, member.truth
    sensor = member.recording.height, member.recording.width
    objects = truth.objects.copy()
    for name, other in (("x", "y"), ("width", "height"), ("vx", "vy")):
        objects[name], objects[other] = truth.objects[other], truth.objects[name]
    ignore = {_TRANSPOSED_EDGE[edge]: band for edge, band in rule.ignore.items()}
    return _changed(
        member,
        Events(events.t_us, events.y, events.x, events.p),
        sensor,
        replace(truth, objects=objects),
        replace(rule, ignore=ignore),
    )


def halved(member: Member) -> Member:
    """Seen by a sensor with half as many pixels a side: four pixels are one; an odd last row or column is lost."""
    events = member.recording.events
    sensor = member.recording.width // 2, member.recording.height // 2
    inside = (events.x < 2 * sensor[0]) & (events.y < 2 * sensor[1])
    events = events.where(inside)
    return _scaled(member, Events(events.t_us, events.x // 2, events.y // 2, events.p), sensor, 0.5)


def doubled(member: Member, seed: Any) -> Member:
    """Seen by a sensor with twice as many pixels a side: an event comes from any of the four pixels that were one."""
    events, random = member.recording.events, np.random.default_rng(seed)
    x, y = (
        2 * axis + random.integers(0, 2, len(events), dtype=np.uint16) for axis in (events.x, events.y)
    )  # below 2^16: sensors have at most 1,280 pixels a side
    sensor = 2 * member.recording.width, 2 * member.recording.height
    return _scaled(member, Events(events.t_us, x, y, events.p), sensor, 2.0)


def at_speed(member: Member, factor: float) -> Member:
    """Everything `factor` times as fast; the age at which a track's state is no output becomes shorter with it."""
    events, truth, rule = member.recording.events, member.truth, member.rule
    start_us = int(events.t_us[0])

    def moved(t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        return start_us + np.floor((t_us - start_us) / factor).astype(np.int64)

    objects = truth.objects.copy()
    objects["vx"], objects["vy"] = objects["vx"] * factor, objects["vy"] * factor
    return _changed(
        member,
        replace(events, t_us=moved(events.t_us)),
        truth=GroundTruth(moved(truth.instants_us), objects, truth.ids),
        rule=replace(rule, max_age_us=round(rule.max_age_us / factor)),
    )


def thinned(member: Member, lost: float, seed: Any) -> Member:
    """A part of the events, chosen at random, is lost."""
    return _changed(member, without(member.recording.events, lost, seed))


def without(events: Events, lost: float, seed: Any) -> Events:
    """The events without a part of them, chosen at random."""
    return events.where(np.random.default_rng(seed).random(len(events)) >= lost)


def noisy(member: Member, hz: float, seed: Any) -> Member:
    """With background events of either polarity, `hz` a pixel and second."""
    recording = member.recording
    span_us = int(recording.events.t_us[0]), int(recording.events.t_us[-1]) + 1
    noise = poisson_noise((recording.width, recording.height), span_us, hz, np.random.default_rng(seed))
    return _changed(member, merged(recording.events, noise))


def poisson_noise(sensor: tuple[int, int], span_us: tuple[int, int], hz: float, random: np.random.Generator) -> Events:
    """Independent events of every pixel, `hz` a pixel and second, in [begin, end)."""
    count = random.poisson(hz * sensor[0] * sensor[1] * (span_us[1] - span_us[0]) * 1e-6)
    x, y = (random.integers(0, side, count, dtype=np.uint16) for side in sensor)
    return Events(np.sort(random.integers(*span_us, count)), x, y, random.integers(0, 2, count, dtype=np.uint8))


def merged(*parts: Events) -> Events:
    """Several streams as one; of events in one microsecond those of the first stream come first."""
    together = Events.joined(parts)
    order = np.argsort(together.t_us, kind="stable")
    return Events(*(getattr(together, name)[order] for name in ("t_us", "x", "y", "p")))


def spliced(member: Member, other: Member, offset_px: tuple[int, int]) -> Member:
    """Two members of one clock on a sensor that holds both, the other `offset_px` to the right and down.

    Bands in which outputs are ignored become objects that need not be found, since they no longer lie at the edges.
    """
    if not np.array_equal(member.truth.instants_us, other.truth.instants_us):
        raise ValueError(f"{member.name}, {other.name}: must have the same instants")
    right, down = offset_px
    ours, theirs = member.recording, other.recording
    sensor = max(ours.width, theirs.width + right), max(ours.height, theirs.height + down)
    moved = Events(theirs.events.t_us, theirs.events.x + np.uint16(right), theirs.events.y + np.uint16(down), theirs.events.p)
    rows, ids = [], []
    for one, at in ((member, (0, 0)), (other, offset_px)):
        objects = np.concatenate((one.truth.objects, _bands(one)))
        objects["x"] += at[0]
        objects["y"] += at[1]
        objects["object"] += len(ids)
        rows.append(objects)
        ids += [f"{at[0]},{at[1]}:{name}" for name in (*one.truth.ids, *one.rule.ignore)]
    rule = replace(member.rule, ignore={})
    return _changed(
        member, merged(ours.events, moved), sensor, _by_frame(member.truth.instants_us, np.concatenate(rows), tuple(ids)), rule
    )


def _bands(member: Member) -> NDArray[np.void]:
    """The bands that a member's rule ignores, at every instant, as objects that are not counted."""
    truth, rule = member.truth, member.rule
    objects = np.zeros((len(rule.ignore), len(truth.instants_us)), OBJECT)
    objects["frame"] = np.arange(len(truth.instants_us))
    objects["vx"] = objects["vy"] = np.nan
    low, size = rule.edge_px, (member.recording.width, member.recording.height)
    for number, (edge, band) in enumerate(rule.ignore.items()):
        wide, high = (band, size[1]) if edge in ("left", "right") else (size[0], band)
        own = objects[number]
        own["object"] = len(truth.ids) + number
        own["width"], own["height"] = wide, high
        own["x"] = low + (size[0] - wide / 2 if edge == "right" else wide / 2)
        own["y"] = low + (size[1] - high / 2 if edge == "bottom" else high / 2)
    return objects.ravel()


def _scaled(member: Member, events: Events, sensor: tuple[int, int], factor: float) -> Member:
    """Truth and rule of a member whose pixels are `factor` as long a side: pixel i's middle is at factor (i + 1/2) - 1/2."""
    objects, rule = member.truth.objects.copy(), member.rule
    for axis in ("x", "y"):
        objects[axis] = factor * (objects[axis] + 0.5) - 0.5
    for name in ("width", "height", "vx", "vy"):
        objects[name] *= factor
    rule = replace(
        rule,
        edge_px=factor * (rule.edge_px + 0.5) - 0.5,
        ignore={edge: factor * band for edge, band in rule.ignore.items()},
    )
    return _changed(member, events, sensor, replace(member.truth, objects=objects), rule)


def _changed(
    member: Member,
    events: Events,
    sensor: tuple[int, int] | None = None,
    truth: GroundTruth | None = None,
    rule: Rule | None = None,
) -> Member:
    assert truth is None or not member.alternatives  # which would have to change alike
    recording = member.recording
    recording = Recording(events, *(sensor or (recording.width, recording.height)), recording.name)
    rule = (rule or member.rule).on((recording.width, recording.height))
    return replace(member, recording=recording, truth=truth or member.truth, rule=rule)


def _mirrored(axis: NDArray[np.uint16], size: int) -> NDArray[np.uint16]:
    return np.uint16(size - 1) - axis


def _by_frame(instants_us: NDArray[np.int64], objects: NDArray[np.void], ids: tuple[str, ...]) -> GroundTruth:
    return GroundTruth(instants_us, objects[np.argsort(objects["frame"], kind="stable")], ids)

# SPDX-License-Identifier: Apache-2.0
"""The page's data, as columns of integers and a few facts about them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.timeline import OPEN, lifetimes

from .material import Material
from .objects import TRUTH, objects_of
from .pack import Column, thinned_events
from .paths import Paths, lasting, log_paths, truth_paths

__all__ = ["Collected", "collect", "looks_of"]

_LOOKS = ("hardware", "model", "software")  # sides with a look of their own
_ALIKE = {"a": "hardware", "b": "software"}  # two runs
_LABELS = {"hardware": ("hardware", "HW"), "software": ("software", "SW"), "a": ("A", "A"), "b": ("B", "B")}  # long, short
_OTHERS = 4  # looks for further engines
_BINS = 800  # of the curve of events over time
_STEPS_MAX = 8_000  # of the curve of clusters alive
_JOINT_MAX = 1 << 22  # of what may be counted without sorting
_CELLS_MAX = 2_048  # per side: of larger sensors several pixels are drawn as one


@dataclass(frozen=True)
class Collected:
    """`columns`: data to pack; `facts`: plain values; `paths`, `objects`: lives, and the numbers of their objects, of each side
    and of the truth; `shown`: events kept."""

    columns: dict[str, Column]
    facts: dict[str, Any]
    paths: dict[str, Paths]
    objects: dict[str, NDArray[np.int64]]
    shown: int


def collect(material: Material, events_max: int) -> Collected:
    """Collect the page's data, with at most `events_max` events."""
    begin_us, end_us = material.span_us
    paths = {side.name: log_paths(side.log, end_us) for side in material.sides}
    if material.truth is not None:
        paths[TRUTH] = truth_paths(material.truth.objects)
    columns, owners = _events(material, events_max)
    edges_us = np.linspace(begin_us, max(end_us, begin_us + 1), _BINS + 1)[1:-1]
    columns["rate"] = Column(np.diff(np.searchsorted(material.events.t_us, edges_us), prepend=0, append=len(material.events)))
    looks = looks_of([side.name for side in material.sides])
    sides: list[dict[str, Any]] = []
    numbers = objects_of(paths)
    for name, own in paths.items():
        side = next((side for side in material.sides if side.name == name), None)
        lives = lifetimes(side.log, end_us) if side else own.lives
        columns |= own.columns(name, begin_us) | _alive(name, lives[lasting(lives)], begin_us)
        columns[f"{name}.object"] = Column(numbers[name], delta=True)
        label, short = _LABELS.get(name, (name, name))
        sides.append(
            {
                "name": name,
                "label": label,
                "short": short,
                "ids": own.names,
                "labels": own.classes.labels,
                "look": looks.get(name, TRUTH),
                "moving": own.moving,
                "waves": side.run if side else None,
            }
        )
    facts = {
        "width": material.recording.width,
        "height": material.recording.height,
        "cell": _cell(material),
        "duration": end_us - begin_us,
        "events": len(material.events),
        "shown": len(columns["t"].values),
        "owners": owners,
        "sides": sides,
    }
    return Collected(columns, facts, paths, numbers, len(columns["t"].values))


def _cell(material: Material) -> int:
    return -(-max(material.recording.width, material.recording.height) // _CELLS_MAX)


def looks_of(names: list[str]) -> dict[str, str]:
    """The colour and dash pattern of each side, by the names that the style sheet has for them."""
    alike = {name: _ALIKE.get(name, name) for name in names}
    others = [name for name in names if alike[name] not in _LOOKS or (name == "model" and "software" in names)]
    return {name: f"other{others.index(name) % _OTHERS + 1}" if name in others else alike[name] for name in names}


def _events(material: Material, events_max: int) -> tuple[dict[str, Column], list[list[int]]]:
    """Columns of the events to show, and a table of owner codes: one owner per side for each code."""
    events, cell = material.events, _cell(material)
    kept = thinned_events(len(events), events_max)
    if len(kept) == len(events):
        kept = slice(None)  # type: ignore[assignment]
    codes, owners = _joint([side.log.owner[kept] for side in material.sides], len(events.t_us[kept]))
    t_us = events.t_us[kept] - material.span_us[0]
    columns = {
        "t": Column(t_us, delta=True, noise=True),
        "x": Column(events.x[kept] // cell, noise=True),
        "y": Column(events.y[kept] // cell, noise=True),
        "p": Column(np.packbits(events.p[kept], bitorder="little"), noise=True),
        "owner": Column(codes, noise=True),
    }
    return columns, owners


def _joint(owners: list[NDArray[np.int16]], n: int) -> tuple[NDArray[np.int64], list[list[int]]]:
    """The owners of an event on all sides as one code; the most frequent combinations get the smallest codes."""
    if not owners or not n:
        return np.zeros(n, np.int64), [[-1] * len(owners)]
    joint = np.zeros(n, np.int64)
    for owner in owners:
        joint = joint * (int(owner.max()) + 3) + owner + 2
    if int(joint.max()) > _JOINT_MAX:
        joint = np.unique(joint, return_inverse=True)[1]
    counts = np.bincount(joint)
    present = np.flatnonzero(counts)
    by_count = present[np.argsort(-counts[present], kind="stable")]
    rank = np.zeros(len(counts), np.int64)
    rank[by_count] = np.arange(len(by_count))
    first = np.zeros(len(counts), np.int64)
    first[joint[::-1]] = np.arange(n)[::-1]
    return rank[joint], [[int(owner[first[code]]) for owner in owners] for code in by_count]


def _alive(name: str, lives: NDArray[np.void], begin_us: int) -> dict[str, Column]:
    """The number of lives over time, as steps; of very many steps an even selection."""
    births_us, ends_us = np.sort(lives["birth_us"]), np.sort(lives["end_us"][lives["ended"] != OPEN])
    times_us = np.unique(np.concatenate(([begin_us], births_us, ends_us)))
    times_us = times_us[:: -(-len(times_us) // _STEPS_MAX)]
    counts = np.searchsorted(births_us, times_us, "right") - np.searchsorted(ends_us, times_us, "right")
    return {f"{name}.alive_t": Column(times_us - begin_us, delta=True), f"{name}.alive": Column(counts, delta=True)}

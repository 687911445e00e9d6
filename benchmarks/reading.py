# SPDX-License-Identifier: Apache-2.0
"""How fast files are read and written, on one thread, beside the libraries that read the same files.

One stream in every format; ours gives checked blocks of events, theirs whatever they make of the file. The files are in the
page cache.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

import streams
from evcot.events import Events
from evcot.files import open_recording, write_events
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed

__all__ = ["measure"]

_SENSOR = (streams.WIDTH, streams.HEIGHT)
_OWN_GOAL_M = 50.0  # what a decoder of our own shall reach
_LIBRARY_SHARE = 0.8  # of the library's own rate
_WRITTEN = {"aedat4": ".aedat4", "evt2": ".raw", "evt3": ".raw", "csv": ".csv", "npz": ".npz"}
# Decoded here, not by a library: a rate of their own is the goal.
_OWN = ("aedat4", "evt2", "evt3", "dat", "es", "aedat2")


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """read_* and write_* for each format, then read_*_vs_* for each library that reads it."""
    try:
        import faery
    except ImportError as missing:
        raise Skip("faery is not installed: it makes some of the files") from missing
    events = streams.joined(500_000 if quick else 4_000_000)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as place:
        files = _files(faery, events, Path(place))
        runs: dict[str, Callable[[], Timing]] = {f"read_{name}": _ours(path, len(events)) for name, path in files.items()}
        runs |= {f"faery_{name}": _faery(faery, files[name], len(events)) for name in ("aedat4", "evt2", "evt3", "dat", "es")}
        runs["h5py_hdf5"] = _h5py(files["hdf5"], len(events))
        runs |= {f"write_{name}": _writes(name, events, Path(place) / f"again{suffix}") for name, suffix in _WRITTEN.items()}
        turns = take_turns(runs, 3 if quick else 7)
    for name in runs:
        kind, _, form = name.partition("_")
        if kind in ("faery", "h5py"):
            continue
        rate = len(events) / turns.seconds(name, Clock.CPU) / 1e6
        own = kind == "read" and form in _OWN
        yield Result(
            name, rate, "M events/s", _OWN_GOAL_M if own else None, "goal" if own else "", goal=Goal(1) if own else None,
            how="CPU time",
        )  # fmt: skip
    for name in runs:
        library, _, form = name.partition("_")
        if library in ("faery", "h5py"):
            ours = f"read_{form}"
            rates = [len(events) / turns.seconds(each, Clock.CPU) / 1e6 for each in (ours, name)]
            yield Result(
                f"{ours}_vs_{library}", rates[0], "M events/s", rates[1], library,
                turns.speed_ratio(ours, name, Clock.CPU), Goal(_LIBRARY_SHARE), "CPU time",
            )  # fmt: skip


def _files(faery: Any, events: Events, folder: Path) -> dict[str, Path]:
    """The stream in every format: name -> file."""
    files = {}
    for name, suffix in _WRITTEN.items():
        files[name] = folder / f"{name}{suffix}"
        write_events(files[name], _SENSOR, [events], name)
    packet = np.zeros(len(events), faery.EVENTS_DTYPE)
    packet["t"], packet["x"], packet["y"], packet["on"] = events.t_us, events.x, events.y, events.p
    for name, options in (("dat", {"version": "dat2"}), ("es", {})):
        files[name] = folder / f"{name}.{name}"
        faery.events_stream_from_array(packet, _SENSOR).to_file(files[name], **options)
    files["aedat2"] = folder / "davis.aedat"
    files["aedat2"].write_bytes(_aedat2(events))
    files["hdf5"] = folder / "dsec.h5"
    with h5py.File(files["hdf5"], "w") as file:
        for name, values in (("t", events.t_us.astype(np.uint32)), ("x", events.x), ("y", events.y), ("p", events.p)):
            file.create_dataset(f"events/{name}", data=values, chunks=(1 << 16,))
        file["t_offset"] = np.int64(0)
    return files


def _aedat2(events: Events) -> bytes:
    """The layout of a DAVIS346: y in bits 30..22 counted from the bottom, x in 21..12 from the right, polarity in 11."""
    x, y = (np.asarray(axis, np.uint32) for axis in (streams.WIDTH - 1 - events.x, streams.HEIGHT - 1 - events.y))
    words = np.empty((len(events), 2), ">u4")
    words[:, 0] = y << 22 | x << 12 | events.p.astype(np.uint32) << 11
    words[:, 1] = events.t_us
    return b"#!AER-DAT2.0\r\n# AEChip: eu.seebetter.ini.chips.davis.Davis346blue\r\n" + words.tobytes()


def _checked(count: int, expected: int) -> None:
    assert count == expected, f"{count} events of {expected}"


def _ours(path: Path, expected: int) -> Callable[[], Timing]:
    def work() -> None:
        with open_recording(path, _SENSOR) as file:
            _checked(sum(len(block) for block in file.blocks()), expected)

    return lambda: timed(work)


def _faery(faery: Any, path: Path, expected: int) -> Callable[[], Timing]:
    def work() -> None:
        stream = faery.events_stream_from_file(path, dimensions_fallback=_SENSOR)
        _checked(sum(len(packet) for packet in stream), expected)

    return lambda: timed(work)


def _h5py(path: Path, expected: int) -> Callable[[], Timing]:
    def work() -> None:
        with h5py.File(path) as file:
            columns: list[NDArray[Any]] = [file[f"events/{name}"][:] for name in "txyp"]
            _checked(len(columns[0]), expected)

    return lambda: timed(work)


def _writes(name: str, events: Events, path: Path) -> Callable[[], Timing]:
    def work() -> None:
        write_events(path, _SENSOR, [events], name)

    def run() -> Timing:
        path.unlink(missing_ok=True)
        timing = timed(work)
        assert os.path.getsize(path)
        return timing

    return run

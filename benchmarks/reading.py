# SPDX-License-Identifier: Apache-2.0
"""Speed of reading and writing files, compared with libraries for the same formats; wall time, since evcot decodes ahead.

One stream in every format, in the page cache. Ours gives checked blocks of events, theirs what they make of the file: h5py the
columns as they are stored, rosbags an object of every event (of a few messages only); raw_mcap is rosbags without decoding.
HDF5 is opened outside the reading and has its own row for that: a child process looks such a file over first.
"""

from __future__ import annotations

import os
import struct
import tempfile
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

import streams
from evcot.events import Events
from evcot.recordings.files import RecordingFile, open_recording, write_events
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed

__all__ = ["measure"]

_SENSOR = (streams.WIDTH, streams.HEIGHT)
_OWN_GOAL_M = 50.0  # what a decoder of our own shall reach
_LIBRARY_SHARE = 0.8  # of the library's own rate
_WRITTEN = {"aedat4": ".aedat4", "evt2": ".raw", "evt3": ".raw", "csv": ".csv", "npz": ".npz"}
# Decoded here, not by a library: a rate of their own is the goal.
_OWN = ("aedat4", "evt2", "evt3", "dat", "es", "aedat2", "aedat3", "csv")
_LIBRARIES = ("faery", "h5py", "rosbags")
_MESSAGE_EVENTS = 10_000
_MESSAGES_DECODED = 5
_EVENT_ARRAY = "dvs_msgs/msg/EventArray"


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
        runs["open_hdf5"] = lambda: timed(lambda: open_recording(files["hdf5"], _SENSOR).__exit__(None, None, None))
        runs["rosbags_mcap"] = _rosbags(files["mcap"], _MESSAGES_DECODED, decoded=True)
        runs["raw_mcap"] = _rosbags(files["mcap"], len(events) // _MESSAGE_EVENTS, decoded=False)
        runs |= {f"write_{name}": _writes(name, events, Path(place) / f"again{suffix}") for name, suffix in _WRITTEN.items()}
        turns = take_turns(runs, 3 if quick else 7)
    decoded = dict.fromkeys(runs, len(events)) | {"rosbags_mcap": _MESSAGES_DECODED * _MESSAGE_EVENTS}
    rates = {name: decoded[name] / turns.seconds(name, Clock.WALL) / 1e6 for name in runs}
    yield Result("open_hdf5", 1e3 * turns.seconds("open_hdf5", Clock.WALL), "ms", how="wall time")
    for name, rate in rates.items():
        kind, _, form = name.partition("_")
        if kind == "read" and form in _OWN:
            yield Result(name, rate, "M events/s", _OWN_GOAL_M, "goal", goal=Goal(1), how="wall time")
        elif kind in ("read", "write", "raw"):
            yield Result(name, rate, "M events/s", how="wall time")
        elif kind in _LIBRARIES:
            ours = rates[f"read_{form}"]
            ratio = ours / rate
            yield Result(f"read_{form}_vs_{kind}", ours, "M events/s", rate, kind, ratio, Goal(_LIBRARY_SHARE), "wall time")


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
    files["aedat3"] = folder / "dvs.aedat"
    files["aedat3"].write_bytes(_aedat3(events))
    files["mcap"] = _mcap(events, folder / "bag")
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


def _aedat3(events: Events) -> bytes:
    """Polarity packets of 1,000 events: data with x in bits 31..17, y in 16..2, polarity in 1, valid in 0; then the time."""
    words = np.empty((len(events), 2), "<u4")
    words[:, 0] = events.x.astype(np.uint32) << 17 | events.y.astype(np.uint32) << 2 | events.p.astype(np.uint32) << 1 | 1
    words[:, 1] = events.t_us
    packets = (words[begin : begin + 1000] for begin in range(0, len(words), 1000))
    return b"#!AER-DAT3.1\r\n#Source 1: DAVIS346\r\n#!END-HEADER\r\n" + b"".join(
        struct.pack("<hh6i", 1, 1, 8, 4, 0, len(each), len(each), len(each)) + each.tobytes() for each in packets
    )


def _mcap(events: Events, folder: Path) -> Path:
    """A ROS 2 bag of dvs_msgs/EventArray, whose bytes are laid out here: the library would make an object of every event."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/dvs/events", _EVENT_ARRAY, typestore=_message_types())
        for begin in range(0, len(events), _MESSAGE_EVENTS):
            part = events[begin : begin + _MESSAGE_EVENTS]
            writer.write(topic, 1000 * int(part.t_us[-1]), _event_array(part))
    return next(folder.glob("*.mcap"))


def _message_types() -> Any:
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    event = "uint16 x\nuint16 y\nbuiltin_interfaces/Time ts\nbool polarity\n"
    array = "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events\n"
    store.register(get_types_from_msg(event, "dvs_msgs/msg/Event"))
    store.register(get_types_from_msg(array, _EVENT_ARRAY))
    return store


def _event_array(events: Events) -> bytes:
    """A message in CDR: the first event's x follows the head at once, any other's stands behind a gap of one byte."""
    head = struct.pack("<HxxiiI7sxIII", 1 << 8, 0, 0, 7, b"camera", streams.HEIGHT, streams.WIDTH, len(events))
    names, formats = ["x", "y", "s", "ns", "p"], ["<u2", "<u2", "<i4", "<u4", "u1"]
    row = np.dtype({"names": names, "formats": formats, "offsets": [0, 2, 6, 10, 14], "itemsize": 16})
    rows = np.zeros(len(events), row)
    rows["x"], rows["y"], rows["p"] = events.x, events.y, events.p
    rows["s"], rows["ns"] = events.t_us // 1_000_000, events.t_us % 1_000_000 * 1000
    first = struct.pack("<HH", events.x[0], events.y[0])
    return head + first + bytes(rows.tobytes()[6:-1])


def _checked(count: int, expected: int) -> None:
    assert count == expected, f"{count} events of {expected}"


def _ours(path: Path, expected: int) -> Callable[[], Timing]:
    def all_of(file: RecordingFile) -> None:
        _checked(sum(len(block) for block in file.blocks()), expected)

    def whole() -> None:
        with open_recording(path, _SENSOR) as file:
            all_of(file)

    def opened() -> Timing:
        with open_recording(path, _SENSOR) as file:
            return timed(lambda: all_of(file))

    return opened if path.suffix == ".h5" else lambda: timed(whole)


def _faery(faery: Any, path: Path, expected: int) -> Callable[[], Timing]:
    def work() -> None:
        stream = faery.events_stream_from_file(path, dimensions_fallback=_SENSOR)
        _checked(sum(len(packet) for packet in stream), expected)

    return lambda: timed(work)


def _h5py(path: Path, expected: int) -> Callable[[], Timing]:
    def all_of(file: h5py.File) -> None:
        columns: list[NDArray[Any]] = [file[f"events/{name}"][:] for name in "txyp"]
        _checked(len(columns[0]), expected)

    def opened() -> Timing:
        with h5py.File(path) as file:
            return timed(lambda: all_of(file))

    return opened


def _rosbags(path: Path, messages: int, *, decoded: bool) -> Callable[[], Timing]:
    """The library on the first messages: taken apart into events, or only handed over."""
    from rosbags.rosbag2.storage_mcap import McapReader

    store = _message_types()

    def work() -> None:
        reader = McapReader(path)
        reader.open()
        for _, _, data in islice(reader.messages(list(reader.connections)), messages):
            if decoded:
                _checked(len(store.deserialize_cdr(data, _EVENT_ARRAY).events), _MESSAGE_EVENTS)
        reader.close()

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

# SPDX-License-Identifier: Apache-2.0
"""Survey of an HDF5 file's content, in a separate process.

On damaged metadata the HDF5 library may never return: it hung on two of 4,000 corruptions of a small file. So all metadata
that are needed before numbers can be read are collected by a child process, which can be killed. The child runs this file as
a script: nothing of the package is imported at its top.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

__all__ = ["NAMES", "Part", "Survey", "survey"]

Survey = dict[str, Any]
Part = dict[str, Any]

SECONDS = 20.0
# Groups of events, and the time index that may accompany them: DSEC, the packagers for E2VID, and v2e, which once said
# "event"; Prophesee; M3ED; MVSEC.
_PLACES: tuple[tuple[str, str], ...] = (
    ("events", "ms_to_idx"),
    ("event", ""),
    ("CD/events", ""),
    ("prophesee/left", "prophesee/left/ms_map_idx"),
    ("prophesee/right", "prophesee/right/ms_map_idx"),
    ("davis/left/events", ""),
    ("davis/right/events", ""),
    ("/", "ms_to_idx"),
)
# What the fields of an event are called, here and in the other formats whose columns have names.
NAMES = {
    "t": ("t", "ts", "timestamps", "timestamp", "time"),
    "x": ("x", "xs", "x_coordinates"),
    "y": ("y", "ys", "y_coordinates"),
    "p": ("p", "ps", "polarity", "polarities", "pol", "on"),
}
# A row per event: of floating-point numbers in MVSEC, of whole ones in v2e.
_FLOAT_MATRIX = {"x": 0, "y": 1, "t": 2, "p": 3}
_WHOLE_MATRIX = {"t": 0, "x": 1, "y": 2, "p": 3}
_DEEPEST_GROUP, _MOST_GROUPS = 4, 1000  # in which events are looked for where no place is a known one
# A dataset in a single compressed chunk has to be in memory as a whole, and so has every other column.
_MOST_CHUNK_BYTES = 1 << 28
_MOST_MEMORY_BYTES = 1 << 29  # limit for the survey process itself


def survey(path: Path, *, matlab: bool = False, first: str = "") -> Survey:
    """Survey a file: "columns" (for each of t, x, y, p the dataset, the field or column to pick, its rows per chunk, its
    filters), "count", "t_offset", "index", "sensor", "details", and the "others" that hold events.

    Args:
        matlab: accept any struct with the fields x, y, p, ts, and variables of these names, which may be matrices of one row;
            or, without them, a matrix of four columns, which are then called 0 to 3.
        first: the struct or matrix to take of several, if it is there.

    Raises:
        RecordingError: the file holds no events in a known layout, or its metadata are damaged.
    """
    from ...errors import RecordingError
    from .printable import printable

    command = [sys.executable, "-P", __file__, str(path.absolute()), "matlab" if matlab else "", first]
    try:
        child = subprocess.run(command, capture_output=True, timeout=SECONDS, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        raise RecordingError(
            f"the HDF5 library did not finish reading the file's structure within {SECONDS:g} s: is it damaged?"
        ) from None
    try:
        found: Survey = json.loads(child.stdout)
    except ValueError:
        output = child.stderr.decode(errors="replace").strip().splitlines()[-1:] or [f"status {child.returncode}"]
        raise RecordingError(f"the HDF5 library crashed ({printable(output[0])}): is the file damaged?") from None
    if "error" in found:
        raise RecordingError(printable(found["error"]))
    return found


class _Refusal(Exception):
    """A file that violates a rule; the message is shown to the user."""


def _survey(path: str, matlab: bool, first: str) -> Survey:
    import h5py

    _bound_memory()
    with h5py.File(path, "r") as file:
        size = Path(path).stat().st_size
        places = [*((name, "") for name in file if name != "#refs#"), ("/", "")] if matlab else _PLACES
        present = sorted((place for place in places if _is_here(file, place[0])), key=lambda place: place[0] != first)
        if not any(_columns(file[place]) for place, _ in present):
            present = [(place, "") for place in _groups(file)]
        for at, (place, index) in enumerate(present):
            columns = _columns(file[place])
            if columns and (not matlab or isinstance(file[place], h5py.Group)):
                counts = {field: _check(file[part["dataset"]], part, size, matlab) for field, part in columns.items()}
                held_bytes = sum({part["dataset"]: part["chunk_bytes"] for part in columns.values()}.values())
                if held_bytes > _MOST_CHUNK_BYTES:
                    raise _Refusal(
                        f"{place}: compressed chunks of {held_bytes} bytes: must be at most {_MOST_CHUNK_BYTES} in all"
                    )
                if len(set(counts.values())) > 1:
                    held = ", ".join(f"{part['dataset']} {counts[field]}" for field, part in columns.items())
                    raise _Refusal(f"{held} values: all must be the same")
                others = [other for other, _ in present[at + 1 :] if other != "/" and _columns(file[other])]
                return {
                    "columns": columns,
                    "count": counts["t"],
                    "t_offset": _offset(file) if place in ("events", "/") else 0,
                    "index": _index(file, index, size),
                    "sensor": _sensor(file, place),
                    "others": others,
                    "details": {"events": place} | ({"also holds": ", ".join(others)} if others else {}),
                }
        matrices = _matrices(file) if matlab else {}
        if matrices:
            name = first if first in matrices else max(sorted(matrices), key=lambda each: matrices[each]["0"]["rows"])
            for part in matrices[name].values():
                _check(file[name], part, size, matlab)
            return {
                "columns": matrices[name],
                "count": matrices[name]["0"]["rows"],
                "others": [other for other in matrices if other != name],
                "details": {"events": name},
            }
        found = ", ".join(sorted(file)[:8]) or "nothing"
        raise _Refusal(f"holds no events in a known layout: has {found} at its top level")


def _matrices(file: Any) -> dict[str, dict[str, Part]]:
    """The columns of each matrix of four, which MATLAB stores as four rows."""
    import h5py

    found: dict[str, dict[str, Part]] = {}
    for name in file:
        matrix = file[name]
        if isinstance(matrix, h5py.Dataset) and matrix.ndim == 2 and matrix.shape[0] == 4 and matrix.dtype.kind in "iuf":
            own = _part(matrix, None)
            own |= {"axis": 1, "rows": matrix.shape[1], "chunk": matrix.chunks[1] if own["chunk_bytes"] else 1}
            found[name] = {str(line): own | {"line": line} for line in range(4)}
    return found


def _groups(file: Any) -> list[str]:
    """The groups, in order, whose members have the names of t, x, y and p; down to a depth, and not all of a huge file."""
    found: list[str] = []
    waiting = [(name, 1) for name in sorted(file)]
    for name, depth in waiting:
        if len(waiting) > _MOST_GROUPS or not hasattr(file[name], "keys"):
            continue
        if _columns(file[name]):
            found.append(name)
        elif depth < _DEEPEST_GROUP:
            waiting += [(f"{name}/{member}", depth + 1) for member in sorted(file[name])]
    return found


def _is_here(file: Any, name: str) -> bool:
    """Whether the path exists; each step is looked up in its group's list of members."""
    at = file
    for step in name.strip("/").split("/"):
        if step and (not hasattr(at, "keys") or step not in at):
            return False
        at = at[step] if step else at
    return True


def _columns(found: Any) -> dict[str, Part]:
    """The location of each of t, x, y, p; empty if this is not a list of events."""
    import h5py

    if isinstance(found, h5py.Dataset):
        picks: dict[str, Any]
        if found.dtype.names:
            picks = {field: _alias(names, found.dtype.names) for field, names in NAMES.items()}
        else:
            matrix = _FLOAT_MATRIX if found.dtype.kind == "f" else _WHOLE_MATRIX
            picks = dict(matrix) if found.ndim == 2 and found.shape[1] == len(matrix) else {}
        return {field: _part(found, pick) for field, pick in picks.items()} if picks and None not in picks.values() else {}
    if not isinstance(found, h5py.Group):
        return {}
    members = list(found)
    aliases = {field: _alias(names, members) for field, names in NAMES.items()}
    if None in aliases.values():
        return {}
    datasets = {field: found[name] for field, name in aliases.items()}
    if not all(isinstance(dataset, h5py.Dataset) for dataset in datasets.values()):
        return {}
    return {field: _part(dataset, None) for field, dataset in datasets.items()}


def _alias(names: tuple[str, ...], present: Any) -> str | None:
    return next((name for name in names if name in present), None)


def _part(dataset: Any, pick: str | int | None) -> Part:
    creation = dataset.id.get_create_plist()
    filters = [creation.get_filter(i) for i in range(creation.get_nfilters())]
    axis = 1 if pick is None and dataset.ndim == 2 and dataset.shape[0] == 1 else 0  # MATLAB's row vectors
    packed = dataset.chunks if filters else None
    chunk_bytes = dataset.dtype.itemsize
    for side in packed or ():
        chunk_bytes *= side
    return {
        "dataset": dataset.name,
        "pick": pick,
        "axis": axis,
        "line": 0,
        "chunk": packed[axis] if packed else 1,
        "chunk_bytes": chunk_bytes if packed else 0,
        "filters": [[int(each[0]), each[3].decode(errors="replace")] for each in filters],
    }


def _check(dataset: Any, part: Part, file_bytes: int, matlab: bool) -> int:
    """The number of values in the dataset; raises unless all of them are stored in the file."""
    name, pick = dataset.name, part["pick"]
    dtype = dataset.dtype[pick] if isinstance(pick, str) else dataset.dtype
    flat = dataset.shape is not None and (
        dataset.ndim == 1 or (dataset.ndim == 2 and (part["axis"] or 1 in dataset.shape if matlab else pick is not None))
    )
    if not flat or dtype.kind not in "iufb" or dtype.itemsize > 8:
        raise _Refusal(f"{name}: is {dataset.shape} of {dtype}: must be a list of numbers")
    if dataset.is_virtual or dataset.external:
        raise _Refusal(f"{name}: lies in another file: must be in this one")
    if not dataset.size:
        return 0
    if dataset.chunks:
        chunks = 1
        for length, chunk in zip(dataset.shape, dataset.chunks, strict=True):
            chunks *= -(-length // chunk)
        held = dataset.id.get_num_chunks()
        if held != chunks:
            raise _Refusal(f"{name}: holds {held} of {chunks} chunks: must hold all")
    elif dataset.id.get_storage_size() != dataset.nbytes or (dataset.id.get_offset() or 0) + dataset.nbytes > file_bytes:
        raise _Refusal(f"{name}: of its {dataset.nbytes} bytes not all are in the file; is it cut off?")
    return int(dataset.shape[part["axis"]] if pick is not None or part["axis"] else dataset.size)


def _index(file: Any, name: str, file_bytes: int) -> Part | None:
    """The time index, if there is a usable one."""
    if not name or not _is_here(file, name) or file[name].shape is None or file[name].ndim != 1:
        return None
    part = _part(file[name], None)
    try:
        _check(file[name], part, file_bytes, False)
    except _Refusal:
        return None
    return part if part["chunk_bytes"] <= _MOST_CHUNK_BYTES else None


def _bound_memory() -> None:
    """Limit the memory of this process, where the system supports it: a chunk may expand to any size."""
    try:
        import resource

        now_bytes = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (now_bytes + _MOST_MEMORY_BYTES,) * 2)
    except (ImportError, OSError, ValueError):
        return


def _offset(file: Any) -> int:
    """DSEC: offset to add to every time, in microseconds."""
    if "t_offset" not in file:
        return 0
    offset = file["t_offset"]
    if offset.size != 1 or offset.dtype.kind not in "iu":
        raise _Refusal(f"t_offset: is {offset.shape} of {offset.dtype}: must be one whole number of microseconds")
    value = int(offset[()].item())
    if abs(value) >= 1 << 62:
        raise _Refusal(f"t_offset = {value}: must be below 2^62")
    return value


def _sensor(file: Any, place: str) -> list[int] | None:
    """(width, height) from the attributes of the group or its parents; or from datasets beside its columns, as in M3ED."""
    import h5py

    above = [place.rsplit("/", depth)[0] for depth in range(place.count("/") + 1)] if place != "/" else []
    for name in [*above, "/"]:
        attributes = dict(file[name].attrs)
        geometry = attributes.get("geometry", "")
        geometry = geometry.decode(errors="replace") if isinstance(geometry, bytes) else str(geometry)
        readings: tuple[list[Any], ...] = (
            [attributes.get("width"), attributes.get("height")],
            geometry.split("x"),
            _listed(attributes.get("sensor_resolution"))[1::-1],  # has the height first
            _listed(attributes.get("resolution")),
        )
        for sides in readings:
            if len(sides) == 2 and all(str(side).strip().isdecimal() and len(str(side)) < 20 for side in sides):
                return [int(side) for side in sides]
    sides = [file.get(f"{place}/{name}") for name in ("width", "height")]
    if all(isinstance(side, h5py.Dataset) and side.size == 1 and side.dtype.kind in "iu" for side in sides):
        return [int(side[()].item()) for side in sides]
    beside = f"{place}/calib/resolution"
    if place.startswith("prophesee") and _is_here(file, beside) and file[beside].shape == (2,):
        return [int(side) for side in file[beside][()]]
    return None


def _listed(value: Any) -> list[Any]:
    """Up to three numbers of an array; an empty list for anything else."""
    return list(value.flat[:3]) if hasattr(value, "flat") else []


def _main() -> None:
    path, kind, first = sys.argv[1:]
    try:
        found = _survey(path, kind == "matlab", first)
    except _Refusal as error:
        found = {"error": str(error)}
    except Exception as error:
        # Any exception of h5py here is caused by the file.
        found = {"error": f"its HDF5 tables are damaged: {error or type(error).__name__}"}
    print(json.dumps(found))


if __name__ == "__main__":
    _main()

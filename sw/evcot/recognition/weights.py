# SPDX-License-Identifier: Apache-2.0
"""A trained classifier as a file: weights, registers and classes, with the tracker that they belong to and a checksum.

Rules S of docs/recognition.md: size and speed of a track, with the hardware's verdict, to its class, in software.
"""

from __future__ import annotations

import zipfile
import zlib
from dataclasses import astuple, dataclass, field, fields, replace
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError, reason_of
from ..hardware.classifier import LOSS_MAX, VERSION, RecognitionRegisters
from ..outputs import note_input, written_aside
from ..tracks.record import ClassNames, check_class_name
from .model import Network

__all__ = ["MOTION_INPUTS", "SPEED_FLOOR_PX_S", "Weights", "class_indices", "inputs_of"]

MOTION_INPUTS = 4  # of rule S2 besides those of the classes: width, height, speed, 1
SPEED_FLOOR_PX_S = 20.0  # added to a speed before its logarithm: slower objects stand still (tuned on the validation set)


def inputs_of(
    winner: NDArray[np.int64], margin: NDArray[np.int64], windows: NDArray[np.int64], states: NDArray[np.void], classes: int
) -> NDArray[np.float64]:
    """Rule S2: (n, classes + MOTION_INPUTS), from verdicts of the network's classes and the newest records of their tracks."""
    inputs = np.zeros((len(winner), classes + MOTION_INPUTS))
    inputs[np.arange(len(winner)), winner] = np.log2(1 + windows) * margin / (LOSS_MAX * windows)
    speed = np.hypot(states["vx"], states["vy"])
    motion = np.maximum(states["width"], 1.0), np.maximum(states["height"], 1.0), speed + SPEED_FLOOR_PX_S
    inputs[:, classes:-1] = np.log(np.stack(motion, axis=1))
    inputs[:, -1] = 1.0
    return inputs


def class_indices(size_speed: NDArray[np.float64], raw: NDArray[np.void], states: NDArray[np.void]) -> NDArray[np.int64]:
    """Rules S1 and S3: the class of each verdict, (n,) int64; classes that the network does not have stay.

    Args:
        size_speed: (classes + MOTION_INPUTS, classes), of `Weights`.
        raw: of dtype `RAW_VERDICT`.
        states: of dtype `TRACK`, the newest record of each verdict's track.
    """
    winner, margin, windows = (raw[name].astype(np.int64) for name in ("class", "margin", "windows"))
    known = winner < size_speed.shape[1]
    inputs = inputs_of(winner[known], margin[known], windows[known], states[known], size_speed.shape[1])
    winner[known] = np.argmax(inputs @ size_speed, axis=1)
    return winner


_ARRAY_BYTES_MAX = 1 << 16  # of a file's array, which may claim anything
_ARRAYS = ("version", "tracker", "registers", "class_ids", "class_names", "w1", "w2", "size_speed", "checksum")


@dataclass(frozen=True, eq=False)
class Weights:
    """A trained classifier.

    Attributes:
        network: its weights.
        registers: of the classifier; K is 2^window_log2.
        class_ids: the number that labels give each class, in the order of the network.
        tracker: name of the module whose owned events it was trained on.
        class_names: of the classes, in the same order; a class that labels do not name has its number.
        size_speed: (classes + MOTION_INPUTS, classes) float64, weights of rules S; (0, 0) for none.

    Raises:
        ConfigError: class numbers that are not one for each class of network and registers, or occur twice; the same of names;
            `size_speed` of another shape or type, or with a value that is not finite.
    """

    network: Network
    registers: RecognitionRegisters
    class_ids: tuple[int, ...]
    tracker: str = "cot_motion"
    class_names: tuple[str, ...] = ()
    size_speed: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        count = self.network.w2.shape[1]
        if not len(set(self.class_ids)) == len(self.class_ids) == count == self.registers.classes:
            shown = ", ".join(map(str, self.class_ids))
            raise ConfigError(f"class_ids = {shown}: must be {count} different numbers, as w2 and registers have classes")
        if not self.class_names:
            object.__setattr__(self, "class_names", tuple(map(str, self.class_ids)))
        for name in self.class_names:
            check_class_name(name)
        if not len(set(self.class_names)) == len(self.class_names) == count:
            shown = ", ".join(self.class_names)
            raise ConfigError(f"class_names = {shown}: must be {count} different names, one for each of class_ids")
        table = self.size_speed
        if table.dtype != np.float64 or table.shape not in ((0, 0), (count + MOTION_INPUTS, count)):
            wanted = f"({count + MOTION_INPUTS}, {count}) or (0, 0) float64"
            raise ConfigError(f"size_speed is {table.shape} {table.dtype}: must be {wanted}")
        if not np.isfinite(table).all():
            raise ConfigError("size_speed: must be finite numbers")

    def named(self, names: ClassNames) -> Weights:
        """The same with these names of its classes.

        Raises:
            ConfigError: two classes with one name.
        """
        return replace(self, class_names=tuple(names.get(number, str(number)) for number in self.class_ids))

    @property
    def names(self) -> ClassNames:
        """The name of each class by its number."""
        return dict(zip(self.class_ids, self.class_names, strict=True))

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write an npz file; equal weights give equal files.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        arrays = self._arrays() | {"checksum": np.array(self.checksum)}
        with written_aside(Path(path), force=force) as file, zipfile.ZipFile(file, "w") as archive:
            for name in _ARRAYS:
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as member:
                    np.lib.format.write_array(member, arrays[name], allow_pickle=False)

    @classmethod
    def load(cls, path: Path | str) -> Weights:
        """Read a file that `save` wrote.

        Raises:
            ConfigError: the file is missing, damaged, of another version, or has weights of another shape: names the file.
        """
        arrays = _read(Path(path))
        version = arrays["version"]
        if version.ndim or version != VERSION:
            raise ConfigError(f"{path}: version = {version}: must be {VERSION}: train again")
        checksum = str(arrays.pop("checksum"))
        if checksum != _checksum(arrays):
            raise ConfigError(f"{path}: checksum = {checksum!r}: must be {_checksum(arrays)!r}: the file is damaged")
        for name, count in (("registers", len(fields(RecognitionRegisters))), ("class_ids", arrays["class_ids"].size)):
            array = arrays[name]
            if array.dtype != np.int64 or array.shape != (count,):
                raise ConfigError(f"{path}: {name} is {array.shape} {array.dtype}: must be ({count},) int64")
        try:
            registers = RecognitionRegisters(*arrays["registers"].tolist())
            class_ids = tuple(arrays["class_ids"].tolist())
            names = tuple(str(name) for name in arrays["class_names"].ravel().tolist())
            network = Network(arrays["w1"], arrays["w2"])
            return cls(network, registers, class_ids, str(arrays["tracker"]), names, arrays["size_speed"])
        except ConfigError as error:
            raise ConfigError(f"{path}: {error}") from error

    @property
    def checksum(self) -> str:
        """As in the file."""
        return _checksum(self._arrays())

    def _arrays(self) -> dict[str, NDArray[Any]]:
        return {
            "version": np.array(VERSION), "tracker": np.array(self.tracker),
            "registers": np.array(astuple(self.registers), np.int64), "class_ids": np.array(self.class_ids, np.int64),
            "class_names": np.array(self.class_names, np.str_),
            "w1": self.network.w1, "w2": self.network.w2, "size_speed": self.size_speed,
        }  # fmt: skip


def _checksum(arrays: dict[str, NDArray[Any]]) -> str:
    made_of = blake2b(digest_size=8)
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        made_of.update(f"{name} {array.dtype.str} {array.shape} ".encode() + array.tobytes())
    return made_of.hexdigest()


def _read(path: Path) -> dict[str, NDArray[Any]]:
    note_input(path)
    try:
        with path.open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise ConfigError(f"{path}: is a single array: must be weights that evcot train wrote")
            missing = [name for name in _ARRAYS if name not in archive.files]
            if missing:
                raise ConfigError(f"{path}: has no array {missing[0]}: must be weights that evcot train wrote: train again")
            assert archive.zip is not None
            for name in _ARRAYS:
                if archive.zip.getinfo(f"{name}.npy").file_size > _ARRAY_BYTES_MAX:
                    rule = f"must be at most {_ARRAY_BYTES_MAX} bytes, as in weights that evcot train wrote"
                    raise ConfigError(f"{path}: {name} is longer: {rule}")
            return {name: archive[name] for name in _ARRAYS}
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    except (ValueError, EOFError, KeyError, MemoryError, zipfile.BadZipFile, zlib.error) as error:
        if isinstance(error, ConfigError):
            raise
        raise ConfigError(f"{path}: is damaged, or no npz file: must be weights that evcot train wrote") from error

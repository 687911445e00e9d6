# SPDX-License-Identifier: Apache-2.0
"""The golden model of the classifier: tables around the compiled kernels. docs/recognition.md specifies the rules."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..hardware.classifier import CELLS, CLASSES_MAX, HIDDEN, RAW_VERDICT, RecognitionRegisters
from ._windows import FIELD_COUNT, FRESH, GLOBAL_COUNT, fill, judge

__all__ = ["Classifier", "Network", "OwnedEvents", "Windows"]

_RUN_WINDOWS = 1024  # of the compiled loop's buffers


class OwnedEvents(NamedTuple):
    """What the tracker decides on a run of n events; those without an owner do not count.

    Attributes:
        owner: (n,) int16, the slot, or a negative number.
        rel_x, rel_y: (n,) uint16, `dx` and `dy` modulo 2^rel_w.
        visible: (n,) bool, whether the owner is visible.
    """

    owner: NDArray[np.int16]
    rel_x: NDArray[np.uint16]
    rel_y: NDArray[np.uint16]
    visible: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Network:
    """The weights of the network.

    Attributes:
        w1: (CELLS^2, HIDDEN) int8, cells row by row from the lowest y.
        w2: (HIDDEN, classes) int8.

    Raises:
        ConfigError: another shape, or another type.
    """

    w1: NDArray[np.int8]
    w2: NDArray[np.int8]

    def __post_init__(self) -> None:
        of_w1, of_w2 = [(CELLS**2, HIDDEN)], [(HIDDEN, classes) for classes in range(2, CLASSES_MAX + 1)]
        for name, array, shapes, wanted in (
            ("w1", self.w1, of_w1, f"({CELLS**2}, {HIDDEN})"),
            ("w2", self.w2, of_w2, f"({HIDDEN}, 2 to {CLASSES_MAX})"),
        ):
            if array.dtype != np.int8 or array.shape not in shapes:
                raise ConfigError(f"{name} is {array.shape} {array.dtype}: must be {wanted} int8")


class Closed(NamedTuple):
    """Windows in the order in which they closed.

    Attributes:
        event: (n,) int64, index of the closing event in the run.
        slot: (n,) int64.
        stage: (n,) uint8, 0 for the first window of a track, 1 for its second, else 2.
        images: (n, CELLS^2) uint8.
    """

    event: NDArray[np.int64]
    slot: NDArray[np.int64]
    stage: NDArray[np.uint8]
    images: NDArray[np.uint8]


class Windows:
    """Owned events to windows, as a stream: rules W, N, F and Q.

    Args:
        n_slots: of the tracker.
        rel_w: bits of a relative address.
    """

    def __init__(self, registers: RecognitionRegisters, n_slots: int, rel_w: int) -> None:
        self._registers, self._rel_w = registers, rel_w
        self._state = np.zeros((n_slots, FIELD_COUNT), np.int64)
        self._state[:, FRESH] = 1
        self._globals = np.zeros(GLOBAL_COUNT + n_slots + 1, np.int64)
        self._cells = np.zeros((n_slots, CELLS**2), np.uint8)
        self._closed = np.zeros((_RUN_WINDOWS, 2), np.int64)
        self._stages = np.zeros(_RUN_WINDOWS, np.uint8)
        self._images = np.zeros((_RUN_WINDOWS, CELLS**2), np.uint8)

    def feed(self, events: OwnedEvents) -> Iterator[Closed]:
        """The windows that a run of events closes, in parts, each valid until the next one is asked for."""
        done = 0
        registers = self._registers
        while done < len(events.owner):
            done, count = fill(
                self._state, self._globals, self._cells, registers.window_log2, registers.scale_start, self._rel_w,
                *events, done, self._closed, self._stages, self._images,
            )  # fmt: skip
            yield Closed(self._closed[:count, 0], self._closed[:count, 1], self._stages[:count], self._images[:count])


class Classifier:
    """The golden model of the classifier as a stream: the result does not depend on how events are split into runs.

    Args:
        registers, network: the number of classes is that of the network.
        n_slots, rel_w: as of `Windows`.

    Raises:
        ConfigError: another number of classes in the registers.
    """

    def __init__(self, registers: RecognitionRegisters, network: Network, n_slots: int, rel_w: int) -> None:
        self._n_slots, self._rel_w = n_slots, rel_w
        self._seen = 0
        self.write(registers, network)

    def write(self, registers: RecognitionRegisters, network: Network) -> None:
        """Change registers and weights before the next event (rules R1 and R2): the windows of all slots begin anew.

        Raises:
            ConfigError: as of the class.
        """
        classes = network.w2.shape[1]
        if registers.classes != classes:
            raise ConfigError(f"recognition.classes = {registers.classes}: must be {classes}, as of w2")
        self._registers = registers
        self._windows = Windows(registers, self._n_slots, self._rel_w)
        self._w1, self._w2 = network.w1.astype(np.int32), network.w2.astype(np.int32)
        self._votes = np.zeros((self._n_slots, classes), np.int64)
        self._voted = np.zeros(self._n_slots, np.int64)

    def feed(self, events: OwnedEvents) -> NDArray[np.void]:
        """Verdicts of a run of events, (m,) of dtype `RAW_VERDICT`; see `Windows.feed`."""
        registers = self._registers
        rows = []
        for closed in self._windows.feed(events):
            out = np.zeros((len(closed.stage), 5), np.int64)
            pairs = np.stack((closed.event + self._seen, closed.slot), axis=1)
            count = judge(
                self._w1, self._w2, registers.shift_1, registers.shift_2, registers.margin_min,
                pairs, closed.stage, closed.images, self._votes, self._voted, out,
            )  # fmt: skip
            rows.append(out[:count])
        self._seen += len(events.owner)
        table = np.concatenate([np.zeros((0, 5), np.int64), *rows])
        verdicts = np.zeros(len(table), RAW_VERDICT)
        for name, column in zip(RAW_VERDICT.names or (), table.T, strict=True):
            verdicts[name] = column
        return verdicts

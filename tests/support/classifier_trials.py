# SPDX-License-Identifier: Apache-2.0
"""The RTL of the classifier next to its golden model: owned events, writes of registers and weights, verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evcot.hardware.classifier import CELLS, CLASSES_MAX, HIDDEN, RecognitionRegisters
from evcot.ranges import ranges_of
from evcot.recognition.model import Classifier, Network
from evcot.recognition.model import OwnedEvents as ModelEvents
from evcot.recognition.weight_memory import REGISTER_ADDRESSES, memory_words

from .stream_device import Bundle, StreamDevice, StreamRun

__all__ = [
    "VERDICT_FIELDS",
    "ClassifierTrial",
    "OwnedEvents",
    "candidate",
    "joined",
    "model_verdicts",
    "object_events",
    "random_network",
    "random_owned",
    "random_registers",
]

VERDICT_FIELDS = ("slot", "id", "seq", "class", "margin", "windows")
INPUTS = (
    Bundle("cfg_", ("addr", "data")),
    Bundle("weight_", ("address", "data")),
    Bundle("s_", ("slot", "dx", "dy", "visible", "id", "seq")),
)


class OwnedEvents(NamedTuple):
    """Owned events: slot, address in half pixels, whether the owner is visible, its track id."""

    slot: NDArray[np.int64]
    dx: NDArray[np.int64]
    dy: NDArray[np.int64]
    visible: NDArray[np.bool_]
    id: NDArray[np.int64]

    def part(self, begin: int, end: int) -> OwnedEvents:
        return OwnedEvents(
            self.slot[begin:end], self.dx[begin:end], self.dy[begin:end], self.visible[begin:end], self.id[begin:end]
        )


@dataclass
class _State:
    """What the writes so far have set."""

    registers: RecognitionRegisters
    enable: bool
    network: Network | None


class ClassifierTrial:
    """A device, and the golden model that follows its writes.

    Attributes:
        device: the RTL.
        lost: verdicts of the model that the RTL did not give.
    """

    def __init__(self, n_slots: int = 8, radix_w: int = 8, seq_w: int = 32, id_w: int = 16, verdicts: int = 4) -> None:
        parameters = {"N": n_slots, "RADIX_W": radix_w, "SEQ_W": seq_w, "ID_W": id_w, "VERDICTS": verdicts}
        outputs = (Bundle("m_", VERDICT_FIELDS),)
        self.device = StreamDevice("classifier", parameters, inputs=INPUTS, outputs=outputs, has_idle=True)
        self.n_slots, self.rel_w, self.seq_w = n_slots, radix_w + 2, seq_w
        self.reset()

    def reset(self) -> None:
        self.device.reset()
        self._state = _State(RecognitionRegisters(), enable=False, network=None)
        self._classifier: Classifier | None = None
        self._before = 0  # events that `_classifier` has seen
        self._seq = 0
        self.lost = 0

    def write(self, registers: RecognitionRegisters, network: Network | None = None) -> None:
        """Write what differs, without events; then `enable` = 1."""
        if network is not None:
            self.run(None, [("enable", 0)])
            self.write_weights(network)
        self.run(None, [*differences(self._state.registers, registers), ("enable", 1)])

    def write_weights(self, network: Network, events: OwnedEvents | None = None) -> None:
        """Write all weights, as events flow."""
        words = memory_words(network)
        self._state.network = network
        self.run(events, (), np.stack((np.arange(len(words)), words), axis=1))

    def run(
        self,
        events: OwnedEvents | None,
        writes: Sequence[tuple[str, int]] = (),
        weights: NDArray[np.int64] | None = None,
        *,
        may_lose: bool = False,
    ) -> StreamRun:
        """Events and writes at once; the verdicts must be those of the model.

        Args:
            may_lose: some of the model's verdicts may be missing; they are counted.

        Returns:
            What the RTL did.
        """
        empty = np.zeros(0, np.int64)
        events = events or OwnedEvents(empty, empty, empty, empty.astype(bool), empty)
        seq = (self._seq + np.arange(len(events.slot))) % (1 << min(self.seq_w, 63))
        mask = (1 << self.rel_w) - 1
        columns = (events.slot, events.dx & mask, events.dy & mask, events.visible, events.id, seq)
        words: dict[str, ArrayLike] = {
            "s_": np.stack([np.asarray(column, np.uint64) for column in columns], axis=1),
            "cfg_": [(REGISTER_ADDRESSES[name], value) for name, value in writes],
            "weight_": np.zeros((0, 2), np.int64) if weights is None else weights,
        }
        done = self.device.run(words)
        self._seq += len(seq)
        wanted = self._model(events, seq, writes, done)
        got = done.words["m_"].astype(np.int64)
        if may_lose:
            kept = np.isin(wanted[:, 2], got[:, 2])
            self.lost += int((~kept).sum())
            wanted = wanted[kept]
        assert_same(got, wanted)
        return done

    def _model(
        self, events: OwnedEvents, seq: NDArray[np.int64], writes: Sequence[tuple[str, int]], done: StreamRun
    ) -> NDArray[np.int64]:
        """The model's verdicts: a write takes effect before the event of the clock in which it is accepted."""
        state = self._state
        cuts = np.searchsorted(done.accepted["s_"], done.accepted["cfg_"]).tolist()
        rows = [self._verdicts(events.part(0, cuts[0] if cuts else len(seq)), seq)]
        for n, (name, value) in enumerate(writes):
            if name == "enable":
                state.enable = bool(value)
            else:
                state.registers = replace(state.registers, **{name: value})
            self._renew()
            end = cuts[n + 1] if n + 1 < len(cuts) else len(seq)
            rows.append(self._verdicts(events.part(cuts[n], end), seq[cuts[n] :]))
        return np.concatenate(rows)

    def _renew(self) -> None:
        """After a write all windows begin anew (rule R1)."""
        state = self._state
        self._classifier, self._before = None, 0
        if state.enable:
            assert state.network is not None
            network = Network(state.network.w1, state.network.w2[:, : state.registers.classes].copy())
            self._classifier = Classifier(state.registers, network, self.n_slots, self.rel_w)

    def _verdicts(self, events: OwnedEvents, seq: NDArray[np.int64]) -> NDArray[np.int64]:
        """Verdicts of events between two writes."""
        if self._classifier is None or not len(events.slot):
            return np.zeros((0, len(VERDICT_FIELDS)), np.int64)
        found = verdicts_of(self._classifier, self.rel_w, events)
        at = found[:, 2] - self._before
        self._before += len(events.slot)
        found[:, 1], found[:, 2] = events.id[at], seq[at]
        return found


def verdicts_of(classifier: Classifier, rel_w: int, events: OwnedEvents) -> NDArray[np.int64]:
    """Verdicts of the golden model, without ids; `seq` counts all of its events."""
    rel_x, rel_y = ((column & ((1 << rel_w) - 1)).astype(np.uint16) for column in (events.dx, events.dy))
    found = classifier.feed(ModelEvents(events.slot.astype(np.int16), rel_x, rel_y, events.visible))
    none = np.zeros(len(found), np.int64)
    columns = (found["slot"], none, found["seq"], found["class"], found["margin"], found["windows"])
    return np.stack([column.astype(np.int64) for column in columns], axis=1)


def model_verdicts(
    registers: RecognitionRegisters, network: Network, events: OwnedEvents, n_slots: int = 8, rel_w: int = 10
) -> NDArray[np.int64]:
    """Verdicts of the golden model on events from the first on."""
    found = verdicts_of(Classifier(registers, network, n_slots, rel_w), rel_w, events)
    found[:, 1] = events.id[found[:, 2]]
    return found


def assert_same(got: NDArray[np.int64], wanted: NDArray[np.int64]) -> None:
    """Verdicts are the same; else the first that is not is named."""
    for n, (ours, theirs) in enumerate(zip(got.tolist(), wanted.tolist(), strict=False)):
        assert ours == theirs, f"verdict {n} of {len(wanted)}: {VERDICT_FIELDS}: RTL {ours}, model {theirs}"
    assert len(got) == len(wanted)


def differences(old: RecognitionRegisters, new: RecognitionRegisters) -> list[tuple[str, int]]:
    """The writes that lead from one to the other."""
    names = [field.name for field in fields(new)]
    return [(name, after) for name, before, after in zip(names, astuple(old), astuple(new), strict=True) if before != after]


def random_network(rng: np.random.Generator) -> Network:
    """Weights of all sizes, small and at the ends of their range."""
    size = rng.choice([3.0, 30.0, 200.0])
    w1, w2 = (
        np.clip(rng.normal(0, size, shape), -128, 127).astype(np.int8) for shape in ((CELLS**2, HIDDEN), (HIDDEN, CLASSES_MAX))
    )
    return Network(w1, w2)


def random_registers(rng: np.random.Generator, window_log2: int = 8) -> RecognitionRegisters:
    def between(name: str) -> int:
        low, high = (int(end) for end in ranges_of(RecognitionRegisters)[name][:2])
        return int(rng.choice([low, high])) if rng.random() < 0.15 else int(rng.integers(low, high, endpoint=True))

    return RecognitionRegisters(
        window_log2=window_log2, scale_start=int(min(2 ** rng.uniform(5, 12), 4095)), shift_1=int(rng.integers(0, 10)),
        shift_2=int(rng.integers(2, 13)), classes=between("classes"), margin_min=int(rng.choice([0, between("margin_min")])),
    )  # fmt: skip


def object_events(rng: np.random.Generator, slot: int, n: int, size: float, slant: float = 0.0, track: int = 1) -> OwnedEvents:
    """Events of one visible object: a slanted cloud."""
    y = rng.normal(0, size, n)
    x = rng.normal(0, size * 0.7, n) + slant * y
    dx, dy = (np.clip(np.rint(column), -500, 500).astype(np.int64) for column in (x, y))
    return OwnedEvents(np.full(n, slot), dx, dy, np.ones(n, bool), np.full(n, track))


def random_owned(rng: np.random.Generator, n: int, n_slots: int, rel_w: int, flips: float = 1e-3) -> OwnedEvents:
    """Traffic of all slots: slots take turns in bursts; each has its place, size and slant, and turns visible and invisible."""
    bursts = rng.geometric(1 / rng.choice([1.01, 3.0, 40.0]), n)
    slot = np.repeat(rng.integers(0, n_slots, n), bursts)[:n]
    half = 1 << (rel_w - 1)
    size = half * 2.0 ** rng.uniform(-4, 1, n_slots)
    place = rng.uniform(-0.3, 0.3, (2, n_slots)) * half
    slant = rng.uniform(-1.5, 1.5, n_slots)
    y = rng.normal(0, 1, n) * size[slot]
    x = rng.normal(0, 0.6, n) * size[slot] + slant[slot] * y
    dx, dy = (
        np.clip(np.rint(part + off[slot]), -half, half - 1).astype(np.int64) for part, off in zip((x, y), place, strict=True)
    )
    tracks = np.zeros(n, np.int64)
    visible = np.ones(n, bool)
    for each in range(n_slots):
        own = np.flatnonzero(slot == each)
        turns = np.cumsum(rng.random(len(own)) < flips * rng.choice([0.1, 1, 5]))
        visible[own] = turns % 2 == 0
        tracks[own] = turns // 2 * n_slots + each
    return OwnedEvents(slot, dx, dy, visible, tracks % (1 << 15))


def joined(parts: Sequence[OwnedEvents]) -> OwnedEvents:
    """One after the other."""
    return OwnedEvents(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def candidate(slot: int, n: int = 1) -> OwnedEvents:
    """Events of an owner that is not visible."""
    zeros = np.zeros(n, np.int64)
    return OwnedEvents(np.full(n, slot), zeros, zeros, zeros.astype(bool), zeros)

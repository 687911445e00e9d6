# SPDX-License-Identifier: Apache-2.0
"""The rules of docs/recognition.md, one after the other, in plain Python: an independent model of the classifier."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from evcot.hardware.classifier import RecognitionRegisters
from evcot.recognition.model import Network

__all__ = ["OwnedEvent", "SlowClassifier"]

SIDE = 12


class OwnedEvent(NamedTuple):
    """An owned event: signed address in half pixels."""

    seq: int
    slot: int
    dx: int
    dy: int
    visible: bool


def clamp(value: int, low: int, high: int) -> int:
    return max(low, min(high, value))


@dataclass
class Slot:
    """The table of state."""

    fresh: bool = True
    count: int = 0
    pending: bool = False
    stage: int = 0
    cell: list[list[int]] = field(default_factory=list)
    off_u: int = 0
    off_v: int = 0
    scale_x: int = 0
    scale_y: int = 0
    skew: int = 0
    vote: list[int] = field(default_factory=list)
    voted: int = 0


class SlowClassifier:
    """See `recognition.model.Classifier`."""

    def __init__(self, registers: RecognitionRegisters, network: Network, n_slots: int) -> None:
        self.registers, self.w1, self.w2 = registers, network.w1.tolist(), network.w2.tolist()
        self.slots = [Slot() for _ in range(n_slots)]
        self.queue: list[int] = []
        self.busy = 0
        self.images: list[list[int]] = []

    def feed(self, events: Iterable[OwnedEvent]) -> list[tuple[int, int, int, int, int]]:
        """Verdicts as (seq, slot, class, margin, windows)."""
        return [verdict for event in events if (verdict := self.event(event)) is not None]

    def event(self, e: OwnedEvent) -> tuple[int, int, int, int, int] | None:
        if self.queue:  # Q2
            self.busy -= 1
            if self.busy == 0:
                self.slots[self.queue.pop(0)].pending = False
                self.busy = 768
        s = self.slots[e.slot]
        if not e.visible:  # W2
            s.count, s.fresh = 0, True
            return None
        if s.pending:  # W3
            return None
        if s.count == 0:  # W4
            s.cell = [[0] * SIDE for _ in range(SIDE)]
            if s.fresh:
                s.fresh, s.stage = False, 0
                s.off_u = s.off_v = s.skew = 0
                s.scale_x = s.scale_y = self.registers.scale_start
        v = clamp(((e.dy * s.scale_y) >> 4) - s.off_v, -1536, 1535)  # N1
        u = clamp(((e.dx * s.scale_x) >> 4) - s.off_u - ((s.skew * v) >> 7), -1536, 1535)
        row = s.cell[(v >> 8) + 6]  # N2
        row[(u >> 8) + 6] = min(row[(u >> 8) + 6] + 1, 15)
        s.count += 1  # W5
        if s.count < 1 << self.registers.window_log2:
            return None
        s.count, s.pending = 0, True  # W6, Q1
        self.queue.append(e.slot)
        if len(self.queue) == 1:
            self.busy = 768
        self.fit(s)
        verdict = self.verdict(s, e) if s.stage else None
        s.stage = min(s.stage + 1, 2)
        return verdict

    def fit(self, s: Slot) -> None:
        cells = [(2 * u - 11, 2 * v - 11, s.cell[v][u]) for v in range(SIDE) for u in range(SIDE)]
        total = sum(c for _, _, c in cells)
        by = self.registers.window_log2 + (2 if s.stage else 0)
        s.off_u = clamp(s.off_u + ((sum(c * u for u, _, c in cells) << 7) >> by), -1024, 1023)
        s.off_v = clamp(s.off_v + ((sum(c * v for _, v, c in cells) << 7) >> by), -1024, 1023)
        wide = 9 * total - 2 * sum(c * abs(u) for u, _, c in cells)
        high = 9 * total - 2 * sum(c * abs(v) for _, v, c in cells)
        s.scale_x = clamp(s.scale_x + ((s.scale_x * wide) >> (by + 3)), 16, 4095)
        s.scale_y = clamp(s.scale_y + ((s.scale_y * high) >> (by + 3)), 16, 4095)
        skewed = sum(c * u if v > 0 else -c * u for u, v, c in cells)
        s.skew = clamp(s.skew + ((skewed << 5) >> by), -127, 127)

    def verdict(self, s: Slot, e: OwnedEvent) -> tuple[int, int, int, int, int]:
        r = self.registers
        image = [count for row in s.cell for count in row]
        self.images.append(image)
        sums = [sum(w[j] * c for w, c in zip(self.w1, image, strict=True)) for j in range(32)]
        hidden = [min(max(one, 0) >> r.shift_1, 255) for one in sums]
        score = [sum(w[k] * h for w, h in zip(self.w2, hidden, strict=True)) for k in range(r.classes)]
        if s.stage == 1:
            s.voted, s.vote = 0, [0] * r.classes
        if s.voted == 128:
            s.voted, s.vote = 64, [one >> 1 for one in s.vote]
        s.voted += 1
        s.vote = [vote + min((max(score) - one) >> r.shift_2, 255) for vote, one in zip(s.vote, score, strict=True)]
        winner = s.vote.index(min(s.vote))
        margin = min(vote for k, vote in enumerate(s.vote) if k != winner) - s.vote[winner]
        return e.seq, e.slot, 15 if margin < r.margin_min * s.voted else winner, margin, s.voted

# SPDX-License-Identifier: Apache-2.0
"""The extended contract once more, in plain Python and by objects, as docs/motion.md has it; nothing is shared with kernels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count, pairwise
from math import ceil, log2
from typing import Any

from evcot.hardware.motion.contract import MotionRegisters
from evcot.tracks.log import DROPPED, Kind

__all__ = ["SlowArray"]

PX = 4096  # a pixel, in units of a side
LATER, LATER_TICKS = 64, 256  # events or ticks until what was computed takes effect
REACH_PX = 512  # how far out a box may be moved, of a sensor of at most as many pixels
Record = tuple[int, ...]


def pixel(value: int) -> int:
    """To nearest, halves up."""
    return (value + PX // 2) // PX


def divided(distance: int, shift: int, ticks: int) -> int:
    """distance * 2^shift / ticks by four leading bits: 1.abc is inverted to a multiple of 1/128."""
    exponent = ticks.bit_length() - 1
    abc = (ticks * 8 >> exponent) - 8
    inverse = round(128 / (1 + (abc + 0.5) / 8))
    scale = exponent + 7 - shift
    return distance * inverse // (1 << scale) if scale >= 0 else distance * inverse * (1 << -scale)


@dataclass
class Seen:
    """One axis of a slot as events see and change it: what is in effect."""

    lo: int
    hi: int
    beyond: list[bool] = field(default_factory=lambda: [False, False])
    hidden: list[bool] = field(default_factory=lambda: [False, False])
    box: tuple[int, int] = (1, 0)  # holds nothing
    window: tuple[int, int] = (1, 0)

    def measure(self, place: int, out: int, back: int) -> None:
        if all(self.hidden):
            return
        moves = [-out if place < self.lo else back, out if place > self.hi else -back]
        self.beyond = [self.beyond[0] or place < self.lo, self.beyond[1] or place > self.hi]
        if self.hidden[0]:
            moves[0] = moves[1]
        if self.hidden[1]:
            moves[1] = moves[0]
        self.lo, self.hi = self.lo + moves[0], self.hi + moves[1]


@dataclass
class Axis:
    """One axis of a slot as jobs compute it."""

    lo: int
    hi: int
    v: int = 0
    off: list[int] = field(default_factory=lambda: [0, 0])  # what events have moved each side since the last correction
    beyond: list[bool] = field(default_factory=lambda: [False, False])
    hidden: list[bool] = field(default_factory=lambda: [False, False])
    moves: list[int] = field(default_factory=lambda: [0, 0])  # of both sides, as it takes effect
    ring: int = 0
    box: tuple[int, int] = (1, 0)  # holds nothing
    bins: list[int] = field(default_factory=lambda: [0] * 16)
    bin_px: int = 1
    start: int = 0
    ways: list[int] = field(default_factory=list)  # of the corrections in one direction, the last ones
    was: int = 0
    pace: int = 0
    stated: int = 0

    @property
    def side(self) -> int:
        return max(self.hi - self.lo, 0)

    @property
    def px(self) -> int:
        return self.side // PX

    @property
    def window(self) -> tuple[int, int]:
        return self.box[0] - self.ring, self.box[1] + self.ring

    def set_box(self, ring: int) -> None:
        low, high = pixel(self.lo), pixel(self.hi)
        if high < low:
            low = high = (low + high) // 2
        self.box, self.ring = (low, high), ring

    def common(self, slower: bool) -> int:
        """Twice the way of both sides."""
        if not slower:
            return sum(self.off)
        if (self.off[0] > 0) != (self.off[1] > 0):
            return 0
        return 2 * (self.off[0] if abs(self.off[0]) < abs(self.off[1]) else self.off[1])

    def go(self, way: int) -> None:
        """A correction moves it by this way."""
        if way == 0 or (self.ways and (way > 0) != (self.ways[-1] > 0)):
            self.ways = []
        if way:
            self.ways.append(way)

    def begin_pace(self) -> None:
        self.was, self.pace, self.stated = self.lo + self.hi, 2 * self.v, 2 * self.v

    def follow(self, steps: int) -> None:
        way = (self.lo + self.hi - self.was + 2**19) % 2**20 - 2**19
        way = max(-65536, min(65535, way))
        self.pace += (way - self.pace + steps // 2) // steps
        self.stated += (self.pace - self.stated + steps // 2) // steps
        self.was = self.lo + self.hi

    def clear_bins(self) -> None:
        self.bins, self.bin_px = [0] * 16, 2 ** max(0, self.px.bit_length() - 4)

    def cut(self, share: int, least_px: int) -> None:
        limit = max(1, sum(self.bins) >> share)
        full = [b for b in range(16) if self.bins[b] > limit]
        gaps = [(b - a - 1, -a) for a, b in pairwise(full) if b - a > 1]
        if not gaps or max(gaps)[0] * self.bin_px < least_px:
            return
        width, begin = max(gaps)[0], 1 - max(gaps)[1]
        end = begin + width
        if sum(self.bins[:begin]) >= sum(self.bins[end:]):
            self.hi = self.lo + begin * self.bin_px * PX
        else:
            self.lo += end * self.bin_px * PX
            self.hi = max(self.hi, self.lo)


def gap(a: tuple[int, int], b: tuple[int, int]) -> int:
    return max(a[0], b[0]) - min(a[1], b[1])


class Slot:
    """A candidate or a visible track."""

    def __init__(self, number: int, r: MotionRegisters, x: int, y: int, now: int, counted: int | None = None) -> None:
        counted = now if counted is None else counted
        self.number, self.r, self.visible, self.id = number, r, False, 0
        self.left = False  # lost, but it may return
        self.axes = [Axis((at - r.seed_px) * PX, (at + r.seed_px) * PX) for at in (x, y)]
        self.count = self.support = self.corrections = self.together = self.looked = 0
        self.partner: Slot | None = None
        self.meets, self.n_ev = False, r.nev_low
        self.last = self.seeded = now
        self.usual, self.deadline, self.reported = r.detect_ticks, counted + r.detect_ticks, 0
        for axis in self.axes:
            axis.clear_bins()
        self.seen = [Seen(axis.lo, axis.hi) for axis in self.axes]
        self.visible_seen = self.left_seen = False
        self.owned = 0  # events since the last job
        self.corrects = True  # a correction, or the slot as a new candidate, has not taken effect
        self.merged = False  # since the last correction
        self.free = self.free_later = False  # computed, and with the slot's next effect
        self.due: tuple[int, int] | None = None  # event and tick before which what was computed takes effect
        self.computed = False  # something of it has not taken effect
        self.ends_with: Slot | None = None  # another slot's step has ended it, and it ends in effect as that one takes effect
        self.support = 1
        self.set_window()

    def wait(self, number: int, now: int) -> None:
        self.due = number + LATER, now + LATER_TICKS

    def begin(self, support_max: int) -> None:
        """A job begins with what events have made of the slot."""
        for axis, seen in zip(self.axes, self.seen, strict=True):
            low, high = seen.lo + axis.moves[0], seen.hi + axis.moves[1]
            axis.off = [axis.off[0] + low - axis.lo, axis.off[1] + high - axis.hi]
            axis.lo, axis.hi, axis.beyond = low, high, [False, False]
        self.support, self.owned = min(self.support + self.owned, support_max), 0

    def finish(self) -> None:
        """The job ends: what is to take effect."""
        self.computed = True
        self.free_later = self.free
        for axis, seen in zip(self.axes, self.seen, strict=True):
            axis.moves = [axis.lo - seen.lo, axis.hi - seen.hi]

    def take_effect(self) -> None:
        self.computed = self.corrects = False
        self.visible_seen, self.left_seen = self.visible, self.left
        for axis, seen in zip(self.axes, self.seen, strict=True):
            seen.lo, seen.hi, axis.moves = seen.lo + axis.moves[0], seen.hi + axis.moves[1], [0, 0]
            seen.hidden, seen.box, seen.window = list(axis.hidden), axis.box, axis.window
            seen.beyond = [a or b for a, b in zip(seen.beyond, axis.beyond, strict=True)]

    def set_window(self) -> None:
        for axis, ring in zip(self.axes, self.rings(), strict=True):
            axis.set_box(ring)

    def rings(self) -> tuple[int, int]:
        r, (x, y) = self.r, self.axes
        known = self.visible or self.corrections >= 4

        def across(axis: Axis) -> int:
            return (axis.px >> r.ring_across) + r.ring_px

        def along(axis: Axis, other: Axis) -> int:
            return (other.px >> r.ring_along) + r.ring_px if axis.px < r.elongation * other.px else across(axis)

        if known and abs(y.v) >= 2 * abs(x.v):
            rings = across(x), along(y, x)
        elif known and abs(x.v) >= 2 * abs(y.v):
            rings = along(x, y), across(y)
        else:
            rings = (x.px >> r.ring_any) + r.ring_px, (y.px >> r.ring_any) + r.ring_px
        return min(rings[0], r.ring_max), min(rings[1], r.ring_max)

    def holds(self, place: tuple[int, int]) -> bool:
        return all(axis.window[0] <= at <= axis.window[1] for axis, at in zip(self.axes, place, strict=True))

    def sees(self, place: tuple[int, int]) -> bool:
        """Whether the window in effect holds it."""
        return all(seen.window[0] <= at <= seen.window[1] for seen, at in zip(self.seen, place, strict=True))

    def boxes(self, place: tuple[int, int]) -> bool:
        """Whether the box in effect holds it."""
        return all(seen.box[0] <= at <= seen.box[1] for seen, at in zip(self.seen, place, strict=True))

    def take(self, place: tuple[int, int], shared: bool, support_max: int, in_burst: bool = False) -> bool:
        r = self.r
        self.owned = min(self.owned + 1, support_max)
        if shared:
            return False
        back = r.side_step >> r.side_share
        faster = 1 if self.visible_seen else 2
        outwards = 4 * faster if in_burst else faster
        for axis, seen, at in zip(self.axes, self.seen, place, strict=True):
            number = (at - pixel(seen.lo)) // axis.bin_px
            if r.gap_corrections and not self.corrects and 0 <= number < 16:
                axis.bins[number] += 1
            seen.measure(at * PX, outwards * (r.side_step - back), faster * back)
        if self.corrects:
            return False
        self.count += 1
        return self.count >= self.n_ev

    def correct(self, now: int, counted: int | None = None, in_burst: bool = False) -> None:
        r = self.r
        self.count = 0
        for axis, seen in zip(self.axes, self.seen, strict=True):
            axis.beyond, seen.beyond = seen.beyond, [False, False]
            part = axis.side >> r.side_shrink if r.side_shrink and not self.meets else 0
            if not axis.beyond[0]:
                axis.lo, axis.off[0] = axis.lo + part, axis.off[0] + part
            if not axis.beyond[1]:
                axis.hi, axis.off[1] = axis.hi - part, axis.off[1] - part
            axis.beyond = [False, False]
        self.look()
        ticks = min(max(now - self.last, 1), 2**24 - 1)
        for axis in self.axes:
            if self.corrections >= 2 and ticks > 1:
                way = axis.common(self.corrections < r.settle and not in_burst)
                axis.go(way)
                gain = 1 if in_burst else min(1 + self.corrections // 2**r.gain_slow, r.gain_log2)
                if self.meets:
                    gain += 1
                elif in_burst:
                    gain -= len(axis.ways) >= 3
                elif r.gain_fast and gain > r.gain_fast:
                    gain = max(gain - max(min(len(axis.ways), 7) - 2, 0), r.gain_fast)
                change = divided(way, r.step_log2 - 1 - gain, ticks)
                axis.v = max(-r.speed_max, min(r.speed_max, axis.v + change))
            if ticks > 1:
                axis.off = [0, 0]
        if self.corrections == 0:
            self.usual = ticks
        elif ticks > 1:
            self.usual += (ticks - self.usual) // 4
        self.last = now
        self.corrections = min(self.corrections + 1, 63)
        if self.corrections == 4:
            for axis in self.axes:
                axis.start = axis.lo + axis.hi
                axis.begin_pace()
        self.n_ev = min(max(sum(axis.px for axis in self.axes), r.nev_low), r.nev_high)
        self.deadline = (now if counted is None else counted) + min(
            max(self.usual * 2**r.life_log2, r.life_ticks), r.coast_ticks
        )
        self.set_window()

    def look(self) -> None:
        r, (x, y) = self.r, self.axes
        if not r.gap_corrections:
            return
        self.looked += 1
        if self.merged:
            self.merged = False
            self.clear_bins()
        if self.looked < r.gap_corrections:
            return
        if self.corrections >= 8 and (x.v or y.v):
            sides = x.px, y.px
            for i, axis, other in ((0, x, y), (1, y, x)):
                if 2 * abs(other.v) >= abs(axis.v):
                    axis.cut(r.gap_share, r.gap_px)
                elif sides[i] >= r.elongation * sides[1 - i]:
                    axis.cut(r.gap_share, max(r.gap_px, sides[1 - i] // 2))
        self.clear_bins()

    def clear_bins(self) -> None:
        self.looked = 0
        for axis in self.axes:
            axis.clear_bins()

    def advance(self, now: int) -> None:
        r = self.r
        silent = not self.meets and now - self.last > 2 * self.usual
        for axis in self.axes:
            way = axis.v // 2**r.coast_slow if silent else axis.v
            if all(-REACH_PX * PX <= side + way < 2 * REACH_PX * PX for side in (axis.lo, axis.hi)):
                axis.lo, axis.hi = axis.lo + way, axis.hi + way
            if silent and r.friction:
                axis.v -= axis.v >> r.friction

    def bound(self) -> None:
        most = self.r.side_max * PX
        for axis in self.axes:
            if axis.hi - axis.lo > most:
                middle = (axis.lo + axis.hi) // 2
                axis.lo, axis.hi = middle - most // 2, middle + most // 2

    def follow(self) -> None:
        """The stated velocity, over as many steps as the shorter side takes to pass."""
        speed = max(abs(axis.stated) for axis in self.axes)
        slow = next((steps for steps in (16, 8, 4) if speed * steps <= min(axis.side for axis in self.axes)), 2)
        for axis in self.axes:
            axis.follow(slow)

    def moves_with(self, other: Slot) -> bool:
        fastest = max(abs(axis.v) for one in (self, other) for axis in one.axes)
        apart = max(abs(a.v - b.v) for a, b in zip(self.axes, other.axes, strict=True))
        return apart <= (fastest >> self.r.join_speed) + PX // 64

    def is_one_with(self, other: Slot) -> bool:
        r, leader = self.r, self if self.support >= other.support else other
        gaps = [gap(a.box, b.box) for a, b in zip(self.axes, other.axes, strict=True)]
        sides = [[axis.box[1] - axis.box[0] for axis in one.axes] for one in (self, other)]
        abreast = [gaps[i] <= -(min(sides[0][i], sides[1][i]) // 2) for i in (0, 1)]
        near = [r.join_px, r.join_px]
        ahead = 1 if abs(leader.axes[1].v) >= abs(leader.axes[0].v) else 0
        near[ahead] += max(sides[0][1 - ahead], sides[1][1 - ahead]) >> r.join_reach
        return any(abreast[i] and gaps[1 - i] <= near[1 - i] for i in (0, 1))

    def unite(self, other: Slot, support_max: int) -> None:
        for axis, its in zip(self.axes, other.axes, strict=True):
            axis.lo, axis.hi = min(axis.lo, its.lo), max(axis.hi, its.hi)
            axis.off, axis.beyond, axis.was = [0, 0], [True, True], axis.lo + axis.hi
        self.support = min(self.support + other.support, support_max)
        self.deadline = max(self.deadline, other.deadline)
        self.partner, self.together, self.merged = None, 0, True
        self.set_window()

    def appears(self, now: int) -> bool:
        r = self.r
        sides = [axis.hi - axis.lo for axis in self.axes]
        way = max(abs(axis.lo + axis.hi - axis.start) for axis in self.axes)
        return (
            self.corrections >= 4
            and self.support >= r.birth_support
            and min(sides) >= r.birth_px * PX
            and now - self.seeded >= r.birth_ticks
            and way >= (sum(sides) >> (r.birth_travel + 1)) + 2 * PX
        )

    def reaches(self, other: Slot) -> bool:
        """Whether the windows share a pixel."""
        return all(gap(a.window, b.window) <= 0 for a, b in zip(self.axes, other.axes, strict=True))

    def hide(self, others: list[Slot]) -> None:
        self.meets = False
        for axis in self.axes:
            axis.hidden = [False, False]
        for other in others:
            if not self.reaches(other):
                continue
            self.meets = True
            for i in (0, 1):
                mine, its = self.axes[i], other.axes[i]
                if gap(self.axes[1 - i].box, other.axes[1 - i].window) <= 0:
                    inside = [its.window[0] <= side <= its.window[1] for side in mine.box]
                    mine.hidden = [a or b for a, b in zip(mine.hidden, inside, strict=True)]


class SlowArray:
    """All slots.

    Attributes:
        records: (seq, time, kind, id, other id, middle x, y, sides x, y, velocity x, y, support, n_ev, slot).
        owners: of each event; `of_tracks`: whether its owner is visible.
        jobs: what the hardware computes them from, and what takes effect later, in order.
    """

    def __init__(self, registers: MotionRegisters, n_slots: int, support_max: int, id_mask: int) -> None:
        self.r, self.support_max, self.id_mask = registers, support_max, id_mask
        self.slots: list[Slot | None] = [None] * n_slots
        self.records: list[Record] = []
        self.owners: list[int] = []
        self.of_tracks: list[bool] = []
        self.births = 0
        self.seeded: Slot | None = None  # has begun, and is not in effect
        self.jobs: list[tuple[dict[str, Any], dict[str, Any]]] = []
        self.steps = self._steps_after(0)
        self.step_tick, self.step_slot = next(self.steps)
        self.came, self.empty, self.paused = False, 0, 0  # empty periods do not count for deadlines, up to 32 in a row
        self.latest: list[int] = []  # ticks of the last 16 kept events

    def event(self, now: int, x: int, y: int, kept: bool = True) -> None:
        """The next event; one that a filter took out advances time and the count."""
        number = len(self.owners)
        while self.step_tick <= now:
            self._take_effect(number, self.step_tick)
            if self.step_slot == 0:
                self.empty = 0 if self.came else self.empty + 1
                if 0 < self.empty <= 32:
                    self.paused += 2**self.r.step_log2
                self.came = False
            slot = self.slots[self.step_slot]
            if slot is not None:
                self._job("step", slot, self.step_tick)
            self.step_tick, self.step_slot = next(self.steps)
        if not kept:
            self.owners.append(DROPPED)
            self.of_tracks.append(False)
            return
        self.came = True
        self._take_effect(number, now)
        in_burst = self.latest == [now] * 16
        self.latest = [*self.latest, now][-16:]
        slot, shared = self._owner((x, y))
        self.of_tracks.append(slot is not None and slot.visible_seen)
        if slot is None and self.seeded is None:
            slot = self._seed((x, y), now)
        elif slot is not None and slot.take((x, y), shared, self.support_max, in_burst):
            self._job("correction", slot, now, in_burst)
        self.owners.append(-1 if slot is None else slot.number)

    def _job(self, kind: str, slot: Slot, now: int, in_burst: bool = False) -> None:
        """What an event or a motion step causes; nothing of a slot that another one's step has ended, but that it waits."""
        job = self._cause(kind, slot, now) | {"in_burst": in_burst}
        if kind == "correction" or slot.due is None:
            slot.wait(len(self.owners), now)
        slot.corrects = slot.corrects or kind == "correction"
        ended: list[int] = []
        void = slot.free or (slot.left and kind == "correction")
        if not void:
            living = [other for other in self.slots if other is not None and not other.free]
            slot.begin(self.support_max)
            if kind == "correction":
                slot.correct(now, now - self.paused, in_burst)
                if slot.visible:
                    self._record(slot, Kind.MOVED, now)
            elif kind == "step":
                self._step(slot, now)
            slot.finish()
            ended = [other.number for other in living if other.free and other is not slot]
        self.jobs.append((job, self._effect(slot, void, ended)))

    def _cause(self, kind: str, slot: Slot, now: int) -> dict[str, Any]:
        return {
            "kind": kind,
            "slot": slot.number,
            "seq": len(self.owners),
            "time": now,
            "counted": now - self.paused,
            "waits": slot.due is not None,
            "sides": [side for seen in slot.seen for side in (seen.lo, seen.hi)],
            "marks": [mark for seen in slot.seen for mark in seen.beyond],
            "owned": slot.owned,
            "in_burst": False,
        }

    def _effect(self, slot: Slot, void: bool, ended: list[int]) -> dict[str, Any]:
        return {
            "slot": slot.number,
            "void": void,
            "state": 0 if slot.free_later else 3 if slot.left else 2 if slot.visible else 1,
            "moves": [move for axis in slot.axes for move in axis.moves],
            "hidden": [hidden for axis in slot.axes for hidden in axis.hidden],
            "mark_all": all(mark for axis in slot.axes for mark in axis.beyond),
            "n_ev": slot.n_ev,
            "bin_log2": [axis.bin_px.bit_length() - 1 for axis in slot.axes],
            "box": [bound for axis in slot.axes for bound in axis.box],
            "window": [bound for axis in slot.axes for bound in axis.window],
            "ended": ended,
        }

    def _steps_after(self, now: int) -> Iterator[tuple[int, int]]:
        """Tick and slot of each motion step, from the next multiple of a period on."""
        period = 2**self.r.step_log2
        places = 2 ** ceil(log2(len(self.slots)))
        for n in count(now // period + 1):
            for i in range(len(self.slots)):
                yield n * period + i * period // places, i

    def _take_effect(self, number: int, now: int) -> None:
        """What takes effect before this event or motion step."""
        for slot in self.slots:
            if slot is None:
                continue
            if self.slots[slot.number] is slot and slot.due is not None and (slot.due[0] <= number or slot.due[1] <= now):
                slot.due = None
                if slot.computed:
                    slot.take_effect()
                    if slot is self.seeded:
                        self.seeded = None
                    if slot.free_later:
                        self.slots[slot.number] = None
                    self._end_with(slot)

    def _end_with(self, slot: Slot) -> None:
        """Slots that end with this one, and those that end with them."""
        for other in self.slots:
            if other is not None and other.ends_with is slot:
                self.slots[other.number] = None
                if other is self.seeded:
                    self.seeded = None
                self._end_with(other)

    def restart(self, number: int, now: int) -> None:
        """A mode of this slot is written, after the event at `now`."""
        self._take_effect(1 << 62, now)
        slot = self.slots[number]
        if slot is not None and slot.visible:
            slot.begin(self.support_max)
            self._record(slot, Kind.LOST, now)
        self.slots[number] = None

    def write(self, registers: MotionRegisters, now: int) -> None:
        """Other registers, after the event at `now`; lives go on."""
        changes = registers.step_log2 != self.r.step_log2
        self.r = registers
        for slot in self.slots:
            if slot is not None:
                slot.r = registers
        if changes:
            self.steps = self._steps_after(now)
            self.step_tick, self.step_slot = next(self.steps)

    def _owner(self, place: tuple[int, int]) -> tuple[Slot | None, bool]:
        here = [
            slot
            for slot in self.slots
            if slot is not None and not slot.left_seen and slot is not self.seeded and slot.sees(place)
        ]
        visible = [slot for slot in here if slot.visible_seen]
        for choice in ([slot for slot in visible if slot.boxes(place)], visible):
            if choice:
                return choice[0], len(choice) > 1
        return (here[0] if here else None), False

    def _seed(self, place: tuple[int, int], now: int) -> Slot | None:
        free = [i for i, slot in enumerate(self.slots) if slot is None]
        free += [i for i, slot in enumerate(self.slots) if slot is not None and slot.left_seen]
        if not free:
            return None
        slot = self.seeded = self.slots[free[0]] = Slot(free[0], self.r, *place, now, now - self.paused)
        job = self._cause("seed", slot, now)
        slot.wait(len(self.owners), now)
        slot.computed = True
        self.jobs.append((job, self._effect(slot, False, [])))
        return slot

    def _record(self, slot: Slot, kind: Kind, time: int, other: int = 0) -> None:
        x, y = slot.axes
        middle = [(axis.lo + axis.hi) // 2 for axis in slot.axes]
        seq = len(self.owners)
        slot.reported = time
        self.records.append(
            (
                seq,
                time,
                int(kind),
                slot.id,
                other,
                *middle,
                x.side,
                y.side,
                x.stated // 2,
                y.stated // 2,
                slot.support,
                slot.n_ev,
                slot.number,
            )
        )

    def _living(self, but: Slot) -> list[Slot]:
        return [slot for slot in self.slots if slot is not None and slot is not but and not slot.left and not slot.free]

    def _step(self, slot: Slot, now: int) -> None:
        r = self.r
        if now - self.paused >= slot.deadline:
            if slot.visible:
                self._record(slot, Kind.LOST, now)
            if slot.visible and r.return_ticks:
                slot.visible, slot.left, slot.deadline = False, True, now - self.paused + r.return_ticks
                for axis in slot.axes:
                    axis.set_box(r.ring_max)
            else:
                slot.free = True
            return
        if slot.left:
            return
        known = slot.visible or slot.corrections >= 4
        if known:
            slot.advance(now)
        slot.bound()
        if known:
            slot.follow()
        slot.set_window()
        self._join(slot, now)
        if not slot.visible:
            if self._absorbed(slot) or not slot.appears(now):
                return
            slot.visible = True
            gone = [
                other for other in self.slots if other is not None and other.left and not other.free and slot.reaches(other)
            ]
            if gone:
                slot.id = gone[0].id
                self._end(gone[0], slot)
                self._record(slot, Kind.MOVED, now)
                return
            slot.id = self.births & self.id_mask
            self.births += 1
            self._record(slot, Kind.BORN, now)
            return
        slot.hide([other for other in self._living(slot) if other.visible])
        if now - slot.reported >= r.report_steps * 2**r.step_log2:
            self._record(slot, Kind.MOVED, now)

    def _join(self, slot: Slot, now: int) -> None:
        r = self.r
        partner = None
        if slot.corrections >= 4:
            settled = [other for other in self._living(slot) if other.corrections >= 4]
            partner = next((other for other in settled if slot.moves_with(other) and slot.is_one_with(other)), None)
        if partner is None:
            slot.together = max(slot.together - 1, 0)
            return
        if slot.partner is None or slot.partner.number != partner.number:
            slot.partner, slot.together = partner, 0
        slot.together += 1
        younger = now - max(slot.seeded, partner.seeded)
        if slot.together < min(max(r.join_steps, younger // 2**r.step_log2 // 2**r.join_life), 65535):
            return
        if slot.visible != partner.visible:
            stays = slot.visible
        else:
            stays = partner.seeded >= slot.seeded if r.keep_older else partner.support <= slot.support
        if not stays:
            return
        if partner.visible:
            self._record(partner, Kind.MERGED, now, other=slot.id)
        slot.unite(partner, self.support_max)
        self._end(partner, slot)
        if slot.visible:
            self._record(slot, Kind.MOVED, now)

    def _end(self, slot: Slot, by: Slot) -> None:
        slot.free, slot.ends_with = True, by

    def _absorbed(self, slot: Slot) -> bool:
        middle = tuple((axis.box[0] + axis.box[1]) // 2 for axis in slot.axes)
        if any(other.visible and other.holds((middle[0], middle[1])) for other in self._living(slot)):
            slot.free = True
            return True
        for other in self._living(slot):
            if other.visible or any(gap(a.box, b.box) > 0 for a, b in zip(slot.axes, other.axes, strict=True)):
                continue
            if slot.support < other.support:
                return True
            slot.unite(other, self.support_max)
            self._end(other, slot)
        return False

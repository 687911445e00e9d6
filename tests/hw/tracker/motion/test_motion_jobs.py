# SPDX-License-Identifier: Apache-2.0
"""motion_jobs.v: jobs in order, slots that wait until they are due, and slots that end with others."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

N, SLOT_W, X_W, Y_W, SIDE_W, SUP_W, SEQ_W, TIME_W, DUE_W = 6, 3, 4, 3, 13, 5, 18, 20, 12
WIDTHS = {
    "N": N, "SLOT_W": SLOT_W, "X_W": X_W, "Y_W": Y_W, "SIDE_W": SIDE_W, "SUP_W": SUP_W, "SEQ_W": SEQ_W, "TIME_W": TIME_W,
    "DUE_W": DUE_W,
}  # fmt: skip
FIELDS = {"flag": 1, "x": X_W, "y": Y_W, "sides": 4 * SIDE_W, "marks": 4, "owned": SUP_W}  # nothing looks into these
CORRECTION, SEED, STEP, END = range(4)
LATER, LATER_TICKS, MOST, UNDER_WAY = 64, 256, 112, 12
LATENCY, NEXT, WORK = 3, 1, 2  # clocks until a job comes, and the next one; least number that it takes
SHOWN, NEXT_SHOWN, READY = 4, 2, 2  # until a slot that waits is shown, and the next one; until it is ready, from its last job
PACES = (0.02, 0.3), (0.1, 0.11), (0.1, 0.3), (0.1, 0.8), (0, 0.3), (0.1, 0.3), (1, 0.01)  # how often a job comes, and is done


@dataclass
class Entry:
    """A slot that waits; skipped if it is not the slot's current one."""

    slot: int
    due: tuple[int, int]
    came: int


@dataclass
class Jobs:
    """All that is inside, at once."""

    jobs: list[tuple[int, dict[str, int]]] = field(default_factory=list)  # since when, and the job
    entries: list[Entry] = field(default_factory=list)
    waits: dict[int, Entry] = field(default_factory=dict)
    computed: set[int] = field(default_factory=set)
    ends_with: dict[int, int] = field(default_factory=dict)
    corrects: set[int] = field(default_factory=set)  # slots of which a correction or a seed is not in effect
    void: set[int] = field(default_factory=set)  # jobs of these compute nothing: they have ended, and no candidate has begun

    def pending(self, slot: int, kinds: tuple[int, ...] = (CORRECTION, SEED, STEP, END)) -> int:
        return sum(job["slot"] == slot and job["kind"] in kinds and job["real"] for _, job in self.jobs)

    def come(self, clock: int, job: dict[str, int]) -> None:
        slot, kind = job["slot"], job["kind"]
        self.jobs.append((clock, job | {"waits": int(slot in self.waits)}))
        if job["real"] and (kind in (CORRECTION, SEED) or slot not in self.waits):
            self.waits[slot] = Entry(slot, ((job["seq"] + LATER) % 256, (job["time"] + LATER_TICKS) % (1 << DUE_W)), clock)
            self.entries.append(self.waits[slot])
        if kind in (CORRECTION, SEED):
            self.corrects.add(slot)
        if kind == SEED:
            self.ends_with.pop(slot, None)

    def end(self, slot: int, by: int) -> None:
        self.void.add(slot)
        if not self.pending(slot, (SEED,)):
            self.ends_with[slot] = by

    def ended(self, slot: int) -> set[int]:
        """Those that end with it, and with those."""
        some = {other for other, by in self.ends_with.items() if by == slot}
        return some.union(*(self.ended(other) for other in some))

    def done(self, computes: bool) -> None:
        _, job = self.jobs.pop(0)
        if job["kind"] == SEED:
            self.void.discard(job["slot"])
        if computes:
            self.computed.add(job["slot"])

    def take(self) -> None:
        slot = self.entries.pop(0).slot
        for other in {slot} | self.ended(slot):
            self.waits.pop(other, None)
            self.computed.discard(other)
            self.corrects.discard(other)
            if other != slot:
                del self.ends_with[other]


@pytest.mark.parametrize("seed", range(3))
def test_random_jobs(seed: int) -> None:
    """Jobs come often or rarely, and are computed fast or slowly, each for some time."""
    rng, inside = np.random.default_rng(seed), Jobs()
    sim = load("motion_jobs", WIDTHS, extra_flags=PORTS_ONLY_FLAGS)
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    seq = time = began = held = 0
    done_at = pop_at = job_at = end_at = due_from = stale_at = mask_at = masked_until = -9
    mask_slot, was_masked = -1, False
    level, was_due, taken = MOST, False, False  # level: jobs inside, a clock before
    seen = dict.fromkeys(("correction", "seed", "step", "life", "empty", "skip", "take", "chain", "nothing", "anew", "full"), 0)
    for clock in range(30_000):
        if clock % 150 == 0:
            often, speed = PACES[int(rng.integers(len(PACES) - 1)) if clock % 3_000 else -1]
            full = often > speed  # periods are empty
        # ---- the job that is next
        comes_at = max(inside.jobs[0][0] + LATENCY, done_at + NEXT) if inside.jobs else clock + 1
        valid = clock >= comes_at
        assert (int(io.idle), int(io.job_valid), int(io.room)) == (not inside.jobs, valid, level < MOST)
        level = len(inside.jobs)
        if valid:
            shown = inside.jobs[0][1]
            late = {"seq", "time"} if clock == comes_at else set()  # these come a clock later
            assert {name: int(io[f"job_{name}"]) for name in shown if name not in late} == {
                name: value for name, value in shown.items() if name not in late
            }
        # ---- the slot that is next; one whose entry is not the current one is shown for 4 clocks at most
        due = bool(int(io.due_valid))
        if was_due and not due and not taken:
            entry = inside.entries.pop(0)
            assert inside.waits.get(entry.slot) is not entry
            pop_at, stale_at = clock - 1, -9
            seen["skip"] += 1
        assert int(io.due_any) == bool(inside.entries)
        assert due == (bool(inside.entries) and clock >= max(inside.entries[0].came + SHOWN, pop_at + NEXT_SHOWN))
        ready = bool(int(io.ready))
        if due:
            slot = inside.entries[0].slot
            due_from = due_from if was_due else clock
            assert (int(io.due_slot), (int(io.due_event), int(io.due_tick))) == (slot, inside.entries[0].due)
            is_current, ended = inside.waits.get(slot) is inside.entries[0], inside.ended(slot)
            stale_at = -9 if is_current else max(stale_at, clock) if stale_at < 0 else stale_at
            assert is_current or clock <= max(stale_at, due_from) + 2
            may = is_current and not inside.pending(slot) and not (was_masked and slot == mask_slot)
            assert may or not ready
            if ready:
                assert (int(io.due_own), int(io.due_ended)) == (slot in inside.computed, sum(1 << other for other in ended))
            else:
                rounds = (len(ended) + 1) * N + 2 if inside.ends_with else 0
                must = max(max(due_from, end_at) + 4 + rounds, done_at + READY, job_at + READY, masked_until + READY)
                assert not may or clock < must
        else:
            assert not ready
        io.j_valid = io.job_done = io.finish = io.ends = io.due_taken = io.mask = 0
        was_masked = mask_at < clock <= masked_until
        io.mask_busy = int(was_masked)
        # ---- something takes effect
        taken = ready and rng.random() < 0.3
        if taken:
            io.due_taken, taken_slot = 1, slot
            fast = slot in inside.computed & inside.corrects and not inside.ended(slot)  # then others may cause jobs
            seen["take"] += 1
            seen["chain"] += any(inside.ended(other) for other in inside.ended(slot))
            seen["nothing"] += slot not in inside.computed
            inside.take()
            pop_at = clock
        # ---- work
        if valid and not was_masked and rng.random() < 0.1:
            io.mask, mask_at, mask_slot = 1, clock, inside.jobs[0][1]["slot"]
            masked_until = clock + int(rng.integers(1, 30))
        elif clock >= comes_at + WORK and rng.random() < speed:
            job = inside.jobs[0][1]
            computes = bool(job["real"]) and (job["slot"] not in inside.void or job["kind"] == SEED)
            others = [i for i in range(N) if i not in inside.void and i != job["slot"]]
            if computes and job["kind"] == STEP and others and began < 3 and rng.random() < 0.8:
                io.ends, io.ends_slot, end_at, began = 1, int(rng.choice(others)), clock, began + 1
                inside.end(int(io.ends_slot), job["slot"])
            else:
                io.job_done, io.finish, done_at, began = 1, int(computes), clock, 0
                inside.done(computes)
        # ---- a job
        held = held + 1 if not int(io.room) else 0
        kind = STEP if full else int(rng.choice(4, p=[0.5, 0.2, 0.25, 0.05]))
        slot = int(rng.integers(N))
        kind = SEED if kind == CORRECTION and slot in inside.void else kind
        real = kind < STEP or (not full and rng.random() < 0.9)
        allowed = kind >= STEP or slot not in inside.corrects
        allowed = allowed and (kind != SEED or slot not in inside.ends_with.values())
        allowed = (allowed or not real) and (not taken or (fast and kind < STEP and slot != taken_slot))
        if allowed and held <= UNDER_WAY and rng.random() < often:
            seq, time = seq + int(rng.integers(400)), time + int(rng.integers(400))
            job = {"real": int(real), "kind": kind, "slot": slot, "seq": seq % (1 << SEQ_W), "time": time % (1 << TIME_W)}
            job |= {name: int(rng.integers(1 << bits)) for name, bits in FIELDS.items()}
            io.j_valid, job_at = 1, clock
            for name, value in job.items():
                setattr(io, f"j_{name}", value)
            end_at = clock if kind == SEED else end_at
            seen["anew"] += kind == CORRECTION and slot in inside.waits
            seen["full"] += held == UNDER_WAY
            seen[("correction", "seed", "step", "life")[kind] if real else "empty"] += 1
            inside.come(clock, job)
        was_due = due
        sim.clock.tick()
    assert min(seq, time) > 4 << 16
    assert min(seen.values()) > 1, seen

# SPDX-License-Identifier: Apache-2.0
"""motion_turn.v: what comes next, whatever comes when; nothing passes what is due before it, and nothing waits for long."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from evcot.hardware.contract import Mode
from evcot.hardware.registers import motion_addresses
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

N, SLOT_W, TIME_W, DUE_W = 5, 3, 32, 24
MODE, STEP_LOG2 = motion_addresses()["mode"], motion_addresses()["step_log2"]
STAGES, EFFECT = 7, 6  # clocks until a token is done and causes a job, or an effect is done
LATER, LATER_TICKS = 64, 256
SHOWN, NEXT, READY = 4, 2, 2  # clocks until a slot that waits is shown, behind another one, and ready at the earliest
PATIENCE = {"token": 6, "step": 9, "effect": 9, "end": 24}  # clocks in which what may come does; slots that are free end, too


@dataclass
class Waiting:
    """A slot that waits."""

    slot: int
    event: int
    tick: int
    came: int
    pause: int  # clocks from when it is shown until its jobs are done
    own: bool
    ended: int


@dataclass
class Surroundings:
    """Tokens, the pipeline and slots that wait."""

    rng: np.random.Generator
    token: tuple[int, bool, bool] | None = None  # time, event, taken out by a filter
    pipe: dict[int, tuple[str, int, int, int]] = field(default_factory=dict)  # by clock: what is done, time, number, slot
    entries: list[Waiting] = field(default_factory=list)
    corrects: int = 0
    alive: int = 0
    time: int = 0

    def wait(self, clock: int, slot: int, number: int, tick: int, corrects: bool) -> None:
        """A job: the slot begins to wait, if it does not wait already."""
        rng = self.rng
        if any(entry.slot == slot for entry in self.entries):
            return
        pause = READY if rng.random() < 0.7 else READY + int(rng.integers(60))
        ended = 1 << int(rng.integers(N)) & ~(1 << slot) if rng.random() < 0.1 else 0
        own = corrects or rng.random() < 0.8
        self.entries.append(Waiting(slot, number + LATER, tick + LATER_TICKS, clock, pause, own, ended))
        self.corrects |= int(corrects) << slot


@pytest.mark.parametrize("seed", range(3))
def test_random_traffic(seed: int) -> None:
    rng = np.random.default_rng(seed)
    widths = {"N": N, "SLOT_W": SLOT_W, "TIME_W": TIME_W, "DUE_W": DUE_W}
    sim, around = load("motion_turn", widths, extra_flags=PORTS_ONLY_FLAGS), Surroundings(rng)
    io = sim.io
    io.step_log2 = step_log2 = 5
    io.rst = io.cfg_rst = 1
    sim.clock.tick()
    io.rst = io.cfg_rst = 0
    next_step, now, issued, step_slot, seeded = 1 << step_log2, 0, 0, 0, [False] * N
    period = next_before = next_step
    restarts: dict[int, int] = {}  # slots that live and must end, and since when
    came, empty, forces, held, settled, changes = False, 0, False, 0, 8, True
    unseen = False  # a slot that does not live may have to end
    shown_at = pop_at = wrote_at = -99
    last_tick = last_now = 0
    may_since = {"token": 0, "step": 0, "effect": 0, "end": 0}  # since when it may come
    job: tuple[int, int, int] | None = None  # of a step in the clock before: real, pauses, ends
    could_step, before, was_room, dead_step_at, shortest = False, False, False, -99, 99  # before: the clock before
    seen = dict.fromkeys(
        ("token", "step", "dead", "effect", "fast", "end", "lowest", "event", "tick", "far", "empty", "many empty", "same"), 0
    )
    for clock in range(30_000):
        # ---- a step that began in the clock before
        if int(io.holds) and held == 0:
            assert before  # decided in the clock before it comes
            held, pauses = 4, step_slot == 0 and not came and empty < 32
            lives = bool(around.alive >> step_slot & 1)
            assert (int(io.job_real), int(io.job_pauses), int(io.job_ends)) == (lives, pauses, 0)
            assert (job is not None) == (lives or pauses)
            if lives and clock - 1 + STAGES in around.pipe:
                around.pipe[clock - 1 + STAGES] = ("step", next_step, issued, step_slot)
            if step_slot == 0:
                seen["many empty"] += not came and empty == 32
                empty = 0 if came else min(empty + 1, 32)
                seen["empty"] += pauses
                came = False
            if not lives and not pauses:
                shortest, dead_step_at = min(shortest, clock - dead_step_at), clock
                seen["dead"] += 1
            seen["step"] += 1
            step_slot = (step_slot + 1) % N
            period += 1 << step_log2 if step_slot == 0 else 0
            next_step = period + (step_slot << step_log2 >> SLOT_W)
        elif job is not None:  # then it is the end of a life
            slot, real = job[0], around.alive >> job[0] & 1
            assert (int(io.job_real), int(io.job_pauses), int(io.job_ends)) == (real, 0, 1)
            forces = True
        held = max(held - 1, 0)
        assert int(io.holds) == (held > 0)
        assert settled > 5 or int(io.next_step) == next_step
        assert int(io.now) == now
        assert clock <= wrote_at + 2 or int(io.seeded) == sum(1 << i for i in range(N) if seeded[i])
        # ---- what is shown to it
        io.cfg_valid = 0
        nothing = not (around.pipe or around.entries or around.token or restarts or held)
        if rng.random() < (0.3 if clock <= wrote_at + 2 else 0.002):
            io.cfg_valid, io.cfg_addr, io.cfg_slot, io.cfg_data = 1, MODE, int(rng.integers(N)), int(rng.integers(2)) | 4
            slot, wrote_at = int(io.cfg_slot), clock
            seeded[slot] = int(io.cfg_data) % 4 == Mode.SEEDED
            if around.alive >> slot & 1:
                restarts.setdefault(slot, clock)
            unseen = True
        elif settled == 0 and nothing and int(io.quiet) and rng.random() < 0.2:
            io.cfg_valid, io.cfg_addr, step_log2 = 1, STEP_LOG2, int(rng.choice([3, 4, 5, 8]))
            io.cfg_data, changes, settled = step_log2, step_log2 != int(io.step_log2), 10
            seen["same"] += not changes
        if clock % 400 < 320 and around.token is None and settled <= 4 and rng.random() < 0.6:
            event = clock < 12_000 and rng.random() < 0.8
            ticks = 400 if rng.random() < 0.01 else 12 if clock % 2_000 < 1_000 else 3
            around.time += int(rng.integers(ticks))
            around.token = (around.time, event, not event and rng.random() < 0.5)
        if clock % 50 == 0 and not unseen and not around.pipe:
            around.alive = int(rng.integers(1 << N)) if rng.random() < 0.8 else 0
        due = bool(around.token) and around.time >= next_before
        counts = around.token is not None and (around.token[1] or around.token[2])
        far = around.time - last_now >= LATER_TICKS
        io.q_due, io.q_runs, io.q_event, io.q_counts = (
            int(due), int(bool(around.token) and not due), int(bool(around.token) and around.token[1]), int(counts),
        )  # fmt: skip
        io.q_late, io.q_far = int(around.time >= last_tick), int(far)
        room, clears = rng.random() < 0.95, rng.random() < 0.03
        io.room, io.op_clear, io.alive, io.corrects = int(room), int(clears), around.alive, around.corrects
        first = around.entries[0] if around.entries else None
        shown = first is not None and clock >= max(first.came + SHOWN, pop_at + NEXT)
        shown_at = shown_at if shown and shown_at > pop_at else clock if shown else -99
        ready = first is not None and shown and clock >= shown_at + first.pause
        io.due_any, io.due_valid, io.ready = int(first is not None and first.came < clock), int(shown), int(ready)
        if first is not None and clock + 1 >= max(first.came + SHOWN, pop_at + NEXT):  # a clock before
            io.due_slot, io.due_event, io.due_tick = first.slot, first.event % 256, first.tick
            io.due_own, io.due_ended = int(first.own), first.ended
        done = around.pipe.get(clock)
        io.active = int(bool(around.pipe))
        io.d_valid, io.effect_done = int(done is not None and done[0] == "token"), int(done is not None and done[0] == "effect")
        io.d_time = done[1] if done is not None else 0
        # ---- what it says
        token, effect, step = bool(int(io.takes_token)), bool(int(io.op_effect)), bool(int(io.op_step))
        assert token + effect + step + clears <= 1
        ending = {slot for slot, since in restarts.items() if since <= clock - 5}
        by_event = first is not None and first.event <= issued
        by_tick = first is not None and ((due and first.tick <= next_step) or (not due and first.tick <= around.time))
        is_due = by_event or (around.token is not None and by_tick)
        fast = first is not None and first.own and not first.ended and bool(around.corrects >> first.slot & 1)
        kinds = {what for what, *_ in around.pipe.values()}
        steps_under_way = "step" in kinds
        if token:
            assert around.token is not None
            assert not is_due
            assert not due
            assert was_room
            assert not ending
            assert not forces
            assert held == 0
            assert not (far and around.pipe)
            seen["far"] += far
        if effect:
            assert first is not None
            assert ready
            assert is_due or unseen
            assert kinds <= {"clear"} or (fast and not steps_under_way)
            seen["event"] += by_event
            seen["tick"] += is_due and not by_event
            seen["fast"] += bool(around.pipe)
        if step:
            assert not around.pipe
            ends = int(io.work_slot) in restarts and int(io.work_time) == now and (bool(ending) or not due)
            if ends:
                assert not around.entries
                assert int(io.work_slot) == min(slot for slot, since in restarts.items() if since <= clock - 3)
                seen["end"] += 1
                seen["lowest"] += len(restarts) > 1
                del restarts[int(io.work_slot)]
            else:
                assert (int(io.work_slot), int(io.work_time)) == (step_slot, next_step)
        unseen = unseen and not (int(io.quiet) and clock > wrote_at + 3)
        rests = not around.pipe and held == 0 and not ending and not forces
        before = could_step
        could_step = due and rests and not is_due and room
        may = {
            "token": rests and room and around.token is not None and not due and not is_due and not clears,
            "step": could_step and not restarts and not clears,
            "effect": ready and is_due and not around.pipe and held == 0 and not clears,
            "end": bool(ending) and not around.pipe and not around.entries and held == 0 and not clears,
        }
        comes = {"token": token, "step": step, "effect": effect, "end": step}
        for name in may:
            late = may[name] and not comes[name] and (not unseen or ending) and settled < 5
            may_since[name] = may_since[name] + 1 if late else 0
            assert may_since[name] <= PATIENCE[name], name
        # ---- what follows
        job = (int(io.work_slot), 0, 0) if step else None
        if token and around.token is not None:
            around.pipe[clock + STAGES] = ("token", around.time, issued, int(rng.integers(N)))
            came = came or around.token[1]
            issued += int(counts)
            around.token = None
            seen["token"] += 1
        if step:
            around.pipe[clock + STAGES] = ("step", now, issued, int(io.work_slot))
        if effect:
            around.pipe[clock + EFFECT] = ("effect", 0, 0, 0)
            pop_at = clock
            around.entries.pop(0)
            seen["effect"] += 1
        if clears:
            around.pipe.setdefault(clock + EFFECT, ("clear", 0, 0, 0))
        last_tick, last_now, was_room, next_before = int(io.due_tick), now, room, next_step
        if done is not None:
            what, tick, number, slot = around.pipe.pop(clock)
            if what == "effect":
                around.corrects &= int(sum(1 << entry.slot for entry in around.entries))
            if what == "token":
                now = tick
            if what == "step" and around.alive >> slot & 1:
                around.wait(clock, slot, number, tick, corrects=False)
            if what == "token" and rng.random() < 0.1:
                around.wait(clock, slot, number, tick, corrects=True)
                assert all(time < tick + LATER_TICKS for name, time, *_ in around.pipe.values() if name == "token")
        forces = forces and bool(around.entries or around.pipe)
        sim.clock.tick()
        settled = max(settled - 1, 0)
        if settled == 8:
            io.step_log2 = step_log2
            if changes:
                next_step = period = next_before = ((now >> step_log2) + 1) << step_log2
                step_slot = 0
    assert min(seen.values()) > 0, seen
    assert shortest == 5

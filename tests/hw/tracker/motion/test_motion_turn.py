# SPDX-License-Identifier: Apache-2.0
"""motion_turn.v: what comes next, whatever comes when; steps and ends of lives wait until nothing is under way."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from evcot.hardware.contract import Mode
from evcot.hardware.registers import motion_addresses
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.testing import lint

N, SLOT_W, TIME_W = 5, 3, 32
MODE, STEP_LOG2 = motion_addresses()["mode"], motion_addresses()["step_log2"]
STAGES = 6  # of the pipeline that takes what comes


@dataclass
class Surroundings:
    """Tokens, work and slots that wait, around the module; each as slow as it likes."""

    time: int = 0
    due: bool = False
    token: bool = False
    counts: bool = False
    pipe: list[tuple[str, int]] = field(default_factory=lambda: [("", 0)] * STAGES)
    jobs: list[int] = field(default_factory=list)  # slots that wait for work,
    puts: list[int] = field(default_factory=list)  # that wait to be in force
    pause: int = 0  # clocks until the next one of them is shown
    busy: int = 0  # clocks of work
    op: str = ""

    @property
    def shown(self) -> bool:
        return bool(self.puts) and self.pause == 0

    @property
    def nothing(self) -> bool:
        return not (self.token or self.jobs or self.puts or self.busy or self.op or any(what for what, _ in self.pipe))


@pytest.mark.parametrize("seed", range(3))
def test_random_traffic(seed: int) -> None:
    sim, rng = (
        load("motion_turn", {"N": N, "SLOT_W": SLOT_W, "TIME_W": TIME_W}, extra_flags=PORTS_ONLY_FLAGS),
        np.random.default_rng(seed),
    )
    io, around = sim.io, Surroundings()
    io.step_log2 = step_log2 = 5
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    next_step, now, issued, seeded = 1 << step_log2, 0, 0, [False] * N
    period, step_slot = next_step, 0
    restarts: dict[int, int] = {}  # slots whose life must end, and since when
    written: tuple[int, bool] | None = None  # a slot whose mode was written in the clock before, and whether it is seeded then
    could_start = could_take = put_busy = rested = False
    writes = stepping = (
        0  # an operation that writes, or a slot that is put in force, was taken in the clock before; clocks of a step
    )
    seen = dict.fromkeys(
        (
            "op",
            "put",
            "token",
            "step",
            "end",
            "end before step",
            "lowest",
            "reached",
            "no room",
            "write",
            "same",
            "over",
            "empty",
            "too many empty",
        ),
        0,
    )
    quiet_since, settled, putting, steps_change = 0, 8, 0, True
    seen |= {"empty": 0, "too many empty": 0}
    came, empty, paused, kept = False, 0, 0, False  # periods in which no event came
    for clock in range(9_000):
        # ---- what is shown to it
        wrote_mode, io.cfg_valid = bool(int(io.cfg_valid)) and int(io.cfg_addr) == MODE, 0
        if rng.random() < (0.3 if wrote_mode else 0.006):
            io.cfg_valid, io.cfg_addr, io.cfg_slot, io.cfg_data = 1, MODE, int(rng.integers(N)), int(rng.integers(2)) | 4
        elif settled == 0 and int(io.quiet) and around.nothing and not stepping and rng.random() < 0.2:
            io.cfg_valid, io.cfg_addr, step_log2 = 1, STEP_LOG2, int(rng.integers(9))
            io.cfg_data, steps_change = step_log2, step_log2 != int(io.step_log2)
            settled = 10
        if clock % 200 < 150 and not around.token and settled <= 4 and not stepping and rng.random() < 0.5:
            around.token, around.counts, around.time = True, rng.random() < 0.8, around.time + int(rng.integers(20))
            around.due = around.time >= next_step
        if around.jobs and not around.busy and not stepping:
            around.busy = int(rng.integers(5, 30))
        if around.busy and not around.op and rng.random() < 0.2:
            around.op = str(rng.choice(["reads", "writes"]))
        kept = around.counts and clock < 1_000
        room, reached = rng.random() < 0.9, around.shown and rng.random() < 0.3
        waits, working = bool(around.jobs or around.puts), bool(around.busy or around.op)
        io.q_due, io.q_counts, io.room = int(around.token and around.due), int(around.counts), int(room)
        io.q_event = int(kept)
        io.q_runs = int(around.token and not around.due)
        io.op_valid, io.op_writes = int(bool(around.op)), int(around.op == "writes")
        io.op_beside = int(bool(around.op) and not stepping)
        io.put_valid, io.reached = int(around.shown), int(reached)
        io.put_slot = put_slot = around.puts[0] if around.shown else int(rng.integers(N))
        kind, time = around.pipe[-1]
        io.d_valid, io.d_time, io.put_done = int(kind == "token"), time, int(kind == "put")
        active = any(what for what, _ in around.pipe)
        io.active, io.waits_none, io.rests = int(active), int(not waits), int(not working)
        # ---- what it says
        took = {name: bool(int(io[f"takes_{name}"])) for name in ("op", "put", "token")}
        step, end = bool(int(io.steps)), bool(int(io.ends_life))
        ending = {slot: since for slot, since in restarts.items() if since <= clock - 3}
        stop = bool(ending) or (around.token and around.due)
        assert int(io.op_ready) == (not writes)
        assert took["op"] == (bool(around.op) and not writes)
        assert took["put"] == (not around.op and not writes and around.shown and not put_busy and (reached or stop))
        may_take = not around.op and not writes and not reached and not stop and around.token
        assert took["token"] == (may_take and could_take)
        assert int(io.issues) == (took["token"] and around.counts)
        assert (step or end) == could_start
        assert end == (could_start and bool(ending))
        if end:
            assert int(io.work_slot) == min(slot for slot, since in restarts.items() if since <= clock - 2)
            seen["end before step"] += around.token and around.due
            seen["lowest"] += len(ending) > 1
        over = stepping >= 3 and rested  # its last clock
        assert int(io.holds) == (stepping > 0)
        assert not put_busy or int(io.puts_slot) == putting
        assert put_busy or not around.shown or int(io.puts_slot) == put_slot
        assert (int(io.issued), int(io.following), int(io.now)) == (issued % 256, (issued + 1) % 256, now)
        assert int(io.seeded) == sum(1 << i for i in range(N) if seeded[i])
        assert settled > 5 or int(io.next_step) == next_step
        assert int(io.paused) == paused
        under_way = stepping or reached or put_busy or restarts or written
        assert not int(io.quiet) or not (under_way or (steps_change and 5 < settled < 10))
        quiet_since = 0 if under_way or settled > 5 else quiet_since + 1
        assert int(io.quiet) or quiet_since < 3
        for name, happens in (*took.items(), ("step", step), ("end", end), ("reached", reached), ("over", over)):
            seen[name] += happens
        seen["no room"] += may_take and not could_take
        # ---- what follows
        could_start = bool(
            not stepping
            and not (step or end)
            and stop
            and not active
            and not waits
            and not working
            and not around.op
            and not writes
        )
        rested = not working
        could_take = room and not stepping and not (step or end)
        if took["put"]:
            put_busy, putting = True, put_slot
            around.puts.pop(0)
            around.pause = 3
        elif kind == "put":
            put_busy = False
        around.pause = max(around.pause - 1, 0)
        writes = (took["op"] and around.op == "writes") or took["put"]
        if kind == "token":
            now = time
            free = [slot for slot in range(N) if slot not in around.jobs + around.puts]
            if free and rng.random() < 0.1:
                around.jobs.append(int(rng.choice(free)))
        what = next((name for name in took if took[name]), "")
        around.pipe = [(what, around.time), *around.pipe[:-1]]
        issued += int(io.issues)
        if took["token"]:
            around.token = False
        if took["op"]:
            around.op = ""
        if around.busy:
            around.busy -= 1
            if around.busy == 0 and around.jobs and not stepping:
                around.puts.append(around.jobs.pop(0))
        came = came or (took["token"] and kept)
        if step:
            assert int(io.work_slot) == step_slot
        if step and step_slot == 0:
            empty = 0 if came else empty + 1
            paused += 1 << step_log2 if 0 < empty <= 32 else 0
            seen["empty"] += 0 < empty <= 32
            seen["too many empty"] += empty > 32
            came = False
        if step:
            step_slot = (step_slot + 1) % N
            period += 1 << step_log2 if step_slot == 0 else 0
            next_step = period + (step_slot << step_log2 >> SLOT_W)
        if step or end:
            stepping, around.busy = 1, int(rng.integers(0, 20))
        elif stepping:
            stepping = 0 if over else stepping + 1
            if over:
                around.due = around.token and around.time >= next_step
        if end:
            del restarts[int(io.work_slot)]
        if written:
            restarts.setdefault(written[0], clock)
            seeded[written[0]] = written[1]
        writes_mode = int(io.cfg_valid) and int(io.cfg_addr) == MODE
        written = (int(io.cfg_slot), int(io.cfg_data) % 4 == Mode.SEEDED) if writes_mode else None
        sim.clock.tick()
        settled = max(settled - 1, 0)
        if settled == 8:
            io.step_log2 = step_log2
            if steps_change:
                next_step = period = ((now >> step_log2) + 1) << step_log2
                step_slot = 0
            seen["write"] += 1
            seen["same"] += not steps_change
    assert min(seen.values()) > 0, seen


def test_lint() -> None:
    assert lint("motion_turn") == (0, "")
    assert lint("motion_turn", N=1, SLOT_W=1) == (0, "")

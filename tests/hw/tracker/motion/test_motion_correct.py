# SPDX-License-Identifier: Apache-2.0
"""motion_correct.v: a correction, or a candidate that begins, in order, however long looks and records take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_control import Control, Said, check_reset_of_job

SLOT_W = 3
LAST, SEEDED, REPORTED = range(3)
JOBS = 1  # seed of jobs among which each axis is cut at either side
LOOK = 47  # clocks of a look at an axis: motion_gaps.v
TO_SIDES = ("c_seed", "c_shrink", "c_cut_high", "c_cut_low", "c_order", "c_offset", "c_reflect", "c_settle")
COMMANDS = (*TO_SIDES, "c_speed", "c_times", "c_count", "c_bins", "c_window", "look", "keep", "keep_window", "keep_start")


@dataclass
class Job:
    """A slot, and what decides."""

    slot: int
    seeds: bool
    visible: bool
    shrinks: bool
    meets: bool
    corrections: int
    look_due: bool
    merged: bool
    resting: bool
    looks: tuple[bool, bool]
    found: tuple[bool, bool]
    low_stays: tuple[bool, bool]
    instant: bool


def random_job(rng: np.random.Generator) -> Job:
    flags = [bool(flag) for flag in rng.integers(2, size=7)]
    corrections = int(rng.choice([0, 1, 2, 3, 7, 8, 8, 8, 62, 63]))
    resting, slot = rng.random() < 0.2, int(rng.integers(1 << SLOT_W))
    return Job(
        slot, rng.random() < 0.2, *flags[:3], corrections, rng.random() < 0.7, rng.random() < 0.2, resting,
        (rng.random() < 0.7, flags[3]),
        (flags[4], rng.random() < 0.7), (flags[5], flags[6]), rng.random() < 0.3,
    )  # fmt: skip


def work_of(job: Job) -> list[str]:
    """What is done, in order, without bins that are cleared meanwhile: docs/motion.md, rules C."""
    written = ["keep", "keep_window"]
    if job.seeds:
        return ["c_seed", "c_settle", "c_bins", "c_window", *written]
    said = ["fetch", "load"]
    if job.shrinks and not job.meets:
        said += ["c_shrink"]
    said += ["c_offset"]
    if job.look_due:
        if job.corrections >= 8 and not job.resting and not job.merged:
            for on_y in (0, 1):
                if job.looks[on_y]:
                    said += [f"look {on_y}"]
                    if job.found[on_y]:
                        said += [f"c_cut_high {on_y}"] if job.low_stays[on_y] else [f"c_cut_low {on_y}", f"c_order {on_y}"]
        said += ["c_bins"]
    turns = job.corrections >= 2 and not job.instant
    said += [
        "c_reflect" if job.instant else "c_settle",
        *["c_speed"] * turns,
        "c_times",
        "c_count",
        *["keep_start"] * (job.corrections == 3),
    ]
    said += [f"say {int(Kind.MOVED)}"] * job.visible
    return [*said, "c_window", *written]


class Correct(Control):
    """Its records are MOVED, and of the slot of a job it is known while it rests: see motion_order.v."""

    def kind(self) -> int:
        return int(Kind.MOVED)

    def handed_on(self) -> int:
        return int(self.io.slot if int(self.io.rests) else self.io.at)


def words(said: list[Said], axes: dict[int, int]) -> list[str]:
    """The commands as words, with the axis of those that have one."""
    found = []
    for i, (name, _, *more) in enumerate(said):
        on_axis = name in ("look", "c_cut_high", "c_cut_low", "c_order")
        found.append(" ".join([name, *(str(int(number)) for number in more), *[str(axes.get(i))] * on_axis]))
    return found


@pytest.mark.parametrize("seed", [0, 1])
def test_a_reset_at_any_moment_of_a_job_ends_it(seed: int) -> None:
    check_reset_of_job(load("motion_correct", {"SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS), COMMANDS, start=1, seed=seed)


@pytest.mark.parametrize("stalls", [False, True])
def test_random_jobs(stalls: bool) -> None:
    sim = load("motion_correct", {"SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS)
    io, rng, jobs = sim.io, np.random.default_rng(1), np.random.default_rng(JOBS)
    control = Correct(sim, rng, COMMANDS, TO_SIDES)
    control.reset()
    control.stalls = stalls
    clocks: dict[str, set[int]] = {}
    kinds = set()
    done: list[Job] = []
    for _ in range(160):
        job = random_job(jobs)
        done.append(job)
        for _clock in range(int(rng.integers(0, 3))):
            assert int(io.rests)
            control.clock()
        io.start, io.seed, io.slot = 1, int(job.seeds), job.slot
        io.shrinks, io.resting, io.visible = int(job.shrinks), int(job.resting), int(job.visible)
        control.said.clear()
        axes: dict[int, int] = {}
        begun, busy, look_in, noted, corrections, on_y = control.clocks, 0, 0, -9, job.corrections, [0] * 4
        on_axis = 0
        if not job.seeds:
            control.read()  # motion_order.v does
        while True:
            # What is not there yet is random: of memory two clocks behind the slot, of the axis a clock behind it.
            any_ = [int(bit) for bit in rng.integers(2, size=3)]
            was_loaded = any(name == "load" for name, *_ in control.said)
            io.q_meets = int(job.meets) if control.steady(3) and control.at[0] == job.slot else any_[0]
            io.corrections = corrections if was_loaded else int(rng.integers(64))
            io.instant = int(job.instant)
            io.look_due, io.merged = (int(job.look_due), int(job.merged)) if was_loaded else any_[1:]
            looks = job.looks[on_y[0]] if len(set(on_y[:2])) == 1 and control.clocks >= noted + 3 else bool(any_[2])
            io.looks = int(looks)
            io.inverse_goes_on = int(busy > 1)
            io.look_done = int(look_in == 1)
            on_y = [int(io.look_y), *on_y[:3]]
            n_said = len(control.said)
            counts = int(io.c_count)
            control.clock()
            corrections = min(corrections + counts, 63)
            axes |= dict.fromkeys(range(n_said, len(control.said)), on_y[0])
            io.start = 0
            busy = int(rng.integers(2, 17 if stalls else 9)) if int(io.c_inverse) else max(busy - 1, 0)
            look_in = (int(rng.integers(1, 30)) if stalls else LOOK) if int(io.look) else max(look_in - 1, 0)
            if int(io.look):
                io.gap_found, io.low_stays = int(job.found[int(io.look_y)]), int(job.low_stays[int(io.look_y)])
            noted = control.clocks if int(io.c_note) else noted
            if int(io.c_times):
                assert busy == 0
            if on_axis:  # y has the command a clock later
                assert int(io.look_y) == on_y[0]
            on_axis = int(io.c_cut_high) or int(io.c_cut_low) or int(io.c_order)
            if int(io.say):
                assert (int(io.since), int(io.keep_now)) == (REPORTED, 1)
            if int(io.c_seed):
                assert (int(io.since), int(io.keep_now)) == (SEEDED, 1)
            if int(io.keep):
                assert (int(io.since), int(io.keep_now)) == (LAST, 1)
            if int(io.done):
                break
        took = control.clocks - begun
        cleared = [number for name, _, *more in control.said for number in more if name == "clear"]
        assert cleared == (list(range(16)) if "c_bins" in work_of(job) else [])  # all of them, before the job is done
        control.clock()
        assert (int(io.keep_until), int(io.rests), control.at[0]) == (1, 1, job.slot)
        said = words(control.said, axes)
        assert [word for word in said if not word.startswith("clear")] == work_of(job)
        assert not cleared or said.index("c_bins") < said.index("clear 0")  # of the new width
        assert {slot for _, slot, *_ in control.said} == {job.slot}
        kind = "seed" if job.seeds else "look" if job.look_due else "correction"
        clocks.setdefault(kind, set()).add(took)
        kinds.add((kind, job.visible))
    assert len(kinds) == 6
    for kind, (least, most) in {"correction": (23, 40), "look": (37, 178), "seed": (30, 31)}.items():
        assert stalls or (least <= min(clocks[kind]) and max(clocks[kind]) <= most)
    every = {word for job in done for word in work_of(job)}
    assert {f"{name} {on_y}" for name in ("look", "c_cut_high", "c_cut_low", "c_order") for on_y in (0, 1)} < every

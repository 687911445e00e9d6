# SPDX-License-Identifier: Apache-2.0
"""motion_slot.v: what is counted of several slots, whatever commands come one after the other, and what of it memory keeps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

SLOT_W, SIDE_W, PX_W, REL_W, SUP_W, ID_W = 2, 20, 9, 6, 8, 3
SLOTS, MOST = 1 << SLOT_W, (1 << SUP_W) - 1
KEPT = {"sides": 4 * SIDE_W, "v": 32, "refs": 4 * SIDE_W, "usual": 24}
AXES = ("sides", "refs", "moves")  # x in the upper half
WINDOW = {"box": 4 * PX_W, "window": 4 * PX_W}
START = {"start": SIDE_W + 1}
MOVES = {"moves": 4 * SIDE_W, "state": 2, "middle": 2 * REL_W}
COMMANDS = (
    "load", "begin_job", "unite", "seed", "offset", "count", "begin_bins", "pair", "part", "meet", "keep", "keep_window",
    "keep_id", "keep_start", "finish", "ran",
)  # fmt: skip
OUTPUTS = ("support", "merged", "corrections", "marks", "hidden", "meets", "runs", "n_ev", "together", "log2")


@dataclass
class State:
    """The slot that is worked on."""

    support: int = 0
    corrections: int = 0
    looked: int = 0
    meets: int = 0
    hidden: int = 0
    runs: int = 0
    marks: int = 0
    merged: int = 0
    n_ev: int = 0
    partner: int | None = None
    together: int = 0
    log2: int = 0

    def forget_partner(self) -> None:
        self.partner, self.together = None, 0


def bins_log2(length: int) -> int:
    return max(0, length.bit_length() - 4)


def command(name: str, slot: State, memory: State, io: Any, at: int) -> State:
    """What a command does to it."""
    if name in ("load", "begin_job", "unite"):
        more = {"load": 0, "begin_job": int(io.job_owned), "unite": slot.support}[name]
        slot = replace(memory, support=min(memory.support + more, MOST), marks=int(io.job_marks) * (name == "begin_job"))
        if name == "unite":
            slot.marks, slot.merged = 15, 1
            slot.forget_partner()
    elif name == "seed":
        slot = State(1, n_ev=int(io.nev_low), looked=slot.looked, log2=slot.log2, merged=slot.merged)
    elif name == "offset":
        slot.marks = 0
        slot.looked += int(io.gap_corrections) > 0
    elif name == "count":
        slot.n_ev = min(max(int(io.length_x) + int(io.length_y), int(io.nev_low)), int(io.nev_high))
        slot.corrections = min(slot.corrections + 1, 63)
    elif name == "begin_bins":
        slot.looked = slot.merged = 0
        slot.log2 = bins_log2(int(io.length_y)) << 5 | bins_log2(int(io.length_x))
    elif name == "pair":
        slot.together = slot.together + 1 if slot.partner == at else 1
        slot.partner = at
    elif name == "part":
        slot.together = max(slot.together - 1, 0)
    elif name == "ran":
        slot.runs = slot.runs & 0xF0 | int(io.run_next)
    elif name == "meet":
        slot.meets, slot.hidden = int(io.meets_now), int(io.hidden_now)
    return slot


def axis_of(word: int, of_y: int) -> int:
    return (word if of_y else word >> 2 * SIDE_W) % (1 << 2 * SIDE_W)


def show(io: Any, values: dict[str, int], of_y: int) -> None:
    """One axis of what is written."""
    io.sides_y = io.moves_y = of_y
    for name in AXES:
        io[name] = axis_of(values[name], of_y)


def test_random_commands() -> None:
    sim = load(
        "motion_slot",
        {"SLOT_W": SLOT_W, "SIDE_W": SIDE_W, "PX_W": PX_W, "REL_W": REL_W, "SUP_W": SUP_W, "ID_W": ID_W},
        extra_flags=PORTS_ONLY_FLAGS,
    )
    io, rng = sim.io, np.random.default_rng(3)
    memory = [State() for _ in range(SLOTS)]
    words: dict[tuple[int, str], int] = {}
    effects = [State() for _ in range(SLOTS)]
    births, slot = 0, State()
    seen = dict.fromkeys(COMMANDS, 0)
    full = most = again = resumed = 0
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    first = [
        (name, at)
        for at in range(SLOTS)
        for name in ("seed", "begin_bins", "keep", "keep_window", "keep_id", "keep_start", "finish")
    ]
    for round_ in range(1_600):
        name, at = first[round_] if round_ < len(first) else (str(rng.choice(COMMANDS)), int(rng.integers(SLOTS)))
        if name == "pair" and rng.random() < 0.5 and slot.partner is not None:
            at = slot.partner
        io.at = at
        low, high = sorted(int(n) for n in rng.integers(1, 1_024, 2))
        values = {
            "job_owned": int(rng.integers(MOST + 1)) >> int(rng.integers(4)), "job_marks": int(rng.integers(16)),
            "length_x": int(rng.integers(1 << PX_W)) >> int(rng.integers(PX_W)),
            "length_y": int(rng.integers(1 << PX_W)) >> int(rng.integers(PX_W)), "meets_now": int(rng.integers(2)),
            "hidden_now": int(rng.integers(16)), "nev_low": low, "nev_high": high, "gain_log2": int(rng.integers(1, 13)),
            "gain_slow": int(rng.integers(7)), "gain_fast": int(rng.integers(13)), "run_next": int(rng.integers(16)),
            "gap_corrections": int(rng.integers(256)) >> int(rng.integers(9)), "burst": int(rng.random() < 0.3),
            "from": int(rng.integers(SLOTS)), "e_slot": int(rng.integers(SLOTS)),
            "ask_start": int(name != "keep_id" and rng.random() < 0.5),
        }  # fmt: skip
        values |= {word: int.from_bytes(rng.bytes(16)) % (1 << bits) for word, bits in (KEPT | WINDOW | START | MOVES).items()}
        for port, value in values.items():
            if port not in AXES:
                io[port] = value
        show(io, values, of_y=0)
        for _clock in range(2):
            sim.clock.tick()
        repeat = int(rng.integers(1, 40)) if name in ("count", "pair", "part") else 1
        for _ in range(repeat):
            was = slot.together
            slot = command(name, slot, memory[at], io, at)
            again += slot.together > was > 0
            if name == "keep":
                memory[at] = replace(slot)
            if name == "finish":
                effects[at] = replace(slot)
            if name in ("keep", "keep_window", "keep_start", "finish"):
                fields = {"keep": KEPT, "keep_window": WINDOW, "keep_start": START, "finish": MOVES}[name]
                words.update({(at, word): values[word] for word in fields})
            if name == "keep_id":
                io.resume = int(round_ >= len(first) and rng.random() < 0.5)
                if int(io.resume):  # the id of the slot that `at` has just left
                    io.at = left = int(rng.integers(SLOTS))
                    for _clock in range(3):
                        sim.clock.tick()
                    io.at = at
                    resumed += words[at, "id"] != words[left, "id"]
                    words[at, "id"] = words[left, "id"]
                else:
                    words[at, "id"], births = births, (births + 1) % (1 << ID_W)
            together = ("load", name) if name in ("begin_job", "unite") else (name,)
            for port in together:
                io[port] = 1
            sim.clock.tick()
            for port in together:
                io[port] = 0
            show(io, values, of_y=1)
            if round_ >= len(first):
                for port in OUTPUTS:
                    assert int(getattr(io, port)) == getattr(slot, port), (name, port)
            if name == "ran":  # then of y
                io.run_next = int(rng.integers(16))
                sim.clock.tick()
                slot.runs = slot.runs & 0x0F | int(io.run_next) << 4
                assert int(io.runs) == slot.runs
            if name in ("keep", "finish"):  # then of y
                sim.clock.tick()
        if round_ < len(first):
            continue
        seen[name] += 1
        for _clock in range(3):
            sim.clock.tick()
        gain = 1 if values["burst"] else min(1 + (slot.corrections >> values["gain_slow"]), values["gain_log2"])
        room = 1 if values["burst"] else max(gain - values["gain_fast"], 0) if values["gain_fast"] else 0
        assert int(io.gain) == gain + slot.meets
        assert int(io.room) == (0 if slot.meets else room)
        assert int(io.look_due) == (
            values["gap_corrections"] > 0 and (slot.merged or slot.looked + 1 >= values["gap_corrections"])
        )
        full += slot.support == MOST
        most += slot.corrections == 63
        assert (int(io.q_meets), int(io.q_support)) == (memory[at].meets, memory[at].support)
        assert all(int(io[f"q_{word}"]) == words[at, word] for word in KEPT if word not in AXES)
        for of_y in range(2):
            io.read_y = of_y
            sim.clock.tick()
            sim.clock.tick()
            assert all(int(io[f"q_{word}"]) == axis_of(words[at, word], of_y) for word in AXES)
        assert int(io.q_start if int(io.ask_start) else io.q_id) == words[at, "start" if int(io.ask_start) else "id"]
        assert all(int(io[f"p_{word}"]) == words[values["from"], word] for word in WINDOW)
        after, e_slot = effects[values["e_slot"]], values["e_slot"]
        assert (int(io.e_marks), int(io.e_hidden), int(io.e_n_ev)) == (after.marks, after.hidden, after.n_ev)
        assert all(int(io[f"e_{word}"]) == words[e_slot, word] for word in MOVES)
    assert min(seen.values()) > 50
    assert min(full, most, again, resumed) > 5

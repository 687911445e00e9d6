# SPDX-License-Identifier: Apache-2.0
"""motion_context.v: each group of a slot as it was last written, of three slots at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

SIDE_W, PX_W, REL_W, SUP_W, ID_W = 20, 9, 6, 8, 7
EFFECT = ("state", "moves", "marks", "hidden", "middle", "n_ev")
AXES = ("sides", "refs", "moves")  # x in the upper half


def groups(slot_w: int) -> dict[str, dict[str, int]]:
    """What is written together, with widths; `hidden` is in the upper bits of `meets`."""
    state = {
        "sides": 4 * SIDE_W, "support": SUP_W, "merged": 1, "v": 32, "refs": 4 * SIDE_W, "corrections": 6, "looked": 8,
        "meets": 5, "runs": 8, "n_ev": 10, "has_partner": 1, "partner": slot_w, "together": 16, "usual": 24, "log2": 10,
    }  # fmt: skip
    window = {"box": 4 * PX_W, "window": 4 * PX_W}
    return {
        "keep": state,
        "keep_window": window,
        "keep_id": {"id": ID_W},
        "keep_start": {"start": SIDE_W + 1},
        "finish": {"state": 2, "moves": 4 * SIDE_W, "marks": 4, "meets": 5, "n_ev": 10, "middle": 2 * REL_W},
    }


def axis_of(word: int, of_y: int) -> int:
    return (word if of_y else word >> 2 * SIDE_W) % (1 << 2 * SIDE_W)


def show(io: Any, values: dict[str, int], of_y: int) -> None:
    """One axis of what is written."""
    io.sides_y = io.moves_y = of_y
    for name in AXES:
        setattr(io, name, axis_of(values[name], of_y))


@pytest.mark.parametrize("slot_w", [1, 3, 6])
def test_random_slots(slot_w: int) -> None:
    widths = {"SLOT_W": slot_w, "SIDE_W": SIDE_W, "PX_W": PX_W, "REL_W": REL_W, "SUP_W": SUP_W, "ID_W": ID_W}
    sim = load("motion_context", widths, extra_flags=PORTS_ONLY_FLAGS)
    io, rng, of = sim.io, np.random.default_rng(1), groups(slot_w)
    slots = 1 << slot_w
    bits_of = {name: bits for fields in of.values() for name, bits in fields.items()}
    read = {name: keep for keep in ("keep",) for name in of[keep]} | {"moves": "finish"}
    starts: dict[tuple[int, int], int] = {}  # of slot and axis
    has: dict[tuple[str, int, str], int] = {}
    apart = starts_read = 0
    for round_ in range(500 + 3 * slots):
        begins = round_ < 3 * slots  # first the ids, then the starts of x, then of y
        io.at = at = round_ % slots if begins else int(rng.integers(slots))
        io.on_y = on_y = int(round_ >= 2 * slots) if begins else int(rng.integers(2))
        values = {name: int.from_bytes(rng.bytes(16)) % (1 << bits) for name, bits in bits_of.items()}
        for name, value in values.items():
            if name not in AXES:
                setattr(io, name, value)
        first_y = int(rng.integers(2))
        show(io, values, first_y)
        values["hidden"] = values["meets"] >> 1
        for keep, fields in of.items():
            does = begins or rng.random() < 0.4
            if keep == "keep_id" and begins:
                does = round_ < slots
            if keep == "keep_start" and int(io.keep_id):  # never at once
                does = False
            setattr(io, keep, int(does))
            if does:
                has.update({(keep, at, name): values[name] for name in (*fields, "hidden")})
            if does and keep == "keep_start":
                starts[at, on_y] = values["start"]
        sim.clock.tick()
        for keep in of:
            setattr(io, keep, 0)
        show(io, values, 1 - first_y)
        sim.clock.tick()
        if round_ < 3 * slots - 1:
            continue
        # An answer of three other slots comes in each clock, two later.
        asked: list[tuple[int, int, int, int, int, int]] = []
        for _clock in range(4):
            io.at, io["from"], io.e_slot = (int(number) for number in rng.integers(slots, size=3))
            io.on_y, io.ask_start, io.read_y = (int(number) for number in rng.integers(2, size=3))
            asked.append((int(io.at), int(io["from"]), int(io.e_slot), int(io.on_y), int(io.ask_start), int(io.read_y)))
            sim.clock.tick()
            if len(asked) > 1:
                here, window_of, effect_of, axis, of_start, read_y = asked[-2]
                if of_start:
                    assert int(io.q_start) == starts[here, axis]
                else:
                    assert int(io.q_id) == has["keep_id", here, "id"]
                starts_read += of_start
                for name, keep in read.items():
                    word = has[keep, here, name]
                    assert int(getattr(io, f"q_{name}")) == (axis_of(word, read_y) if name in AXES else word), name
                for name in ("box", "window"):
                    assert int(getattr(io, f"p_{name}")) == has["keep_window", window_of, name]
                for name in EFFECT:
                    assert int(getattr(io, f"e_{name}")) == has["finish", effect_of, name], name
                apart += len({*asked[-2][:3]}) > 1 and asked[-1] != asked[-2]
    assert min(apart, starts_read) > 100

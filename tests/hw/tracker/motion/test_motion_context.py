# SPDX-License-Identifier: Apache-2.0
"""motion_context.v: each group of a slot as it was last written; box and window of another slot while it is put in force."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.testing import lint

SIDE_W, PX_W, ID_W = 20, 9, 7


def groups(slot_w: int) -> dict[str, dict[str, int]]:
    """What is written together, with widths."""
    state = {
        "v": 32, "refs": 4 * SIDE_W, "corrections": 6, "looked": 8, "meets": 5, "runs": 8, "n_ev": 10, "has_partner": 1,
        "partner": slot_w, "together": 16, "usual": 24, "log2": 10,
    }  # fmt: skip
    return {
        "keep": state,
        "keep_window": {"box": 4 * PX_W, "window": 4 * PX_W},
        "keep_id": {"id": ID_W},
        "keep_start": {"start": 2 * SIDE_W + 2},
    }


@pytest.mark.parametrize("slot_w", [1, 3])
def test_random_slots(slot_w: int) -> None:
    sim = load("motion_context", {"SLOT_W": slot_w, "SIDE_W": SIDE_W, "PX_W": PX_W, "ID_W": ID_W}, extra_flags=PORTS_ONLY_FLAGS)
    io, rng, of = sim.io, np.random.default_rng(1), groups(slot_w)
    slots = 1 << slot_w
    widths = {name: bits for fields in of.values() for name, bits in fields.items()}
    has: dict[tuple[int, str], int] = {}
    compared = 0
    for round_ in range(500 + slots):
        io.at = at = round_ if round_ < slots else int(rng.integers(slots))
        values = {name: int.from_bytes(rng.bytes(16)) % (1 << bits) for name, bits in widths.items()}
        for name, value in values.items():
            setattr(io, name, value)
        io.puts = 0
        for keep, fields in of.items():
            does = round_ < slots or rng.random() < 0.4
            setattr(io, keep, int(does))
            if does:
                has.update({(at, name): values[name] for name in fields})
        sim.clock.tick()
        for keep in of:
            setattr(io, keep, 0)
        if round_ < slots - 1:
            continue
        # An answer of another slot comes in each clock, two later.
        asked: list[int] = []
        placed: list[int] = []
        for _clock in range(4):
            io.at, io.puts, io.put_slot = (int(number) for number in rng.integers((slots, 2, slots)))
            asked.append(int(io.at))
            placed.append(int(io.put_slot) if int(io.puts) else asked[-1])
            sim.clock.tick()
            if len(asked) > 1:
                for name in ("box", "window", "n_ev"):
                    assert int(getattr(io, f"p_{name}")) == has[placed[-2], name]
                for name in widths.keys() - {"box", "window"}:
                    assert int(getattr(io, f"q_{name}")) == has[asked[-2], name], name
                compared += asked[-1] != asked[-2]
    assert compared > 100


def test_lint() -> None:
    assert lint("motion_context") == (0, "")
    assert lint("motion_context", SLOT_W=1) == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""motion_lives.v: which slots have a visible track, a candidate, a track that may return, and four corrections behind them."""

from __future__ import annotations

import numpy as np

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load

N = 5
COMMANDS = ("seed", "settle", "appear", "lapse", "leave")


def test_random_lives() -> None:
    """Every life goes on by any of the steps that are open to it."""
    sim, rng = load("motion_lives", {"N": N, "SLOT_W": 3}, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
    io = sim.io
    states, settled = ["free"] * N, [False] * N
    seen: dict[str, int] = {}
    io.rst = 1
    sim.clock.tick()
    for _clock in range(4_000):
        assert int(io.visible) == sum(1 << i for i in range(N) if states[i] == "visible")
        assert int(io.candidate) == sum(1 << i for i in range(N) if states[i] == "candidate")
        assert int(io.left) == sum(1 << i for i in range(N) if states[i] == "left")
        lives = [i for i in range(N) if states[i] in ("visible", "candidate")]
        assert all(int(io.settled) >> i & 1 == settled[i] for i in lives)
        for name in COMMANDS:
            setattr(io, name, 0)
        io.rst = int(rng.random() < 0.002)
        io.at = slot = int(rng.integers(N))
        open_to = {
            "free": ["seed"],
            "candidate": ["none", "lapse", "appear" if settled[slot] else "settle"],
            "visible": ["none", "lapse", "leave"],
            "left": ["none", "lapse", "seed"],
        }
        command = str(rng.choice(open_to[states[slot]]))
        if command != "none":
            setattr(io, command, 1)
            io.lapse = int(command in ("lapse", "leave"))
            after = {"seed": "candidate", "settle": "candidate", "appear": "visible", "lapse": "free", "leave": "left"}
            states[slot] = after[command]
            settled[slot] = command != "seed" and (settled[slot] or command == "settle")
            seen[command] = seen.get(command, 0) + 1
        if int(io.rst):
            states, settled = ["free"] * N, [False] * N
        sim.clock.tick()
    assert set(seen) == set(COMMANDS)
    assert min(seen.values()) > 100

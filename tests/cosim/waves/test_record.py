# SPDX-License-Identifier: Apache-2.0
"""Recording a simulation that is driven by hand."""

from __future__ import annotations

from pathlib import Path

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from evcot_cosim.waves import Wave, always, recorded


def test_a_recorded_input_is_seen_before_the_edge_that_takes_it(tmp_path: Path) -> None:
    """pyverilator's own dumps would show a seed together with the state that it has become."""
    sim = load("lfsr", {"WIDTH": 8})
    reset(sim)
    with recorded(sim, tmp_path / "seed.vcd") as path:
        sim.io.load = 1
        for seed in (1, 2, 3):
            sim.io.seed = seed
            sim.clock.tick()
        sim.io.load = 0
        sim.clock.tick()
    s = Wave.open(path).sampled("TOP.clk")
    assert s["TOP.seed"].values.tolist() == [1, 2, 3, 3]
    assert s["TOP.state"].values.tolist() == [0, 1, 2, 3]
    assert always(s["TOP.state"] == s["TOP.seed"].previous(), where=s["TOP.load"].previous()) == 3
    assert list(tmp_path.iterdir()) == [path]

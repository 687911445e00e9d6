# SPDX-License-Identifier: Apache-2.0
"""Waveforms recorded by hand, and the guide to them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from evcot_cosim.waves import Wave, WaveformError, after, always, recorded
from evcot_cosim.waves import __all__ as waveform_names


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


VcdText = Callable[..., str]

GUIDE = Path(__file__).parents[3] / "docs" / "waveforms.md"


def test_the_examples_of_the_guide_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vcd_text: VcdText) -> None:
    monkeypatch.chdir(tmp_path)
    signals = {
        "rst": "1000000000", "req": "0010010000", "ack": "0001001000", "state": [0, 1, 2, 4, 1, 2, 5, 1, 1, 1],
        "count": [0, 1, 2, 3, 4, 5, 6, 7, 8, 12], "s_valid": "0111001100", "s_ready": "1001110100",
        "s_x": [0, 7, 7, 7, 1, 2, 3, 3, 4, 5],
    }  # fmt: skip
    Path("run.vcd").write_text(vcd_text(signals))
    names: dict[str, object] = {}
    examples = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    assert len(examples) == 4
    for example in examples:
        exec(compile(example, str(GUIDE), "exec"), names)
    used = "\n".join(examples)
    for name in waveform_names:
        assert name in used or name[0].isupper(), f"{name} has no example"


def test_the_failure_that_the_guide_shows_is_what_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vcd_text: VcdText
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("run.vcd").write_text(vcd_text({"req": "0010010000", "ack": "0001000000"}))
    s = Wave.open("run.vcd").sampled("clk")
    with pytest.raises(WaveformError) as error:
        after(s["req"].rose).within(3).expect(s["ack"])
    assert f"```text\n{error.value}\n```" in GUIDE.read_text()

# SPDX-License-Identifier: Apache-2.0
"""docs/waveforms.md: its examples run, and every name has one."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from evcot_cosim.waves import Wave, WaveformError, after
from evcot_cosim.waves import __all__ as waveform_names

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

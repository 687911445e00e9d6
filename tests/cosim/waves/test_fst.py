# SPDX-License-Identifier: Apache-2.0
"""The FST of a waveform says what its VCD says, read back by GTKWave's own converter where that is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import OutputError
from evcot.hardware.modules import Module
from evcot_cosim.waves import Wave
from evcot_cosim.waves.fst import fst_writer, write_fst

pytestmark = pytest.mark.skipif(fst_writer() is None, reason="needs pylibfst")


@pytest.mark.skipif(shutil.which("fst2vcd") is None, reason="needs fst2vcd, of GTKWave")
def test_says_what_the_vcd_says(vcds: dict[Module, Path], tmp_path: Path) -> None:
    vcd = vcds["cot_array"]
    write_fst(vcd, tmp_path / "x.fst")
    assert (tmp_path / "x.fst").stat().st_size < vcd.stat().st_size / 4
    subprocess.run(["fst2vcd", "-f", "x.fst", "-o", "back.vcd"], cwd=tmp_path, check=True, capture_output=True)
    before, after = Wave.open(vcd), Wave.open(tmp_path / "back.vcd")
    assert before.timescale == after.timescale
    names = {entry.path: entry.width for entry in before.signals}
    assert names == {entry.path: entry.width for entry in after.signals}
    s, t = before.sampled("TOP.clk"), after.sampled("TOP.clk")
    assert np.array_equal(s.times, t.times)
    for path in names:
        assert np.array_equal(s[path].values, t[path].values), path


def test_is_whole_or_not_there(vcds: dict[Module, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OutputError, match=r"none/x\.fst: cannot be written"):
        write_fst(vcds["cot_array"], tmp_path / "none" / "x.fst")

    def full(source: object, target: object) -> None:
        raise OSError(28, "No space left on device")

    for call in ("replace", "link", "rename"):
        monkeypatch.setattr(os, call, full)
    with pytest.raises(OutputError, match=r"x\.fst: cannot be written: No space left on device"):
        write_fst(vcds["cot_array"], tmp_path / "x.fst")
    assert not list(tmp_path.iterdir())

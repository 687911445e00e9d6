# SPDX-License-Identifier: Apache-2.0
"""The FST of a waveform says what its VCD says, read back by GTKWave's own converter where that is installed."""

from __future__ import annotations

import errno
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import OutputError
from evcot.hardware.modules import Module
from evcot_cosim.waves import Wave
from evcot_cosim.waves.fst import fst_writer, write_fst
from support.full_disk import full_disk

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


def test_says_why_a_file_cannot_be_created(vcds: dict[Module, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The library opens six files and allocates memory, and says only whether that worked."""
    few = "import resource, runpy, sys; resource.setrlimit(resource.RLIMIT_NOFILE, (7, 7)); "
    run = "sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')"
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\nshift\nexec {shlex.quote(sys.executable)} -c {shlex.quote(few + run)} "$@"\n')
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    with pytest.raises(OutputError, match=rf"x\.fst: cannot be written: {os.strerror(errno.EMFILE)} \(an FST needs"):
        write_fst(vcds["cot_array"], tmp_path / "x.fst")
    assert list(tmp_path.iterdir()) == [python]


@pytest.mark.parametrize("room", [0, 300, 4_096, 8_192, -2_000, -100, -1])
def test_cut_off_file_is_refused(vcds: dict[Module, Path], room: int, tmp_path: Path) -> None:
    """The library ignores that the disk is full: here, that a file may have so many bytes and no more."""
    write_fst(vcds["cot_array"], tmp_path / "whole.fst")
    room += (tmp_path / "whole.fst").stat().st_size if room < 0 else 0
    message = r"x\.fst: cannot be written: (is cut off after \d+ bytes|pylibfst was ended by)"
    with full_disk(room), pytest.raises(OutputError, match=message):
        write_fst(vcds["cot_array"], tmp_path / "x.fst")
    assert [path.name for path in tmp_path.iterdir()] == ["whole.fst"]


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

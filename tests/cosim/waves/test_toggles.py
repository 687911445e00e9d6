# SPDX-License-Identifier: Apache-2.0
"""Toggles counted in a VCD: by hand, against vcdvcd on a waveform of the RTL, and what a damaged file is answered with."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.errors import OutputError
from evcot_cosim.rtl.build import load
from evcot_cosim.waves.errors import VcdError
from evcot_cosim.waves.toggles import Activity, count_toggles, write_saif
from evcot_cosim.waves.vcd import parse

HEADER = """$timescale 1ns $end
$scope module top $end
$var wire 1 ! clk $end
$var wire 4 "# bus [3:0] $end
$scope module u_in $end
$var wire 1 ! clk $end
$var reg 3 $ odd [0:2] $end
$upscope $end
$upscope $end
$enddefinitions $end
"""


def activity(tmp_path: Path, changes: str, header: str = HEADER) -> Activity:
    path = tmp_path / "waves.vcd"
    path.write_text(header + changes)
    return count_toggles(path)


def of(found: Activity, path: str) -> tuple[list[int], list[int], list[int]]:
    """Toggles, time at 1 and time unknown of each bit, the lowest first."""
    bits = next(found.bits(signal) for signal in found.signals if signal.path == path)
    return found.toggles[bits].tolist(), found.high[bits].tolist(), found.unknown[bits].tolist()


def test_changes_and_times_are_those_of_each_bit(tmp_path: Path) -> None:
    found = activity(tmp_path, '#10\n$dumpvars\n0!\nb0011 "#\nb1 $\n$end\n#15\n1!\n#20\n0!\nb110 "#\n#25\n1!\n#30\n')
    assert (found.duration, found.unit) == (20, "1ns")
    assert of(found, "top.clk") == ([3], [5 + 5], [0])
    assert of(found, "top.bus") == ([1, 0, 1, 0], [10, 20, 10, 0], [0] * 4)  # 0011, then 0110
    assert of(found, "top.u_in.odd") == ([0] * 3, [20, 0, 0], [0] * 3)
    assert of(found, "top.u_in.clk") == of(found, "top.clk")


def test_what_is_unknown_does_not_toggle(tmp_path: Path) -> None:
    found = activity(tmp_path, '#0\nx!\nbx "#\n#4\n1!\nb1z0 "#\n#6\nx!\n#7\n0!\n#9\n$comment 1! b1 "# $end\n1!\n#10\n')
    assert of(found, "top.clk") == ([1], [2 + 1], [4 + 1])
    assert of(found, "top.bus") == ([0] * 4, [0, 0, 6, 0], [4, 10, 4, 4])  # 1z0 has a 0 above
    assert of(found, "top.u_in.odd") == ([0] * 3, [0] * 3, [10] * 3)  # never told


def test_equal_to_what_vcdvcd_reads_of_the_rtl(tmp_path: Path) -> None:
    """Every signal of a window, random inputs: the same changes as in the lists of another reader."""
    path = tmp_path / "waves.vcd"
    sim = load("cot_window", {}, extra_flags=("--trace-max-array", "64"))
    rng = np.random.default_rng(3)
    sim.start_vcd_trace(str(path), False)
    for _ in range(200):
        for name, bits in (("asked", 1), ("centre", 13), ("radius", 9), ("inset", 10)):
            sim.io[name] = int(rng.integers(1 << bits))
        sim.add_to_vcd_trace()
    sim.stop_vcd_trace()
    found, other, moved = count_toggles(path), parse(path), 0
    for signal in found.signals:
        texts = [text.rjust(signal.width, "0") for _, text in other.data[signal.code].tv]
        changed = sum(a != b for before, after in pairwise(texts) for a, b in zip(before, after, strict=True))
        assert found.toggles_of(signal) == changed, signal.path
        moved += changed
    assert moved > 1000


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ("#0\n0!\n#5\n1!\n#4\n", r"waves.vcd: byte \d+: time runs backwards: must never decrease"),
        ("#0\n0!\n1", r"waves.vcd: byte \d+: not a value change"),
        ('#0\nb10101 "#\n#1\n', r"waves.vcd: byte \d+: not a value change"),  # five bits of four
        ("#0\n1%\n#1\n", r"waves.vcd: byte \d+: not a value change"),  # not declared
        ('#0\nb12 "#\n#1\n', r"waves.vcd: byte \d+: not a value change"),
        ("#0x\n", r"waves.vcd: byte \d+: not a value change"),
    ],
)
def test_a_damaged_file_is_named(tmp_path: Path, changes: str, message: str) -> None:
    with pytest.raises(VcdError, match=message):
        activity(tmp_path, changes)


@pytest.mark.parametrize("text", ["", "nothing", HEADER.replace("$enddefinitions $end", "")])
def test_another_file_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(VcdError, match=r"waves\.vcd: not a"):
        activity(tmp_path, "", text)


SAIF = r"""(SAIFILE
(SAIFVERSION "2.0")
(DIRECTION "backward")
(DESIGN "top")
(PROGRAM_NAME "evcot") (VERSION "X.Y")
(DIVIDER / )
(TIMESCALE 1 ns)
(DURATION 20)
(INSTANCE top
(NET
(clk (T0 10) (T1 10) (TX 0) (TC 3) (IG 0))
(bus\[0\] (T0 10) (T1 10) (TX 0) (TC 1) (IG 0))
(bus\[1\] (T0 0) (T1 20) (TX 0) (TC 0) (IG 0))
(bus\[2\] (T0 10) (T1 10) (TX 0) (TC 1) (IG 0))
(bus\[3\] (T0 20) (T1 0) (TX 0) (TC 0) (IG 0))
)
(INSTANCE u_in
(NET
(clk (T0 10) (T1 10) (TX 0) (TC 3) (IG 0))
(odd\[2\] (T0 0) (T1 20) (TX 0) (TC 0) (IG 0))
(odd\[1\] (T0 20) (T1 0) (TX 0) (TC 0) (IG 0))
(odd\[0\] (T0 20) (T1 0) (TX 0) (TC 0) (IG 0))
)
)
)
)
"""


def test_saif_has_every_bit_by_its_index_in_its_instance(tmp_path: Path) -> None:
    found = activity(tmp_path, '#10\n0!\nb0011 "#\nb1 $\n#15\n1!\n#20\n0!\nb110 "#\n#25\n1!\n#30\n')
    path = tmp_path / "waves.saif"
    write_saif(found, path, "top", found.signals)
    assert path.read_text() == SAIF.replace("X.Y", evcot.__version__)
    with pytest.raises(OutputError, match=r"waves\.saif"):
        write_saif(found, path, "top", found.signals)
    write_saif(found, path, "top", found.signals[:1], force=True)
    assert path.read_text().count("(TC ") == 1

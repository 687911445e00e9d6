# SPDX-License-Identifier: Apache-2.0
"""A VCD means the same wherever its white space is, and what cannot be read is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import OutputError
from evcot_cosim.waves import Wave
from evcot_cosim.waves import vcd_lines as module
from evcot_cosim.waves.errors import VcdError
from support.full_disk import full_disk

HEADER = """$date
    big bang $end
$version Riviera-PRO $end $comment $var wire 1 ? none $end
$timescale
  1
  ns $end
$scope module top $end $var wire 1 ! a $end
$var reg 4 " n [3:0] $end $var real 64 % r $end
$scope module  $end $var wire 1 $auto inner$1 $end $upscope $end
$scope module \\$scopeinfo $end $var wire 1 & $upscope$2 $end $upscope $end
$upscope $end $enddefinitions $end
"""
CHANGES = """#0
$dumpvars
0!
b0 "
r0.5 %
0$auto
1&
$end
#5
1!
b101 "
sred %
#10
0!
b11 "
1$auto
#15
"""
BODIES = {
    "a line each": CHANGES,
    "one line": " ".join(CHANGES.split()),
    "one line with tabs": "\t".join(CHANGES.split()),
    "a word each": "\n".join(CHANGES.split()),
    "carriage returns and tabs": CHANGES.replace("\n", "\r\n").replace(" ", "\t"),
    "times with fractions of zero": CHANGES.replace("#5", "#5.0").replace("#10", "#10.00"),
    "a comment between changes": CHANGES.replace("#5", "$comment b1 0! #99 $end\n#5"),
    "levels of std_logic": CHANGES.replace("1!", "H!").replace("#10\n0!", "#10\nL!"),
    "capital letters": CHANGES.replace("b", "B"),
}


def made(folder: Path, text: str) -> Path:
    (folder / "w.vcd").write_text(text)
    return folder / "w.vcd"


def changes_of(wave: Wave, name: str) -> list[tuple[int, str]]:
    signal = wave[name]
    return [(int(time), signal.text(i)) for i, time in enumerate(signal.times)]


@pytest.mark.parametrize("block", [1 << 20, 7])
@pytest.mark.parametrize("body", BODIES)
def test_white_space_changes_nothing(body: str, block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_BLOCK", block)
    monkeypatch.setattr(module, "_LONGEST", 2 * block + 40)
    wave = Wave.open(made(tmp_path, HEADER + BODIES[body]))
    assert changes_of(wave, "top.a") == [(0, "0"), (5, "1"), (10, "0")]
    assert changes_of(wave, "top.n") == [(0, "0"), (5, "5"), (10, "3")]
    assert changes_of(wave, "top.inner$1") == [(0, "0"), (10, "1")]
    assert changes_of(wave, "top.\\$scopeinfo.$upscope$2") == [(0, "1")]
    assert (wave.end_time, wave.timescale.text(3)) == (15, "3 ns")


def test_a_vector_without_digits_is_unknown(tmp_path: Path) -> None:
    wave = Wave.open(made(tmp_path, HEADER + CHANGES.replace('b101 "', 'b "')))
    assert changes_of(wave, "top.n") == [(0, "0"), (5, "x"), (10, "3")]


def test_a_signal_that_is_left_out_is_named(tmp_path: Path) -> None:
    wave = Wave.open(made(tmp_path, HEADER + CHANGES))
    for name in ("r", "top.r"):
        with pytest.raises(VcdError, match=f"w.vcd: {name} is a real, which is left out: must be a signal of bits"):
            wave[name]


def test_full_temporary_folder_is_not_an_error_of_the_vcd(tmp_path: Path) -> None:
    vcd = made(tmp_path, HEADER + CHANGES)
    with full_disk(10), pytest.raises(OutputError, match=r"^/.*/lines\.vcd: cannot be written: File too large$"):
        Wave.open(vcd)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER.replace("wire 1 !", "port 1 !") + CHANGES, "is an extended VCD"),
        (HEADER + "#0\npD 6 0 !\n", "is an extended VCD"),
        (HEADER + "$dumpports\n", "is an extended VCD"),
        (HEADER + "#0\nq!\n", "'q!': must be a time or a value change"),
        (HEADER + "#1.5\n", "#1.5: must be a whole number of time units, not negative"),
        (HEADER + "#0\nb1", "not a whole VCD: the last value has no code"),
        (HEADER.replace("ns", "nm"), "$timescale 1 nm: must be 1, 10 or 100 s, ms, us, ns, ps or fs"),
        (HEADER.replace("wire 1 ! a", "wire 1 !"), "$var wire 1 !: must have a type, a size, a code and a name"),
        (HEADER.replace("wire 1 ! a", "wire 1 $scope a"), "has a keyword as its code"),
        ("$upscope $end", "$upscope: must close a scope"),
        ("$scope module top $end", "not a VCD: must begin with declarations"),
        ("\x7fELF" * 9, "not a VCD: must begin with declarations"),
        ("x" * 5_000_000, "not a whole VCD: a word has more than 4194304 characters"),
    ],
)
def test_refused_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(VcdError) as caught:
        Wave.open(made(tmp_path, text))
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path}/w.vcd: ")
    assert "\n" not in str(caught.value)

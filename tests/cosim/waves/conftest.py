# SPDX-License-Identifier: Apache-2.0
"""Waveforms given by one value per cycle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from evcot_cosim.waves import Samples, Wave

Values = Sequence[int | str]


def text_of(signals: dict[str, Values], width: int = 4) -> str:
    """One value per cycle for each signal, an integer or the bits as text. Cycle i's edge is at 10 i + 5.

    Text as a whole is a one-bit signal, "0110"; anything else has `width` bits. Unchanged values are not repeated.
    """
    codes = {name: chr(ord("a") + i) for i, name in enumerate(signals)}
    widths = {name: 1 if isinstance(values, str) else width for name, values in signals.items()}
    lines = ["$timescale 1ns $end", "$scope module TOP $end", "$var wire 1 ! clk $end", "$scope module dut $end"]
    for name, code in codes.items():
        bits = widths[name]
        lines.append(f"$var reg {bits} {code} {name} {f'[{bits - 1}:0] ' if bits > 1 else ''}$end")
    lines += ["$upscope $end", "$upscope $end", "$enddefinitions $end"]
    shown: dict[str, int | str] = {}
    for i in range(max((len(values) for values in signals.values()), default=0)):
        lines += [f"#{10 * i}", "0!"]
        for name, values in signals.items():
            if shown.get(name) != values[i]:
                value = shown[name] = values[i]
                text = f"{value:b}" if isinstance(value, int) else value
                lines.append(f"{text}{codes[name]}" if widths[name] == 1 else f"b{text} {codes[name]}")
        lines += [f"#{10 * i + 5}", "1!"]
    return "\n".join(lines) + "\n"


@pytest.fixture
def vcd_text() -> Callable[..., str]:
    """The text of a VCD."""
    return text_of


@pytest.fixture
def sampled(tmp_path: Path) -> Callable[..., Samples]:
    """Sampled signals of a waveform given by one value per cycle."""

    def make(**signals: Values) -> Samples:
        path = tmp_path / "run.vcd"
        path.write_text(text_of(signals))
        return Wave.open(path).sampled("clk")

    return make

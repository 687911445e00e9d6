# SPDX-License-Identifier: Apache-2.0
"""Temporal properties of waveforms in readable Python; docs/waveforms.md has an example of each.

wave = Wave.open("run.vcd")
s = wave.sampled("clk")
after(s["req"].rose).within(3).expect(s["ack"])
"""

from __future__ import annotations

from .checks import After, after, always, handshake_stable, never, one_of, sometime, stable_until, transitions
from .errors import PropertyError, VcdError, WaveformError
from .expr import Expr
from .gtkwave import write_view
from .record import recorded
from .vcd import Declared, Signal
from .wave import Samples, Wave

__all__ = [
    "After",
    "Declared",
    "Expr",
    "PropertyError",
    "Samples",
    "Signal",
    "VcdError",
    "Wave",
    "WaveformError",
    "after",
    "always",
    "handshake_stable",
    "never",
    "one_of",
    "recorded",
    "sometime",
    "stable_until",
    "transitions",
    "write_view",
]

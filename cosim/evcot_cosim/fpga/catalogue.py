# SPDX-License-Identifier: Apache-2.0
"""Catalogue of the measured modules, one line each.

Parameters not given here have their defaults. Time enters as single pulses of a prescaler, TICK_W = 1.
Filters with a memory are measured for two sensors: 128 x 128, and 346 x 260 where the name says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

from evcot.errors import ConfigError

__all__ = ["MODULES", "Answer", "Module", "chosen"]

Answer = Literal["record", "centre", "beat", "token", "event", "aer_event", "aer_request"]
"""The output to which latency is counted.

record, centre, beat: the output for the event that moves the centre of the last of all trackers, counted from the token, from
the request, and from the event's beat to the first beat of the record. token: the same token. event: the decoded event of a
word. aer_event: the event of a request. aer_request: the request for an event.
"""


@dataclass(frozen=True)
class Module:
    """One line of the table.

    Attributes:
        name: name on the command line and in the figures.
        top: name of the Verilog module.
        parameters: parameters that differ from their defaults.
        sizes: values of N to measure; empty for a module without N.
        usual: those of `sizes` that are measured by default.
        answer: the output to which its latency is counted; None if it has no such output.
        asks_mhz: the Fmax that it must reach wherever it is routed, by its own constraint; None if it has none.
        small: it is mapped for few LUTs where the device has commands for that.
        without: devices without the block RAM that it needs.
    """

    name: str
    top: str
    parameters: Mapping[str, int] = field(default_factory=dict)
    sizes: tuple[int, ...] = ()
    usual: tuple[int, ...] = ()
    answer: Answer | None = None
    asks_mhz: float | None = None
    small: bool = False
    without: tuple[str, ...] = ()

    @property
    def shown(self) -> int | None:
        """The size that a table of all modules shows: the first of the usual ones; None if it has no N."""
        return self.usual[0] if self.usual else None

    def at(self, n: int | None) -> dict[str, int]:
        """All parameters for one size."""
        return {**self.parameters, **({} if n is None else {"N": n})}


_SIZES = (1, 2, 4, 8, 16, 32, 64)
_TICK = {"TICK_W": 1}
_SMALL = {"TICK_W": 1, "X_W": 7, "Y_W": 7}
# What the host makes whole again: with it 8 slots of the array fit the block RAMs of an HX8K.
_NARROW = {"TICK_W": 20, "SEQ_W": 32, "ID_W": 16, "TIME_W": 32, "TC_W": 22}
_PIXELS = {"WIDTH": 128, "HEIGHT": 128}
# Chains with memories of cells: HAS = 127 is all filters but rowcol, 191 all but decay.
_VGA = {"TICK_W": 1, "X_W": 10, "Y_W": 9, "WIDTH": 640, "HEIGHT": 480}
_HD = {"TICK_W": 1, "X_W": 11, "Y_W": 10, "WIDTH": 1280, "HEIGHT": 720}
# As in hw/fpga/examples: kv260_evcot.v and davis_evcot.v.
_KV260 = {
    "SOURCES": 16, "SOURCE": 4, "WIDTH": 1280, "HEIGHT": 720, "X_W": 11, "Y_W": 10, "DATA_W": 64,
}  # fmt: skip

_DAVIS = {
    "SOURCES": 4, "SOURCE": 2, "WIDTH": 240, "HEIGHT": 180, "X_W": 8, "Y_W": 8, "DATA_W": 32
}  # fmt: skip

# The default configuration (trackers/presets.py) between AXI streams, and for larger sensors, HD with
# cells of 2 x 2 pixels.
_DEFAULT = {"TRACKER": 2, "HAS": 24, "CELL_PX": 1, "TICKS": 0}
_DEFAULT_VGA = {**_DEFAULT, "X_W": 10, "Y_W": 9, "WIDTH": 640, "HEIGHT": 480}
_DEFAULT_HD = {**_DEFAULT, "CELL_PX": 2, "X_W": 11, "Y_W": 10, "WIDTH": 1280, "HEIGHT": 720}

_TABLE = (
    Module("evcot_top_default", "evcot_top", _DEFAULT, (8, 16, 32), (16,), asks_mhz=100, small=True),
    Module("evcot_top_classifier", "evcot_top", {**_DEFAULT, "CLASSIFY": 1}, (8,), (8,), small=True),
    Module("evcot_top_default_640x480", "evcot_top", _DEFAULT_VGA, (16,), (16,), small=True),
    Module("evcot_top_default_1280x720", "evcot_top", _DEFAULT_HD, (16,), (16,), small=True),
    Module("cot", "cot", _TICK, answer="record"),
    Module("cot_chain", "cot_chain", _TICK, (1, 2, 4, 8), (8,), "record"),
    Module("cot_array", "cot_array", _TICK, _SIZES, (8, 32), "record"),
    Module("cot_array_narrow", "cot_array", _NARROW, (8,), (8,), "record"),
    Module("cot_motion", "cot_motion", _TICK, _SIZES, (8,)),
    Module("classifier", "classifier", {}, (4, 8, 16), (8,), without=("up5k", "hx8k")),  # a RAM that both ports write
    Module("cot_published_chain", "cot_published_chain", answer="centre"),
    Module("filter_region", "filter_region", _SMALL, answer="token"),
    Module("filter_polarity", "filter_polarity", _SMALL, answer="token"),
    Module("filter_mask", "filter_mask", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_refractory", "filter_refractory", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_activity", "filter_activity", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_recent", "filter_recent", _SMALL, answer="token"),
    Module("filter_decay", "filter_decay", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_rowcol", "filter_rowcol", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_cells", "filter_cells", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_cells_346x260", "filter_cells", _TICK, answer="token"),
    Module("filter_chain", "filter_chain", {**_SMALL, **_PIXELS}, answer="token"),
    Module("filter_chain_346x260", "filter_chain", _TICK, answer="token"),
    Module("filter_chain_346x260_cells", "filter_chain", {**_TICK, "HAS": 127, "CELL_PX": 1}, answer="token"),
    Module("filter_chain_640x480_cells", "filter_chain", {**_VGA, "HAS": 127, "CELL_PX": 2}, answer="token"),
    Module("filter_chain_1280x720_coarse", "filter_chain", {**_HD, "HAS": 127, "CELL_PX": 4}, answer="token"),
    Module("filter_chain_1280x720_fine", "filter_chain", {**_HD, "HAS": 191, "CELL_PX": 2}, answer="token"),
    Module("hough_lines", "hough_lines", _TICK, answer="token"),
    Module("evt2_decoder", "evt2_decoder", answer="event"),
    Module("evt21_decoder", "evt21_decoder", answer="event"),
    Module("evt3_decoder", "evt3_decoder", answer="event"),
    Module("lfsr_event_source", "lfsr_event_source"),
    Module("overload_fifo", "overload_fifo", answer="token"),
    Module("aer_in", "aer_in", answer="aer_event"),
    Module("aer_out", "aer_out", answer="aer_request"),
    Module("evcot_top", "evcot_top", {}, _SIZES, (8,), "beat"),
    Module("evcot_top_kv260", "evcot_top", _KV260, (8,), (8,), asks_mhz=125),
    Module("evcot_top_davis", "evcot_top", _DAVIS, (4,), (4,), asks_mhz=100),
)

MODULES: Mapping[str, Module] = MappingProxyType({module.name: module for module in _TABLE})
"""By name."""


def chosen(names: list[str]) -> list[Module]:
    """The modules with these names; all for an empty list.

    Raises:
        ConfigError: there is no such module.
    """
    for name in names:
        if name not in MODULES:
            raise ConfigError(f"module {name}: not measured; there are {', '.join(MODULES)}")
    return [MODULES[name] for name in names or MODULES]

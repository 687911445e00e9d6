# SPDX-License-Identifier: Apache-2.0
"""The published tracker and its cascade in hardware, clock by clock: plays stories to both hardware and model.

A story is a list of events, with clocks counted from the end of initialisation; both must match at every clock.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.hardware.published.model import (
    CASCADE_INPUT,
    CASCADE_OUTPUT,
    SELECT,
    SELECT_NONE,
    TRACKER_INPUT,
    TRACKER_OUTPUT,
    Handshakes,
    Played,
    PublishedCascade,
    PublishedConfig,
)

from ..rtl.build import PORTS_ONLY_FLAGS, RANDOM_INITIAL_FLAGS, build

__all__ = [
    "CASCADE",
    "LIBRARY",
    "TRACKER",
    "Event",
    "Ports",
    "Top",
    "at",
    "equal",
    "play",
    "quiet",
    "reset_cascade",
    "rtl",
    "simulation",
]


Ports = NDArray[np.void]


@dataclass(frozen=True)
class Top:
    """A module with a clock `clk`: its name, its parameters, and its other ports at one clock.

    Attributes:
        given, read: input ports that are set and output ports that are read at each clock, none wider than 32 bits.
        valid_with: output ports that are read as 0 while another, active low, is high.
    """

    module: str
    parameters: tuple[tuple[str, int], ...]
    given: np.dtype[np.void]
    read: np.dtype[np.void]
    valid_with: tuple[tuple[str, str], ...] = ()


@cache
def simulation(top: Top, initial_seed: int = 0) -> PyVerilator:
    """The compiled module with a C++ loop that plays one row of port values per clock.

    Args:
        initial_seed: of the values that registers have before the first reset; 0: zeros.
    """
    given, read, model, valid_with = top.given, top.read, f"V{top.module}", dict(top.valid_with)
    sets = gets = ""
    for name, (kind, offset, *_) in (given.fields or {}).items():
        sets += f"{{ uint32_t v = 0; memcpy(&v, in + {offset}, {kind.itemsize}); top->{name} = v; }}"
    for name, (kind, offset, *_) in (read.fields or {}).items():
        value = f"top->{valid_with[name]} ? 0 : top->{name}" if name in valid_with else f"top->{name}"
        gets += f"{{ uint32_t v = {value}; memcpy(out + {offset}, &v, {kind.itemsize}); }}"
    drive = f"""#include <cstring>
#include "{model}.h"
extern "C" void evcot_clocks({model}* top, int64_t n, const uint8_t* in, uint8_t* out) {{
    for (; n; --n, in += {given.itemsize}, out += {read.itemsize}) {{
        top->clk = 0; {sets} top->eval(); {gets} top->clk = 1; top->eval();
    }}
}}
"""
    flags = (*PORTS_ONLY_FLAGS, *(RANDOM_INITIAL_FLAGS if initial_seed else ()))
    return build(top.module, dict(top.parameters), {"clocks.cpp": drive}, extra_flags=flags).load(initial_seed)


def rtl(top: Top, inputs: Ports, sim: PyVerilator | None = None) -> Ports:
    """The hardware's output ports just before each clock edge, in a `simulation` that goes on from call to call."""
    sim = sim or simulation(top)
    inputs, outputs = np.ascontiguousarray(inputs), np.zeros(len(inputs), top.read)
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (inputs, outputs))
    sim.lib.evcot_clocks(ctypes.c_void_p(sim.model), ctypes.c_int64(len(inputs)), *pointers)
    return outputs


Event = tuple[int, int, int]  # clock, high, low


# Ports that are valid only while their request is low. The library's line has a word at all times.
_VALID_WITH = tuple((f"m_{port}_{line}", f"m_{port}_req_n") for port in ("pass", "event", "centre") for line in ("high", "low"))

TRACKER = Top("cot_published", (), TRACKER_INPUT, TRACKER_OUTPUT, _VALID_WITH)
CASCADE = Top(
    "cot_published_chain", (("LIBRARY_LINE", 0),), CASCADE_INPUT, CASCADE_OUTPUT, (("m_word", "m_req_n"), *_VALID_WITH)
)
LIBRARY = Top("cot_published_chain", (("LIBRARY_LINE", 1),), CASCADE_INPUT, CASCADE_OUTPUT, _VALID_WITH)


def quiet(top: Top, n: int) -> Ports:
    """Inputs for n clocks without a request or an acknowledge."""
    rows = np.zeros(n, top.given)
    for name in rows.dtype.names or ():
        if name.endswith("_n"):
            rows[name] = 1
    return rows


def equal(found: Ports, expected: Ports, inputs: Ports, seed: object = None) -> None:
    """Raise AssertionError with the first clock at which two traces differ."""
    if len(differing := np.flatnonzero(found != expected)):
        at = differing[0]
        raise AssertionError(f"seed {seed}, clock {at}, {inputs[at]}: hardware {found[at]}, model {expected[at]}")


def reset_cascade(top: Top, configs: Sequence[PublishedConfig]) -> None:
    """Reset the hardware and write its registers, as the model's constructor does."""
    rows = quiet(top, 1)
    rows["rst"] = 1
    writes = [write for i, config in enumerate(configs) for write in config.writes(i)]
    writes += [(SELECT, SELECT_NONE)] if configs else []
    written = quiet(top, len(writes) + 1)
    written["cfg_valid"][:-1] = 1
    for row, (address, data) in zip(written, writes, strict=False):
        row["cfg_addr"], row["cfg_data"] = address, data
    rtl(top, np.concatenate([rows, written] if writes else [rows]))


def play(events: Iterable[Event], *configs: PublishedConfig, top: Top = CASCADE, **patterns: list[int]) -> Played:
    """Play a story to a new cascade in hardware and model, which must match at every clock; returns the model's trace."""
    model = PublishedCascade(configs, library_line=top is LIBRARY)
    reset_cascade(top, configs)
    ready = model.clock
    clock, high, low = np.array(list(events), np.int64).reshape(-1, 3).T
    handshakes = Handshakes(**{name: np.array(pattern) for name, pattern in patterns.items()})
    played = model.play(ready + clock, high, low, handshakes, trace=True)
    equal(rtl(top, played.inputs), played.outputs, played.inputs)
    return played._replace(
        acknowledged=played.acknowledged - ready, word_clock=played.word_clock - ready, pass_clock=played.pass_clock - ready
    )


def at(clocks: Iterable[int], high: int = 100, low: int = 100) -> list[Event]:
    """Events at one pixel at these clocks."""
    return [(clock, high, low) for clock in clocks]

# SPDX-License-Identifier: Apache-2.0
"""Plays rows of port values to any module, one row a clock, and reads its outputs just before each clock edge."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from pyverilator import PyVerilator

from ..rtl.build import PORTS_ONLY_FLAGS, RANDOM_INITIAL_FLAGS, build

__all__ = ["Ports", "Top", "rtl", "simulation"]

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

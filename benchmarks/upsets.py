# SPDX-License-Identifier: Apache-2.0
"""Single-bit upsets in registers and memories of cot, cot_array and cot_motion while events flow: what becomes of each.

python benchmarks/upsets.py                          # every bit of every register, 64 bits of each memory
python benchmarks/upsets.py cot --share 0.1          # a tenth of them
python benchmarks/upsets.py --output upsets.json

Each upset inverts one bit, at a random clock between a fifth and half of a busy run with stalls. Its outputs are compared with
those without upset:

    masked    all are the same
    heals     those of the last quarter of the events are the same
    ids       these differ in the ids of tracks alone
    settings  they differ otherwise, and the bit is in a register that the user writes (an instance u_regs)
    wrong     they differ otherwise
    hangs     no handshake for 2^22 clocks, or more outputs than there is room for

A reset follows every run. If the run was not masked, a run without upset must then give what it gave at first. Otherwise the
exit code is 1.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import re
import sys
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.contract import Shape
from evcot.outputs import written_aside
from evcot.ticks import TickedEvents
from evcot_cosim.devices.device import Device
from evcot_cosim.devices.driver import PARAMETERS, source
from evcot_cosim.lockstep.random_runs import random_config, random_motion, random_outlines, random_traffic
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, build
from evcot_cosim.rtl.files import rtl_files

SHAPE = Shape(n_slots=4, x_w=6, y_w=6, frac=2, tick_w=8, radix_w=4, nev_w=5, tc_w=10, sup_w=8, id_w=8, seq_w=16, time_w=32)
MODULES = ("cot", "cot_array", "cot_motion")
FATES = ("masked", "heals", "ids", "settings", "wrong", "hangs")
_EVENTS = 1_200
_OF_MEMORY = 64  # bits of each memory
_ROOM = 1 << 16  # words of each output
_QUIET = 1 << 22  # clocks without a handshake: after an upset in time, up to 2^20 ticks of motion steps follow at once

_CPP = """
#include "V{top}.h"
#include "V{top}___024root.h"
#include "verilated_syms.h"
#include <cstdint>
#include <string>

extern "C" {{

// A line for each variable: scope, name, bits, entries, bytes of an entry, address.
int64_t evcot_variables(char* out, int64_t room) {{
    std::string text;
    for (const auto& scope : *Verilated::threadContextp()->scopeNameMap()) {{
        const VerilatedVarNameMap* const variables = scope.second->varsp();
        if (!variables) continue;
        for (const auto& variable : *variables) {{
            const VerilatedVar& is = variable.second;
            uint64_t entries = 1;
            for (const auto& range : is.unpackedRanges()) entries *= range.elements();
            text += std::string(scope.first) + " " + variable.first + " " + std::to_string(is.entBits())
                + " " + std::to_string(entries) + " " + std::to_string(is.entSize()) + " "
                + std::to_string(reinterpret_cast<uintptr_t>(is.datap())) + "\\n";
        }}
    }}
    if (static_cast<int64_t>(text.size()) < room) text.copy(out, text.size());
    return text.size();
}}

// Drives all tokens; inverts a bit at the end of clock `when`. Returns the clocks, or -1 for a hang.
int64_t evcot_upset(V{top}* top, const uint64_t* tokens, int64_t n, int64_t when, uint8_t* at, int bit,
                    uint64_t** out, int64_t* count, int64_t room, int64_t quiet_max) {{
    uint32_t random = 1;
    int64_t next = 0, clock = 0, quiet = 0;
    count[0] = count[1] = count[2] = 0;
    for (;; ++clock) {{
        const uint64_t* token = tokens + 6 * (next < n ? next : n - 1);
        top->s_valid = next < n;
        top->s_tick = token[0];
        top->s_event = token[1];
        top->s_x = token[2];
        top->s_y = token[3];
        top->s_p = token[4];
        {given}
        random = random * 1664525u + 1013904223u;
        top->m_cm_ready = (random >> 29) != 0;
        top->m_own_ready = (random >> 26 & 7) != 0;
        top->m_pass_ready = (random >> 23 & 7) != 0;
        top->clk = 0;
        top->eval();
        bool moved = false;
        if (top->s_valid && top->s_ready) {{ ++next; moved = true; }}
        {taken}
        for (int stream = 0; stream < 3; ++stream)
            if (count[stream] + 16 > room) return -1;
        const bool done = next == n && top->idle && !moved;
        top->clk = 1;
        top->eval();
        if (clock == when) *at ^= 1 << bit;
        quiet = moved ? 0 : quiet + 1;
        if (done && quiet > 200) return clock;
        if (quiet > quiet_max) return -1;
    }}
}}
}}
"""


class Bit(NamedTuple):
    """One bit of a register or memory; `address` of its byte."""

    name: str
    address: int
    bit: int


class Run(NamedTuple):
    """Outputs of a run: of each stream, a row for each word; `clocks` is -1 where it hangs."""

    clocks: int
    cm: NDArray[np.uint64]
    own: NDArray[np.uint64]
    passed: NDArray[np.uint64]


class Bench:
    """One module on busy traffic."""

    def __init__(self, module: str, seed: int) -> None:
        rng = np.random.default_rng([MODULES.index(module), seed])
        shape = replace(SHAPE, n_slots=1) if module == "cot" else SHAPE
        motion = module == "cot_motion"
        config = random_motion(rng, shape) if motion else random_config(rng, shape, module)
        without = {"cot": {"n_slots"}, "cot_motion": {"frac", "nev_w", "tc_w"}}.get(module, set())
        parameters = {verilog: getattr(shape, name) for name, verilog in PARAMETERS.items() if name not in without}
        text = rtl_files()[f"{module}.v"].read_text()
        self.columns = {
            stream: re.findall(rf"\boutput\s+(?:wire|reg)\s+(?:\[[^\]]*\]\s+)?(m_{stream}_(?!valid)\w+)", text)
            for stream in ("cm", "own", "pass")
        }
        given = [f"top->{name} = token[5];" for name in ("s_seq", "next_seq") if module == "cot"]
        given += ["top->s_skip = 0;"] if module != "cot" else []
        taken = "\n".join(
            f"if (top->m_{stream}_valid && top->m_{stream}_ready) {{ moved = true; "
            + " ".join(f"out[{at}][count[{at}]++] = top->{name};" for name in names) + " }"
            for at, (stream, names) in enumerate(self.columns.items())
        )  # fmt: skip
        files = {
            "stream.cpp": source(module, shape, motion),
            "upset.cpp": _CPP.format(top=module, given=" ".join(given), taken=taken),
        }
        model = build(module, parameters, files, extra_flags=(*PORTS_ONLY_FLAGS, "--public-flat-rw"))
        self.device = Device(config, model=model)
        self.library = self.device.sim.lib
        self.library.evcot_upset.restype = self.library.evcot_variables.restype = ctypes.c_int64
        make = random_outlines if motion else random_traffic
        self.tokens = _tokens(make(rng, shape, _EVENTS, 2.0), shape)
        self.module, self.rng = module, rng

    def run(self, when: int = -1, bit: Bit | None = None) -> Run:
        """From reset, with an upset after clock `when`."""
        self.device.reset()
        rooms = [np.zeros(_ROOM, np.uint64) for _ in range(3)]
        out = (ctypes.c_void_p * 3)(*(room.ctypes.data for room in rooms))
        count = np.zeros(3, np.int64)
        clocks = self.library.evcot_upset(
            ctypes.c_void_p(self.device.sim.model), ctypes.c_void_p(self.tokens.ctypes.data), ctypes.c_int64(len(self.tokens)),
            ctypes.c_int64(when), ctypes.c_void_p(bit.address if bit else 0), bit.bit if bit else 0, out,
            ctypes.c_void_p(count.ctypes.data), ctypes.c_int64(_ROOM), ctypes.c_int64(_QUIET),
        )  # fmt: skip
        found = (
            room[:n].reshape(-1, len(names))
            for room, n, names in zip(rooms, count.tolist(), self.columns.values(), strict=True)
        )
        return Run(clocks, *found)

    def bits(self, share: float) -> Iterator[Bit]:
        """Bits of registers and of memories."""
        room = self.library.evcot_variables(None, ctypes.c_int64(0)) + 1
        text = ctypes.create_string_buffer(room)
        self.library.evcot_variables(text, ctypes.c_int64(room))
        texts = {path.stem: re.sub(r"//[^\n]*", "", path.read_text()) for path in rtl_files().values() if path.suffix == ".v"}
        parts = {name: dict(_parts(text, texts.keys())) for name, text in texts.items()}
        for line in text.value.decode().splitlines():
            scope, name, bits, entries, size, address = line.split(" ")
            module = self.module
            for step in scope.split(".")[2:]:
                module = parts[module].get(step, module)
            if not scope.startswith("TOP.TOP") and name in _registers(texts[module]):
                every = [(entry, bit) for entry in range(int(entries)) for bit in range(int(bits))]
                if int(entries) > 1:
                    every = [every[at] for at in self.rng.choice(len(every), min(_OF_MEMORY, len(every)), replace=False)]
                for entry, bit in every:
                    if self.rng.random() < share:
                        yield Bit(f"{scope}.{name}", int(address) + entry * int(size) + bit // 8, bit % 8)

    def fate(self, found: Run, clean: Run) -> str:
        """What became of an upset."""
        if found.clocks < 0:
            return "hangs"
        if all(np.array_equal(mine, theirs) for mine, theirs in zip(found[1:], clean[1:], strict=True)):
            return "masked"
        last = [self._last_quarter(run) for run in (found, clean)]
        if all(np.array_equal(mine, theirs) for mine, theirs in zip(*last, strict=True)):
            return "heals"
        ids = [at for at, name in enumerate(self.columns["cm"]) if name in ("m_cm_id", "m_cm_other")]
        for rows in (last[0][0], last[1][0]):
            rows[:, ids] = 0
        return "ids" if all(np.array_equal(mine, theirs) for mine, theirs in zip(*last, strict=True)) else "wrong"

    def _last_quarter(self, run: Run) -> list[NDArray[np.uint64]]:
        parts = []
        for rows, names in zip(run[1:], self.columns.values(), strict=True):
            seq = names.index(next(name for name in names if name.endswith("_seq")))
            parts.append(rows[rows[:, seq] >= 3 * _EVENTS // 4].copy())
        return parts


@cache
def _registers(text: str) -> frozenset[str]:
    """Names that a module declares as registers, and assigns at a clock."""
    declared: set[str] = set()
    for names in re.findall(r"\breg\b(?:\s+signed)?(?:\s*\[[^\]]*\])?([^;)]*?)(?=;|\)\s*;|\b(?:input|output)\b)", text):
        declared |= set(re.findall(r"(?:^|,)\s*(\w+)", names))
    statements, found = text, 1
    while found:  # conditions, in which <= compares
        statements, found = re.subn(r"\([^()]*\)", "", statements)
    assigned = set(re.findall(r"(\w+)(?:\s*\[[^\]]*\])*\s*<=", statements))
    for group in re.findall(r"\{([^{}]*)\}\s*<=", statements):
        assigned |= set(re.findall(r"\b([a-z_]\w*)", group))
    return frozenset(declared & assigned)


def _parts(text: str, modules: Collection[str]) -> Iterator[tuple[str, str]]:
    """Instances in a module, and of which module each is."""
    for at in re.finditer(r"\b(u_\w+)\s*\(", text):
        before = re.findall(r"\b\w+\b", text[: at.start()].rpartition(";")[2].rpartition("begin")[2])
        found = [name for name in before if name in modules]
        if found:
            yield at[1], found[0]


def _tokens(events: TickedEvents, shape: Shape) -> NDArray[np.uint64]:
    """Rows of tick, event, x, y, p and number of the event, or of the next one where there is none."""
    rows, now, most = [], 0, (1 << shape.tick_w) - 1
    for number, (tick, x, y, p) in enumerate(
        zip(*(column.tolist() for column in (events.ticks, events.x, events.y, events.p)), strict=True)
    ):
        while tick - now > most:
            rows.append((most, 0, x, y, p, number))
            now += most
        rows.append((tick - now, 1, x, y, p, number))
        now = tick
    return np.array(rows, np.uint64)


def study(module: str, share: float, seed: int) -> dict[str, Any]:
    """All upsets of a module."""
    bench = Bench(module, seed)
    clean = bench.run()
    assert clean.clocks > 0
    fates: Counter[str] = Counter()
    where: dict[str, Counter[str]] = {fate: Counter() for fate in FATES}
    residue = []
    for bit in bench.bits(share):
        when = int(bench.rng.integers(clean.clocks // 5, clean.clocks // 2))
        fate = bench.fate(bench.run(when, bit), clean)
        if fate == "wrong" and ".u_regs." in bit.name:
            fate = "settings"
        fates[fate] += 1
        where[fate][bit.name] += 1
        if fate != "masked" and bench.fate(bench.run(), clean) != "masked":
            residue.append(bit.name)
    told = f"{len(clean.cm)} records, {len(clean.own)} owned and {len(clean.passed)} passed events"
    print(f"{module}: {clean.clocks} clocks, {told}")
    print(
        "  "
        + ", ".join(f"{fates[fate]} {fate}" for fate in FATES)
        + f", of {fates.total()}; not healed by a reset: {len(residue)}"
    )
    for fate in ("wrong", "hangs"):
        for name, count in where[fate].most_common():
            print(f"    {fate} {count} {name}")
    for name in residue:
        print(f"    after a reset {name}")
    return {"upsets": fates.total(), **{fate: fates[fate] for fate in FATES}, "residue": len(residue)}


def main() -> int:
    """Run the study; 1 where a reset does not heal an upset."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0] if __doc__ else None)
    parser.add_argument("modules", nargs="*", help=f"of {', '.join(MODULES)} (default: all)")
    parser.add_argument("--share", type=float, default=1.0, help="of the bits (default: all)")
    parser.add_argument("--seed", type=int, default=22, help="of registers, traffic and upsets (default: %(default)s)")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write seed and numbers")
    options = parser.parse_args()
    if unknown := [name for name in options.modules if name not in MODULES]:
        parser.error(f"{unknown[0]}: must be one of {', '.join(MODULES)}")
    if not 0 < options.share <= 1:
        parser.error(f"--share {options.share:g}: must be more than 0, at most 1")
    print(f"seed {options.seed}")
    found = {module: study(module, options.share, options.seed) for module in options.modules or MODULES}
    if options.output:
        with written_aside(options.output) as file:
            file.write(json.dumps({"seed": options.seed, **found}, indent=1).encode() + b"\n")
    return int(any(numbers["residue"] for numbers in found.values()))


if __name__ == "__main__":
    sys.exit(main())

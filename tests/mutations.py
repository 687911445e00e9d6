# SPDX-License-Identifier: Apache-2.0
"""Do the tests bite? Breaks the RTL in one place at a time and runs the tests that should notice, on the broken copy.

`python tests/mutations.py` prints which test caught each mutation and exits with 1 when one survives; `--write` also writes
the table to docs/mutations.md. Spaces aside, the text to replace must stand in its file exactly once.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from evcot_cosim.build import cache_dir, verilog_dir
from evcot_cosim.testing import broken_copy

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "docs" / "mutations.md"
HEADING = """# What the tests catch

The RTL, broken in one place at a time. Made by `python tests/mutations.py --write`, which runs the tests of the modules
concerned on each broken copy and fails when one of them goes unnoticed. Named is the first test that failed in each test file.

| mutation | in | caught by |
|---|---|---|
"""

ARRAY, CHAIN, COT, UPDATE = "test_cot_array.py", "test_cot_chain.py", "test_cot.py", "test_cot_update.py"
FILTERS = "test_filter_chain.py"
PUBLISHED = "test_cot_published.py"


@dataclass(frozen=True)
class Mutation:
    """One broken place, and the files in tests/hw whose tests should notice."""

    meaning: str
    file: str
    right: str
    wrong: str
    tests: tuple[str, ...]


MUTATIONS = (
    Mutation("window misses its last column", "cot.v", "token_x <= hi_x", "token_x < hi_x", (COT, CHAIN)),
    Mutation("window misses its first column", "cot_array.v", "x >= lo_x[i", "x > lo_x[i", (COT, ARRAY)),
    Mutation(
        "ticks of an owned event do not travel on",
        "cot.v",
        "pass_pending <= token_tick != {TICK_W{1'b0}};",
        "pass_pending <= 1'b0;",
        (COT, CHAIN),
    ),
    Mutation("ticks that end a life count twice", "cot.v", "tick_used ? {TICK_W{1'b0}} : s_tick", "s_tick", (COT, CHAIN)),
    Mutation(
        "timer not restarted by an event", "cot.v", "updated <= 1'b0; tc <= {TC_W{1'b0}};", "updated <= 1'b0;", (COT, CHAIN)
    ),
    Mutation(
        "timer restarted by centre updates alone",
        "cot_array.v",
        "starts_timer = lives",
        "starts_timer = updates || merges",
        (COT, ARRAY),
    ),
    Mutation(
        "lifetime a tick too long",
        "cot_array.v",
        "<= {{(DUE_W - TICK_W) {1'b0}}, tick} &&",
        "< {{(DUE_W - TICK_W) {1'b0}}, tick} &&",
        (COT, ARRAY),
    ),
    Mutation(
        "candidate's time a tick too short",
        "cot.v",
        "tc2_after > {{(SUM_W - TC_W) {1'b0}}, detect_ticks}",
        "tc2_after >= {{(SUM_W - TC_W) {1'b0}}, detect_ticks}",
        (COT, CHAIN),
    ),
    Mutation("lives ended by one token end in slot order", "cot_array.v", "&& left < due_left", "&& !due", (ARRAY,)),
    Mutation(
        "no merge at a birth", "cot_array.v", "if (updates && overlaps)", "if (updates && overlaps && cur_active)", (ARRAY,)
    ),
    Mutation("no second look after a merge", "cot_array.v", "REPORT: phase <= CHECK;", "REPORT: phase <= RUN;", (ARRAY,)),
    Mutation(
        "the lower slot survives, not the older",
        "cot_array.v",
        "older = id[overlap_slot] < id[slot]",
        "older = overlap_slot < slot",
        (ARRAY,),
    ),
    Mutation(
        "a candidate comes before an active window",
        "cot_array.v",
        "owner = in_active ? active_slot : in_candidate ? candidate_slot",
        "owner = in_candidate ? candidate_slot : in_active ? active_slot",
        (ARRAY,),
    ),
    Mutation(
        "merged centre not weighted",
        "weighted_mean.v",
        "s_weight_b} + {{W{1'b0}}, half}",
        "s_weight_a} + {{W{1'b0}}, half}",
        ("test_weighted_mean.py", ARRAY),
    ),
    Mutation(
        "merged centre not rounded", "weighted_mean.v", "ROUND ? den >> 1", "1'b0 ? den >> 1", ("test_weighted_mean.py", ARRAY)
    ),
    Mutation("smaller radius survives a merge", "cot_array.v", "(gone_g > cur_g) ?", "(gone_g < cur_g) ?", (ARRAY,)),
    Mutation("average not rounded", "approach.v", "(FRAC > 0) ?", "(FRAC > 8) ?", ("test_approach.py", COT)),
    Mutation("event at distance g counts as in the ring", "cot_update.v", "dx} > inner", "dx} >= inner", (UPDATE, COT)),
    Mutation("centre moves one event late", "cot_update.v", "last = counted >=", "last = counted >", (UPDATE, COT)),
    Mutation(
        "N_ev halves when slower and doubles when faster",
        "cot_update.v",
        ": slower ? ((doubled > {1'b0, nev_max}) ? nev_max : doubled[NEV_W-1:0]) : faster ?",
        ": faster ? ((doubled > {1'b0, nev_max}) ? nev_max : doubled[NEV_W-1:0]) : slower ?",
        (UPDATE, COT),
    ),
    Mutation(
        "support wraps",
        "cot_update.v",
        "(support == {SUP_W{1'b1}}) ? support : support + 1'b1",
        "support + 1'b1",
        (UPDATE, COT),
    ),
    Mutation(
        "window not clipped at the last pixel",
        "cot_window.v",
        "(sum > last_pixel) ? last_pixel : sum",
        "sum",
        ("test_cot_window.py", COT),
    ),
    Mutation("track id used again", "cot.v", "next_id <= next_id + ID_STEP[ID_W-1:0];", "next_id <= next_id;", (COT, CHAIN)),
    Mutation("track id used again", "cot_array.v", "births <= births + 1'b1;", "births <= births;", (COT, ARRAY)),
    Mutation(
        "LOST by a mode write carries the last event's number",
        "cot.v",
        "token_seq + {{(SEQ_W - 1) {1'b0}}, had_event}",
        "token_seq",
        (COT,),
    ),
    Mutation(
        "skid buffer drops a word under stall",
        "skid_buffer.v",
        "!output_free && (skid_valid_reg || accept)",
        "!output_free && accept",
        ("test_skid_buffer.py", ARRAY),
    ),
    Mutation(
        "arbiter changes a waiting word",
        "stream_arbiter.v",
        "if (output_free) begin m_valid_reg <= |s_valid; m_data_reg <= granted_data;",
        "m_data_reg <= granted_data; if (output_free) begin m_valid_reg <= |s_valid;",
        ("test_stream_arbiter.py", CHAIN),
    ),
    Mutation("array goes on while an output waits", "cot_array.v", "(m_own_ready || !m_own_valid) &&", "", (ARRAY,)),
    Mutation(
        "register write goes to slot 0",
        "cot_regs.v",
        "radix_th_mem[cfg_slot] <=",
        "radix_th_mem[0] <=",
        ("test_cot_regs.py", ARRAY),
    ),
    Mutation(
        "LFSR tapped a bit too low",
        "lfsr.v",
        "TAPS = TABLE_ROW[WIDTH-1:0]",
        "TAPS = TABLE_ROW[WIDTH-1:0] >> 1",
        ("test_lfsr.py",),
    ),
    Mutation(
        "LFSR accepts the seed that locks it up",
        "lfsr.v",
        "seed_error = load && (&seed)",
        "seed_error = 1'b0",
        ("test_lfsr.py",),
    ),
    Mutation(
        "a mark beyond the sensor hits a pixel on it",
        "filter_mask.v",
        "mask_valid && mask_column < COLUMNS &&",
        "mask_valid &&",
        ("test_filter_mask.py",),
    ),
    Mutation(
        "tokens move on while a mark has the memory's port",
        "filter_mask.v",
        "advance = space && !marks",
        "advance = space",
        ("test_filter_mask.py",),
    ),
    Mutation("a stamp wraps", "filter_recent.v", "!jump && !quarters[1]", "!jump", ("test_filter_recent.py",)),
    Mutation(
        "a pixel vouches for itself",
        "filter_recent.v",
        "near_x && near_y && !same",
        "near_x && near_y",
        ("test_filter_recent.py", FILTERS),
    ),
    Mutation(
        "two filters in each other's place",
        "filter_chain.v",
        "REFRACTORY = `EVCOT_FILTER_REFRACTORY; localparam ACTIVITY = `EVCOT_FILTER_ACTIVITY;",
        "REFRACTORY = `EVCOT_FILTER_ACTIVITY; localparam ACTIVITY = `EVCOT_FILTER_REFRACTORY;",
        (FILTERS,),
    ),
    Mutation(
        "time goes on before the walk has ended",
        "stamp_walk.v",
        "goes = held && !clearing && (walked || !crosses)",
        "goes = held && !clearing",
        ("test_filter_activity.py", "test_filter_refractory.py"),
    ),
    Mutation(
        "steps beyond what stamps can tell wrap",
        "stamp_walk.v",
        "(wide_step > {{(WIDE_W - W) {1'b0}}, KEEP}) ? KEEP : wide_step[W-1:0]",
        "wide_step[W-1:0]",
        ("test_filter_activity.py",),
    ),
    Mutation(
        "a visit undoes the event that came between",
        "stamp_memory.v",
        "missed = age_visits && (read_access || found_access || then_access)",
        "missed = age_visits && (read_access || then_access)",
        ("test_stamp_memory.py", "test_filter_activity.py"),
    ),
    Mutation(
        "a neighbour comes round the border",
        "stamp_memory.v",
        "y != 32'd0, y + 32'd1 < DOWN",
        "1'b1, 1'b1",
        ("test_filter_decay.py",),
    ),
    Mutation(
        "an event right behind another does not know that it stayed",
        "filter_refractory.v",
        "(same_as_first && stays) ? age_now : then",
        "then",
        ("test_filter_refractory.py",),
    ),
    Mutation(
        "an event does not know that the third one before it stayed",
        "filter_refractory.v",
        "passed <= read_at == age_at && writes",
        "passed <= 1'b0",
        ("test_filter_refractory.py",),
    ),
    Mutation(
        "fractions of a unit are lost",
        "filter_decay.v",
        "fraction <= clock[CLOCK_FRAC-1:0]",
        "fraction <= 0",
        ("test_filter_decay.py",),
    ),
    Mutation(
        "published: an event that meets the initialisation waits instead of being lost",
        "cot_published.v",
        "s_ack_n = !(state == INIT_CELL || state == REQ_RECEIVED",
        "s_ack_n = !(state == REQ_RECEIVED",
        (PUBLISHED,),
    ),
    Mutation(
        "published: the average takes an event in once however long it waits",
        "cot_published.v",
        "EV_NO_PROC: begin av_high <= next_high; av_low <= next_low;",
        "EV_NO_PROC: begin if (!m_ack_n) av_high <= next_high; if (!m_ack_n) av_low <= next_low;",
        (PUBLISHED,),
    ),
    Mutation(
        "published: expires at any clock past MaxTime", "cot_published.v", "tc == max_time", "tc >= max_time", (PUBLISHED,)
    ),
    Mutation(
        "published: compares with TC2 one update back",
        "cot_published.v",
        "diff <= tc2 - tc2_2",
        "diff <= tc2 - tc2_1",
        (PUBLISHED,),
    ),
    Mutation(
        "published: the top edge triggers growth",
        "cot_published.v",
        "|| {1'b0, ev_high} + {1'b0, g} < {1'b0, cm_high};",
        "|| {1'b0, ev_high} + {1'b0, g} < {1'b0, cm_high} || {1'b0, ev_high} > {1'b0, cm_high} + {1'b0, g};",
        (PUBLISHED,),
    ),
    Mutation("two words run together on the line", "aer_merge.v", "busy <= !m_req_n;", "busy <= 1'b0;", (PUBLISHED,)),
)


def first_failures(verilog: Path, tests: tuple[str, ...], cache: Path) -> list[str]:
    """The first test that fails on this RTL in each file, as file::name."""
    found = []
    for name in tests:
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", f"tests/hw/{name}"]
        environment = os.environ | {"EVCOT_VERILOG": str(verilog), "EVCOT_CACHE": str(cache)}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        failed = re.search(r"^(?:FAILED|ERROR) tests/hw/(.*?)(?: - .*)?$", done.stdout, re.MULTILINE)
        if "ToolchainError" in done.stdout or done.returncode > 1 or (done.returncode and not failed):
            raise SystemExit(f"{name} did not run on {verilog}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        if failed:
            found.append(failed[1])
    return found


def verdict(mutation: Mutation) -> list[str]:
    """Which tests catch it; empty when it survives."""
    with tempfile.TemporaryDirectory() as folder:
        verilog = broken_copy(Path(folder) / "verilog", mutation.file, mutation.right, mutation.wrong)
        cache = Path(folder) / "cache"
        cache.mkdir()
        (cache / "runtime").symlink_to(cache_dir() / "runtime")  # the same for every design
        return first_failures(verilog, mutation.tests, cache)


def merged(rows: Mapping[Mutation, str]) -> Iterator[str]:
    """The rows of all mutations in their order: what was tried now, and what the table says of the others."""
    for mutation in MUTATIONS:
        row = rows.get(mutation) or known_row(mutation)
        if row is not None:
            yield row


def known_row(mutation: Mutation) -> str | None:
    """What the table says of a mutation."""
    head = f"| {mutation.meaning} | `{mutation.file}` | "
    return next((row for row in TABLE.read_text(encoding="utf-8").splitlines() if row.startswith(head)), None)


def main() -> int:
    """Exit code 0 when every mutation was caught."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--write", action="store_true", help=f"write what was tried to {TABLE.relative_to(ROOT)}")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutations tried at a time (default: one per core)")
    parser.add_argument("--only", default="", help="only mutations whose file or meaning contains this")
    parser.add_argument("--new", action="store_true", help="only mutations that the table does not have yet")
    options = parser.parse_args()
    os.environ.setdefault("EVCOT_CACHE", str(ROOT / "build" / "cache"))
    mutations = [m for m in MUTATIONS if options.only in f"{m.file} {m.meaning}" and not (options.new and known_row(m))]

    every_test = tuple(sorted({name for mutation in mutations for name in mutation.tests}))
    if broken := first_failures(verilog_dir(), every_test, cache_dir()):
        raise SystemExit(f"fails on the RTL as it is: {', '.join(broken)}")

    rows, survivors = {}, 0
    with ThreadPoolExecutor(options.jobs) as pool:
        for mutation, caught in zip(mutations, pool.map(verdict, mutations), strict=True):
            survivors += not caught
            tests = ", ".join(f"`{name}`" for name in caught) or "**nothing**"
            rows[mutation] = f"| {mutation.meaning} | `{mutation.file}` | {tests} |"
            print(rows[mutation], flush=True)
    print(f"{len(mutations)} mutations, {survivors} survived")
    if options.write:
        TABLE.write_text(HEADING + "".join(f"{row}\n" for row in merged(rows)), encoding="utf-8")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: Apache-2.0
"""Do the tests bite? Breaks the RTL in one place at a time and runs the tests that should notice, on the broken copy.

`python tests/mutations.py` makes the mistakes in mutations.toml, prints which test caught each and exits with 1 when one
survives; `--write` also writes the table to docs/mutations.md.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from evcot_cosim.rtl.build import cache_dir
from evcot_cosim.rtl.files import rtl_files, verilog_dir
from support.testing import broken_copy, broken_text

ROOT = Path(__file__).parents[1]
MISTAKES = ROOT / "tests" / "mutations.toml"
KERNELS = ROOT / "build" / "cache" / "numba"  # of Python, the same for every mutation
TABLE = ROOT / "docs" / "mutations.md"
HEADING = """# What the tests catch

Each row is the RTL with one mistake in it, and the tests that noticed. The table is written by `python tests/mutations.py
--write`, which runs the tests of the modules concerned on each broken copy, and fails if any mistake goes unnoticed. Of each
test file the first test that failed is named.

| mutation | in | caught by |
|---|---|---|
"""


@dataclass(frozen=True)
class Mutation:
    """One broken place, and the files in tests/hw whose tests should notice."""

    meaning: str
    file: str
    right: str
    wrong: str
    tests: tuple[str, ...]


def mutations() -> Iterator[Mutation]:
    """All of them, file by file."""
    for file, mistakes in tomllib.loads(MISTAKES.read_text(encoding="utf-8")).items():
        own = f"test_{Path(file).stem}.py"
        for mistake in mistakes:
            yield Mutation(mistake["meaning"], file, mistake["right"], mistake["wrong"], tuple(mistake.get("tests", [own])))


def path_of(test: str) -> Path:
    """Where below tests/hw a test file is."""
    (path,) = (ROOT / "tests" / "hw").rglob(test)
    return path


def first_failures(verilog: Path, tests: tuple[str, ...], cache: Path) -> list[str]:
    """The first test that fails on this RTL in each file, as file::name; a linter's complaint is none."""
    found = []
    for name in tests:
        pytest = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider"]
        command = [*pytest, "-k", "not lints", str(path_of(name))]
        environment = os.environ | {"EVCOT_VERILOG": str(verilog), "EVCOT_CACHE": str(cache), "NUMBA_CACHE_DIR": str(KERNELS)}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        failed = re.search(r"^(?:FAILED|ERROR) tests/hw/(?:\w+/)*(.*?)(?: - .*)?$", done.stdout, re.MULTILINE)
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


def row_of(mutation: Mutation, caught: str) -> str:
    """Its row in the table."""
    return f"| {mutation.meaning} | `{mutation.file}` | {caught} |"


def known_row(mutation: Mutation) -> str | None:
    """What the table says of a mutation that was caught."""
    head = row_of(mutation, "`").removesuffix(" |")
    return next((row for row in TABLE.read_text(encoding="utf-8").splitlines() if row.startswith(head)), None)


def write_table(everything: Sequence[Mutation], rows: Mapping[Mutation, str]) -> None:
    """All mutations in their order: what was tried now, and what the table says of the others."""
    merged = [rows.get(mutation) or known_row(mutation) for mutation in everything]
    TABLE.write_text(HEADING + "".join(f"{row}\n" for row in merged if row), encoding="utf-8")


def main() -> int:
    """Exit code 0 when every mutation was caught."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--write", action="store_true", help=f"write what was tried to {TABLE.relative_to(ROOT)}")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutations tried at a time (default: one per core)")
    parser.add_argument("--only", default="", help="only mutations whose file or meaning contains this")
    parser.add_argument("--new", action="store_true", help="only mutations that the table does not have yet")
    options = parser.parse_args()
    os.environ.setdefault("EVCOT_CACHE", str(ROOT / "build" / "cache"))
    everything = list(mutations())
    chosen = [m for m in everything if options.only in f"{m.file} {m.meaning}" and not (options.new and known_row(m))]

    rtl = rtl_files()
    for mutation in chosen:  # raises at once where a text is gone
        broken_text(rtl[mutation.file].read_text(), mutation.file, mutation.right, mutation.wrong)
    every_test = tuple(sorted({name for mutation in chosen for name in mutation.tests}))
    if broken := first_failures(verilog_dir(), every_test, cache_dir()):
        raise SystemExit(f"fails on the RTL as it is: {', '.join(broken)}")

    rows, survivors = {}, 0
    with ThreadPoolExecutor(options.jobs) as pool:
        for mutation, caught in zip(chosen, pool.map(verdict, chosen), strict=True):
            survivors += not caught
            rows[mutation] = row_of(mutation, ", ".join(f"`{name}`" for name in caught) or "**nothing**")
            print(rows[mutation], flush=True)
            if options.write:  # whatever becomes of the rest
                write_table(everything, rows)
    print(f"{len(chosen)} mutations, {survivors} survived")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())

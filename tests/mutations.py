# SPDX-License-Identifier: Apache-2.0
"""Do the tests bite? Breaks the RTL in one place at a time and runs the tests that must fail, on the broken copy.

`python tests/mutations.py` makes the mistakes in mutations.toml, prints which test caught each and exits with 1 when one
survives; `--write` also writes these tests to mutations.toml. `make docs` makes a page of it.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from evcot_cosim.rtl.build import cache_dir
from evcot_cosim.rtl.files import rtl_files, verilog_dir
from support.testing import broken_copy, broken_text

ROOT = Path(__file__).parents[1]
MISTAKES = ROOT / "tests" / "mutations.toml"
_COLUMNS = 128  # of a line of mutations.toml
KERNELS = ROOT / "build" / "cache" / "numba"  # of Python, the same for every mutation


@dataclass(frozen=True)
class Mutation:
    """One broken place, and the tests in tests/hw that must fail: `file`, or `file::test` once that is known."""

    meaning: str
    file: str
    right: str
    wrong: str
    tests: tuple[str, ...]


def mutations() -> Iterator[Mutation]:
    """All of them, file by file."""
    for file, mistakes in tomllib.loads(MISTAKES.read_text(encoding="utf-8")).items():
        for mistake in mistakes:
            yield Mutation(mistake["meaning"], file, mistake["right"], mistake["wrong"], tuple(mistake["tests"]))


def path_of(test: str) -> str:
    """A test of tests/hw as pytest takes it: the path of its file, and its name."""
    file, *names = test.split("::")
    (path,) = (ROOT / "tests" / "hw").rglob(file)
    return "::".join([str(path), *names])


def first_failures(verilog: Path, tests: tuple[str, ...], cache: Path) -> list[str]:
    """The first test that fails on this RTL in each file, as file::name; a linter's complaint is none."""
    found = []
    for name in tests:
        pytest = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider"]
        command = [*pytest, path_of(name)]
        environment = os.environ | {"EVCOT_VERILOG": str(verilog), "EVCOT_CACHE": str(cache), "NUMBA_CACHE_DIR": str(KERNELS)}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        failed = re.search(r"^(?:FAILED|ERROR) tests/hw/(?:\w+/)*([\w.:]+)", done.stdout, re.MULTILINE)
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


def write(mutation: Mutation, caught: Sequence[str]) -> None:
    """Write the tests that caught a mutation into its block of mutations.toml."""
    tests = f"tests = [{', '.join(map(json.dumps, caught))}]"
    if len(tests) > _COLUMNS:
        tests = "\n".join(["tests = [", *(f"    {json.dumps(test)}," for test in caught), "]"])
    text = MISTAKES.read_text(encoding="utf-8")
    begin = text.index(f'[["{mutation.file}"]]\nmeaning = {json.dumps(mutation.meaning, ensure_ascii=False)}\n')
    block, gap, rest = text[begin:].partition("\n\n")
    block = re.sub(r"^tests = \[[^\]]*\]", lambda _: tests, block, flags=re.MULTILINE)
    MISTAKES.write_text(text[:begin] + block + gap + rest, encoding="utf-8")


def main() -> int:
    """Exit code 0 when every mutation was caught."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--write", action="store_true", help=f"write the tests that failed to {MISTAKES.name}")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutations tried at a time (default: one per core)")
    parser.add_argument("--only", default="", help="only mutations whose file or meaning contains this")
    parser.add_argument("--new", action="store_true", help="only mutations without the name of a test")
    options = parser.parse_args()
    os.environ.setdefault("EVCOT_CACHE", str(ROOT / "build" / "cache"))
    chosen = [m for m in mutations() if options.only in f"{m.file} {m.meaning}"]
    if options.new:
        chosen = [m for m in chosen if any("::" not in test for test in m.tests)]

    rtl = rtl_files()
    for mutation in chosen:  # raises at once where a text is gone
        broken_text(rtl[mutation.file].read_text(), mutation.file, mutation.right, mutation.wrong)
    every_test = tuple(sorted({name for mutation in chosen for name in mutation.tests}))
    if broken := first_failures(verilog_dir(), every_test, cache_dir()):
        raise SystemExit(f"fails on the RTL as it is: {', '.join(broken)}")

    survivors = 0
    with ThreadPoolExecutor(options.jobs) as pool:
        for mutation, caught in zip(chosen, pool.map(verdict, chosen), strict=True):
            survivors += not caught
            print(f"{mutation.file}: {mutation.meaning}: {', '.join(caught) or 'SURVIVED'}", flush=True)
            if options.write and caught:  # at once, whatever becomes of the rest
                write(mutation, caught)
    print(f"{len(chosen)} mutations, {survivors} survived")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())

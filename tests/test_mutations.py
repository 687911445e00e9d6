# SPDX-License-Identifier: Apache-2.0
"""mutations.toml: every mistake has one place in the RTL as it is, and names tests that are there and caught it.

random_mutants.py: which places of Verilog and Python are mutated, and how; equivalent_mutants.toml: each row is such a mutant.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from evcot_cosim.rtl.files import rtl_files
from mutations import Mutation, mutations, path_of
from random_mutants import ROOT, Equivalent, Mutant, equivalents, python_kind, python_mutants, reason_of, rtl_mutants
from support.testing import broken_text

RTL = {name: path.read_text() for name, path in rtl_files().items()}


@cache
def names_in(file: str) -> frozenset[str]:
    """Names of all tests of a file, `Class::test` for those in a class."""
    body = ast.parse(Path(path_of(file)).read_text(encoding="utf-8")).body
    classes = [one for one in body if isinstance(one, ast.ClassDef)]
    named = [(f"{one.name}::", part) for one in classes for part in one.body] + [("", part) for part in body]
    return frozenset(prefix + part.name for prefix, part in named if isinstance(part, ast.FunctionDef))


def faults(mutation: Mutation) -> Iterator[str]:
    """What is wrong with a row of mutations.toml."""
    try:
        broken_text(RTL[mutation.file], mutation.file, mutation.right, mutation.wrong)  # raises where the text is gone
    except Exception as error:
        yield f"{mutation.file}, {mutation.meaning}: {error!r}"
    if not mutation.tests:
        yield f"{mutation.file}, {mutation.meaning}: no test is named"
    for test in mutation.tests:
        file, _, name = test.partition("::")
        if not name:
            yield f"{file}: run python tests/mutations.py --new --write"
        elif name not in names_in(file):
            yield f"{test}: there is no such test"


def test_every_mutation_has_its_place_and_names_tests_that_exist() -> None:
    assert [fault for mutation in mutations() for fault in faults(mutation)] == []


def test_a_row_without_its_place_or_its_test_is_reported() -> None:
    (place, test) = faults(Mutation("gone", "cot_axis.v", "no such text", "", ("test_cot.py::test_of_nothing",)))
    assert "cot_axis.v, gone: " in place
    assert test == "test_cot.py::test_of_nothing: there is no such test"


MODULE = """\
module counter #(
    parameter W = 4 - 1
) (
    input  wire         clk,
    output reg  [W-1:0] count  // + 1
);
    localparam LAST = 4'd9;
    always @(posedge clk) begin
        if (count <= LAST) count <= count + 4'd15;
        for (k = 0; k < 3; k = k + 1) `MACRO(k)
    end
endmodule
"""
FUNCTION = '''\
LIMIT = 3


def clamp(value: int, unit: str = "µm") -> int:
    """Add 1 + 1."""
    if value > LIMIT and unit == "µm":  # 2 * 2
        raise ValueError(f"{value + 1}")
    return value * 2
'''


def test_verilog_is_mutated_in_its_statements_alone() -> None:
    assert {mutant.describe(MODULE) for mutant in rtl_mutants("counter.v", MODULE)} == {
        "counter.v:9: count <= LAST -> !(count <= LAST)",
        "counter.v:9: <= -> <",
        "counter.v:9: count <= count + 4'd15; -> ;",
        "counter.v:9: + -> -",
        "counter.v:9: 4'd15 -> 4'd0",
    }


def test_python_is_mutated_in_function_bodies_alone() -> None:
    assert {mutant.describe(FUNCTION) for mutant in python_mutants("clamp.py", FUNCTION)} == {
        'clamp.py:6: value > LIMIT and unit == "µm" -> (not (value > LIMIT and unit == "µm"))',
        "clamp.py:6: and -> or",
        "clamp.py:6: > -> >=",
        "clamp.py:6: == -> !=",
        "clamp.py:8: * -> +",
        "clamp.py:8: 2 -> 3",
    }


def test_a_mutant_differs_in_its_place_alone() -> None:
    (last,) = [one for one in python_mutants("clamp.py", FUNCTION) if one.wrong == "3"]
    assert last.text(FUNCTION) == FUNCTION.replace("value * 2", "value * 3")


def test_every_equivalent_mutant_is_one_that_is_drawn() -> None:
    for row in equivalents("rtl"):
        drawn = rtl_mutants(row.file, RTL[row.file])
        assert any(reason_of(mutant, RTL[row.file], [row]) for mutant in drawn), row
    for row in equivalents("python"):
        source = (ROOT / "sw" / row.file).read_text(encoding="utf-8")
        assert any(reason_of(mutant, source, [row]) for mutant in python_mutants(row.file, source)), row


def test_a_row_of_an_equivalent_mutant_names_one_place() -> None:
    row = Equivalent("counter.v", "count + 4'd15", "count - 4'd15", "an example")
    reasons = {mutant.describe(MODULE): reason_of(mutant, MODULE, [row]) for mutant in rtl_mutants("counter.v", MODULE)}
    assert {where for where, why in reasons.items() if why == row.why} == {"counter.v:9: + -> -"}
    gone = Equivalent("counter.v", "count + 4'd14", "count - 4'd14", "")
    with pytest.raises(ValueError, match=r"counter\.v holds .* 0 times: must be once"):
        gone.mutated(MODULE)


@pytest.mark.parametrize(
    ("module", "mirror"),
    [
        ("filters/cells.py", "test_cells.py"),
        ("recordings/formats/hdf5_survey.py", "test_hdf5.py"),  # a part of hdf5.py
        ("recordings/formats/_text_kernel.py", "test_text.py"),
        ("trackers/frame_based.py", "test_detections.py"),  # which imports it
    ],
)
def test_the_tests_of_a_python_module_run_first(module: str, mirror: str) -> None:
    first, others = python_kind().stages(Mutant(f"evcot/{module}", 0, 0, ""))
    assert [path.name for path in first] == [mirror]
    assert others
    assert not set(first) & set(others)

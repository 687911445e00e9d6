# SPDX-License-Identifier: Apache-2.0
"""The generated C++ drive: one text per top and shape, its structs those that Python hands over."""

from __future__ import annotations

import re

import pytest

from evcot.hardware.contract import RECORD, Shape
from evcot_cosim.devices.driver import DRIVE, PARAMETERS, Status, source

TOPS = ["cot", "cot_chain", "cot_array"]
SIZES = {"int64_t": 8, "uint64_t": 8, "uint32_t": 4, "uint16_t": 2, "uint8_t": 1}


def struct(text: str, name: str) -> list[tuple[str, str]]:
    """(type, field) of a C struct in the text."""
    body = re.search(rf"struct {name} {{\n(.*?)\n}};", text, re.DOTALL)
    assert body is not None
    return [(ctype, name) for ctype, name in (line.strip().rstrip(";").rsplit(" ", 1) for line in body[1].splitlines())]


@pytest.mark.parametrize("top", TOPS)
def test_a_record_is_laid_out_as_numpy_has_it(top: str) -> None:
    fields = struct(source(top, Shape(n_slots=1)), "Record")
    assert [name for _, name in fields] == list(RECORD.names or ())
    offset = 0
    for ctype, name in fields:
        dtype, at = RECORD.fields[name][:2]  # type: ignore[index]
        assert (offset, SIZES[ctype]) == (at, dtype.itemsize)
        offset += SIZES[ctype]
    assert offset == RECORD.itemsize


def test_a_job_is_laid_out_as_ctypes_has_it() -> None:
    fields = struct(source("cot_array", Shape()), "Job")
    assert [name for _, name in fields] == [field[0] for field in DRIVE.job._fields_]
    assert all(ctype.endswith("*") or SIZES[ctype] == 8 for ctype, _ in fields)


def test_statuses_have_the_numbers_that_python_knows() -> None:
    listed = re.search(r"enum Status { (.*?), }", source("cot", Shape(n_slots=1)))
    assert listed is not None
    assert dict(entry.split(" = ") for entry in listed[1].split(", ")) == {s.name: str(s.value) for s in Status}


def test_widths_become_constants() -> None:
    text = source("cot_array", Shape(tick_w=3, seq_w=9, time_w=34))
    assert "kTickMax = 7;" in text
    assert "kSeqMask = 511ull;" in text
    assert f"kTimeMask = {2**34 - 1}ull;" in text


def test_only_ports_that_the_top_has_are_used() -> None:
    cot, array = source("cot", Shape(n_slots=1)), source("cot_array", Shape())
    assert "io->s_seq" in cot
    assert "io->m_cm_slot" not in cot
    assert "io->s_seq" not in array
    assert "io->m_cm_slot" in array


def test_every_field_of_a_shape_is_a_parameter() -> None:
    assert set(PARAMETERS) == set(Shape.__dataclass_fields__)

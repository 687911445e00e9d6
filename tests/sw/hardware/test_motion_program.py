# SPDX-License-Identifier: Apache-2.0
"""The assembler of the array with motion, and that its program fits the hardware."""

from __future__ import annotations

import pytest

from evcot.hardware.motion.program.assembler import WORD_W, Field, Hot, Kind, Op, Operand, Out, Program
from evcot.hardware.motion.program.program import ENTRIES, program

OP_LSB = 18


def mem(field: Field, slot: int = 0) -> Operand:
    return Operand(Kind.MEM, field, 0, slot)


@pytest.mark.parametrize(
    ("first", "second", "clocks"),
    [
        ((Op.ST, mem(Field.T0)), (Op.LD, mem(Field.T0)), 4),
        ((Op.ST, mem(Field.T0)), (Op.LD, mem(Field.T0, slot=1)), 4),
        ((Op.ST, mem(Field.T0)), (Op.LD, mem(Field.T1)), 1),
        ((Op.ST, mem(Field.T0)), (Op.ST, mem(Field.T0)), 1),
        ((Op.STH, Operand(Kind.HOT, Hot.LO)), (Op.SUB, Operand(Kind.HOT, Hot.HI)), 5),
        ((Op.STH, Operand(Kind.HOT, Hot.LO)), (Op.SUB, Operand(Kind.IMM, 3)), 1),
        ((Op.SWAP, None), (Op.LD, mem(Field.V)), 4),
        ((Op.SWAP, None), (Op.LD, Operand(Kind.IMM, 0)), 1),
        ((Op.TAKE, None), (Op.EXT, None), 2),
        ((Op.PICK, None), (Op.TAKE, None), 2),
        ((Op.OUT, None), (Op.PICK, None), 4),
        ((Op.OUT, None), (Op.EXT, None), 5),
        ((Op.LD, mem(Field.V)), (Op.ST, mem(Field.V)), 1),
    ],
)
def test_what_needs_a_result_comes_late_enough(
    first: tuple[Op, Operand | None], second: tuple[Op, Operand | None], clocks: int
) -> None:
    text = Program()
    text.put(*first)
    text.put(*second)
    words = text.assemble()
    assert [word >> OP_LSB for word in words] == [first[0], *[Op.NOP] * (clocks - 1), second[0]]


def test_an_instruction_has_its_parts() -> None:
    text = Program()
    text.label("here")
    text.put(Op.LE, Operand(Kind.MEM, Field.SP, 1, 1), mode="or", neg=True, lanes="y", when=5)
    text.put(Op.J, to="here", when=7)
    text.put(Op.OUT, arg=Out.BORN)
    assert text.assemble() == [
        12 << 18 | 2 << 16 | 1 << 15 | 2 << 13 | 5 << 10 | 3 << 6 | 1, 20 << 18 | 3 << 13 | 7 << 10, 19 << 18 | 3 << 13 | 7
    ]  # fmt: skip


def test_the_program_fits_and_jumps_into_itself() -> None:
    words, labels = program()
    assert len(words) <= 1024
    assert max(words) < 1 << WORD_W
    assert set(ENTRIES) <= set(labels)
    targets = {word & 1023 for word in words if word >> OP_LSB in (Op.J, Op.CALL)}
    assert targets <= set(labels.values())
    assert words[-1] >> OP_LSB == Op.RET  # nothing runs off the end

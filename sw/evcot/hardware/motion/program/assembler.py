# SPDX-License-Identifier: Apache-2.0
"""Assembler for motion_engine.v: instructions, labels, and the clocks that must lie between two of them.

Both lanes, x and y, obey the same instruction; each has an accumulator, a flag f and a register s of five bits. An
instruction acts in a lane if the lane is among `lanes` and its predicate holds there. What follows too early on what it needs
is moved apart by `nop`.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from enum import IntEnum

from ..contract import MOTION_BANKS

__all__ = ["FIELDS", "WORD_W", "Ext", "Field", "Hot", "If", "Kind", "Op", "Out", "Pick", "Program", "Value", "When"]

WORD_W = 23


class Op(IntEnum):
    """Operations."""

    NOP = 0
    LD = 1
    ADD = 2
    SUB = 3  # acc - operand
    RSB = 4  # operand - acc
    ADDT = 5  # of times: modulo 2^TIME_W
    SUBT = 6
    SHR1 = 7
    SHR4 = 8
    SHL1 = 9
    SHL4 = 10
    LT = 11  # f: acc < operand
    LE = 12
    LTT = 13  # of times
    FO = 14  # f: that of the other lane
    EXT = 15  # f: a condition from outside
    ST = 16
    STH = 17
    STS = 18
    OUT = 19
    J = 20
    CALL = 21
    RET = 22
    PICK = 23
    TAKE = 24
    SWAP = 25
    DONE = 26


class Kind(IntEnum):
    """Where an operand comes from."""

    MEM = 0
    HOT = 1
    VALUE = 2
    IMM = 3


class Field(IntEnum):
    """Words of a slot in the memory of each lane; scalars are in both."""

    V = 0
    SP = 1  # |v|
    LEN = 2  # px
    BLO = 3
    BHI = 4
    WLO = 5
    WHI = 6
    START = 7
    LAST = 8
    USUAL = 9
    DEADLINE = 10
    SEEDED = 11
    REPORTED = 12
    ID = 13
    CORR = 14
    LOOKED = 15
    TOGETHER = 16
    PARTNER = 17
    MEETS = 18
    HLO = 19
    HHI = 20
    T0 = 24
    T1 = 25
    T2 = 26
    T3 = 27
    T4 = 28


FIELDS = 32


class Hot(IntEnum):
    """Words that events change, in motion_events.v."""

    LO = 0
    HI = 1
    OFF_LO = 2
    OFF_HI = 3
    SUPPORT = 4
    N_EV = 5  # less one; written: the count begins anew
    BEYOND = 6  # read: hi and lo that no event was beyond; written: those that one was beyond
    BINS = 7  # read: log2 of a bin; written with a length: all bins are empty
    HIDDEN = 8  # written only
    WLO = 9  # written only


REGISTERS = {name: number for number, name in enumerate(itertools.chain(*MOTION_BANKS.values()), 1)}
"""Numbers of the registers among the values, without gaps; their addresses have some."""


class Value(IntEnum):
    """Values of motion_values.v behind the registers, which have the numbers of `REGISTERS`."""

    NOW = 40
    EVENT = 41  # 2^-12 px
    OTHER = 42  # slot
    BIRTHS = 43
    LEADING = 44  # of motion_inverse.v
    INVERSE = 45
    GAP_BIN = 46  # of motion_gaps.v
    HALF = 48  # pixel
    TWO = 49  # pixels
    REACH_LO = 50
    REACH_HI = 51
    TICKS_MAX = 52
    TOGETHER_MAX = 53
    SUPPORT_MAX = 54


class Ext(IntEnum):
    """Conditions."""

    VISIBLE = 0
    OTHER_VISIBLE = 1
    OWNED = 2  # a visible window holds the pixel asked for
    RECORD_FREE = 3
    LOOKING = 4
    GAP_FOUND = 5
    LOW_STAYS = 6
    DIVIDING = 7
    CURRENT = 8  # the slot is that of the motion step


class Out(IntEnum):
    """What is done with both accumulators."""

    PLACE_BLO = 0
    PLACE_BHI = 1
    PLACE_WLO = 2
    PLACE_WHI = 3
    ASK_LO = 4
    ASK_HI = 5
    BEGIN = 6  # slot: a candidate
    BORN = 7
    FREE = 8
    FREE_OTHER = 9
    TODO = 10
    REST = 11
    DIVISOR = 12
    SCALE = 13  # log2 of a bin, of lane x
    SCALE_Y = 14
    LOOK_X = 15
    LOOK_Y = 16
    KIND = 17
    HEAD = 18
    MIDDLE = 19
    SIDES = 20
    MOVES = 21
    ID = 22
    OTHER_ID = 23
    N_EV = 24
    SUPPORT = 25
    RECORD = 26


class Pick(IntEnum):
    """Among which slots the next one is sought."""

    LIVES = 0  # not yet done in this step
    PARTNER = 1
    TOUCH = 2
    HIDE = 3


class If(IntEnum):
    """Predicates."""

    ALWAYS = 0
    F = 1
    NF = 2
    S0 = 3
    S1 = 4
    S2 = 5
    S3 = 6
    S4 = 7


class When(IntEnum):
    """Of a jump: by f of lane x, of lane y, of both, of any."""

    ALWAYS = 0
    X = 1
    NX = 2
    Y = 3
    NY = 4
    ALL = 5
    NALL = 6
    ANY = 7


_MODES = {"set": 0, "and": 1, "or": 2}


@dataclass(frozen=True)
class Operand:
    """Operand of an instruction."""

    kind: Kind
    index: int
    lane: int = 0  # 1: of the other lane
    slot: int = 0  # 1: of the other slot

    @property
    def code(self) -> int:
        """Ten bits."""
        if self.kind is Kind.IMM:
            return self.kind << 8 | self.index
        return self.kind << 8 | self.lane << 7 | self.slot << 6 | self.index


@dataclass
class _Word:
    op: Op
    operand: Operand | None
    label: str
    mode: int
    neg: int
    lanes: int
    pred: int
    arg: int


class Program:
    """Instructions and labels."""

    def __init__(self) -> None:
        self.words: list[_Word] = []
        self.labels: dict[str, int] = {}

    def label(self, name: str) -> None:
        """The next instruction can be jumped to."""
        self.labels[name] = len(self.words)

    def put(
        self, op: Op, operand: Operand | None = None, *, mode: str = "set", neg: bool = False, lanes: str = "xy", when: int = 0,
        to: str = "", arg: int = 0,
    ) -> None:  # fmt: skip
        """Add an instruction, after as many `nop` as it needs."""
        word = _Word(
            op,
            operand,
            to,
            _MODES[mode],
            int(neg),
            ("x" in lanes) | ("y" in lanes) << 1,
            when,
            operand.code if operand else arg,
        )
        while not self._may_follow(word):
            self.words.append(_Word(Op.NOP, None, "", 0, 0, 0, 0, 0))
        self.words.append(word)

    def _may_follow(self, word: _Word) -> bool:
        return all(distance >= _distance(before, word) for distance, before in enumerate(reversed(self.words[-6:]), start=1))

    def assemble(self) -> list[int]:
        """The words of the program."""
        words = []
        for word in self.words:
            arg = self.labels[word.label] if word.label else word.arg
            words.append(int(word.op) << 18 | word.mode << 16 | word.neg << 15 | word.lanes << 13 | word.pred << 10 | arg)
        return words


def _distance(before: _Word, word: _Word) -> int:
    """How many clocks `word` must come after `before`."""
    reads = word.operand if word.op not in (Op.ST, Op.STH) else None
    if before.op in (Op.TAKE, Op.SWAP):
        if reads is not None and reads.kind in (Kind.MEM, Kind.HOT, Kind.VALUE):
            return 4
        return 2 if word.op is Op.EXT else 0
    if before.op is Op.ST and reads is not None and reads.kind is Kind.MEM and before.operand is not None:
        return 4 if reads.index == before.operand.index else 0
    if before.op is Op.STH and reads is not None and reads.kind is Kind.HOT:
        return 5
    if before.op is Op.PICK and word.op is Op.TAKE:
        return 2
    if before.op is Op.OUT:
        if word.op is Op.PICK:
            return 4
        if word.op is Op.EXT:
            return 5
        if reads is not None and reads.kind is Kind.VALUE and before.arg == Out.BORN:
            return 4
    return 0

# SPDX-License-Identifier: Apache-2.0
"""The program: docs/motion.md's rules for a slot, as motion_engine.v carries them out."""

from __future__ import annotations

from ....tracks.log import Kind as Record
from .assembler import REGISTERS, Ext, Field, Hot, If, Kind, Op, Operand, Out, Pick, Program, Value, When

__all__ = ["ENTRIES", "program"]

ENTRIES = ("correct", "seed", "step", "restart")
"""Where the program is entered: by an event, by a motion step, by a write of `mode`."""

_F = Field


def _mem(field: Field, *, lane: int = 0, slot: int = 0) -> Operand:
    return Operand(Kind.MEM, field, lane, slot)


def _hot(field: Hot, *, slot: int = 0) -> Operand:
    return Operand(Kind.HOT, field, 0, slot)


def _imm(value: int) -> Operand:
    return Operand(Kind.IMM, value)


def _value(value: Value) -> Operand:
    return Operand(Kind.VALUE, value)


def _register(name: str) -> Operand:
    return Operand(Kind.VALUE, REGISTERS[name])


class _Writer(Program):
    """Instructions by name."""

    def load(self, operand: Operand, when: int = 0, lanes: str = "xy") -> None:
        self.put(Op.LD, operand, when=when, lanes=lanes)

    def add(self, operand: Operand, when: int = 0, lanes: str = "xy") -> None:
        self.put(Op.ADD, operand, when=when, lanes=lanes)

    def sub(self, operand: Operand, when: int = 0, lanes: str = "xy") -> None:
        self.put(Op.SUB, operand, when=when, lanes=lanes)

    def rsb(self, operand: Operand, when: int = 0) -> None:
        self.put(Op.RSB, operand, when=when)

    def store(self, field: Field, when: int = 0, lanes: str = "xy") -> None:
        self.put(Op.ST, _mem(field), when=when, lanes=lanes)

    def hot(self, field: Hot, when: int = 0, lanes: str = "xy") -> None:
        self.put(Op.STH, _hot(field), when=when, lanes=lanes)

    def below(self, operand: Operand, mode: str = "set", lanes: str = "xy") -> None:
        self.put(Op.LT, operand, mode=mode, lanes=lanes)

    def at_least(self, operand: Operand, mode: str = "set", lanes: str = "xy") -> None:
        self.put(Op.LT, operand, mode=mode, neg=True, lanes=lanes)

    def at_most(self, operand: Operand, mode: str = "set", lanes: str = "xy") -> None:
        self.put(Op.LE, operand, mode=mode, lanes=lanes)

    def above(self, operand: Operand, mode: str = "set", lanes: str = "xy") -> None:
        self.put(Op.LE, operand, mode=mode, neg=True, lanes=lanes)

    def is_so(self, condition: Ext, mode: str = "set", lanes: str = "xy") -> None:
        self.put(Op.EXT, arg=condition, mode=mode, lanes=lanes)

    def jump(self, to: str, when: int = 0) -> None:
        self.put(Op.J, to=to, when=when)

    def call(self, to: str) -> None:
        self.put(Op.CALL, to=to)

    def out(self, what: Out) -> None:
        self.put(Op.OUT, arg=what)

    def shift(self, op: Op, times: int = 1, when: int = 0, lanes: str = "xy") -> None:
        for _ in range(times):
            self.put(op, when=when, lanes=lanes)

    def to_px(self) -> None:
        self.shift(Op.SHR4, 3)

    def from_px(self) -> None:
        self.shift(Op.SHL4, 3)

    def right_by_s(self, bits: int) -> None:
        """Shift by s, of so many bits."""
        self._by_s(Op.SHR1, Op.SHR4, bits)

    def left_by_s(self, bits: int) -> None:
        self._by_s(Op.SHL1, Op.SHL4, bits)

    def _by_s(self, one: Op, four: Op, bits: int) -> None:
        for bit in range(bits):
            self.shift(four if bit > 1 else one, 1 << (bit - 2 if bit > 1 else bit), when=If.S0 + bit)

    def to_s(self, operand: Operand) -> None:
        self.load(operand)
        self.put(Op.STS)

    def as_bit(self, field: Field) -> None:
        """The flag as a word."""
        self.load(_imm(0))
        self.load(_imm(1), If.F)
        self.store(field)

    def at_least_zero(self) -> None:
        self.below(_imm(0))
        self.load(_imm(0), If.F)

    def at_most_that(self, operand: Operand) -> None:
        self.above(operand)
        self.load(operand, If.F)

    def at_least_that(self, operand: Operand) -> None:
        self.below(operand)
        self.load(operand, If.F)

    def magnitude(self) -> None:
        self.below(_imm(0))
        self.rsb(_imm(0), If.F)

    def length(self) -> None:
        """Of the box, px."""
        self.load(_hot(Hot.HI))
        self.sub(_hot(Hot.LO))
        self.at_least_zero()
        self.to_px()

    def record(self, kind: Record) -> None:
        self.load(_imm(int(kind)))
        self.call("record")

    def times_elongation(self) -> None:
        """elongation * the other axis' length."""
        self.to_s(_register("elongation"))
        self.load(_imm(0))
        for bit in (If.S3, If.S2, If.S1, If.S0):
            self.add(_mem(_F.LEN, lane=1), bit)
            if bit != If.S0:
                self.shift(Op.SHL1)

    def next_slot(self, among: Pick, otherwise: str) -> None:
        self.put(Op.PICK, arg=among)
        self.put(Op.TAKE, arg=int(among is not Pick.LIVES))
        self.jump(otherwise, When.NX)


def _correct(w: _Writer) -> None:
    w.label("correct")
    w.to_s(_register("side_shrink"))
    w.at_most(_imm(0))
    w.load(_mem(_F.MEETS))
    w.at_least(_imm(1), "or")
    w.load(_hot(Hot.HI))
    w.sub(_hot(Hot.LO))
    w.load(_imm(0), If.F)
    w.at_least_zero()
    w.right_by_s(4)
    w.store(_F.T0)
    w.to_s(_hot(Hot.BEYOND))
    w.load(_hot(Hot.LO))
    w.add(_mem(_F.T0), If.S0)
    w.hot(Hot.LO)
    w.load(_hot(Hot.OFF_LO))
    w.add(_mem(_F.T0), If.S0)
    w.hot(Hot.OFF_LO)
    w.load(_hot(Hot.HI))
    w.sub(_mem(_F.T0), If.S1)
    w.hot(Hot.HI)
    w.load(_hot(Hot.OFF_HI))
    w.sub(_mem(_F.T0), If.S1)
    w.hot(Hot.OFF_HI)
    w.load(_imm(0))
    w.hot(Hot.BEYOND)
    w.at_least(_register("gap_corrections"))
    w.jump("ticks", When.X)
    w.load(_mem(_F.LOOKED))
    w.add(_imm(1))
    w.store(_F.LOOKED)
    w.below(_register("gap_corrections"))
    w.jump("ticks", When.X)
    _gaps(w)
    _velocity(w)
    w.load(_imm(0))
    w.hot(Hot.OFF_LO)
    w.hot(Hot.OFF_HI)
    w.load(_mem(_F.CORR))
    w.at_most(_imm(0))
    w.load(_mem(_F.T0))
    w.sub(_mem(_F.USUAL), If.NF)
    w.shift(Op.SHR1, 2, If.NF)
    w.add(_mem(_F.USUAL), If.NF)
    w.store(_F.USUAL)
    w.load(_value(Value.NOW))
    w.store(_F.LAST)
    w.load(_mem(_F.CORR))
    w.below(_imm(63))
    w.add(_imm(1), If.F)
    w.store(_F.CORR)
    w.at_most(_imm(4))
    w.at_least(_imm(4), "and")
    w.load(_hot(Hot.LO))
    w.add(_hot(Hot.HI))
    w.store(_F.START, If.F)
    w.length()
    w.store(_F.LEN)
    w.to_s(_register("life_log2"))
    w.load(_mem(_F.USUAL))
    w.left_by_s(4)
    w.at_least_that(_register("life_ticks"))
    w.at_most_that(_register("coast_ticks"))
    w.put(Op.ADDT, _value(Value.NOW))
    w.store(_F.DEADLINE)
    w.load(_mem(_F.LEN))
    w.add(_mem(_F.LEN, lane=1))
    w.at_least_that(_register("nev_low"))
    w.at_most_that(_register("nev_high"))
    w.sub(_imm(1))
    w.hot(Hot.N_EV)
    w.call("window")
    w.is_so(Ext.VISIBLE)
    w.jump("done", When.NX)
    w.record(Record.MOVED)
    w.label("done")
    w.put(Op.DONE)


def _gaps(w: _Writer) -> None:
    w.load(_mem(_F.CORR))
    w.below(_imm(8))
    w.jump("looked", When.X)
    w.load(_mem(_F.SP))
    w.at_most(_imm(0))
    w.jump("looked", When.ALL)
    w.length()
    w.store(_F.LEN)
    w.load(_mem(_F.SP, lane=1))
    w.shift(Op.SHL1)
    w.at_least(_mem(_F.SP))
    w.as_bit(_F.T0)  # across the motion
    w.times_elongation()
    w.at_most(_mem(_F.LEN))
    w.load(_mem(_F.T0))
    w.at_least(_imm(1), "or")
    w.as_bit(_F.T1)  # to be looked at
    w.load(_mem(_F.LEN, lane=1))
    w.shift(Op.SHR1)
    w.at_least_that(_register("gap_px"))
    w.store(_F.T2)
    w.load(_mem(_F.T0))
    w.at_least(_imm(1))
    w.load(_register("gap_px"))
    w.store(_F.T2, If.F)
    for lane, scale, look, yes, no in (
        ("x", Out.SCALE, Out.LOOK_X, When.X, When.NX),
        ("y", Out.SCALE_Y, Out.LOOK_Y, When.Y, When.NY),
    ):
        w.load(_mem(_F.T1))
        w.at_least(_imm(1))
        w.jump(f"looked_{lane}", no)
        w.load(_hot(Hot.BINS))
        w.out(scale)
        w.load(_mem(_F.T2))
        w.out(look)
        w.label(f"looking_{lane}")
        w.is_so(Ext.LOOKING)
        w.jump(f"looking_{lane}", yes)
        w.is_so(Ext.GAP_FOUND)
        w.jump(f"looked_{lane}", no)
        w.to_s(_hot(Hot.BINS))
        w.load(_value(Value.GAP_BIN))
        w.left_by_s(5)
        w.from_px()
        w.add(_hot(Hot.LO))
        w.is_so(Ext.LOW_STAYS)
        w.hot(Hot.HI, If.F, lane)
        w.hot(Hot.LO, If.NF, lane)
        w.above(_hot(Hot.HI))
        w.hot(Hot.HI, If.F, lane)
        w.label(f"looked_{lane}")
    w.label("looked")
    w.length()
    w.hot(Hot.BINS)
    w.load(_imm(0))
    w.store(_F.LOOKED)


def _velocity(w: _Writer) -> None:
    w.label("ticks")
    w.load(_value(Value.NOW))
    w.put(Op.SUBT, _mem(_F.LAST))
    w.at_least_that(_imm(1))
    w.at_most_that(_value(Value.TICKS_MAX))
    w.store(_F.T0)
    w.out(Out.DIVISOR)
    w.load(_mem(_F.CORR))
    w.below(_imm(2))
    w.jump("corrected", When.X)
    # T1: the gain; T2: d
    w.to_s(_register("gain_slow"))
    w.load(_mem(_F.CORR))
    w.right_by_s(3)
    w.add(_imm(1))
    w.at_most_that(_register("gain_log2"))
    w.add(_mem(_F.MEETS))
    w.store(_F.T1)
    w.load(_mem(_F.CORR))
    w.below(_register("settle"))
    w.jump("slower", When.X)
    w.load(_hot(Hot.OFF_LO))
    w.add(_hot(Hot.OFF_HI))
    w.store(_F.T2)
    w.jump("divide")
    w.label("slower")
    w.load(_hot(Hot.OFF_LO))
    w.magnitude()
    w.store(_F.T2)
    w.load(_hot(Hot.OFF_HI))
    w.magnitude()
    w.above(_mem(_F.T2))  # of equals the high side
    w.load(_hot(Hot.OFF_HI))
    w.load(_hot(Hot.OFF_LO), If.F)
    w.shift(Op.SHL1)
    w.store(_F.T2)
    w.load(_hot(Hot.OFF_LO))
    w.above(_imm(0))
    w.as_bit(_F.T3)
    w.load(_hot(Hot.OFF_HI))
    w.above(_imm(0))
    w.load(_imm(0))
    w.load(_imm(1), If.F)
    w.sub(_mem(_F.T3))
    w.below(_imm(0))
    w.above(_imm(0), "or")  # one is positive, the other not
    w.load(_imm(0))
    w.store(_F.T2, If.F)
    w.label("divide")
    w.is_so(Ext.DIVIDING)
    w.jump("divide", When.X)
    w.load(_value(Value.INVERSE))
    w.shift(Op.SHR4)
    w.put(Op.STS)
    w.load(_imm(0))
    for bit in (If.S2, If.S1, If.S0):
        w.shift(Op.SHL1)
        w.add(_mem(_F.T2), bit)
    w.store(_F.T3)
    w.to_s(_value(Value.INVERSE))
    w.load(_mem(_F.T3))
    for bit in (If.S3, If.S2, If.S1, If.S0):
        w.shift(Op.SHL1)
        w.add(_mem(_F.T2), bit)
    w.store(_F.T2)  # the product
    w.load(_value(Value.LEADING))
    w.add(_mem(_F.T1))
    w.add(_imm(8))
    w.sub(_register("step_log2"))
    w.put(Op.STS)
    w.below(_imm(0))
    w.jump("enlarge", When.X)
    w.at_least(_imm(32))
    w.load(_mem(_F.T2))
    w.shift(Op.SHR4, 8, If.F)
    w.right_by_s(5)
    w.jump("change")
    w.label("enlarge")  # what is beyond 16 bits is beyond any velocity
    w.rsb(_imm(0))
    w.put(Op.STS)
    w.load(_value(Value.TOGETHER_MAX))
    w.rsb(_imm(0))
    w.store(_F.T1)
    w.load(_mem(_F.T2))
    w.at_most_that(_value(Value.TOGETHER_MAX))
    w.at_least_that(_mem(_F.T1))
    w.left_by_s(4)
    w.label("change")
    w.add(_mem(_F.V))
    w.store(_F.V)
    w.load(_register("speed_max"))
    w.rsb(_imm(0))
    w.store(_F.T1)
    w.load(_mem(_F.V))
    w.at_most_that(_register("speed_max"))
    w.at_least_that(_mem(_F.T1))
    w.store(_F.V)
    w.label("corrected")


def _window(w: _Writer) -> None:
    w.label("window")
    w.length()
    w.store(_F.LEN)
    w.load(_mem(_F.V))
    w.magnitude()
    w.store(_F.SP)
    w.load(_hot(Hot.LO))
    w.add(_value(Value.HALF))
    w.to_px()
    w.store(_F.BLO)
    w.load(_hot(Hot.HI))
    w.add(_value(Value.HALF))
    w.to_px()
    w.store(_F.BHI)
    w.below(_mem(_F.BLO))
    w.add(_mem(_F.BLO), If.F)
    w.shift(Op.SHR1, 1, If.F)
    w.store(_F.BLO, If.F)
    w.store(_F.BHI, If.F)
    w.is_so(Ext.VISIBLE)
    w.load(_mem(_F.CORR))
    w.at_least(_imm(4), "or")
    w.load(_mem(_F.SP, lane=1))
    w.shift(Op.SHL1)
    w.at_most(_mem(_F.SP), "and")
    w.put(Op.FO, mode="and", neg=True, lanes="x")  # of equals y
    w.as_bit(_F.T0)  # the motion is along this axis
    w.put(Op.FO, mode="or")
    w.load(_register("ring_any"))
    w.load(_register("ring_across"), If.F)
    w.store(_F.T1)
    w.load(_mem(_F.LEN))
    w.store(_F.T2)
    w.times_elongation()
    w.above(_mem(_F.LEN))
    w.load(_mem(_F.T0))
    w.at_least(_imm(1), "and")
    w.load(_register("ring_along"))
    w.store(_F.T1, If.F)
    w.load(_mem(_F.LEN, lane=1))
    w.store(_F.T2, If.F)
    w.load(_mem(_F.BLO))
    w.out(Out.PLACE_BLO)
    w.load(_mem(_F.BHI))
    w.out(Out.PLACE_BHI)
    w.to_s(_mem(_F.T1))
    w.load(_mem(_F.T2))
    w.right_by_s(4)
    w.add(_register("ring_px"))
    w.at_most_that(_register("ring_max"))
    w.store(_F.T3)
    w.rsb(_mem(_F.BLO))
    w.store(_F.WLO)
    w.hot(Hot.WLO)
    w.out(Out.PLACE_WLO)
    w.load(_mem(_F.BHI))
    w.add(_mem(_F.T3))
    w.store(_F.WHI)
    w.out(Out.PLACE_WHI)
    w.put(Op.RET)


def _record(w: _Writer) -> None:
    w.label("record")
    w.out(Out.KIND)
    w.label("recording")
    w.is_so(Ext.RECORD_FREE)
    w.jump("recording", When.NX)
    w.out(Out.HEAD)
    w.load(_hot(Hot.LO))
    w.add(_hot(Hot.HI))
    w.shift(Op.SHR1)
    w.out(Out.MIDDLE)
    w.load(_hot(Hot.HI))
    w.sub(_hot(Hot.LO))
    w.at_least_zero()
    w.out(Out.SIDES)
    for operand, what in (
        (_mem(_F.V), Out.MOVES),
        (_mem(_F.ID), Out.ID),
        (_mem(_F.ID, slot=1), Out.OTHER_ID),
        (_hot(Hot.N_EV), Out.N_EV),
        (_hot(Hot.SUPPORT), Out.SUPPORT),
    ):
        w.load(operand)
        if what is Out.N_EV:
            w.add(_imm(1))
        w.out(what)
    w.out(Out.RECORD)
    w.load(_value(Value.NOW))
    w.store(_F.REPORTED)
    w.put(Op.RET)


def _seed(w: _Writer) -> None:
    w.label("seed")
    w.out(Out.BEGIN)
    w.load(_register("seed_px"))
    w.from_px()
    w.store(_F.T0)
    w.rsb(_value(Value.EVENT))
    w.hot(Hot.LO)
    w.load(_value(Value.EVENT))
    w.add(_mem(_F.T0))
    w.hot(Hot.HI)
    w.load(_imm(0))
    for hot in (Hot.OFF_LO, Hot.OFF_HI, Hot.BEYOND, Hot.HIDDEN, Hot.SUPPORT):
        w.hot(hot)
    for field in (_F.V, _F.MEETS, _F.CORR, _F.TOGETHER, _F.LOOKED):
        w.store(field)
    w.sub(_imm(1))
    w.store(_F.PARTNER)
    w.load(_register("nev_low"))
    w.sub(_imm(1))
    w.hot(Hot.N_EV)
    w.load(_value(Value.NOW))
    w.store(_F.LAST)
    w.store(_F.SEEDED)
    w.load(_register("detect_ticks"))
    w.store(_F.USUAL)
    w.put(Op.ADDT, _value(Value.NOW))
    w.store(_F.DEADLINE)
    w.length()
    w.hot(Hot.BINS)
    w.call("window")
    w.put(Op.DONE)


def _restart(w: _Writer) -> None:
    w.label("restart")
    w.is_so(Ext.VISIBLE)
    w.jump("ended", When.NX)
    w.record(Record.LOST)
    w.label("ended")
    w.out(Out.FREE)
    w.put(Op.DONE)


def _step(w: _Writer) -> None:
    w.label("step")
    w.out(Out.TODO)
    w.label("next")
    w.next_slot(Pick.LIVES, "done")
    w.load(_value(Value.NOW))
    w.put(Op.LTT, _mem(_F.DEADLINE))
    w.jump("alive", When.X)
    w.is_so(Ext.VISIBLE)
    w.jump("lapse", When.NX)
    w.record(Record.LOST)
    w.label("lapse")
    w.out(Out.FREE)
    w.jump("next")

    w.label("alive")
    w.is_so(Ext.VISIBLE)
    w.load(_mem(_F.CORR))
    w.at_least(_imm(4), "or")
    w.jump("long", When.NX)
    w.load(_hot(Hot.LO))
    w.add(_mem(_F.V))
    w.store(_F.T0)
    w.below(_value(Value.REACH_HI))
    w.at_least(_value(Value.REACH_LO), "and")
    w.load(_hot(Hot.HI))
    w.add(_mem(_F.V))
    w.below(_value(Value.REACH_HI), "and")
    w.at_least(_value(Value.REACH_LO), "and")
    w.hot(Hot.HI, If.F)
    w.load(_mem(_F.T0))
    w.hot(Hot.LO, If.F)
    w.load(_value(Value.NOW))
    w.put(Op.SUBT, _mem(_F.LAST))
    w.store(_F.T1)
    w.to_s(_register("friction"))
    w.at_most(_imm(0))
    w.load(_mem(_F.MEETS))
    w.at_least(_imm(1), "or")
    w.load(_mem(_F.USUAL))
    w.shift(Op.SHL1, 2)
    w.at_least(_mem(_F.T1), "or")
    w.load(_mem(_F.V))
    w.right_by_s(4)
    w.rsb(_mem(_F.V))
    w.store(_F.V, If.NF)

    w.label("long")
    w.load(_hot(Hot.HI))
    w.sub(_hot(Hot.LO))
    w.store(_F.T0)
    w.load(_hot(Hot.LO))
    w.add(_hot(Hot.HI))
    w.shift(Op.SHR1)
    w.store(_F.T2)
    w.load(_register("side_max"))
    w.from_px()
    w.below(_mem(_F.T0))
    w.shift(Op.SHR1)
    w.store(_F.T1)
    w.rsb(_mem(_F.T2))
    w.hot(Hot.LO, If.F)
    w.load(_mem(_F.T2))
    w.add(_mem(_F.T1))
    w.hot(Hot.HI, If.F)
    w.call("window")
    _partner(w)
    _join(w)
    w.label("joined")
    w.is_so(Ext.VISIBLE)
    w.jump("hiding", When.X)
    _candidate(w)
    _hiding(w)
    w.load(_value(Value.NOW))
    w.put(Op.SUBT, _mem(_F.REPORTED))
    w.right_by_s(5)
    w.below(_register("report_steps"))
    w.jump("next", When.X)
    w.record(Record.MOVED)
    w.jump("next")


def _ask_box(w: _Writer) -> None:
    w.load(_mem(_F.BLO))
    w.out(Out.ASK_LO)
    w.load(_mem(_F.BHI))
    w.out(Out.ASK_HI)


def _partner(w: _Writer) -> None:
    """The lowest slot that moves alike, and can be one object."""
    w.load(_mem(_F.CORR))
    w.below(_imm(4))
    w.jump("alone", When.X)
    w.out(Out.REST)
    _ask_box(w)
    w.label("partner")
    w.next_slot(Pick.PARTNER, "alone")
    w.to_s(_register("join_speed"))
    w.load(_mem(_F.CORR, slot=1))
    w.below(_imm(4))
    w.jump("partner", When.X)
    w.load(_mem(_F.SP))
    for operand in (_mem(_F.SP, lane=1), _mem(_F.SP, slot=1), _mem(_F.SP, lane=1, slot=1)):
        w.at_least_that(operand)
    w.right_by_s(4)
    w.add(_imm(64))
    w.store(_F.T0)
    w.load(_mem(_F.V))
    w.sub(_mem(_F.V, slot=1))
    w.magnitude()
    w.at_most(_mem(_F.T0))
    w.jump("partner", When.NALL)
    # T0: how far the boxes overlap; T1: the longer side; T2: the shorter one
    w.load(_mem(_F.BLO))
    w.at_least_that(_mem(_F.BLO, slot=1))
    w.store(_F.T3)
    w.load(_mem(_F.BHI))
    w.at_most_that(_mem(_F.BHI, slot=1))
    w.sub(_mem(_F.T3))
    w.store(_F.T0)
    w.load(_mem(_F.BHI))
    w.sub(_mem(_F.BLO))
    w.store(_F.T2)
    w.load(_mem(_F.BHI, slot=1))
    w.sub(_mem(_F.BLO, slot=1))
    w.store(_F.T1)
    w.above(_mem(_F.T2))
    w.store(_F.T3)
    w.load(_mem(_F.T2), If.F)
    w.store(_F.T4)  # the shorter one
    w.load(_mem(_F.T3))
    w.load(_mem(_F.T2), If.NF)
    w.store(_F.T1)
    w.load(_mem(_F.T4))
    w.shift(Op.SHR1)
    w.at_most(_mem(_F.T0))
    w.as_bit(_F.T2)  # abreast on this axis
    # the motion of the one with more support: T3: along this axis
    w.load(_mem(_F.SP))
    w.store(_F.T3)
    w.load(_hot(Hot.SUPPORT))
    w.below(_hot(Hot.SUPPORT, slot=1))
    w.load(_mem(_F.SP, slot=1))
    w.store(_F.T3, If.F)
    w.to_s(_register("join_reach"))
    w.load(_mem(_F.T3))
    w.at_least(_mem(_F.T3, lane=1), lanes="y")
    w.above(_mem(_F.T3, lane=1), lanes="x")
    w.load(_mem(_F.T1, lane=1))
    w.right_by_s(4)
    w.load(_register("join_px"), If.NF)
    w.add(_mem(_F.T0))
    w.at_least(_imm(0))  # near on this axis
    w.put(Op.FO)
    w.load(_mem(_F.T2))
    w.at_least(_imm(1), "and")
    w.jump("together", When.ANY)
    w.jump("partner")
    w.label("alone")
    w.load(_mem(_F.TOGETHER))
    w.at_least(_imm(1))
    w.sub(_imm(1), If.F)
    w.store(_F.TOGETHER)
    w.jump("joined")


def _join(w: _Writer) -> None:
    w.label("together")
    w.load(_mem(_F.PARTNER))
    w.at_most(_value(Value.OTHER))
    w.at_least(_value(Value.OTHER), "and")
    w.load(_imm(0))
    w.load(_mem(_F.TOGETHER), If.F)
    w.add(_imm(1))
    w.store(_F.TOGETHER)
    w.load(_value(Value.OTHER))
    w.store(_F.PARTNER)
    w.to_s(_register("step_log2"))
    w.load(_value(Value.NOW))
    w.put(Op.SUBT, _mem(_F.SEEDED))
    w.store(_F.T0)
    w.load(_value(Value.NOW))
    w.put(Op.SUBT, _mem(_F.SEEDED, slot=1))
    w.above(_mem(_F.T0))
    w.load(_mem(_F.T0), If.F)
    w.right_by_s(5)
    w.store(_F.T3)
    w.as_bit(_F.T2)  # the other one is older
    w.to_s(_register("join_life"))
    w.load(_mem(_F.T3))
    w.right_by_s(4)
    w.at_least_that(_register("join_steps"))
    w.at_most_that(_value(Value.TOGETHER_MAX))
    w.above(_mem(_F.TOGETHER))
    w.jump("joined", When.X)
    # who stays? then the slot is the one that goes
    w.is_so(Ext.VISIBLE)
    w.jump("seen", When.X)
    w.is_so(Ext.OTHER_VISIBLE)
    w.jump("merge", When.X)
    w.jump("alike")
    w.label("seen")
    w.is_so(Ext.OTHER_VISIBLE)
    w.jump("stays", When.NX)
    w.label("alike")
    w.load(_register("keep_older"))
    w.at_least(_imm(1))
    w.jump("older", When.X)
    w.load(_hot(Hot.SUPPORT))
    w.below(_hot(Hot.SUPPORT, slot=1))
    w.jump("merge", When.X)
    w.jump("stays")
    w.label("older")
    w.load(_mem(_F.T2))
    w.at_least(_imm(1))
    w.jump("merge", When.X)
    w.label("stays")
    w.put(Op.SWAP)
    w.label("merge")
    w.is_so(Ext.VISIBLE)
    w.jump("unite", When.NX)
    w.record(Record.MERGED)
    w.label("unite")
    w.put(Op.SWAP)
    w.call("united")
    w.is_so(Ext.VISIBLE)
    w.jump("merged", When.NX)
    w.record(Record.MOVED)
    w.label("merged")
    w.is_so(Ext.CURRENT)
    w.jump("next", When.NX)


def _united(w: _Writer) -> None:
    """The slot becomes one with the other, which ends."""
    w.label("united")
    w.load(_hot(Hot.LO, slot=1))
    w.below(_hot(Hot.LO))
    w.hot(Hot.LO, If.F)
    w.load(_hot(Hot.HI, slot=1))
    w.above(_hot(Hot.HI))
    w.hot(Hot.HI, If.F)
    w.load(_hot(Hot.SUPPORT))
    w.add(_hot(Hot.SUPPORT, slot=1))
    w.at_most_that(_value(Value.SUPPORT_MAX))
    w.hot(Hot.SUPPORT)
    w.load(_mem(_F.DEADLINE, slot=1))
    w.put(Op.LTT, _mem(_F.DEADLINE))
    w.store(_F.DEADLINE, If.NF)
    w.out(Out.FREE_OTHER)
    w.load(_imm(3))
    w.hot(Hot.BEYOND)
    w.length()
    w.hot(Hot.BINS)
    w.load(_imm(0))
    w.hot(Hot.OFF_LO)
    w.hot(Hot.OFF_HI)
    w.store(_F.TOGETHER)
    w.store(_F.LOOKED)
    w.sub(_imm(1))
    w.store(_F.PARTNER)
    w.call("window")
    w.put(Op.RET)


def _candidate(w: _Writer) -> None:
    w.load(_mem(_F.BLO))
    w.add(_mem(_F.BHI))
    w.shift(Op.SHR1)
    w.out(Out.ASK_LO)
    w.out(Out.ASK_HI)
    w.is_so(Ext.OWNED)
    w.jump("lapse", When.X)
    w.out(Out.REST)
    w.label("touch")
    _ask_box(w)
    w.next_slot(Pick.TOUCH, "birth")
    w.load(_hot(Hot.SUPPORT))
    w.below(_hot(Hot.SUPPORT, slot=1))
    w.jump("weaker", When.X)
    w.call("united")
    w.jump("touch")
    w.label("weaker")
    w.put(Op.SWAP)
    w.call("united")
    w.jump("next")

    w.label("birth")
    w.load(_hot(Hot.LO))
    w.add(_hot(Hot.HI))
    w.sub(_mem(_F.START))
    w.magnitude()
    w.store(_F.T0)
    w.load(_hot(Hot.HI))
    w.sub(_hot(Hot.LO))
    w.store(_F.T1)
    w.to_s(_register("birth_travel"))
    w.load(_register("birth_px"))
    w.from_px()
    w.above(_mem(_F.T1))
    w.jump("next", When.ANY)
    w.load(_mem(_F.T1))
    w.add(_mem(_F.T1, lane=1))
    w.right_by_s(4)
    w.shift(Op.SHR1)
    w.add(_value(Value.TWO))
    w.at_most(_mem(_F.T0))
    w.jump("far", When.ANY)
    w.jump("next")
    w.label("far")
    w.load(_mem(_F.CORR))
    w.below(_imm(4))
    w.load(_hot(Hot.SUPPORT))
    w.below(_register("birth_support"), "or")
    w.load(_value(Value.NOW))
    w.put(Op.SUBT, _mem(_F.SEEDED))
    w.below(_register("birth_ticks"), "or")
    w.jump("next", When.X)
    w.load(_value(Value.BIRTHS))
    w.store(_F.ID)
    w.out(Out.BORN)
    w.record(Record.BORN)
    w.jump("next")


def _hiding(w: _Writer) -> None:
    w.label("hiding")
    w.load(_imm(0))
    w.store(_F.MEETS)
    w.store(_F.HLO)
    w.store(_F.HHI)
    w.out(Out.REST)
    w.load(_mem(_F.WLO))
    w.out(Out.ASK_LO)
    w.load(_mem(_F.WHI))
    w.out(Out.ASK_HI)
    w.label("hide")
    w.next_slot(Pick.HIDE, "hidden")
    w.load(_imm(1))
    w.store(_F.MEETS)
    w.load(_mem(_F.WLO, slot=1))
    w.at_most(_mem(_F.BHI))
    w.load(_mem(_F.BLO))
    w.at_most(_mem(_F.WHI, slot=1), "and")
    w.put(Op.FO)
    w.as_bit(_F.T0)  # the box touches the window on the other axis
    for side, hides in ((_F.BLO, _F.HLO), (_F.BHI, _F.HHI)):
        w.load(_mem(_F.WLO, slot=1))
        w.at_most(_mem(side))
        w.load(_mem(side))
        w.at_most(_mem(_F.WHI, slot=1), "and")
        w.load(_mem(_F.T0))
        w.at_least(_imm(1), "and")
        w.load(_imm(1))
        w.store(hides, If.F)
    w.jump("hide")
    w.label("hidden")
    w.to_s(_register("step_log2"))
    w.load(_mem(_F.HHI))
    w.shift(Op.SHL1)
    w.add(_mem(_F.HLO))
    w.hot(Hot.HIDDEN)


def program() -> tuple[list[int], dict[str, int]]:
    """The words, and the addresses of all labels."""
    w = _Writer()
    _correct(w)
    _seed(w)
    _restart(w)
    _step(w)
    _united(w)
    _window(w)
    _record(w)
    return w.assemble(), w.labels

# SPDX-License-Identifier: Apache-2.0
"""A design in BTOR2 over the clocks, as terms of Bitwuzla.

BTOR2 is a format of transition systems whose values are words: Niemetz et al., BTOR2, BtorMC and Boolector 3.0, CAV 2018.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

__all__ = ["Failed", "Unrolled"]

_SECONDS = 900  # the most that a question to the solver may take


class Failed(Exception):
    """A property that does not hold, a cover that is not reached, or a fault that is not found."""


class Unrolled:
    """A BTOR2 design over the clocks, as terms of Bitwuzla. Every term has bits, also those of comparisons."""

    def __init__(self, lines: list[list[str]], initial: bool, models: bool = False) -> None:
        import bitwuzla as bw

        self.bw, self.tm = bw, bw.TermManager()
        options = bw.Options()
        options.set(bw.Option.PRODUCE_MODELS, models)
        options.set(bw.Option.TIME_LIMIT_PER, _SECONDS * 1000)
        self.solver = bw.Bitwuzla(self.tm, options)
        self.initial = initial
        self.sorts: dict[str, Any] = {}
        self.init = {line[3]: line[4] for line in lines if line[1] == "init"}
        self.next = {line[3]: line[4] for line in lines if line[1] == "next"}
        self.bads = {line[3]: line[2] for line in lines if line[1] == "bad"}
        self.constraints = [line[2] for line in lines if line[1] == "constraint"]
        self.lines = self._cone(lines)
        self.frames: list[dict[str, Any]] = []
        self.bit = self.tm.mk_bv_sort(1)
        self.one, self.zero = self.tm.mk_bv_value(self.bit, 1), self.tm.mk_bv_value(self.bit, 0)

    def _cone(self, lines: list[list[str]]) -> list[list[str]]:
        """The lines that a property or a constraint depends on."""
        by_name = {line[0]: line for line in lines}
        wanted, found = [*self.bads.values(), *self.constraints], set()
        while wanted:
            name = wanted.pop()
            if name in found:
                continue
            found.add(name)
            line = by_name[name]
            if line[1] == "sort":
                wanted += line[3:] if line[2] == "array" else []
                continue
            if line[1] in ("const", "input", "state"):
                wanted.append(line[2])
            elif line[1] in ("uext", "sext", "slice"):
                wanted += line[2:4]
            else:
                wanted += [word for word in line[2:] if word in by_name]
            wanted += [table[name] for table in (self.init, self.next) if name in table]
        kinds = ("init", "next", "bad", "constraint", "output")
        return [line for line in lines if line[0] in found and line[1] not in kinds]

    def bad(self, name: str, clock: int) -> Any:
        """That a property is broken, or a cover reached, at a clock."""
        return self.true(self.at(clock)[self.bads[name]])

    def true(self, bit: Any) -> Any:
        """A bit as a Boolean."""
        return self.tm.mk_term(self.bw.Kind.EQUAL, [bit, self.one])

    def no(self, term: Any) -> Any:
        """A Boolean's opposite."""
        return self.tm.mk_term(self.bw.Kind.NOT, [term])

    def at(self, clock: int) -> dict[str, Any]:
        """The terms of all lines at a clock; those before it and their constraints are made as well."""
        while len(self.frames) <= clock:
            frame: dict[str, Any] = {}
            before = self.frames[-1] if self.frames else None
            for line in self.lines:
                self._line(line, frame, before)
            self.frames.append(frame)
            for name in self.constraints:
                self.solver.assert_formula(self.true(frame[name]))
        return self.frames[clock]

    def _line(self, line: list[str], frame: dict[str, Any], before: dict[str, Any] | None) -> None:
        name, kind, *rest = line
        tm, bw = self.tm, self.bw
        if kind == "sort":
            if name not in self.sorts:
                wide = rest[0] == "bitvec"
                self.sorts[name] = (
                    tm.mk_bv_sort(int(rest[1])) if wide else tm.mk_array_sort(*(self.sorts[part] for part in rest[1:]))
                )
            return
        sort = self.sorts[rest[0]]
        if kind == "const":
            frame[name] = tm.mk_bv_value(sort, rest[1], 2)
        elif kind == "state" and before is not None and name in self.next:
            frame[name] = before[self.next[name]]
        elif kind == "state" and before is None and self.initial and name in self.init:
            value = frame[self.init[name]]
            frame[name] = tm.mk_const_array(sort, value) if sort.is_array() and not value.sort().is_array() else value
        elif kind in ("input", "state"):
            frame[name] = tm.mk_const(sort, f"{rest[1] if len(rest) > 1 else kind + name}@{len(self.frames)}")
        elif kind in ("uext", "sext"):
            term, more = frame[rest[1]], int(rest[2])
            frame[name] = (
                tm.mk_term(bw.Kind.BV_ZERO_EXTEND if kind == "uext" else bw.Kind.BV_SIGN_EXTEND, [term], [more])
                if more
                else term
            )
        elif kind == "slice":
            frame[name] = tm.mk_term(bw.Kind.BV_EXTRACT, [frame[rest[1]]], [int(rest[2]), int(rest[3])])
        else:
            frame[name] = self._operation(kind, [frame[word] for word in rest[1:]])

    def _operation(self, kind: str, terms: list[Any]) -> Any:
        tm, kinds = self.tm, self.bw.Kind
        if kind == "ite":
            return tm.mk_term(kinds.ITE, [self.true(terms[0]), *terms[1:]])
        if kind in _COMPARISONS:
            return tm.mk_term(kinds.ITE, [tm.mk_term(getattr(kinds, _COMPARISONS[kind]), terms), self.one, self.zero])
        return tm.mk_term(getattr(kinds, _OPERATIONS.get(kind, f"BV_{kind.upper()}")), terms)

    def check(self, *terms: Any) -> bool:
        """Whether all these can be true at once."""
        result = self.solver.check_sat(*terms)
        if result == self.bw.Result.UNKNOWN:
            raise Failed(f"no answer within {_SECONDS} s")
        return bool(result == self.bw.Result.SAT)

    def either(self, terms: list[Any]) -> Any:
        """That at least one is true."""
        return terms[0] if len(terms) == 1 else self.tm.mk_term(self.bw.Kind.OR, terms)

    def trace(self, clocks: int) -> Iterator[str]:
        """The named registers and inputs at each clock of a counterexample: the last check, made with models."""
        for line in self.lines:
            sort: Any = self.sorts.get(line[2])
            if line[1] in ("state", "input", "uext") and len(line) > (5 if line[1] == "uext" else 3) and not sort.is_array():
                values = [self.solver.get_value(self.frames[clock][line[0]]).value(16) for clock in range(clocks + 1)]
                yield f"  {line[-1]:40s} " + " ".join(f"{value:>4s}" for value in values)


_COMPARISONS = {
    "eq": "EQUAL", "neq": "DISTINCT", "ult": "BV_ULT", "ulte": "BV_ULE", "ugt": "BV_UGT", "ugte": "BV_UGE",
    "slt": "BV_SLT", "slte": "BV_SLE", "sgt": "BV_SGT", "sgte": "BV_SGE",
}  # fmt: skip
_OPERATIONS = {
    "read": "ARRAY_SELECT", "write": "ARRAY_STORE", "sll": "BV_SHL", "srl": "BV_SHR", "sra": "BV_ASHR",
    "redand": "BV_REDAND", "redor": "BV_REDOR", "redxor": "BV_REDXOR",
}  # fmt: skip

# SPDX-License-Identifier: Apache-2.0
"""Signals of a simulation, clock by clock, as a WaveDrom description."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pyverilator import PyVerilator

__all__ = ["Diagram", "Lane", "Trace"]

Diagram = dict[str, Any]
"""What WaveDrom draws: https://wavedrom.com/tutorial.html"""


@dataclass(frozen=True)
class Lane:
    """One line of a diagram.

    Attributes:
        name: what is written beside it.
        ports: one port; or several, which `label` puts into words.
        label: their values in words, empty where they mean nothing; None: a wire that is 0 or 1.
        when: a port that says when they mean anything; empty: always.
        outside: changes between two edges, with a clock of its own.
        of: the simulation that it belongs to, if not the trace's.
    """

    name: str
    ports: tuple[str, ...]
    label: Callable[..., str] | None = None
    when: str = ""
    outside: bool = False
    of: PyVerilator | None = None

    def state(self, sim: PyVerilator) -> str:
        """What stands on the line: 0, 1, = and a label, or x."""
        io = (self.of or sim).io
        if self.when and not int(io[self.when]):
            return "x"
        values = [int(io[port]) for port in self.ports]
        if self.label is None:
            return str(values[0])
        label = self.label(*values)
        return f"={label}" if label else "x"


def wire(port: str, *, outside: bool = False, of: PyVerilator | None = None) -> Lane:
    """A wire that carries the name of its port."""
    return Lane(port, (port,), outside=outside, of=of)


def wave(states: Sequence[str]) -> dict[str, Any]:
    """States, one for each clock, as WaveDrom writes them."""
    text, data = "", []
    for before, now in zip(["", *states], states, strict=False):
        if now == before:
            text += "."
        else:
            text += now[0]
            if now[0] == "=":
                data.append(now[1:])
    return {"wave": text, **({"data": data} if data else {})}


@dataclass
class Trace:
    """Notes the lanes' states; `sample` is called once a clock, when all inputs are set and before the edge.

    Attributes:
        groups: name and lanes of each group of lines.
    """

    sim: PyVerilator
    groups: Sequence[tuple[str, Sequence[Lane]]]
    states: list[list[str]] = field(default_factory=list)

    def sample(self, _clock: int = 0) -> None:
        """Note what all lanes show now."""
        self.states.append([lane.state(self.sim) for _, lanes in self.groups for lane in lanes])

    def diagram(self, clocks: int | None = None) -> Diagram:
        """The first `clocks` of what was noted; all if None."""
        columns = iter(list(zip(*self.states[:clocks], strict=True)))
        signal: list[Any] = [{"name": "clk", "wave": "p" + "." * (len(self.states[:clocks]) - 1)}]
        for name, lanes in self.groups:
            lines = []
            for lane in lanes:
                shift = {"phase": -0.5} if lane.outside else {}
                lines.append({"name": lane.name, **wave(next(columns)), **shift})
            signal += [{}, [name, *lines]] if name else [{}, *lines]
        return {"signal": signal, "config": {"hscale": 1}}

# SPDX-License-Identifier: Apache-2.0
"""Records signals of a simulation, clock by clock, as a WaveDrom description."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pyverilator import PyVerilator

__all__ = ["Diagram", "Lane", "Trace"]

Diagram = dict[str, Any]
"""A WaveDrom description: https://wavedrom.com/tutorial.html"""


@dataclass(frozen=True)
class Lane:
    """One line of a diagram.

    Attributes:
        name: its label.
        ports: one port, or several that `label` formats.
        label: formats their values, empty if meaningless; None for a wire that is 0 or 1.
        when: a port that is high while the values are valid; empty: always.
        outside: asynchronous: changes between two edges.
        of: the simulation to which it belongs, if not the trace's.
    """

    name: str
    ports: tuple[str, ...]
    label: Callable[..., str] | None = None
    when: str = ""
    outside: bool = False
    of: PyVerilator | None = None

    def state(self, sim: PyVerilator) -> str:
        """State of the lane: 0, 1, = and a label, or x."""
        io = (self.of or sim).io
        if self.when and not int(io[self.when]):
            return "x"
        values = [int(io[port]) for port in self.ports]
        if self.label is None:
            return str(values[0])
        label = self.label(*values)
        return f"={label}" if label else "x"


def wire(port: str, *, outside: bool = False, of: PyVerilator | None = None) -> Lane:
    """A wire with the name of its port."""
    return Lane(port, (port,), outside=outside, of=of)


def wave(states: Sequence[str]) -> dict[str, Any]:
    """Encode states, one per clock, in WaveDrom's syntax."""
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
    """Records the lanes' states; `sample` is called once a clock, when all inputs are set and before the edge.

    Attributes:
        groups: name and lanes of each group of lines.
    """

    sim: PyVerilator
    groups: Sequence[tuple[str, Sequence[Lane]]]
    states: list[list[str]] = field(default_factory=list)

    def sample(self, _clock: int = 0) -> None:
        """Record the current state of all lanes."""
        self.states.append([lane.state(self.sim) for _, lanes in self.groups for lane in lanes])

    def diagram(self, clocks: int | None = None) -> Diagram:
        """The diagram of the first `clocks` recorded clocks; all if None."""
        columns = iter(list(zip(*self.states[:clocks], strict=True)))
        signal: list[Any] = [{"name": "clk", "wave": "p" + "." * (len(self.states[:clocks]) - 1)}]
        for name, lanes in self.groups:
            lines = []
            for lane in lanes:
                shift = {"phase": -0.5} if lane.outside else {}
                lines.append({"name": lane.name, **wave(next(columns)), **shift})
            signal += [{}, [name, *lines]] if name else [{}, *lines]
        return {"signal": signal, "config": {"hscale": 1}}

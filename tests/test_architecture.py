# SPDX-License-Identifier: Apache-2.0
"""Who may import whom: software never the hardware's side, and what everything rests on none of the wings."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]
ROOTS = {"evcot": REPOSITORY / "sw", "evcot_cosim": REPOSITORY / "cosim"}

# Rooms and single modules, in the order in which data flows: each may import those before it, and nothing of what follows.
ROOMS = {
    "evcot": (
        "_lazy", "_stale_kernels", "_numba_private", "bits", "_zstd", "errors", "ranges", "toml_file", "outputs",
        "templating", "dataframes", "page", "structured", "_sound_kernel", "events", "digest", "ticks", "unfinished",
        "compiling", "recordings", "filters",
        "hough", "tracks", "hardware", "trackers", "scenes", "metrics", "recognition", "pictures", "api", "anomalies",
        "__main__",
    ),
    "evcot_cosim": (
        "tables", "memory", "standard_streams", "rtl", "devices", "lockstep", "vectors", "waves", "report",
        "notebook", "api", "live", "fpga", "sweep", "pages", "commands", "cli", "__main__",
    ),
}  # fmt: skip

# What few users need, and could be lifted out as it is: nothing before the command line imports it.
WINGS = (
    "evcot.anomalies", "evcot.pictures.films", "evcot_cosim.live", "evcot_cosim.pages", "evcot_cosim.fpga", "evcot_cosim.sweep",
)  # fmt: skip
DOORS = ("evcot.api", "evcot_cosim.commands", "evcot_cosim.cli", "evcot_cosim.__main__")


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


def room_of(module: str) -> tuple[str, str]:
    """Package and room of a module; a package's own names are in the room ""."""
    package, _, rest = module.partition(".")
    return package, rest.partition(".")[0]


@pytest.mark.parametrize("package", ROOMS)
def test_every_room_has_its_place_in_the_order(package: str) -> None:
    found = {room for name, room in map(room_of, SOURCES) if name == package and room}
    assert found == set(ROOMS[package])


@pytest.mark.parametrize("package", ROOMS)
def test_a_room_imports_only_rooms_before_it(package: str) -> None:
    for module in (module for module in SOURCES if room_of(module)[0] == package and room_of(module)[1]):
        allowed = ROOMS[package][: ROOMS[package].index(room_of(module)[1]) + 1]
        rooms = {name: room_of(name) for name in imports(module) if name in SOURCES}
        assert [n for n, (top, room) in rooms.items() if top == package and room and room not in allowed] == [], module


def test_software_imports_nothing_of_the_co_simulation() -> None:
    for module in (module for module in SOURCES if within(module, ("evcot",))):
        assert [name for name in imports(module) if within(name, ("evcot_cosim",))] == [], module


def test_nothing_but_wings_and_doors_imports_a_wing() -> None:
    for module in (module for module in SOURCES if not within(module, WINGS + DOORS)):
        assert [name for name in imports(module) if within(name, WINGS)] == [], module


def test_git_ignores_no_source() -> None:
    """A room may be called like a folder that is thrown away: it is there on the disk of its author, and in no clone."""
    command = ["git", "ls-files", "--others", "--ignored", "--exclude-standard", "sw", "cosim", "hw", "tests"]
    listed = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("no git checkout")
    assert [path for path in listed.stdout.splitlines() if "__pycache__" not in path] == []


def test_pytest_looks_into_every_folder_of_tests(pytestconfig: pytest.Config) -> None:
    folders = {part for path in REPOSITORY.glob("tests/**/test_*.py") for part in path.relative_to(REPOSITORY).parts[:-1]}
    passed_by = pytestconfig.getini("norecursedirs")
    assert [folder for folder in folders if any(fnmatch(folder, pattern) for pattern in passed_by)] == []

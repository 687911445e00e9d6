# SPDX-License-Identifier: Apache-2.0
"""Every kind of event file that evcot reads, in the order in which they are tried. A module is imported when it is tried."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from .source import Format

__all__ = ["format_of", "formats"]

_MODULES = (
    "aedat4",
    "aedat3",
    "aedat2",
    "es",
    "matlab",  # before HDF5, which its version 7.3 is
    "hdf5",
    "numpy_files",
    "prophesee",
    "ros",
    "nmnist",
    "text",  # last: almost anything printable looks like text
)

# First bytes, and the module that is tried first because of them; so others need not be imported.
_LIKELY = (
    (b"#!AER-DAT4", "aedat4"),
    (b"#!AER-DAT3", "aedat3"),
    (b"#!AER-DAT", "aedat2"),
    (b"MATLAB", "matlab"),
    (b"\x89HDF", "hdf5"),
    (b"\x93NUMPY", "numpy_files"),
    (b"PK", "numpy_files"),
    (b"% ", "prophesee"),
)


def formats() -> Iterator[Format]:
    """All formats."""
    for name in _MODULES:
        yield from _formats_in(name)


def format_of(start: bytes, path: Path) -> Format | None:
    """The format of a file with these first bytes, see `Format.matches`; None for an unknown one."""
    likely = next((name for magic, name in _LIKELY if start.startswith(magic)), _MODULES[0])
    if start[:1].isdigit() and path.suffix.lower() in (".csv", ".txt"):
        likely = "text"  # no other format begins with a digit, but N-MNIST, which is .bin
    for name in dict.fromkeys((likely, *_MODULES)):
        for kind in _formats_in(name):
            if kind.matches(start, path):
                return kind
    return None


def _formats_in(name: str) -> tuple[Format, ...]:
    found: tuple[Format, ...] = import_module(f".{name}", __package__).FORMATS
    return found

# SPDX-License-Identifier: Apache-2.0
"""Names of the sides of a report, from the engines and the files of logs."""

from __future__ import annotations

import re
from collections.abc import Sequence

from evcot.hardware.modules import MODULES

__all__ = ["side_name", "side_names"]


def side_names(taken: Sequence[str], logs: Sequence[tuple[str, str]]) -> list[str]:
    """Names of sides for logs, given as engine and name of the file: after their engine, else their file."""
    names: list[str] = []
    for engine, stem in logs:
        slug = _slug(side_name(engine, stem, engine))
        offered = [slug, _slug(stem), *(f"{slug}_{i}" for i in range(2, len(taken) + len(names) + 3))]
        names.append(next(name for name in offered if name not in taken and name not in names))
    return names


def side_name(engine: str, stem: str, otherwise: str) -> str:
    """The side that a log is of: `evcot cosim` writes those of the hardware and of its golden model under these names."""
    return stem if engine in MODULES and stem in ("hardware", "model") else otherwise


def _slug(text: str) -> str:
    """A side's name: `truth` is another's."""
    name = re.sub(r"[^a-z0-9_]", "_", text.lower())
    return name if name[:1].isalpha() and name != "truth" else f"log_{name}"

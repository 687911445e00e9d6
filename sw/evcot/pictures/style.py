# SPDX-License-Identifier: Apache-2.0
"""Style and output of figures: equal figures give identical files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigError
from ..outputs import written_aside

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["COLUMN_MM", "DASHES", "INK", "KINDS", "PALETTE", "RULES", "save"]

KINDS = ("tracks", "xy", "alive", "lifetimes")  # of panels
COLUMN_MM = {1: 85.0, 2: 178.0}  # widths of a paper's one and two columns
INK = "#222222"
# Okabe and Ito's palette without its yellow, which is faint on white.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: tuple[Any, ...] = ("-", (0, (4, 2)), (0, (1, 1.2)), (0, (4, 1.5, 1, 1.5)))

RULES: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 7,
    "axes.labelsize": 7,
    "axes.titlesize": 7,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "lines.linewidth": 1.0,
    "pdf.fonttype": 42,  # embedded TrueType fonts, as required by publishers
    "svg.fonttype": "path",
    "svg.hashsalt": "evcot",
}
# No dates or versions, so that files are reproducible.
_METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "ModDate": None, "Creator": None, "Producer": None},
    "svg": {"Date": None, "Creator": None},
}


def save(figure: Figure, path: Path, dpi: float, *, force: bool = False) -> None:
    """Write a figure in the format of the path's suffix.

    Raises:
        ConfigError: a suffix other than .png, .svg, .pdf.
        OutputError: the file exists, or cannot be written.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in _METADATA:
        raise ConfigError(f"{path}: must end in {', '.join(f'.{name}' for name in _METADATA)}")
    with written_aside(path, force=force) as file:
        figure.savefig(file, format=kind, dpi=dpi, metadata=_METADATA[kind])

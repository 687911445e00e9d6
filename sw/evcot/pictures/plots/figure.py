# SPDX-License-Identifier: Apache-2.0
"""A figure of stacked panels, with sizes in millimetres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from ...errors import ConfigError
from ..style import COLUMN_MM, DASHES, KINDS, PALETTE, RULES, save
from .material import Material
from .panels import alive_panel, lives_panel, place_panel, tracks_panel

__all__ = ["plot"]

_MM_PER_INCH = 25.4
_SIDE_MM = (20.0, 1000.0)
_DPI = (50.0, 1200.0)
_LEGEND_MM = 5.0
_ROW_MM = 2.6  # height of a row in the panel of lives


@dataclass(frozen=True)
class _Panel:
    """A panel's drawing function, and its height at a given width, in mm."""

    draw: Callable[[Axes, Material], None]
    height_mm: Callable[[Material, float], float]


def _scene_mm(material: Material, width_mm: float) -> float:
    height, width = material.counts.shape
    return float((width_mm - 12) * height / width + 9)


def _lives_mm(material: Material, _width_mm: float) -> float:
    return min(12 + _ROW_MM * sum(len(material.lives(log)) for log in material.logs), 110)


_TRACKS = (_Panel(tracks_panel, _scene_mm),)
_PLACES = (
    _Panel(lambda ax, material: place_panel(ax, material, "x"), lambda *_: 32),
    _Panel(lambda ax, material: place_panel(ax, material, "y"), lambda *_: 32),
)
_ALIVE = (_Panel(alive_panel, lambda *_: 28),)
_LIVES = (_Panel(lives_panel, _lives_mm),)
_KINDS = dict(zip(KINDS, (_TRACKS, _PLACES, _ALIVE, _LIVES), strict=True))


def plot(
    material: Material, path: Path | str, kinds: Sequence[str] = ("tracks",), *, width_mm: float = COLUMN_MM[1],
    height_mm: float | None = None, dpi: float = 300, force: bool = False,
) -> None:  # fmt: skip
    """Draw a figure and write it; the path's suffix is .png, .svg or .pdf. Equal material gives identical files.

    Args:
        kinds: panels, from top to bottom, of `KINDS`.
        width_mm, height_mm: size; by default the height required by the panels.
        dpi: resolution of a PNG, and of the image of events in the other formats.
        force: replace an existing file.

    Raises:
        ConfigError: an unknown kind or suffix, or an invalid size.
        OutputError: the file exists, or cannot be written.
    """
    unknown = next((kind for kind in kinds if kind not in _KINDS), None)
    if unknown is not None or not kinds:
        raise ConfigError(f"--kind {unknown or ''}: must be one or more of {', '.join(KINDS)}")
    panels = [panel for kind in kinds for panel in _KINDS[kind]]
    heights = [panel.height_mm(material, width_mm) for panel in panels]
    legend_mm = _LEGEND_MM if len(material.logs) > 1 else 0.0
    whole_mm = sum(heights) + legend_mm if height_mm is None else height_mm
    for name, value, (low, high) in (("--width", width_mm, _SIDE_MM), ("--height", whole_mm, _SIDE_MM), ("--dpi", dpi, _DPI)):
        if not low <= value <= high:
            raise ConfigError(f"{name} {value:g}: must be from {low:g} to {high:g}")
    with matplotlib.rc_context(RULES):
        size = width_mm / _MM_PER_INCH, whole_mm / _MM_PER_INCH
        figure = Figure(figsize=size, dpi=dpi, facecolor="white", layout=ConstrainedLayoutEngine(w_pad=0.02, h_pad=0.02))
        FigureCanvasAgg(figure)
        axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
        for ax, panel in zip(axes, panels, strict=True):
            panel.draw(ax, material)
        if legend_mm:
            figure.legend(handles=_legend(material), loc="outside upper center", ncols=len(material.logs), handlelength=2.5)
        save(figure, Path(path), dpi, force=force)


def _legend(material: Material) -> list[Line2D]:
    return [
        Line2D([], [], color=PALETTE[i % len(PALETTE)], linestyle=DASHES[i % len(DASHES)], label=log.name)
        for i, log in enumerate(material.logs)
    ]

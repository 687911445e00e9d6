# SPDX-License-Identifier: Apache-2.0
"""Scores of many settings on many members: summaries by family, the table, the picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from field.scoring import Score

__all__ = ["FIGURES", "Scored", "by_family", "draw", "print_families", "print_table", "summary"]

# field of `Score` -> (heading, format); means over the members of a family
FIGURES: Mapping[str, tuple[str, str]] = {
    "hota": ("HOTA", ".3f"),
    "hota_iou": ("HOTA, IoU", ".3f"),
    "idf1": ("IDF1", ".3f"),
    "answered": ("HOTA when answered", ".3f"),
    "switches": ("switches", ".1f"),
    "tracks_per_object": ("tracks an object", ".2f"),
    "covered": ("covered", ".3f"),
    "one_track": ("by one track", ".3f"),
    "false_per_instant": ("false tracks", ".2f"),
}


@dataclass(frozen=True)
class Scored:
    """A score, and what it is of."""

    contender: str
    settings: str
    family: str
    member: str
    score: Score

    def to_dict(self) -> dict[str, Any]:
        """Plain values, without those that have no meaning."""
        named = {"contender": self.contender, "settings": self.settings, "family": self.family, "member": self.member}
        return named | {name: value for name, value in self.score.to_dict().items() if value is not None}


def by_family(scored: Iterable[Scored], figure: str) -> dict[str, float]:
    """Family -> mean of a figure over its members, in the order of the field; families without the figure are left out."""
    values: dict[str, list[float]] = {}
    for one in scored:
        value = getattr(one.score, figure)
        if value is not None:
            values.setdefault(one.family, []).append(float(value))
    return {family: float(np.mean(own)) for family, own in values.items()}


def summary(scored: Sequence[Scored]) -> dict[str, float | str]:
    """Mean over the families and worst family, of every figure; tracks where nothing is there; events a second."""
    found: dict[str, float | str] = {}
    for figure in FIGURES:
        families = by_family(scored, figure)
        if families:
            found[figure] = float(np.mean(list(families.values())))
    for figure in ("hota", "hota_iou", "answered"):
        families = by_family(scored, figure)
        if families:
            worst = min(families, key=lambda family: families[family])
            found[f"worst_{figure}"], found[f"worst_{figure}_family"] = families[worst], worst
    nothing = [one.score.tracks for one in scored if one.score.hota is None]
    if nothing:
        found["tracks_on_nothing"] = float(np.sum(nothing))
    rates = [one.score.events_per_s for one in scored if one.score.events_per_s and one.score.hota is not None]
    if rates:
        found["events_per_s"] = float(np.median(rates))
    return found


def print_table(rows: Mapping[str, Sequence[Scored]]) -> None:
    """One line a contender with its settings: mean over the families, and the worst family."""
    headings = ["", *(heading for heading, _ in FIGURES.values()), "worst HOTA", "in", "tracks on nothing", "M events/s"]
    _line(headings)
    _line(["---"] * len(headings))
    for title, scored in rows.items():
        found = summary(scored)
        cells = [title, *(_cell(found.get(figure), form) for figure, (_, form) in FIGURES.items())]
        cells += [_cell(found.get("worst_hota"), ".3f"), str(found.get("worst_hota_family", ""))]
        rate = found.get("events_per_s")
        cells += [_cell(found.get("tracks_on_nothing"), ".0f"), _cell(rate / 1e6 if isinstance(rate, float) else None, ".1f")]
        _line(cells)


def print_families(rows: Mapping[str, Mapping[str, float]]) -> None:
    """One line a family, one column a contender."""
    families = list(dict.fromkeys(family for row in rows.values() for family in row))
    _line(["", *rows])
    _line(["---"] * (1 + len(rows)))
    for family in families:
        _line([family, *(_cell(row.get(family), ".3f") for row in rows.values())])
    _line(["mean", *(_cell(float(np.mean(list(row.values()))) if row else None, ".3f") for row in rows.values())])
    _line(["worst", *(_cell(min(row.values(), default=None), ".3f") for row in rows.values())])


def draw(rows: Mapping[str, Mapping[str, float]], title: str, path: Path) -> None:
    """A picture of HOTA by family and contender."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    families = list(dict.fromkeys(family for row in rows.values() for family in row))
    values = np.array([[row.get(family, np.nan) for row in rows.values()] for family in families])
    table = np.vstack((values, np.nanmean(values, axis=0), np.nanmin(values, axis=0)))
    figure, axis = plt.subplots(figsize=(2.8 + 0.95 * len(rows), 1.4 + 0.34 * len(table)), layout="constrained")
    axis.imshow(table, cmap="cividis", vmin=0.0, vmax=1.0, aspect="auto")
    for (row, column), value in np.ndenumerate(table):
        if np.isfinite(value):
            axis.text(
                column, row, f"{value:.2f}", ha="center", va="center", fontsize=8, color="white" if value < 0.5 else "black"
            )
    axis.axhline(len(families) - 0.5, color="black", lw=1.5)
    axis.set_xticks(range(len(rows)), list(rows), rotation=30, ha="left", fontsize=8)
    axis.set_yticks(range(len(table)), [*families, "mean", "worst"], fontsize=8)
    axis.xaxis.tick_top()
    axis.tick_params(length=0)
    axis.set_title(title, fontsize=10)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _cell(value: object, form: str) -> str:
    return format(value, form) if isinstance(value, int | float) else ""


def _line(cells: Sequence[str]) -> None:
    print("| " + " | ".join(cells) + " |", flush=True)

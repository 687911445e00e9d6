# SPDX-License-Identifier: Apache-2.0
"""Scores of many settings on many draws of many members: summaries by family, the tables, the picture.

Leave one family out: settings are chosen on all families of other sources, and scored on the one that was left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from field.draws import Difference, Estimate, differences, estimate, marking, mean_difference, mean_of
from field.scoring import Score
from measure import heading, line

__all__ = [
    "FIGURES",
    "Choice",
    "Scored",
    "by_family",
    "by_member",
    "left_out",
    "picture",
    "print_differences",
    "print_families",
    "print_members",
    "print_table",
]

# field of `Score` -> heading; means over the families, with their errors
FIGURES: Mapping[str, str] = {
    "hota": "HOTA",
    "mota": "MOTA",
    "idf1": "IDF1",
    "hota_iou": "HOTA, IoU",
    "mota_iou": "MOTA, IoU",
    "idf1_iou": "IDF1, IoU",
    "answered": "HOTA when answered",
    "switches": "switches",
    "tracks_per_object": "tracks an object",
    "covered": "covered",
    "one_track": "by one track",
    "false_per_instant": "false tracks",
    "stated_angle_deg": "stated velocity, degrees",
}
_COMPARED = "hota", "hota_iou", "mota_iou", "idf1_iou"  # of two versions


@dataclass(frozen=True)
class Scored:
    """A score, and what it is of; draw None: all events."""

    contender: str
    settings: str
    seed_set: int
    family: str
    member: str
    draw: int | None
    score: Score

    @property
    def title(self) -> str:
        """Of its row."""
        return f"{self.contender}, {self.settings}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values, without those that have no meaning."""
        own = {field.name: getattr(self, field.name) for field in fields(self)[:-1]}
        return own | {name: value for name, value in self.score.to_dict().items() if value is not None}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Scored:
        """What `to_dict` made."""
        score = Score(**{field.name: values[field.name] for field in fields(Score) if field.name in values})
        return cls(*(values[field.name] for field in fields(cls)[:-1]), score)


def by_member(scored: Iterable[Scored], figure: str) -> dict[str, dict[str, dict[int | None, float]]]:
    """Family -> member -> draw -> a figure, in the order of the field; what lacks the figure is left out."""
    values: dict[str, dict[str, dict[int | None, float]]] = {}
    for one in scored:
        value = getattr(one.score, figure)
        if value is not None:
            members = values.setdefault(one.family, {})
            members.setdefault(f"{one.seed_set}: {one.member}", {})[one.draw] = float(value)
    return values


def by_family(scored: Iterable[Scored], figure: str) -> dict[str, Estimate]:
    """Family -> mean of a figure over its members and their draws."""
    return {family: estimate(members) for family, members in by_member(scored, figure).items()}


def print_table(rows: Mapping[str, Sequence[Scored]]) -> None:
    """One line a contender with its settings: mean over the families, and the worst family."""
    figures = [figure for figure in FIGURES if any(by_family(scored, figure) for scored in rows.values())]
    headings = ["", *(FIGURES[figure] for figure in figures), "worst HOTA", "in", "tracks on empty recordings", "M events/s"]
    heading(*headings)
    for title, scored in rows.items():
        cells = [title]
        for figure in figures:
            families = by_family(scored, figure)
            cells.append(str(mean_of(families.values())) if families else "")
        families = by_family(scored, "hota")
        worst = min(families, key=lambda family: families[family].mean, default="")
        cells += [str(families[worst]) if worst else "", worst]
        with_objects = [one for one in scored if one.score.hota is not None]
        draws = {(one.seed_set, one.draw) for one in scored}
        empty = sum(one.score.tracks for one in scored if one.score.hota is None)
        cells.append(f"{empty / max(len(draws), 1):.1f}" if len(with_objects) < len(scored) else "")
        rates = [one.score.events_per_s for one in with_objects if one.score.events_per_s]
        cells.append(f"{np.median(rates) / 1e6:.1f}" if rates else "")
        line(cells)


def print_families(rows: Mapping[str, Mapping[str, Estimate]], seed_sets: Iterable[int]) -> None:
    """One line a family, one column a contender."""
    families = list(dict.fromkeys(family for row in rows.values() for family in row))
    sets = list(seed_sets)
    heading("", "", *rows)
    for family in families:
        line([family, marking(family, sets), *(str(row.get(family, "")) for row in rows.values())])
    line(["mean", "", *(str(mean_of(row.values())) if row else "" for row in rows.values())])
    line(["worst", "", *(str(min(row.values())) if row else "" for row in rows.values())])


def print_members(rows: Mapping[str, Sequence[Scored]]) -> None:
    """One line a member and contender: how far its draws lie apart."""
    heading("", "member", "", "HOTA", "standard deviation", "minimum", "maximum")
    for title, scored in rows.items():
        for family, members in by_member(scored, "hota").items():
            for name, by_draw in members.items():
                hota = list(by_draw.values())
                deviation = f"{np.std(hota, ddof=1):.3f}" if len(hota) > 1 else ""
                line([family, name, title, f"{np.mean(hota):.3f}", deviation, f"{min(hota):.3f}", f"{max(hota):.3f}"])


def print_differences(rows: Mapping[str, tuple[Sequence[Scored], Sequence[Scored]]]) -> None:
    """Of each pair (now, before), one column: how much HOTA has grown by family, and the mean of some figures.

    An error is that of the draws, a second one that of the members; of a mean over families, that of the families.
    """
    found: dict[str, dict[str, dict[str, Difference]]] = {
        figure: {title: differences(*(by_member(own, figure) for own in pair)) for title, pair in rows.items()}
        for figure in _COMPARED
    }
    heading("difference", *rows)
    families = list(dict.fromkeys(family for row in found["hota"].values() for family in row))
    for family in families:
        line([family, *(str(row.get(family, "")) for row in found["hota"].values())])
    for figure, row in found.items():
        line([f"mean, {FIGURES[figure]}", *(str(mean_difference(own.values())) if own else "" for own in row.values())])


def picture(rows: Mapping[str, Mapping[str, Estimate]], title: str, path: Path) -> None:
    """A picture of HOTA by family and contender."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    families = list(dict.fromkeys(family for row in rows.values() for family in row))
    values = np.array([[row[family].mean if family in row else np.nan for row in rows.values()] for family in families])
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


@dataclass(frozen=True)
class Choice:
    """What happened to a family that was left out.

    Attributes:
        settings: the best on the other families: the highest mean of their merits.
        merit: of these settings on this family.
        preset, preset_merit: the best of the contender's presets on this family itself, in hindsight.
        best, best_merit: the best of all settings on this family itself, in hindsight.
    """

    family: str
    settings: str
    merit: float
    preset: str
    preset_merit: float
    best: str
    best_merit: float


def merits(scored: Sequence[Scored]) -> dict[str, dict[str, float]]:
    """Settings -> family -> mean merit of the family's members."""
    values: dict[str, dict[str, list[float]]] = {}
    for one in scored:
        values.setdefault(one.settings, {}).setdefault(one.family, []).append(one.score.merit)
    return {name: {family: float(np.mean(own)) for family, own in row.items()} for name, row in values.items()}


def left_out(scored: Sequence[Scored], sources: Mapping[str, str], presets: Sequence[str]) -> list[Choice]:
    """Every family left out once, together with all families of its source.

    Args:
        scored: of one contender, all its settings on all members.
        sources: family -> source.
        presets: those of the settings that are presets.
    """
    table = merits(scored)
    families = list(next(iter(table.values())))
    choices = []
    for family in families:
        others = [other for other in families if sources[other] != sources[family]]
        chosen = max(table, key=lambda name: float(np.mean([table[name][other] for other in others])))
        preset = max(presets, key=lambda name: table[name][family])
        best = max(table, key=lambda name: table[name][family])
        choices.append(Choice(family, chosen, table[chosen][family], preset, table[preset][family], best, table[best][family]))
    return choices

# SPDX-License-Identifier: Apache-2.0
"""Leave one family out: settings are chosen on all families of other sources, and scored on the one that was left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from field.table import Scored

__all__ = ["Choice", "left_out", "merits"]


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

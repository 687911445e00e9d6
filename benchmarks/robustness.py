# SPDX-License-Identifier: Apache-2.0
"""Sensitivity of a preset to its parameters: each one of `rct`'s `traffic` varied separately, on real traffic.

`python benchmarks/robustness.py` prints the range that docs/evaluation.md quotes. What is changed is what the preset sets.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

from evcot.errors import ConfigError
from evcot.filters.run import apply
from evcot.metrics import Scores, evaluate
from evcot.trackers.rct.config import FILTERS, PRESETS, RctConfig
from evcot.trackers.rct.tracker import track
from quality import TRAFFIC, traffic_cases, traffic_is_here

__all__ = ["changed", "main"]

_PARTS = (0.85, 1.15)


def changed(config: RctConfig) -> Iterator[tuple[str, Any, RctConfig]]:
    """The settings with each number that differs from the default made smaller and larger, where that is allowed."""
    for field in fields(config):
        value = getattr(config, field.name)
        if value == field.default or isinstance(value, bool | str):
            continue
        for part in _PARTS:
            other: Any = round(value * part) if isinstance(value, int) else value * part
            try:
                yield field.name, other, replace(config, **{field.name: other})
            except ConfigError:
                continue


def main() -> None:
    """Measure and print."""
    if not traffic_is_here():
        print(f"{TRAFFIC}.aedat4 is not here")
        return
    (whole,) = (case for case in traffic_cases() if case.name == TRAFFIC)
    kept, _ = apply(whole.recording, FILTERS["traffic"])

    def scores(config: RctConfig) -> Scores:
        return evaluate(track(kept, config), whole.truth, whole.rule)

    rows = [("as it is", "", scores(PRESETS["traffic"]))]
    rows += [(name, f"{value:g}", scores(config)) for name, value, config in changed(PRESETS["traffic"])]
    for name, value, one in rows:
        print(f"{name:18} {value:>8}  HOTA {one.hota:.3f}  IDF1 {one.idf1:.3f}  {one.idsw} switches", flush=True)
    hota, idf1 = ([getattr(one, name) for *_, one in rows] for name in ("hota", "idf1"))
    most = max(one.idsw for *_, one in rows)
    print(f"HOTA {min(hota):.3f} to {max(hota):.3f}, IDF1 {min(idf1):.3f} to {max(idf1):.3f}, at most {most} switches")


if __name__ == "__main__":
    main()

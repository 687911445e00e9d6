# SPDX-License-Identifier: Apache-2.0
"""How much a score of `adaptive` owes to chance: members of the field, again and again without another tenth of the events.

python benchmarks/steadiness.py                        # recorded families: mean, spread, and the range of HOTA
python benchmarks/steadiness.py --keep before.json     # keep the scores, then change the tracker, and:
python benchmarks/steadiness.py --against before.json  # differences of equal recordings, by family, with their standard errors

What is lost is the same in every run, so that differences are of the tracker alone. A change that helps one recording by 0.05
and hurts the next as much is no progress. Compare a family's mean with its standard error, and score other losses
(`--losses-from`) than those on which the change was chosen. Members of test sets are left out.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from evcot.outputs import written_aside
from field import Absent, entries
from field.contenders import ADAPTIVE, contenders
from field.scoring import score
from field.transforms import thinned

__all__ = ["differences", "main", "spread"]

_LOST = 0.1
_RECORDED = "traffic", "pendulum, recorded", "hand"
_FOR_THE_END = "transposed", "x 0.5", "60 % lost", "1 Hz a pixel"  # of traffic: test, never scored here

Scores = Mapping[str, Mapping[str, Sequence[float]]]  # family -> member -> HOTA by loss


def spread(hota: Sequence[float]) -> str:
    """Mean, standard deviation and range in words."""
    deviation = np.std(hota, ddof=1) if len(hota) > 1 else 0.0
    return f"HOTA {np.mean(hota):.3f}, standard deviation {deviation:.3f}, {min(hota):.3f} to {max(hota):.3f}"


def differences(now: Scores, before: Scores) -> dict[str, tuple[float, float]]:
    """Of each family in both: the mean difference of equal recordings, and its standard error.

    Versions of one member are alike, so the error is that of the members' means.
    """
    found = {}
    for family, members in now.items():
        own = before.get(family, {})
        means = []
        for name, hota in members.items():
            both = min(len(hota), len(own.get(name, ())))
            if both:
                means.append(float(np.mean(np.subtract(hota[:both], own[name][:both]))))
        if means:
            error = float(np.std(means, ddof=1) / np.sqrt(len(means))) if len(means) > 1 else float("nan")
            found[family] = float(np.mean(means)), error
    return found


def _measured(families: tuple[str, ...], seed_set: int, losses: Sequence[int]) -> dict[str, dict[str, list[float]]]:
    (adaptive,) = contenders([ADAPTIVE])
    (settings,) = adaptive.settings.values()
    every: dict[str, dict[str, list[float]]] = {}
    for entry in entries(seed_set, quick=False):
        kept_aside = entry.family.startswith("traffic") and entry.name in _FOR_THE_END
        if kept_aside or not entry.family.startswith(families):
            continue
        try:
            member = entry.build()
        except Absent as reason:
            print(f"{entry.family}, {entry.name}: left out: {reason}", file=sys.stderr)
            continue
        versions = [thinned(member, _LOST, (seed_set, 11, loss)) for loss in losses]
        hota = [score(adaptive, settings, version, whole=True).merit for version in versions]
        every.setdefault(entry.family, {})[entry.name] = hota
        print(f"{entry.family}, {entry.name}: {spread(hota)}", flush=True)
    return every


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--families", nargs="+", metavar="WORD", default=_RECORDED, help="families whose name begins so")
    parser.add_argument("--seed-set", type=int, default=1, help="of everything drawn in the field (default 1)")
    parser.add_argument("--losses", type=int, default=6, metavar="N", help="versions of each member (default 6)")
    parser.add_argument("--losses-from", type=int, default=0, metavar="N", help="number of the first (default 0)")
    parser.add_argument("--keep", type=Path, metavar="JSON", help="keep the scores here")
    parser.add_argument("--against", type=Path, metavar="JSON", help="scores kept before")
    options = parser.parse_args()
    before = json.loads(options.against.read_text(encoding="utf-8")) if options.against else {}
    losses = range(options.losses_from, options.losses_from + options.losses)
    now = _measured(tuple(options.families), options.seed_set, losses)
    print()
    for family, members in now.items():
        print(f"{family}: {spread([one for hota in members.values() for one in hota])}")
    for family, (mean, error) in differences(now, before).items():
        print(f"{family}: {mean:+.3f} ± {error:.3f}")
    if options.keep:
        with written_aside(options.keep, force=False) as file:
            file.write((json.dumps(now, indent=1) + "\n").encode())


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Slow against fast: the box experiment with the paper's Table 2, in hardware and golden model, bit for bit.

N_ev of 8, 5 and 3 and a timer TC of 20 and 7 ms, on slow boxes (80 px/s) and on fast ones (400 px/s), with N_ev fixed and
with its dynamic adjustment. `python benchmarks/table2.py` prints docs/table2.md's table; --figure draws docs/images/table2.png.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import fields
from itertools import product
from pathlib import Path
from statistics import fmean

from measure import Result
from table2_runs import SPEEDS, Adjustment, Outcome, Setting, Speed, outcome, scene

__all__ = ["measure"]

N_EV = (8, 5, 3)
TC_MS = (20, 7)
_PAPERS: tuple[tuple[Speed, int, int], ...] = (("slow", 8, 20), ("fast", 5, 7), ("fast", 3, 7))
_FIGURE = Path(__file__).parents[1] / "docs" / "images" / "table2.png"

# field of `Outcome` -> (heading, format)
_COLUMNS = {
    "updates": ("CM updates", ",.0f"),
    "found": ("found", ".1%"),
    "error_px": ("error, px", ".2f"),
    "error_p90_px": ("90 %", ".2f"),
    "lag_px": ("lag, px", ".2f"),
    "lag_ms": ("ms", ".2f"),
    "lost": ("lost", ".1f"),
    "switches": ("switches", ".1f"),
    "fragments": ("fragments", ".1f"),
    "born": ("tracks born", ",.0f"),
    "n_ev": ("N_ev", ".1f"),
    "at_low": ("lowest", ".0%"),
    "at_high": ("highest", ".0%"),
}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """Error and lag of the paper's settings; the reference is the same with N_ev fixed."""
    for speed, n_ev, tc_ms in _PAPERS:
        of = scene(speed, 1, 500_000 if quick else 2_500_000)
        fixed, adjusted = (outcome(of, Setting(n_ev, tc_ms, which)) for which in (Adjustment.FIXED, Adjustment.COARSE))
        how = f"{speed} boxes, N_ev {n_ev}, TC {tc_ms} ms; hardware and model the same bits"
        for name, unit in (("error_px", "px"), ("lag_ms", "ms")):
            value, reference = getattr(adjusted, name), getattr(fixed, name)
            yield Result(f"table2_{speed}_{n_ev}_{name}", value, unit, reference, "N_ev fixed", how=how)


def main() -> None:
    """Measure and print; draw where asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="recordings of each speed (default: 3)")
    parser.add_argument("--hist-avg", type=int, default=1, metavar="K", help="alpha = 2^-K (default: 1, the paper's)")
    parser.add_argument("--model", action="store_true", help="the golden model alone: four times as fast")
    parser.add_argument("--figure", action="store_true", help=f"draw {_FIGURE.name} too")
    options = parser.parse_args()
    for speed in SPEEDS:
        scenes = [scene(speed, seed) for seed in range(1, 1 + options.seeds)]
        print(f"{speed} boxes, seeds 1 to {options.seeds}\n")
        _print_line(["N_ev", "TC, ms", "adjusted", *(heading for heading, _ in _COLUMNS.values())])
        _print_line(["---"] * (3 + len(_COLUMNS)))
        for adjustment, n_ev, tc_ms in product(Adjustment, N_EV, TC_MS):
            setting = Setting(n_ev, tc_ms, adjustment, options.hist_avg)
            mean = _mean([outcome(of, setting, rtl=not options.model) for of in scenes])
            cells = [format(getattr(mean, name), form) for name, (_, form) in _COLUMNS.items()]
            _print_line([str(n_ev), str(tc_ms), adjustment, *cells])
        print()
    if options.figure:
        import table2_figure

        print(table2_figure.draw(_FIGURE))


def _mean(outcomes: Sequence[Outcome]) -> Outcome:
    return Outcome(**{field.name: fmean(getattr(one, field.name) for one in outcomes) for field in fields(Outcome)})


def _print_line(cells: Sequence[str]) -> None:
    print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()

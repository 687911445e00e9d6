# SPDX-License-Identifier: Apache-2.0
"""Tracking error on squares whose events come in bursts of one time: the table of docs/recordings.md.

PYTHONPATH=tests python benchmarks/bursts.py              # the default
PYTHONPATH=tests python benchmarks/bursts.py adaptive     # another engine
PYTHONPATH=tests python benchmarks/bursts.py --rows       # events of a burst come row by row
"""

from __future__ import annotations

import argparse
from fractions import Fraction
from itertools import product

import numpy as np

from support.logs import centre_errors_px

_STEPS_MS = 5, 10, 20, 33, 50, 100
_PER_BURST = Fraction(1, 8), Fraction(1, 6), Fraction(1, 4), Fraction(1, 3), Fraction(1, 2)  # displacement, in sides
_SIDES_PX, _SLOPES = (12, 18, 24, 32, 40), (0, 0.37, 1)


def main() -> None:
    """Print the median and the worst of 15 median errors, px, and how many squares keep a track within half a side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", nargs="?", default="cot_motion")
    parser.add_argument("--rows", action="store_true")
    options = parser.parse_args()
    print("| v T / s |", " | ".join(f"{step_ms} ms" for step_ms in _STEPS_MS), "|")
    for per_burst in _PER_BURST:
        cells = []
        for step_ms in _STEPS_MS:
            errors_px, within = [], 0
            for side, slope in product(_SIDES_PX, _SLOPES):
                found = centre_errors_px(options.engine, step_ms, side, float(per_burst), slope, options.rows)
                errors_px.append(np.median(found))
                within += bool(max(found) < side / 2)
            cells.append(f"{np.median(errors_px):.1f}, {max(errors_px):.1f}, {within}")
        print(f"| {per_burst} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()

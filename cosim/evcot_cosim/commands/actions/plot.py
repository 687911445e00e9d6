# SPDX-License-Identifier: Apache-2.0
"""`evcot plot`: a figure of tracks for a paper."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

from evcot.pictures.plots import Material, density, plot
from evcot.pictures.style import COLUMN_MM

from .tracked import tracked_from

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Draw a figure; 0."""
    with tracked_from(options) as tracked:
        counts, _, last_us = density(tracked.blocks(), tracked.sensor)
        material = Material(counts, tracked.logs, tracked.from_us, last_us, tracked.first_us)
        width_mm = COLUMN_MM[options.columns] if options.width is None else options.width
        kinds = tuple(kind.strip() for kind in options.kind.split(","))
        plot(material, options.output, kinds, width_mm=width_mm, height_mm=options.height, dpi=options.dpi, force=options.force)
    if options.json:
        print(json.dumps({"file": str(options.output), "panels": kinds, "logs": [log.name for log in tracked.logs]}))
    elif not options.quiet:
        print(f"{options.output}: {', '.join(kinds)} of {', '.join(log.name for log in tracked.logs)}")
    return 0

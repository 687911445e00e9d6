# SPDX-License-Identifier: Apache-2.0
"""`evcot presets`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

from evcot.presets import PRESETS

from .tables import print_table

__all__ = ["add"]


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    presets = commands.add_parser("presets", help="list the presets")
    presets.add_argument("--json", action="store_true", help="print every field")
    presets.set_defaults(command=_presets)


def _presets(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    if options.json:
        print(json.dumps({name: config.to_dict() for name, config in PRESETS.items()}, indent=2))
        return 0
    rows = [("name", "N_ev", "window px", "lifetime", "tick")]
    for name, config in PRESETS.items():
        slot = config.cot.slots[0]
        lifetime_ms = slot.max_ticks * config.cot.tick_us / 1000
        rows.append(
            (
                name,
                f"{slot.clust_nev} ({slot.nev_min} to {slot.nev_max})",
                f"{slot.init_radix} + {slot.radix_th}",
                f"{lifetime_ms:g} ms",
                f"{config.cot.tick_us} us",
            )
        )
    print_table(rows)
    return 0

# SPDX-License-Identifier: Apache-2.0
"""The `evcot` command. It imports little itself, so that even an interrupt while the rest loads ends in one line."""

from __future__ import annotations

import gc
import sys

__all__ = ["run"]


def run() -> int:
    """Load the command line and run it; returns the exit code."""
    # Loading makes a million objects that stay. To search them for garbage while they are made, and once more when the
    # process ends, would take a fifth of the time of a short command.
    gc.set_threshold(100_000)
    try:
        from .cli import main

        return main(loaded=gc.freeze)
    except KeyboardInterrupt:
        print("evcot: interrupted: nothing was written", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(run())

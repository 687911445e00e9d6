# SPDX-License-Identifier: Apache-2.0
"""The `evcot` command. It imports little itself, so that even an interrupt while the rest loads ends in one line."""

from __future__ import annotations

import sys

__all__ = ["run"]


def run() -> int:
    """Load the command line and run it; returns the exit code."""
    try:
        from .cli import main

        return main()
    except KeyboardInterrupt:
        print("evcot: interrupted: nothing was written", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(run())

# SPDX-License-Identifier: Apache-2.0
"""`python -m evcot` is the `evcot` command, which is a part of the package evcot_cosim."""

from __future__ import annotations

import importlib
import sys

if __name__ == "__main__":
    try:
        command = importlib.import_module("evcot_cosim.__main__")
    except ModuleNotFoundError:
        sys.exit("evcot: the command needs the package evcot_cosim, which is installed with evcot: pip install evcot")
    sys.exit(command.run())

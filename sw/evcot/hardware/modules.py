# SPDX-License-Identifier: Apache-2.0
"""Names of the hardware trackers, in a module that is cheap to import."""

from __future__ import annotations

from typing import Literal, get_args

__all__ = ["DEFAULT_MODULE", "MODULES", "Module"]

Module = Literal["cot", "cot_chain", "cot_array", "cot_motion"]
"""A hardware tracker, by the name of its Verilog module; its golden model and the logs of both have that name, too."""

MODULES: tuple[Module, ...] = get_args(Module)

DEFAULT_MODULE: Module = "cot_motion"

# SPDX-License-Identifier: Apache-2.0
"""Commands that take several files: each is done on its own."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import TypeVar

from evcot.errors import EvcotError

from ..parsing import USER_ERROR, say_error

__all__ = ["done_each"]

_File = TypeVar("_File")
_Result = TypeVar("_Result")


def done_each(options: argparse.Namespace, files: Sequence[_File], do: Callable[[_File], _Result]) -> tuple[list[_Result], int]:
    """The results of those files with which it could be done, and the exit code: 2 if there was an error, else 0.

    The error of one of several files is printed, and the others are done.

    Raises:
        EvcotError: that of a single file.
    """
    if len(files) == 1:
        return [do(files[0])], 0
    results, code = [], 0
    for file in files:
        try:
            results.append(do(file))
        except EvcotError as error:
            sys.stdout.flush()
            say_error(error, options)
            code = USER_ERROR
    return results, code

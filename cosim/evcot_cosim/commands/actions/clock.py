# SPDX-License-Identifier: Apache-2.0
"""The time of frames, from the options."""

from __future__ import annotations

import argparse

from evcot.errors import ConfigError
from evcot.tracks.formats.base import FrameClock

__all__ = ["clock_from"]


def clock_from(options: argparse.Namespace, origin_us: int = 0) -> FrameClock:
    """The clock of --frame-us and --origin-us; ConfigError where one is outside its range.

    Args:
        origin_us: without --origin-us.
    """
    try:
        return FrameClock(options.frame_us, origin_us if options.origin_us is None else options.origin_us)
    except ConfigError as error:
        raise ConfigError(f"--{str(error).replace('_us', '-us', 1)}") from error

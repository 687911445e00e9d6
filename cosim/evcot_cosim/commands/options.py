# SPDX-License-Identifier: Apache-2.0
"""The options that every command which reads a recording has: a window of time, the sensor, and what to do about damage."""

from __future__ import annotations

import argparse
import math
import re

from evcot.errors import ConfigError
from evcot.unfinished import CHECKPOINT_EVENTS

from .parsing import group_of

__all__ = [
    "checkpoint_option",
    "damage_options",
    "recording_options",
    "sensor_from",
    "window_from",
    "window_options",
]


RECORDING = "recording"  # title of the group


def checkpoint_option(parser: argparse.ArgumentParser) -> None:
    """Add --checkpoint."""
    parser.add_argument(
        "--checkpoint", type=int, default=CHECKPOINT_EVENTS, metavar="EVENTS",
        help="save the state every so many events, so that the same command continues after a kill "
        "(default: %(default)s; 0: never)",
    )  # fmt: skip


def recording_options(parser: argparse.ArgumentParser) -> None:
    """Add --from, --to, --sensor, --struct and --skip-damaged."""
    window_options(parser)
    damage_options(parser)


def window_options(parser: argparse.ArgumentParser) -> None:
    """Add --from and --to."""
    group = group_of(parser, RECORDING)
    group.add_argument(
        "--from", dest="from_ms", type=float, default=0.0, metavar="MS", help="begin this long after the first event"
    )
    group.add_argument("--to", dest="to_ms", type=float, metavar="MS", help="end this long after it (default: the end)")


def damage_options(parser: argparse.ArgumentParser) -> None:
    """Add --sensor, --struct and --skip-damaged."""
    group = group_of(parser, RECORDING)
    group.add_argument(
        "--sensor", metavar="WxH", help="size in pixels (default: as the file states, else the smallest that fits)"
    )
    group.add_argument(
        "--struct", metavar="NAME", help="which struct of a .mat with several of events (default: TD, else the first)"
    )
    group.add_argument("--skip-damaged", action="store_true", help="skip damaged parts, and say how much was skipped")


def window_from(options: argparse.Namespace) -> tuple[int, int | None]:
    """(from, to) in microseconds after the first event, to None for the recording's end.

    Raises:
        ConfigError: no time, or an end that does not follow the beginning.
    """
    for option, ms in (("--from", options.from_ms), ("--to", options.to_ms)):
        if ms is not None and not (math.isfinite(ms) and 0 <= ms <= 1e15):
            raise ConfigError(f"{option} {ms:g}: must be from 0 to 1e15 ms")
    if options.to_ms is not None and options.to_ms <= options.from_ms:
        raise ConfigError(f"--to {options.to_ms:g}: must be after --from {options.from_ms:g}")
    return round(options.from_ms * 1000), None if options.to_ms is None else round(options.to_ms * 1000)


def sensor_from(options: argparse.Namespace) -> tuple[int, int] | None:
    """(width, height) of --sensor, None where it is not given; ConfigError where it is no size."""
    if options.sensor is None:
        return None
    size = re.fullmatch(r"([0-9]{1,6})[xX]([0-9]{1,6})", options.sensor)
    if size is None:
        raise ConfigError(f"--sensor {options.sensor}: must be WIDTHxHEIGHT in pixels, as 346x260")
    return int(size[1]), int(size[2])

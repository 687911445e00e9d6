# SPDX-License-Identifier: Apache-2.0
"""Options that several commands have: recordings and windows, boxes, filters, what is drawn, hardware."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from evcot.errors import ConfigError
from evcot.hardware.modules import DEFAULT_MODULE, MODULES
from evcot.scenes.registry import SCENES
from evcot.tracks.formats import FORMAT_NAMES
from evcot.unfinished import CHECKPOINT_EVENTS

from .parsing import group_of, input_or_name, input_or_scene, input_path, output_option

if TYPE_CHECKING:
    from evcot.tracks.formats.base import FrameClock

__all__ = [
    "DEFAULT_SCENE",
    "FORMATS_TEXT",
    "NUMBERS",
    "RUN_DEFAULT",
    "RUN_LOGS",
    "checkpoint_option",
    "classify_option",
    "clock_from",
    "clock_options",
    "damage_options",
    "filter_options",
    "input_options",
    "milliseconds",
    "recording_options",
    "region",
    "sensor_from",
    "tracked_options",
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


def classify_option(parser: argparse.ArgumentParser) -> None:
    """Add --classify."""
    parser.add_argument("--classify", type=input_path, metavar="NPZ", help="classify tracks with weights of `evcot train`")


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


def window_from(options: argparse.Namespace, length_ms: float | None = None) -> tuple[int, int | None]:
    """(from, to) in microseconds after the first event, to None for the recording's end.

    Args:
        length_ms: of the window where its end is not given; None: up to the recording's end.

    Raises:
        ConfigError: no time, or an end that does not follow the beginning.
    """
    from_ms, to_ms = options.from_ms or 0.0, options.to_ms
    if to_ms is None and length_ms is not None:
        to_ms = from_ms + length_ms
    for option, ms in (("--from", from_ms), ("--to", to_ms)):
        if ms is not None and not (math.isfinite(ms) and 0 <= ms <= 1e15):
            raise ConfigError(f"{option} {ms:g}: must be from 0 to 1e15 ms")
    if to_ms is not None and to_ms <= from_ms:
        raise ConfigError(f"--to {to_ms:g}: must be after --from {from_ms:g}")
    return round(from_ms * 1000), None if to_ms is None else round(to_ms * 1000)


def sensor_from(options: argparse.Namespace) -> tuple[int, int] | None:
    """(width, height) of --sensor, None where it is not given; ConfigError where it is no size."""
    if options.sensor is None:
        return None
    size = re.fullmatch(r"([0-9]{1,6})[xX]([0-9]{1,6})", options.sensor)
    if size is None:
        raise ConfigError(f"--sensor {options.sensor}: must be WIDTHxHEIGHT in pixels, as 346x260")
    return int(size[1]), int(size[2])


FORMATS_TEXT = f"one of {', '.join(FORMAT_NAMES)} (default: by the suffix: .txt, .json, .npy, .mcap)"


def clock_options(parser: argparse.ArgumentParser, origin: str) -> None:
    """Add --frame-us and --origin-us.

    Args:
        origin: what the origin is if it is not given.
    """
    parser.add_argument("--frame-us", type=float, metavar="US", help="time from frame to frame, for formats that number frames")
    parser.add_argument(
        "--origin-us", type=int, metavar="US", help=f"time of frame 1 on the recording's clock (default: {origin})"
    )


def clock_from(options: argparse.Namespace, origin_us: int = 0) -> FrameClock:
    """The clock of --frame-us and --origin-us; ConfigError where one is outside its range.

    Args:
        origin_us: without --origin-us.
    """
    from evcot.tracks.formats.base import FrameClock

    try:
        return FrameClock(options.frame_us, origin_us if options.origin_us is None else options.origin_us)
    except ConfigError as error:
        raise ConfigError(f"--{str(error).replace('_us', '-us', 1)}") from error


def milliseconds(text: str) -> int:
    """Milliseconds as whole microseconds; less than one is none only where it says 0. The name is what argparse prints."""
    ms = float(text)
    if not math.isfinite(ms) or (ms != 0 and round(1000 * ms) == 0):
        raise ValueError(text)
    return round(1000 * ms)


def region(text: str) -> tuple[int, ...]:
    """`X0,Y0,X1,Y1`. The name is what argparse prints."""
    return tuple(int(part) for part in text.split(","))


# option -> (field of FilterConfig, type, argument, help)
NUMBERS: dict[str, tuple[str, Callable[[str], Any], str, str]] = {
    "--refractory": ("refractory_us", milliseconds, "MS", "silence a pixel for this long after each of its events"),
    "--activity": ("activity_us", milliseconds, "MS", "keep an event if a neighbour sent one at most this long before"),
    "--activity-support": ("activity_support", int, "N", "how many neighbours must have sent one (default: 1)"),
    "--activity-noise": (
        "activity_noise_hz",
        float,
        "HZ",
        "let so much noise pass, per pixel and second, by as many neighbours as that takes; needs --cell",
    ),
    "--recent": ("recent_us", milliseconds, "MS", "keep an event if one of the last few events, at most this old, was near"),
    "--recent-radius": ("recent_radius", int, "PX", "how near (default: 4)"),
    "--recent-support": ("recent_support", int, "N", "how many of them must be near (default: 1)"),
    "--recent-depth": ("recent_depth", int, "N", "how many of the last events are remembered (default: 32)"),
    "--decay-tau": (
        "decay_tau_us",
        milliseconds,
        "MS",
        "keep an event if its neighbours' weights, which decay with this time constant, add up",
    ),
    "--decay-epsilon": ("decay_epsilon", float, "W", "weight up to which an event is forgotten (default: 0.1)"),
    "--decay-support": ("decay_support", float, "W", "sum of weights needed (default: 1)"),
    "--rowcol": (
        "rowcol_us",
        milliseconds,
        "MS",
        "keep an event if the last one of a neighbouring row or column, at most this old, was near",
    ),
    "--rowcol-radius": ("rowcol_radius", int, "PX", "how near along the row or column (default: 1)"),
    "--rowcol-support": ("rowcol_support", int, "N", "how many rows and columns must have one (default: 1)"),
    "--cell": (
        "cell_px",
        int,
        "PX",
        "keep times per cell of 1, 2 or 4 pixels, in less memory (default: 0, a time per pixel and filter)",
    ),
}


def filter_options(parser: argparse.ArgumentParser) -> None:
    """Add an option for each filter's settings. A command that has done its work then saves what was learned."""
    group = parser.add_argument_group("filters", "on top of the table [filters] of --config; see docs/filters.md")
    group.add_argument("--region", type=region, metavar="X0,Y0,X1,Y1", help="keep these columns and rows, both bounds included")
    group.add_argument("--polarity", choices=("on", "off"), help="keep events of this polarity")
    group.add_argument(
        "--hot-pixels", type=input_path, metavar="FILE", help="silence the pixels listed there, one `x y` a line"
    )
    group.add_argument("--learn-hot-pixels", action="store_true", help="find hot pixels in the recording and silence them")
    listed = "write there the hot pixels that --learn-hot-pixels finds, for --hot-pixels"
    output_option(parser, "--save-hot-pixels", group=group, metavar="FILE", help=listed)
    for option, (field, kind, metavar, meaning) in NUMBERS.items():
        group.add_argument(option, dest=field, type=kind, metavar=metavar, help=meaning)


RUN_LOGS = ("hardware", "software", "model")
RUN_DEFAULT = ("hardware", "software")


def tracked_options(parser: argparse.ArgumentParser) -> None:
    """Add what `tracked_from` reads."""
    parser.add_argument(
        "source", type=input_path, metavar="RECORDING|RUN", help="a recording, or the folder of a run of `evcot cosim`"
    )
    logs = f"track logs of the recording (.npz); of a run, any of {', '.join(RUN_LOGS)} (default: {' and '.join(RUN_DEFAULT)})"
    parser.add_argument("logs", nargs="*", type=input_or_name, metavar="LOG", help=logs)
    recording_options(parser)


DEFAULT_SCENE = "boxes"


def input_options(parser: argparse.ArgumentParser, *, runs: bool = False, stalls: bool = True) -> None:
    """Add what `job_from` reads; `runs`: the folder of a run is an input too; `stalls`: the streams may be stalled."""
    source = f"a recording, or a scene: {', '.join(SCENES)} (default: {DEFAULT_SCENE})"
    run = "the folder of a run of `evcot cosim`; " if runs else ""
    parser.add_argument("recording", nargs="?", type=input_or_scene, metavar="RUN" if runs else "FILE", help=run + source)
    parser.add_argument("--seed", type=int, metavar="N", help="seed of a scene (default: 1)")
    group = group_of(parser, "hardware")
    group.add_argument(
        "--preset",
        metavar="NAME",
        help="one of `evcot presets` (default: motion; of other hardware the one for the sensor)",
    )
    group.add_argument(
        "--config", type=input_path, metavar="TOML", help="a file that overrides the preset, or a whole run (--print-config)"
    )
    group.add_argument("--slots", type=int, metavar="N", help="tracker slots (default: the preset's)")
    group.add_argument(
        "--hardware", choices=MODULES, help=f"which RTL module (default: the preset's, {DEFAULT_MODULE} without one)"
    )
    parser.set_defaults(stalls=None)
    if stalls:
        group.add_argument("--stalls", type=int, metavar="SEED", help="stall the hardware's streams at random, from this seed")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
    damage_options(parser)
    filter_options(parser)

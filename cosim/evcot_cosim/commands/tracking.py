# SPDX-License-Identifier: Apache-2.0
"""Commands about tracks: `evcot track`, `live`, `train`, `evaluate`, `boxes`, `anomalies` and `presets`."""

from __future__ import annotations

import argparse
from typing import Any

from evcot.metrics import RULES
from evcot.trackers.engines import DEFAULT, ENGINES
from evcot.tracks import CSV, LOG_SUFFIXES

from ..live import PORT
from .options import (
    FORMATS_TEXT,
    checkpoint_option,
    classify_option,
    clock_options,
    damage_options,
    filter_options,
    recording_options,
)
from .parsing import add_command, group_of, input_each, input_or_name, input_path, json_or_quiet, output_option

__all__ = ["add_anomalies", "add_boxes", "add_evaluate", "add_live", "add_presets", "add_track", "add_train"]


def engine_options(parser: argparse.ArgumentParser) -> None:
    """Add --engine, --preset, --config and --set."""
    group = group_of(parser, "engine")
    group.add_argument("--engine", action=_Engine, choices=ENGINES, default=DEFAULT, metavar="NAME")
    group.add_argument("--preset", metavar="NAME", help="one of `evcot presets --engine ENGINE` (default: its first)")
    group.add_argument(
        "--config", type=input_path, metavar="TOML", help="a file whose table named after the engine overrides the preset"
    )
    group.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change one setting of the engine; may be repeated"
    )


class _Engine(argparse.Action):
    """Stores the name; engines of other packages are looked for only to show the help, or where such a name is given."""

    def __call__(self, _parser: Any, namespace: argparse.Namespace, values: Any, _option: str | None = None) -> None:
        setattr(namespace, self.dest, values)

    @property
    def help(self) -> str:
        return "; ".join(f"{name}: {engine.title}" for name, engine in ENGINES.items()) + f" (default: {DEFAULT})"

    @help.setter
    def help(self, _: str | None) -> None: ...


_TRACK_EXAMPLES = """
evcot track drive.aedat4 -o log.npz              # no settings needed
evcot track drive.aedat4 --engine adaptive -o log.npz  # a tracker in software that works in another way
evcot track drive.aedat4 --engine rct --preset traffic -o log.npz
evcot track drive.aedat4 --classify digits.npz -o log.npz  # the class of each track, with weights of `evcot train`
evcot track drive.aedat4 --boxes result.txt --frame-us 40000   # MOTChallenge, 25 frames a second
evcot track drive.raw --engine rct --preset traffic --set radius_px=12 --learn-hot-pixels --json
"""


def add_track(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "track", "track the objects in a recording", _TRACK_EXAMPLES)
    parser.add_argument("recording", type=input_path, metavar="FILE", help="the recording, in any format that evcot reads")
    engine_options(parser)
    output_option(
        parser,
        "-o",
        "--output",
        suffixes=LOG_SUFFIXES,
        metavar="LOG",
        help="write the track log, .npz, .parquet or .csv (records alone)",
    )
    output_option(parser, "--csv", suffixes=(CSV,), metavar="LOG.csv", help="write its records as text, too")
    output_option(parser, "--boxes", metavar="FILE", help="write the tracks' boxes, one per frame (--frame-us)")
    parser.add_argument("--boxes-format", metavar="NAME", help=f"format of the boxes: {FORMATS_TEXT}")
    classify_option(parser)
    clock_options(parser, "the first event")
    recording_options(parser)
    filter_options(parser)
    checkpoint_option(parser)
    json_or_quiet(parser, "print what was found as JSON instead of a table", "no progress, no table")


_LIVE_EXAMPLES = """
evcot live drive.aedat4                        # a file in real time, in the terminal
evcot live drive.aedat4 --web --speed 0.5      # and on a page, at half speed; engine and place are chosen there
evcot live drive.aedat4 --web --classify digits.npz  # the class of each track, with weights of `evcot train`
evcot live drive.aedat4 --web --with-hardware  # hardware in simulation beside the software tracker
evcot live tcp://127.0.0.1:7777 --engine rct --preset traffic --save seen.aedat4
evcot live camera --web                        # needs pip install evcot[camera]
evcot live drive.aedat4 --json
"""


def add_live(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    title = "track and show events while they happen: a file at real speed, a network stream, a camera"
    parser = add_command(commands, "live", title, _LIVE_EXAMPLES)
    source = "a recording; tcp://HOST:PORT, where DV or dv-processing sends AEDAT4; camera, or camera:SERIAL"
    parser.add_argument("source", type=input_or_name, metavar="SOURCE", help=source)
    parser.add_argument(
        "--speed", type=float, default=1.0, metavar="X", help="playback speed of a recording (default: 1, real speed)"
    )
    parser.add_argument("--web", nargs="?", type=int, const=PORT, metavar="PORT", help=f"show a page (default port: {PORT})")
    parser.add_argument(
        "--bind", metavar="ADDRESS", help="address that serves the page (default: 127.0.0.1, this machine only)"
    )
    beside = "run the hardware beside the engine: RTL in simulation while it keeps up, else its golden model"
    parser.add_argument("--with-hardware", action="store_true", help=beside)
    parser.add_argument("--loop", action="store_true", help="play a recording again and again")
    output_option(
        parser, "--save", metavar="FILE", help="record everything received: .aedat4 or .raw; readable even after a kill"
    )
    output_option(parser, "--save-log", suffixes=(".npz",), metavar="LOG.npz", help="write the track log when the run ends")
    classify_option(parser)
    parser.add_argument("--for", dest="for_s", type=float, metavar="S", help="stop after so many seconds")
    engine_options(parser)
    recording_options(parser)
    filter_options(parser)
    json_or_quiet(parser, "print a line of figures a second, and one at the end", "no dashboard, no table")


_TRAIN_EXAMPLES = """
evcot train one.aedat4 two.aedat4 --labels one.json two.json -o digits.npz   # COCO boxes with classes
evcot train drive.raw --labels drive_bbox.npy --size-speed -o vehicles.npz
"""


def add_train(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(commands, "train", "train a classifier of tracks from labelled recordings", _TRAIN_EXAMPLES)
    parser.add_argument(
        "recordings", nargs="+", type=input_path, metavar="FILE", help="recordings, in any format that evcot reads"
    )
    parser.add_argument(
        "--labels", nargs="+", type=input_path, required=True, metavar="BOXES", help="boxes with classes, a file a recording"
    )
    parser.add_argument("--labels-format", metavar="NAME", help=f"format of the labels: {FORMATS_TEXT}")
    output_option(parser, "-o", "--output", suffixes=(".npz",), required=True, metavar="NPZ", help="write the weights")
    group = group_of(parser, "engine")
    group.add_argument("--preset", metavar="NAME", help="of cot_motion, see `evcot presets` (default: its first)")
    group.add_argument("--config", type=input_path, metavar="TOML", help="a file that overrides the preset")
    group.add_argument("--window-log2", type=int, default=10, metavar="N", help="a window has 2^N events (default: 10)")
    group.add_argument(
        "--margin-min", type=int, default=0, metavar="N", help="a smaller margin per window is no class (0 to 255, default: 0)"
    )
    group.add_argument("--size-speed", action="store_true", help="learn to use size and speed of a track, too")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the training (default: 1)")
    clock_options(parser, "0")
    damage_options(parser)
    parser.add_argument("--json", action="store_true", help="print the number of windows of each class as JSON")


_EVALUATE_EXAMPLES = """
evcot evaluate log.npz --truth highway.truth.csv
evcot evaluate build/cosim/highway --truth highway.truth.csv   # all engines of a run
evcot evaluate mine.npz rct.npz frames.npz --truth highway.truth.csv   # side by side
evcot evaluate result.txt --truth gt.txt --frame-us 40000      # MOTChallenge, of any tracker
evcot evaluate log.npz --truth drive_bbox.npy
"""


def add_evaluate(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "evaluate", "score tracks against ground truth: HOTA, CLEAR, ID scores, errors", _EVALUATE_EXAMPLES
    )
    parser.add_argument(
        "logs",
        nargs="+",
        type=input_each,
        metavar="LOG|RUN",
        help="track logs, such as hardware.npz of a run; boxes; or folders of runs, to score all their engines",
    )
    parser.add_argument("--truth", type=input_path, required=True, metavar="TRUTH", help="the ground truth: CSV, or boxes")
    known = ", ".join(RULES)
    parser.add_argument(
        "--rule",
        type=input_or_name,
        metavar="RULE",
        help=f"how to read and score the truth: {known}, or a .toml file (default: the one with the truth's columns)",
    )
    parser.add_argument("--log-format", metavar="NAME", help=f"format of LOG if it has boxes: {FORMATS_TEXT}")
    parser.add_argument("--truth-format", metavar="NAME", help=f"the same of TRUTH: {FORMATS_TEXT}; .csv is read by the rule")
    clock_options(parser, "0")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels (default: the rule's)")
    parser.add_argument("--json", action="store_true", help="print every figure as JSON")


_BOXES_EXAMPLES = """
evcot boxes log.npz result.txt --frame-us 40000        # MOTChallenge, 25 frames a second
evcot boxes log.npz tracks.json --frame-us 40000 --origin-us 1718925184590631 --sensor 346x260
evcot boxes result.txt tracks_bbox.npy --frame-us 40000
evcot boxes log.npz tracks.mcap --frame-us 20000 --sensor 346x260   # for Foxglove; needs pip install evcot[mcap]
"""


def add_boxes(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "boxes", "write tracks as MOTChallenge text, COCO JSON, Prophesee boxes or MCAP", _BOXES_EXAMPLES
    )
    parser.add_argument("source", type=input_path, metavar="A", help="a track log, or boxes in one of the formats")
    output_option(parser, "target", metavar="B", help="what to write")
    parser.add_argument("--source-format", metavar="NAME", help=f"format of A: {FORMATS_TEXT}; .npz is a track log")
    parser.add_argument("--format", metavar="NAME", help=f"format of B: {FORMATS_TEXT}")
    clock_options(parser, "0")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels, which COCO and MCAP state")
    json_or_quiet(parser, "print what was written as JSON")


_ANOMALIES_EXAMPLES = """
evcot anomalies --learn monday.npz tuesday.npz --sensor 346x260 -o normal.npz
evcot anomalies today.npz --normal normal.npz --zones zones.toml
evcot anomalies today.npz --normal normal.npz -o alarms.csv --picture alarms.png
"""


def add_anomalies(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = add_command(
        commands, "anomalies", "flag unusual trajectories: zones, direction, speed, stays", _ANOMALIES_EXAMPLES
    )
    parser.add_argument("logs", type=input_path, nargs="+", metavar="LOG", help="a track log; with --learn one or more")
    parser.add_argument("--learn", action="store_true", help="learn normal motion from the logs, and write it to -o FILE.npz")
    parser.add_argument("--normal", type=input_path, metavar="NPZ", help="normal motion, as written by --learn")
    parser.add_argument("--zones", type=input_path, metavar="TOML", help="zones and counting lines (docs/anomalies.md)")
    parser.add_argument("--recording", type=input_path, metavar="FILE", help="refuse a log that is not of this recording")
    parser.add_argument("--sensor", metavar="WxH", help="size in pixels (default: the recording's, else the smallest)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="a setting of the rules; may be repeated"
    )
    output_option(
        parser,
        "-o",
        "--output",
        suffixes=(".csv", ".json", ".npz"),
        metavar="FILE",
        help="write alarms as .csv or .json; with --learn, normal motion as .npz",
    )
    output_option(parser, "--picture", suffixes=(".png", ".svg", ".pdf"), metavar="PNG", help="draw tracks and alarms there")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")


_PRESETS_EXAMPLES = """
evcot presets                                    # of `evcot cosim`
evcot presets --engine rct                       # of `evcot track --engine rct`
"""


def add_presets(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    presets = add_command(commands, "presets", "list the presets", _PRESETS_EXAMPLES)
    presets.add_argument(
        "--engine", choices=ENGINES, metavar="NAME", help="presets of one engine of `evcot track` (default: of `evcot cosim`)"
    )
    presets.add_argument("--json", action="store_true", help="print every field as JSON")

# SPDX-License-Identifier: Apache-2.0
"""Commands about tracks: `evcot track`, `evaluate`, `boxes`, `anomalies` and `presets`."""

from __future__ import annotations

import argparse

from evcot.metrics import RULES
from evcot.trackers.engines import ENGINES
from evcot.tracks.suffixes import CSV, LOG_SUFFIXES

from .engine_options import engine_options
from .options import FORMATS_TEXT, checkpoint_option, clock_options, filter_options, recording_options
from .parsing import add_command, input_each, input_or_name, input_path, output_option

__all__ = ["add_anomalies", "add_boxes", "add_evaluate", "add_presets", "add_track"]


_TRACK_EXAMPLES = """
evcot track drive.aedat4 -o log.npz              # no settings needed
evcot track drive.aedat4 --engine adaptive -o log.npz  # a tracker in software that works in another way
evcot track drive.aedat4 --engine rct --preset traffic -o log.npz
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
    clock_options(parser, "the first event")
    recording_options(parser)
    filter_options(parser)
    checkpoint_option(parser)
    parser.add_argument("--json", action="store_true", help="print what was found as JSON instead of a table")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")


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
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")


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
